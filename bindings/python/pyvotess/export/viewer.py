"""Cells as one HTML file that a browser shows: it turns, cuts and colors them, without a server and other files."""

from __future__ import annotations

import base64
import json
import os
import zlib
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Union

import numpy as np

from .._arguments import as_path, as_word
from .._input import as_array
from .colors import COLORMAPS, cell_colors, limits, map_values
from .columns import added_columns, cell_columns, color_values, column_of
from .geometry import Mesh, begins, mesh_of
from .whole_file import whole_file

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._state import SeedCells
    from .columns import Columns

    Values = Dict[str, npt.NDArray[Any]]

_GRAY = 255  # the step of the color map for NaN; the others are 0 to 254


@dataclass(frozen=True)
class View:
    """A page that shows cells. Notebooks show it."""

    html: str  #: the whole page

    def __repr__(self) -> str:
        return f"<pyvotess view of {len(self.html)} bytes>"

    def _repr_html_(self) -> str:
        page = escape(self.html, quote=True)
        return f'<iframe srcdoc="{page}" sandbox="allow-scripts" style="width:100%;height:480px;border:0"></iframe>'

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes a ``.html``, whole or not at all. Raises ValueError for another extension, OSError if that fails."""
        file = as_path(path, "path")
        if os.path.splitext(file)[1].lower() != ".html":
            raise ValueError(f"path is {file!r}: give a name that ends in .html")
        with whole_file(file) as name:
            Path(name).write_text(self.html, "utf-8")


def _packed(array: npt.ArrayLike, dtype: str) -> str:
    with np.errstate(over="ignore"):
        data = np.ascontiguousarray(array, np.dtype(dtype).newbyteorder("<")).tobytes()
    return base64.b64encode(zlib.compress(data)).decode()


def _column(name: str, values: npt.NDArray[Any]) -> Dict[str, Any]:
    """Returns what the page needs of a column: (N,) values, or (N, 3) colors."""
    if values.ndim == 2:
        return {"name": name, "steps": _packed(values, "u1")}
    numbers = values.astype(np.float64)
    low, high, logarithmic = limits(numbers)
    with np.errstate(all="ignore"):
        scaled, ends = (np.log(numbers), np.log([low, high])) if logarithmic else (numbers, np.array([low, high]))
        share = (scaled - ends[0]) / (ends[1] - ends[0]) if ends[1] > ends[0] else np.where(np.isnan(numbers), np.nan, 0.5)
    share = np.where(np.isnan(numbers), np.nan, np.nan_to_num(share, nan=0.0))
    steps = np.where(np.isnan(share), _GRAY, np.rint((_GRAY - 1) * np.clip(np.nan_to_num(share), 0, 1)))
    return {
        "name": name, "steps": _packed(steps, "u1"), "values": _packed(numbers, "f4"),
        "low": low, "high": high, "logarithmic": logarithmic,
    }  # fmt: skip


def _color_map(colormap: str) -> List[List[int]]:
    # The scale ends at quantiles, so the ends are there several times.
    even = np.concatenate((np.zeros(4), np.linspace(0, 1, _GRAY), np.ones(4), [np.nan]))
    colors: List[List[int]] = map_values(even, colormap).tolist()
    return colors[4 : 4 + _GRAY] + colors[-1:]


def page(mesh: Mesh, drawn: npt.NDArray[np.bool_], columns: Values, colormap: str, names: Sequence[str]) -> View:
    """Returns the page of closed polyhedra.

    ``drawn``: for each entry of ``mesh.loops``, whether the edge to the next corner of the face is drawn. ``columns``: (N,)
    values or (N, 3) colors. ``names``: those of the polyhedra.
    """
    sizes, faces = np.diff(mesh.offsets), np.diff(mesh.indptr)
    used = mesh.vertices[np.unique(mesh.loops)] if len(mesh.loops) else np.zeros((1, 3))
    low, high = used.min(axis=0), used.max(axis=0)
    longest = max(float((high - low).max()), float(np.finfo(float).tiny))
    unit = longest * max(float(np.linalg.norm((high - low) / longest)) / 2, 0.5)
    vertices = (mesh.vertices - (low + high) / 2) / unit
    # The middle of a polyhedron is the mean of the corners of its faces.
    corners = begins(sizes)[mesh.indptr]
    sums = np.concatenate((np.zeros((1, 3)), np.cumsum(vertices[mesh.loops], axis=0)))
    centers = (sums[corners[1:]] - sums[corners[:-1]]) / np.maximum(np.diff(corners), 1)[:, None]
    data = {
        "vertices": _packed(vertices, "f4"),
        "loops": _packed(mesh.loops, "u4"),
        "drawn": _packed(drawn, "u1"),
        "sizes": _packed(sizes, "u2"),
        "faces": _packed(faces, "u4"),
        "centers": _packed(centers, "f4"),
        "half": ((high - low) / 2 / unit).tolist(),
        "columns": [_column(name, values) for name, values in columns.items()],
        "map": _color_map(colormap),
        "names": list(names),
    }
    # A column's name must not end the element.
    text = json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    template = Path(__file__).with_name("viewer.html").read_text("utf-8")
    return View(template.replace("DATA", text, 1))


def _following(mesh: Mesh) -> npt.NDArray[np.int64]:
    """Returns, for each entry of ``mesh.loops``, the next corner of its face."""
    following = np.arange(1, len(mesh.loops) + 1)
    some = np.diff(mesh.offsets) > 0
    following[mesh.offsets[1:][some] - 1] = mesh.offsets[:-1][some]
    return mesh.loops[following]


def _chosen_first(columns: Values, t: SeedCells, color: Any, colormap: str) -> Values:
    """Returns the columns, the color first."""
    if color is None:
        color = "volume" if "volumes" in t.wanted else "neighbors" if "neighbors" in t.wanted else "x"
    colors = not isinstance(color, str) and as_array(color, "color").ndim == 2
    given = cell_colors(t, color, colormap) if colors else color_values(t, color)[0]
    name = column_of(t, color) if isinstance(color, str) else "color"
    return {name: given, **{other: values for other, values in columns.items() if other != name}}


def view(t: SeedCells, columns: Columns, color: Any, colormap: str, open: Optional[str]) -> View:
    """See :meth:`pyvotess.Tessellation.view`."""
    as_word(colormap, "colormap", COLORMAPS)
    numbers = cell_columns(t)
    added = added_columns(t, columns, numbers)
    for name, values in added.items():
        if values.ndim == 2:
            raise ValueError(f"column {name!r} has shape {values.shape}: .html holds ({len(t)},) values")
    colors = _chosen_first({**added, **numbers}, t, color, colormap)
    if t.in_mesh:
        pieces = t.pieces()  # type: ignore[attr-defined]
        of_pieces = {name: values[pieces.cells] for name, values in colors.items()}
        return view_of_pieces(pieces, {**of_pieces, **_own_columns(pieces)}, colormap)
    mesh = mesh_of(t, "view()", may_skip=True, open=open)
    kept = np.flatnonzero(np.diff(mesh.indptr) > 0)
    # Faces of empty cells are none, so that the others keep their faces.
    shown = mesh._replace(indptr=np.append(mesh.indptr[kept], mesh.indptr[-1]))
    # A closed surface has each edge once in each direction.
    drawn = mesh.loops < _following(mesh)
    return page(shown, drawn, {name: values[kept] for name, values in colors.items()}, colormap, [f"cell {k}" for k in kept])


def _own_columns(pieces: Any) -> Values:
    return {"piece volume": pieces.volumes, "cell": pieces.ids[pieces.cells]}


def view_of_pieces(pieces: Any, columns: Optional[Values] = None, colormap: str = "tide") -> View:
    """See :meth:`pyvotess.Pieces.view`. ``columns``: (P,) values of the pieces; default: their volumes and cells."""
    if pieces.planar:
        raise ValueError("view() works in three dimensions only: use plot(), or save the pieces as .geojson")
    triangles = pieces._corners
    mesh = Mesh(
        np.asarray(pieces.triangle_offsets, np.int64), np.arange(0, 3 * len(triangles) + 1, 3), triangles.ravel(), pieces.vertices
    )
    # An edge is drawn unless both of its triangles lie on one plane between two cells, or both on the surface.
    side = np.repeat(np.where(pieces.on_surface, -1, pieces.sources), 3)
    start, end = mesh.loops, _following(mesh)
    edge = np.minimum(start, end) * len(mesh.vertices) + np.maximum(start, end)
    order = np.lexsort((side, edge))
    begin = np.flatnonzero(np.diff(edge[order], prepend=-1))
    ends = np.append(begin, len(edge))[1:] - 1
    differs = side[order[begin]] != side[order[ends]]
    drawn = np.zeros(len(edge), bool)
    drawn[order[begin[differs]]] = True
    names = [f"piece {k} of cell {i}" for k, i in enumerate(pieces.ids[pieces.cells].tolist())]
    return page(mesh, drawn, _own_columns(pieces) if columns is None else columns, colormap, names)
