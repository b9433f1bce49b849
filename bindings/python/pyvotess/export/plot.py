"""Plots of a tessellation: plane sections by matplotlib, cells in space by PyVista."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Optional, Tuple, Union

import numpy as np

from .._arguments import as_number, shown
from ..pairs import edges_of
from .colors import limits
from .columns import color_values
from .geometry import POLYHEDRON, mesh_of, polyhedra, with_lengths
from .optional import imported

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._state import SeedCells
    from .._types import Float64Array, Int64Array

_AXES = "xyz"


def section(t: SeedCells, axis: int, value: float) -> Tuple[Int64Array, List[Float64Array]]:
    """Returns the cells cut by the plane ``coordinate[axis] == value``, ascending, and their polygons (M, 2).

    Polygons have the other two coordinates, in the order x, y, z.
    """
    indptr, offsets, loops, vertices = mesh_of(t, "plot()")
    above = vertices[:, axis] > value
    # The next corner of each corner in its polygon.
    following = np.arange(1, len(loops) + 1)
    sizes = np.diff(offsets)
    following[offsets[1:][sizes > 0] - 1] = offsets[:-1][sizes > 0]
    crossed = np.flatnonzero(above[loops] != above[loops[following]])
    a, b = loops[crossed], loops[following[crossed]]
    low, high = np.minimum(a, b), np.maximum(a, b)
    cell_of_face = np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))
    cell = cell_of_face[np.searchsorted(offsets, crossed, side="right") - 1]
    # Two faces of a cell share each of its edges.
    edges = np.unique(np.stack([cell, low, high], axis=1), axis=0)
    if len(edges) == 0:
        return np.empty(0, np.int64), []
    cell, low, high = edges.T
    start, end = vertices[low], vertices[high]
    part = (value - start[:, axis]) / (end[:, axis] - start[:, axis])
    others = [k for k in range(3) if k != axis]
    points = (start + part[:, None] * (end - start))[:, others]
    # A section is convex, so its corners are sorted by the angle around its middle.
    cells, first, which, count = np.unique(cell, return_index=True, return_inverse=True, return_counts=True)
    middle = np.stack([np.bincount(which, points[:, k]) for k in range(2)], axis=1) / count[:, None]
    away = points - middle[which]
    order = np.lexsort((np.arctan2(away[:, 1], away[:, 0]), which))
    polygons = np.split(points[order], first[1:])
    kept = count >= 3
    return cells[kept], [polygon for polygon, keep in zip(polygons, kept) if keep]


def _periods(t: SeedCells) -> List[Float64Array]:
    """Returns the periods of the domain, as differences of a face and its counterpart on the opposite side."""
    if t.shifts is None:
        return []
    indptr, offsets, loops, vertices = mesh_of(t, "plot()")

    def middle(face: int) -> Any:
        return vertices[loops[offsets[face] : offsets[face + 1]]].mean(axis=0)

    periods = []
    for step in np.eye(3, dtype=np.int8):
        for face in np.flatnonzero((t.shifts == step).all(axis=1))[:1]:
            cell = np.searchsorted(indptr, face, side="right") - 1
            other = int(t.neighbors.indices[face])
            row = slice(indptr[other], indptr[other + 1])
            back = (t.neighbors.indices[row] == cell) & (t.shifts[row] == -step).all(axis=1)
            periods.append(middle(face) - middle(indptr[other] + int(np.flatnonzero(back)[0])))
    return periods


def _images(t: SeedCells, axis: int, value: float) -> Iterator[Tuple[Int64Array, List[Float64Array]]]:
    """Yields the sections of all images of cells that may reach into the bounds of the domain."""
    periods = _periods(t)
    others = [k for k in range(3) if k != axis]
    # The bounds of a skewed domain may be longer than its edges.
    most = 2 if any(np.count_nonzero(np.abs(p) > 1e-9 * np.abs(p).max()) > 1 for p in periods) else 1
    found: Dict[float, Tuple[Int64Array, List[Float64Array]]] = {}  # by height
    for steps in itertools.product(range(-most, most + 1), repeat=len(periods)):
        shift = sum((k * p for k, p in zip(steps, periods)), np.zeros(3))
        height = value - shift[axis]
        if height not in found:
            found[height] = section(t, axis, height)
        cells, polygons = found[height]
        yield cells, [polygon + shift[others] for polygon in polygons]


def sections_in_box(t: SeedCells, axis: int, value: float) -> Tuple[Int64Array, List[Float64Array]]:
    """As :func:`section`, with images of periodic cells, and without polygons outside of the bounds."""
    others = [k for k in range(3) if k != axis]
    lower, upper = np.asarray(t.box)[:, others]
    found: List[Int64Array] = []
    polygons: List[Float64Array] = []
    for cells, some in _images(t, axis, value):
        seen = [bool((p.max(axis=0) > lower).all() and (p.min(axis=0) < upper).all()) for p in some]
        polygons += itertools.compress(some, seen)
        found.append(cells[np.array(seen, bool)])
    return np.concatenate(found), polygons


def _sections(pieces: Any, axis: int, value: float) -> Tuple[Int64Array, List[List[Float64Array]]]:
    """Returns the pieces that a plane cuts, and their rings, which turn one way around and the other way along holes."""
    corners, piece = pieces._corners, pieces._piece_of
    vertices = np.asarray(pieces.vertices)
    # A vertex is above the plane or below it, never on it: each triangle has one edge that leads down, and one up.
    above = vertices[corners, axis] > value
    met = np.flatnonzero(above.any(axis=1) & ~above.all(axis=1))
    corners, above, piece = corners[met], above[met], piece[met]

    def crossed(down: bool) -> Tuple[Int64Array, Float64Array]:
        side = np.argmax((above == down) & (np.roll(above, -1, axis=1) != down), axis=1)
        rows = np.arange(len(corners))
        ends = np.sort(np.stack((corners[rows, side], corners[rows, (side + 1) % 3]), axis=1), axis=1)
        a, b = vertices[ends[:, 0]], vertices[ends[:, 1]]
        share = (value - a[:, axis]) / (b[:, axis] - a[:, axis])
        return ends[:, 0] * len(vertices) + ends[:, 1], np.delete(a + share[:, None] * (b - a), axis, axis=1)

    (down, places), (up, _) = crossed(True), crossed(False)
    # An edge that leads down in one triangle leads up in another one of the piece.
    following = np.empty(len(met), np.int64)
    following[np.lexsort((up, piece))] = np.lexsort((down, piece))
    rings: Dict[int, List[Float64Array]] = {}
    used = np.zeros(len(met), bool)
    for start in range(len(met)):
        steps, k = [], start
        while not used[k]:
            used[k] = True
            steps.append(k)
            k = int(following[k])
        if len(steps) > 2:
            rings.setdefault(int(piece[start]), []).append(places[steps])
    return np.array(list(rings), np.int64), list(rings.values())


def _plot_sections(t: SeedCells, where: Any, color: Any, ax: Any, style: Any) -> Any:
    pieces = t.pieces()  # type: ignore[attr-defined]
    bounds = np.stack((pieces.vertices.min(axis=0), pieces.vertices.max(axis=0)))
    axis, value = _parse_slice(bounds, where if where is not None else ("z", bounds[:, 2].mean()))
    cut, rings = _sections(pieces, axis, value)
    across, up = (k for k in range(3) if k != axis)
    ax = _draw(t, pieces.cells[cut], rings, (across, up), color, ax, style)
    ax.set(xlim=bounds[:, across], ylim=bounds[:, up], title=f"{_AXES[axis]} = {value:g}")
    return ax


def _parse_slice(box: Float64Array, where: Any) -> Tuple[int, float]:
    try:
        name, value = where
        axis, value = _AXES.index(name), as_number(value, "slice")
    except (TypeError, ValueError):
        raise ValueError(f"slice is {shown(where)}: give an axis and a value, such as ('z', 0.5)") from None
    low, high = box[:, axis]
    if not low < value < high:
        raise ValueError(f"slice at {name} = {value:g} is not inside the domain, which spans {low:g} to {high:g}")
    return axis, value


def _draw(
    t: SeedCells, cells: Int64Array, polygons: List[List[Float64Array]], axes: Tuple[int, int], color: Any, ax: Any, style: Any
) -> Any:
    """Draws polygons of cells in the plane of two axes. A polygon is its outline, then its holes, which turn the other way."""
    import matplotlib.pyplot as plt
    from matplotlib.collections import PathCollection
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.path import Path

    def path_of(rings: List[Float64Array]) -> Path:
        codes = [[Path.MOVETO] + [Path.LINETO] * (len(ring) - 1) + [Path.CLOSEPOLY] for ring in rings]
        return Path(np.concatenate([part for ring in rings for part in (ring, ring[:1])]), np.concatenate(codes))

    values, label = color_values(t, color)
    low, high, logarithmic = limits(values)
    style.setdefault("norm", (LogNorm if logarithmic else Normalize)(low, high))
    style.setdefault("edgecolors", (0, 0, 0, 0.6))
    style.setdefault("linewidths", 0.5)
    box = np.asarray(t.box)
    across, up = axes
    if ax is None:
        ax = plt.subplots()[1]
    collection = PathCollection([path_of(rings) for rings in polygons], array=values[cells], **style)
    ax.add_collection(collection)
    ax.set(xlim=box[:, across], ylim=box[:, up], xlabel=_AXES[across], ylabel=_AXES[up], aspect="equal")
    ax.figure.colorbar(collection, ax=ax, label=label, extend="both")
    return ax


def _plot_slice(t: SeedCells, axis: int, value: float, color: Any, ax: Any, style: Any) -> Any:
    cells, polygons = sections_in_box(t, axis, value)
    across, up = (k for k in range(3) if k != axis)
    ax = _draw(t, cells, [[polygon] for polygon in polygons], (across, up), color, ax, style)
    ax.set_title(f"{_AXES[axis]} = {value:g}")
    return ax


def _plot_plane(t: SeedCells, color: Any, ax: Any, style: Any) -> Any:
    """Draws the cells of the plane, in a periodic domain with their images inside the box; in polygons their pieces."""
    if t.in_mesh:
        pieces = t.pieces()  # type: ignore[attr-defined]
        return _draw(t, pieces.cells, [pieces.rings(k) for k in range(len(pieces))], (0, 1), color, ax, style)
    try:
        polygons = t.polygons
    except AttributeError:
        raise ValueError("plot() needs the polygons of the cells: put 'vertices' into want") from None
    box, edges = np.asarray(t.box), edges_of(t)
    steps = [(-1, 0, 1) if repeats else (0,) for repeats in t.periodic]
    cells, images = [], []
    for shift in itertools.product(*steps):
        for cell, polygon in enumerate(polygons):
            image = polygon + shift @ edges
            if len(image) and (image.max(axis=0) > box[0]).all() and (image.min(axis=0) < box[1]).all():
                cells.append(cell)
                images.append([image])
    return _draw(t, np.array(cells, np.int64), images, (0, 1), color, ax, style)


def _polyhedra(t: SeedCells) -> Tuple[Int64Array, Int64Array, Float64Array]:
    """Returns the cells that are not empty, their VTK polyhedra, each after its length, and the vertices."""
    mesh = mesh_of(t, "plot()")
    cells = np.flatnonzero(np.diff(mesh.indptr) > 0)
    words, begin = polyhedra(mesh, cells)
    return cells, with_lengths(words, np.diff(begin)), mesh.vertices


def _plot_space(t: SeedCells, pyvista: Any, color: Any, **style: Any) -> Any:
    values, label = color_values(t, color)
    cells, words, vertices = _polyhedra(t)
    grid = pyvista.UnstructuredGrid(words, np.full(len(cells), POLYHEDRON, np.uint8), vertices)
    grid.cell_data[label or "value"] = values[cells]
    # Without the cells of one octant.
    points = np.asarray(t.points, np.float64)[cells]
    middle = np.asarray(t.box).mean(axis=0)
    grid = grid.extract_cells(np.flatnonzero(~(points > middle).all(axis=1)))
    plotter = _plotter(pyvista, grid, values, label, {"show_edges": True, **style})
    plotter.add_mesh(pyvista.line_segments_from_points(_frame(np.asarray(t.box))), color="gray")
    return plotter


def _plot_pieces(t: SeedCells, pyvista: Any, color: Any, **style: Any) -> Any:
    values, label = color_values(t, color)
    pieces = t.pieces()  # type: ignore[attr-defined]
    surface = pyvista.PolyData(np.array(pieces.vertices), np.insert(pieces._corners, 0, 3, axis=1).ravel())
    surface.cell_data[label or "value"] = values[pieces.cells[pieces._piece_of]]
    return _plotter(pyvista, surface, values, label, style)


def _plotter(pyvista: Any, grid: Any, values: Float64Array, label: str, style: Dict[str, Any]) -> Any:
    """Returns a plotter that shows the grid, colored by its cell data of this label."""
    low, high, logarithmic = limits(values)
    plotter = pyvista.Plotter()
    style = {"scalars": label or "value", "clim": (low, high), "log_scale": logarithmic, **style}
    # Much light from all around, so that the cells have the colors of the bar.
    style = {"ambient": 0.55, "diffuse": 0.45, **style}
    bar = {"vertical": True, "position_x": 0.86, "position_y": 0.15, "width": 0.06, "height": 0.7}
    style["scalar_bar_args"] = {**bar, **(style.get("scalar_bar_args") or {})}
    plotter.add_mesh(grid, **style)
    plotter.camera_position = "iso"
    plotter.camera.zoom(0.9)
    return plotter


def _frame(box: Float64Array) -> Float64Array:
    """Returns the edges of a box, two points each; those of the open octant end at its middle."""
    corners = np.array(list(itertools.product((0, 1), repeat=3)))
    pairs = [(a, b) for a, b in itertools.combinations(corners, 2) if np.abs(a - b).sum() == 1]
    ends = np.array([(a, (a + b) / 2 if b.all() else b) for a, b in pairs])
    return np.asarray(box[0] + ends.reshape(-1, 3) * (box[1] - box[0]))


def plot(
    t: SeedCells,
    slice: Optional[Tuple[str, float]] = None,
    color: Union[str, npt.ArrayLike] = "volume",
    ax: Any = None,
    **style: Any,
) -> Any:
    """See :meth:`Tessellation.plot`."""
    if ax is not None and not hasattr(ax, "add_collection"):
        raise TypeError(f"ax is {shown(ax)}: give axes of matplotlib")
    if t.planar:
        if slice is not None:
            raise ValueError("plot(): a slice needs three dimensions: leave it out")
        t._require_end("plot()")
        imported("matplotlib", "plot()")
        return _plot_plane(t, color, ax, style)
    if t.in_mesh:
        color_values(t, color)
        if slice is not None or ax is not None:
            imported("matplotlib", "plot()")
            return _plot_sections(t, slice, color, ax, style)
        return _plot_pieces(t, imported("pyvista", "plot() in a mesh"), color, **style)
    mesh_of(t, "plot()")
    middle = float(np.asarray(t.box)[:, 2].mean())
    axis, value = _parse_slice(np.asarray(t.box), slice if slice is not None else ("z", middle))
    color_values(t, color)
    if slice is None and ax is None:
        try:
            import pyvista
        except ImportError:
            pass
        else:
            return _plot_space(t, pyvista, color, **style)
    try:
        import matplotlib.pyplot  # noqa: F401
    except ImportError:
        needed = "matplotlib" if slice is not None or ax is not None else "PyVista or matplotlib"
        raise ImportError(f"plot() needs {needed}: pip install {needed.split()[-1].lower()}") from None
    return _plot_slice(t, axis, value, color, ax, style)
