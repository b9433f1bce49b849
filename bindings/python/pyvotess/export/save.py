"""The formats of :meth:`Tessellation.save`, by extension."""

from __future__ import annotations

import os
import warnings
from typing import TYPE_CHECKING, Any, Dict, NamedTuple, Optional, Union

from . import arrays
from .._arguments import as_number, as_path, as_word, require_one_of
from .colors import COLORMAPS, cell_colors
from .columns import VTU_NAMES, added_columns, named_columns, vtu_columns
from .geometry import mesh_of
from .mesh_file import short_edges_stay, write_mesh, write_pieces, write_pieces_of_cells
from .optional import imported
from .viewer import view
from .whole_file import whole_file

if TYPE_CHECKING:
    from .._state import SeedCells
    from .columns import Columns


class _Kind(NamedTuple):
    mesh: bool = False  # needs the polygons
    planar: bool = False  # holds those of the plane too
    columns: bool = False  # holds columns of the caller
    color: bool = False
    edges: bool = False  # may have short edges collapsed
    package: str = ""  # needed to write it


_KINDS: Dict[str, _Kind] = {
    ".npz": _Kind(columns=True),
    ".h5": _Kind(columns=True, package="h5py"),
    ".hdf5": _Kind(columns=True, package="h5py"),
    ".vtu": _Kind(mesh=True, planar=True, columns=True),
    ".ply": _Kind(mesh=True, color=True),
    ".obj": _Kind(mesh=True),
    ".glb": _Kind(mesh=True, color=True),
    ".stl": _Kind(mesh=True, edges=True),
    ".foam": _Kind(mesh=True, edges=True),
    ".tess": _Kind(mesh=True, edges=True),
    ".msh": _Kind(mesh=True, edges=True),
    ".cgns": _Kind(mesh=True, edges=True),
    ".html": _Kind(mesh=True, columns=True, color=True),
}


def _that(**flags: bool) -> str:
    return " ".join(e for e, kind in _KINDS.items() if all(getattr(kind, k) == v for k, v in flags.items()))


def _checked_kind(
    t: SeedCells, name: str, extension: str, columns: Columns, color: Any, open: Optional[str], min_edge: float
) -> _Kind:
    """Returns the format. Raises before any work if it cannot hold the data."""
    kind = _KINDS.get(extension)
    if kind is None and extension == ".geojson":
        before = "" if t.in_mesh else "tessellate with mesh=, and "
        raise ValueError(f"a .geojson file holds the pieces of cells in polygons: {before}save t.pieces()")
    if kind is None:
        table = ". For tables: t.to_dataframe().to_csv(path)" if extension in (".csv", ".txt") else ""
        raise ValueError(f"path is {name!r}: known are {' '.join(_KINDS)}{table}")
    if kind.mesh and t.ids is not None:
        raise ValueError(f"a {extension} file needs the cells of all points: leave out only=, or write .npz or .h5")
    if named_columns(columns) and not kind.columns:
        raise ValueError(f"{extension} holds no columns: {_that(columns=True)} do")
    if not (0 <= min_edge < float("inf")):
        raise ValueError(f"min_edge is {min_edge}: give a length from 0 on")
    if min_edge and not kind.edges:
        raise ValueError(f"{extension} keeps all edges, and min_edge is given: {_that(edges=True)} collapse short ones")
    if color is not None and not kind.color:
        raise ValueError(f"{extension} holds no colors: {_that(color=True)} do")
    if kind.mesh and t.in_mesh and t.planar:
        raise ValueError(f"a {extension} file holds no polygons with holes: save t.pieces(), as .geojson")
    if kind.mesh and t.in_mesh and extension not in (".vtu", ".html", ".foam", ".msh", ".cgns"):
        raise ValueError(
            f"a {extension} file holds polygons of whole cells: write .vtu, .foam, .msh or .cgns, or save t.pieces(), as "
            ".glb, .obj, .stl or .3mf"
        )
    if kind.mesh and not t.in_mesh:
        mesh_of(t, f"a {extension} file", kind.planar, True, open)
    else:
        require_one_of(open, "open", ("skip",))
    if t.in_mesh and extension == ".vtu" and "neighbors" not in t.wanted:
        raise ValueError("a .vtu file needs the lists of neighbors: put 'neighbors' into want")
    if kind.package:
        imported(kind.package, f"writing {extension}")
    return kind


def save(
    t: SeedCells,
    path: Union[str, os.PathLike[str]],
    columns: Columns,
    color: Any,
    colormap: str,
    open: Optional[str],
    min_edge: float,
) -> None:
    """See :meth:`Tessellation.save`."""
    name = as_path(path, "path")
    as_word(colormap, "colormap", COLORMAPS)
    extension = os.path.splitext(name)[1].lower()
    length = as_number(min_edge, "min_edge")
    kind = _checked_kind(t, name, extension, columns, color, open, length)
    if extension == ".html":
        view(t, columns, color, colormap, open).save(name)
        return
    taken = VTU_NAMES if extension == ".vtu" else arrays.NAMES
    added = added_columns(t, columns, taken)
    if extension == ".glb" and color is None:
        color = "volumes" if "volumes" in t.wanted else "neighbors"
    colors = cell_colors(t, color, colormap) if kind.color and color is not None else None
    with whole_file(name) as temporary:
        if extension == ".npz":
            arrays.write_npz(temporary, t, added)
        elif extension in (".h5", ".hdf5"):
            arrays.write_h5(temporary, t, added, name)
        else:
            data = {**vtu_columns(t), **added} if extension == ".vtu" else {}
            folder, kept = os.path.dirname(os.path.realpath(name)), 0
            if t.in_mesh and kind.edges:
                pieces = t.pieces()  # type: ignore[attr-defined]
                pieces._check_joined(f"a {extension} file")
                kept = write_pieces(temporary, extension, pieces._arrays(pieces.ids), length, folder)
            elif t.in_mesh:
                write_pieces_of_cells(temporary, t, data)
            else:
                kept = write_mesh(temporary, extension, t, data, colors, open is not None, folder, length)
            if kept:
                warnings.warn(short_edges_stay(kept, length), stacklevel=3)
