"""The data of a result, read from the library's handle. It is pickled without the handle."""

from __future__ import annotations

import difflib
import warnings
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple

import numpy as np

from ._arguments import as_number, require_one_of
from ._arrays import ARRAYS, TABLE, ArrayAttributes
from ._call import Handle, raise_on_failure, watched
from ._domain import Domain, text_of_domain
from ._library import lib
from .mesh import Faces, Lists, Neighbors, Rows, count_edges
from .stats import Stats, read_stats

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Float64Array, Int32Array, Int64Array


@dataclass(frozen=True, eq=False)
class ResultData:
    """The data of a result. Arrays have their names in the library, and are missing if empty."""

    arrays: Dict[str, npt.NDArray[Any]]
    box: Float64Array
    periodic: Tuple[bool, ...]
    origin: Optional[Float64Array]
    cell: Optional[Float64Array]
    walls: Float64Array
    planar: bool
    lists_walls: bool
    in_mesh: bool
    least_face: float
    stats: Stats


def _constant(values: Any) -> Float64Array:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def read_result(result: Handle, wanted: Tuple[str, ...]) -> ResultData:
    planar = bool(lib.votess_result_planar(result))
    size = 2 if planar else 3  # of vectors

    box, periodic, edges, walls = (result.array(name) for name in ("box", "periodic", "cell", "walls"))
    arrays = {}
    for name, of in TABLE.items():
        if of.group and of.group not in wanted:
            continue
        array = result.array(name)
        # Where a periodic result has no entries, shifts are empty too.
        if not of.optional or len(array) or (name == "shifts" and periodic.any()):
            arrays[name] = array
    return ResultData(
        arrays=arrays,
        box=_constant(box[:, :size]),
        periodic=tuple(bool(axis) for axis in periodic[:size]),
        origin=_constant(edges[0, :size]) if len(edges) else None,
        cell=_constant(edges[1 : size + 1, :size]) if len(edges) else None,
        walls=_constant(walls[:, [0, 1, 3]]) if planar else walls,
        planar=planar,
        lists_walls=bool(lib.votess_result_lists_walls(result)),
        in_mesh=bool(lib.votess_result_in_mesh(result)),
        least_face=float(lib.votess_result_least_face(result)),
        stats=read_stats(result),
    )


def locked(data: ResultData) -> ResultData:
    """Makes the arrays read-only, like arrays in the library's memory, and returns ``data``."""
    singles = (getattr(data, field.name) for field in fields(data))
    for array in (*data.arrays.values(), *singles):
        if isinstance(array, np.ndarray):
            array.flags.writeable = False
    return data


_WORD_OF = {"neighbors": "neighbors", "cell_vertices": "vertices", "faces": "faces"}
_WORD_OF.update({name: of.group for name, of in TABLE.items() if of.group and not of.optional})


def no_attribute(of: object, name: str, wanted: Optional[Tuple[str, ...]] = None) -> AttributeError:
    """Returns the error for a missing attribute: it names the array, and the word of want that adds it."""
    word = _WORD_OF.get(name, name)
    missing = wanted is not None and word in ARRAYS and word not in wanted
    put = f"put {word!r} into want, which was {wanted}"
    if missing and name in _WORD_OF:
        return AttributeError(f"{name} was not computed: {put}")
    text = f"{type(of).__name__!r} object has no attribute {name!r}"
    if name in ARRAYS and name not in _WORD_OF:  # a word for arrays with other names
        text += f": the name is {' or '.join(ARRAYS[name])}" + (f"; {put}" if missing else "")
    elif not name.startswith("_"):
        names = [known for known in {*dir(type(of)), *vars(of), *_WORD_OF} if not known.startswith("_")]
        near = difflib.get_close_matches(name, sorted(names), 1)
        text += f": did you mean {near[0]!r}?" if near else ""
    return AttributeError(text)


class Cells(ArrayAttributes):
    """The cells of N seeds or queries, in their order."""

    def __init__(self, result: Handle, wanted: Tuple[str, ...]) -> None:
        self._wanted = wanted
        self._data = read_result(result, wanted)

    def __setstate__(self, state: Dict[str, Any]) -> None:
        self.__dict__.update(state)
        locked(self._data)

    if not TYPE_CHECKING:  # a type checker would accept any name

        def __getattr__(self, name: str) -> Any:
            if hasattr(type(self), name):
                return object.__getattribute__(self, name)  # raises the error of the property again
            raise no_attribute(self, name, self.__dict__.get("_wanted"))

    def _check_wanted(self, name: str) -> None:
        if name in _WORD_OF and _WORD_OF[name] not in self._wanted:
            raise no_attribute(self, name, self._wanted)

    def _array(self, name: str) -> npt.NDArray[Any]:
        self._check_wanted(name)
        return self._data.arrays[name]

    def _held(self, name: str) -> Optional[npt.NDArray[Any]]:
        return self._data.arrays.get(name)

    def __len__(self) -> int:
        return len(self.status)

    def _where(self) -> str:
        """Returns the domain in words."""
        where = text_of_domain(self.box, self.cell, self.origin, len(self.walls), self.periodic)
        return f"mesh of volume {self.stats.box_volume:g} in a {where}" if self.in_mesh else where

    @property
    def wanted(self) -> Tuple[str, ...]:
        """The words of ``want`` whose arrays the result holds, with the implied ones."""
        return self._wanted

    @property
    def neighbors(self) -> Lists:
        """Neighbor lists, N rows of ascending ids, walls (negative) first."""
        self._check_wanted("neighbors")
        return Lists(self.indptr, self.indices)

    @property
    def areas(self) -> Float64Array:
        """The same as :attr:`face_areas`."""
        return self.face_areas

    @property
    def cell_vertices(self) -> Lists:
        """The vertices of each cell, N ascending rows."""
        self._check_wanted("cell_vertices")
        return Lists(self.cell_vertex_indptr, self.cell_vertex_indices)

    @property
    def faces(self) -> Faces:
        """The polygons of the faces, one for each entry of ``neighbors.indices``, counterclockwise seen from outside."""
        self._check_wanted("faces")
        return Faces(self.face_offsets, self.face_vertices)

    @property
    def box(self) -> Float64Array:
        """(2, 3) float64, lower and upper corner of the domain; the bounds of a triclinic domain."""
        return self._data.box

    @property
    def periodic(self) -> Tuple[bool, ...]:
        """Whether the domain is periodic along x, y, z, or along the edges of ``cell``. Two flags in the plane."""
        return self._data.periodic

    @property
    def cell(self) -> Optional[Float64Array]:
        """(3, 3) float64, the edges of a triclinic box as rows; None for other domains."""
        return self._data.cell

    @property
    def origin(self) -> Optional[Float64Array]:
        """(3,) float64, the corner of a triclinic box; None for other domains."""
        return self._data.origin

    @property
    def walls(self) -> Float64Array:
        """(M, 4) float64, rows nx, ny, nz, d of the given walls n.x <= d."""
        return self._data.walls

    @property
    def planar(self) -> bool:
        """Whether the points are (N, 2): all vectors then have two components, see the page "two dimensions"."""
        return self._data.planar

    @property
    def in_mesh(self) -> bool:
        """Whether the cells are their parts in a ``mesh``."""
        return self._data.in_mesh

    @property
    def polygons(self) -> List[Float64Array]:
        """The cells of the plane: N arrays (K, 2) of corners, counterclockwise. Needs "vertices" in want.

        In a periodic domain each lies where its seed is in ``wrapped_points``.
        """
        if not self.planar:
            raise AttributeError("polygons are cells of the plane: in space use faces")
        return [self.vertices[corners] for corners in self.cell_vertices]

    def _require_space(self, what: str) -> None:
        if self.planar:
            raise ValueError(f"{what} works in three dimensions only")

    @property
    def open_cells(self) -> npt.NDArray[np.bool_]:
        """(N,) True for a cell that reaches infinity. Needs "volumes" or "faces" in want, or "areas" with ``list_walls``."""
        if not self._is_endless:
            return np.zeros(len(self), bool)
        if "volumes" in self._wanted:
            return np.isinf(self.volumes)
        if "areas" in self._wanted and self.lists_walls:
            infinite = np.isinf(self.face_areas)
        elif self.planar:
            infinite = np.all(self.faces.indices.reshape(-1, 2) == -1, axis=1)
        else:
            infinite = np.diff(self.faces.indptr) == 0
        found: npt.NDArray[np.bool_] = np.zeros(len(self), bool)
        found[np.repeat(np.arange(len(self)), np.diff(self.neighbors.indptr))[infinite]] = True
        return found

    @property
    def _is_endless(self) -> bool:
        return bool(np.isinf(self.box).any())

    def _closed_cells(self, what: str, open: Optional[str]) -> Optional[npt.NDArray[np.bool_]]:
        """Returns the cells that do not reach infinity, None for all. Refuses others unless ``open`` is "skip"."""
        require_one_of(open, "open", ("skip",))
        if not self._is_endless:
            return None
        reach = self.open_cells
        if open is None and reach.any():
            some = "1 cell reaches" if reach.sum() == 1 else f"{int(reach.sum())} cells reach"
            raise ValueError(f"{what}: {some} infinity: leave out such cells by open='skip', or give a box")
        return ~reach

    def _require_end(self, what: str) -> None:
        if self._is_endless:
            raise ValueError(f"{what} needs a box with ends: some cells reach infinity")

    @property
    def lists_walls(self) -> bool:
        """Whether the rows list walls."""
        return self._data.lists_walls

    @property
    def stats(self) -> Stats:
        """Statistics of the run."""
        return self._data.stats

    def voronoi_indices(self, edge_threshold: float = 0.0) -> Int64Array:
        """Returns (N, M) int64: column k counts the faces with k + 3 edges. Needs "faces" in want.

        Edges shorter than ``edge_threshold`` do not count; neither do faces with fewer than three remaining edges.
        Warns about faces far smaller than the mean, as in a rounded lattice. ``min_face`` drops them; the other faces
        keep short edges, which ``edge_threshold`` ignores.

        >>> t.voronoi_indices().sum(axis=1)[:3].tolist()  # faces of each cell
        [14, 10, 16]
        """
        self._require_space("voronoi_indices()")
        self._require_end("voronoi_indices()")
        if self.in_mesh:
            raise ValueError("voronoi_indices() counts edges of whole cells: tessellate without mesh=")
        threshold = as_number(edge_threshold, "edge_threshold")
        if not threshold >= 0:
            raise ValueError(f"edge_threshold is {threshold}: give a length from 0 on")
        tiny = self.stats.tiny_faces
        if tiny and threshold == 0:
            warnings.warn(
                f"{tiny} of {self.stats.faces} faces are smaller than 1e-9 of the mean face. If the points are a rounded "
                "lattice, drop them with min_face=1e-6, and short edges with edge_threshold",
                stacklevel=2,
            )
        return count_edges(self.neighbors, self.faces, self.vertices, threshold)


class SeedCells(Cells):
    """The cells of N seeds. :class:`pyvotess.Tessellation` adds files, pictures and further computations."""

    def __init__(
        self, result: Handle, points: npt.NDArray[Any], wanted: Tuple[str, ...], domain: Domain, weights: Optional[Float64Array] = None
    ) -> None:
        """weights: those of all points where the result has some of their cells."""
        super().__init__(result, wanted)
        self._seed_weights = weights
        self._result: Optional[Handle] = result  # None after unpickling, until needed
        self._points = points
        self._given_domain = domain
        self._places: Optional[Float64Array] = None  # wrapped_points, stored in the pickle

    def __getstate__(self) -> Dict[str, Any]:
        """Returns the state with the arrays and without the library's object."""
        places = self.wrapped_points if any(self.periodic) else None
        return dict(self.__dict__, _result=None, _places=places)

    def _where(self) -> str:
        return super()._where() + ("" if self._given_domain._has_ends else " around them")

    @property
    def domain(self) -> Domain:
        """The given domain; the default one is the box around the points. With the same points it gives the same cells."""
        given = self._given_domain
        return given if given._has_ends or self.in_mesh else given.replace(box=self.box.ravel())

    @property
    def neighbors(self) -> Neighbors:
        """Neighbor lists, N rows. Symmetric: i lists j exactly when j lists i."""
        self._check_wanted("neighbors")
        return Neighbors(self.indptr, self.indices)

    def rows(self) -> Rows:
        """Returns the neighbor lists as ``adjacency`` and ``offsets``, and ``status``, all int32.

        ``adjacency`` is ``indices`` without a copy. Raises ValueError for 2**31 entries or more.

        >>> rows = t.rows()
        >>> rows.adjacency.dtype, len(rows.offsets)
        (dtype('int32'), 101)
        """
        if self.indptr[-1] >= 2**31:
            raise ValueError(f"the rows have {self.indptr[-1]} entries, too many for int32: use indptr and indices")
        return Rows(self.indices, self.indptr.astype(np.int32), self.status.astype(np.int32))

    def _held(self, name: str) -> Optional[npt.NDArray[Any]]:
        held = super()._held(name)
        if held is None and name == "ids" and len(self) < len(self._points):
            return np.empty(0, np.int32)  # only=[]
        if held is None and name == "weights" and self._seed_weights is not None:
            return np.empty(0)  # only=[]
        if held is None and name == "mesh_areas" and self.in_mesh and "surfaces" in self.wanted:
            return np.empty(0)  # no seeds
        return held

    def _check_whole(self) -> None:
        if self.ids is not None:
            raise ValueError("the cells of some points do not form a diagram: leave out only=")

    @property
    def least_face(self) -> float:
        """Area below which ``min_face`` or ``min_area`` dropped faces, length unit squared; 0 without either."""
        return self._data.least_face

    def _require_whole_faces(self, what: str) -> None:
        if self.least_face > 0:
            raise ValueError(f"{what} needs whole cells: leave out min_face and min_area")

    @property
    def points(self) -> npt.NDArray[Any]:
        """(N, 3) the points: the given array, or a converted copy. :meth:`verify` uses it."""
        return self._points

    @property
    def wrapped_points(self) -> Float64Array:
        """(N, 3) float64, the points wrapped into a periodic domain, as a new array. :attr:`shifts` count from there."""
        if self._places is not None:
            return np.array(self._places)
        points = np.array(self._points, dtype=np.float64, order="C")
        if self._result is None:
            return points  # the domain is not periodic
        places = np.empty_like(points)
        raise_on_failure(watched(lib.votess_wrapped_points, self._result, points, len(points), places))
        return places


def _sizes(data: ResultData, places: Float64Array) -> Dict[str, Float64Array]:
    """Returns the lengths and areas whose digits entries of some arrays have. places: of the seeds."""
    held = data.arrays
    sizes: Dict[str, Float64Array] = {}
    if "face_areas" in held:
        rows = np.repeat(np.arange(len(places)), np.diff(held["indptr"]))
        finite = np.where(np.isinf(held["face_areas"]), 0, held["face_areas"])
        surfaces: Float64Array = np.bincount(rows, finite, len(places)).astype(np.float64)
        sizes["face_areas"] = surfaces[rows]
    if "centroids" in held:
        size = np.linalg.norm(held["centroids"] - places, axis=1)
        if "volumes" in held:
            size += np.abs(held["volumes"]) ** (1 / places.shape[1])  # those of crossing rings are below 0
        sizes["centroids"] = size[:, None]
    if "vertices" in held:
        corners = held["cell_vertex_indices"]
        rows = np.repeat(np.arange(len(places)), np.diff(held["cell_vertex_indptr"]))
        reach, size = np.zeros(len(places)), np.zeros(len(held["vertices"]))
        np.maximum.at(reach, rows, np.linalg.norm(held["vertices"][corners] - places[rows], axis=1))
        np.maximum.at(size, corners, reach[rows])
        sizes["vertices"] = size[:, None]
    return sizes


def differing_array(ours: ResultData, again: ResultData, places: Float64Array) -> str:
    """Returns the name of an array that differs, or "". Floating-point arrays may differ by rounding.

    places: of the seeds. ``again`` is made on the CPU.
    """
    if ours.arrays.keys() != again.arrays.keys():
        return ", ".join(sorted(ours.arrays.keys() ^ again.arrays.keys()))
    differ = [name for name, array in ours.arrays.items() if not np.array_equal(array, again.arrays[name], array.dtype.kind == "f")]
    if any(ours.arrays[name].shape != again.arrays[name].shape for name in differ):
        return differ[0]
    single = ours.stats.precision != "double"
    sizes = _sizes(again, places) if differ and not single else {}
    for name in differ:
        array, other = ours.arrays[name], again.arrays[name]
        if array.dtype.kind != "f" or name == "weights":
            return name
        error = 1e-4 if single else 1e-9
        own = np.abs(other) if other.ndim == 1 else np.linalg.norm(other, axis=1, keepdims=True)
        if single:  # rounded by the size of all cells
            allowed = error * (own + np.max(np.abs(other), where=np.isfinite(other), initial=0))
        elif name in sizes and other.ndim == 2:  # places, which are rounded as float64
            allowed = 1e-14 * own + error * sizes[name]
        else:
            allowed = error * (own + sizes.get(name, np.zeros(1)))
        with np.errstate(invalid="ignore"):  # of infinite numbers
            same = (array == other) | (np.abs(array - other) <= allowed) & np.isfinite(other) | np.isnan(array) & np.isnan(other)
        if not same.all():
            return name
    return ""
