"""The domain of cells as one value, and its short forms: arguments of each function that takes one."""

from __future__ import annotations

import ctypes
import difflib
import inspect
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, List, Mapping, Optional, Tuple, TypedDict, TypeVar, Union

import numpy as np

from . import _c_api
from ._arguments import as_number, as_word, require_one_of, shown
from ._call import Handle, raise_on_failure, run
from ._input import as_box, as_cell, as_mesh, as_origin, as_periodic, as_walls
from ._library import lib

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import Unpack

    from ._c_api import OutsideWord, RepairWord
    from ._types import Float64Array, Int32Array


class DomainKeywords(TypedDict, total=False):
    """The short forms of a :class:`Domain`."""

    box: Union[str, npt.ArrayLike, None]
    periodic: Union[None, bool, str, Iterable[bool]]
    cell: Optional[npt.ArrayLike]
    origin: Optional[npt.ArrayLike]
    walls: npt.ArrayLike
    mesh: Any
    mesh_repair: Optional[RepairWord]
    mesh_tolerance: float
    outside: OutsideWord


SHORT_FORMS: Tuple[str, ...] = tuple(DomainKeywords.__annotations__)
_DEFAULTS = {"walls": (), "mesh_tolerance": 0.0, "outside": "error"}  # of others None
_BOXES = {"none": "none", "hull": "hull"}

_Function = TypeVar("_Function", bound=Callable[..., Any])


def with_short_forms(function: _Function) -> _Function:
    """Puts the short forms into the signature that help() shows, in the place of ``**keywords``."""
    signature = inspect.signature(function)
    before: List[inspect.Parameter] = []
    behind: List[inspect.Parameter] = []
    for one in signature.parameters.values():
        if one.kind is not one.VAR_KEYWORD:
            (behind if one.kind is one.KEYWORD_ONLY else before).append(one)
    for name, kind in DomainKeywords.__annotations__.items():
        annotation = getattr(kind, "__forward_arg__", kind)
        before.append(
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=_DEFAULTS.get(name), annotation=annotation)
        )
    function.__signature__ = signature.replace(parameters=before + behind)  # type: ignore[attr-defined]
    return function


def _locked(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Returns the values in an array that nobody changes."""
    if array.flags.writeable or not array.flags.owndata:
        array = np.array(array)
        array.flags.writeable = False
    return array


def _checked(given: Mapping[str, Any]) -> Tuple[Dict[str, Any], Dict[str, int]]:
    """Returns the short forms that say something, each in one form, and the dimensions of those that have some."""
    for name in given:
        if name not in SHORT_FORMS:
            near = difflib.get_close_matches(name, SHORT_FORMS, 1)
            raise TypeError(f"unexpected keyword argument {name!r}" + (f": did you mean {near[0]}?" if near else ""))
    said = {name: value for name, value in given.items() if value is not None}
    values: Dict[str, Any] = {}
    if isinstance(said.get("box"), str):
        values["box"] = as_word(said["box"], "box", _BOXES)
    elif "box" in said:
        values["box"] = as_box(said["box"])
    for name, read in (("cell", as_cell), ("origin", as_origin), ("walls", as_walls)):
        if name in said:
            values[name] = read(said[name])
    if "walls" in values and len(values["walls"]) == 0:
        del values["walls"]
    if "origin" in values and "cell" not in values:
        raise ValueError("origin needs cell: the corners of a box define its place")
    if "cell" in values:
        values.setdefault("origin", np.zeros(len(values["cell"])))
    sizes = {name: value.shape[-1] - (name == "walls") for name, value in values.items() if not isinstance(value, str)}

    require_one_of(said.get("mesh_repair"), "mesh_repair", ("merge",))
    tolerance = as_number(said.get("mesh_tolerance", 0.0), "mesh_tolerance")
    if "mesh_repair" in said and "mesh" not in said:
        raise ValueError("mesh_repair needs a mesh: give one, or leave mesh_repair out")
    if tolerance != 0 and "mesh_repair" not in said:
        raise ValueError("mesh_tolerance needs mesh_repair='merge': set it, or leave mesh_tolerance out")
    if "mesh" in said:
        vertices, triangles = as_mesh(said["mesh"])
        values["mesh"], sizes["mesh"] = (_locked(vertices), _locked(triangles)), vertices.shape[1]
    if "mesh_repair" in said:
        values["mesh_repair"] = said["mesh_repair"]
    if tolerance != 0:
        values["mesh_tolerance"] = tolerance
    if "outside" in said:
        as_word(said["outside"], "outside", _c_api.OUTSIDE)
        if said["outside"] != "error":
            values["outside"] = said["outside"]

    first = next(iter(sizes), "periodic")
    for name, size in sizes.items():
        if size != sizes[first]:
            raise ValueError(f"{name} has {size} dimensions, but {first} has {sizes[first]}: give both the same")
    if "periodic" in said:
        repeats = as_periodic(said["periodic"], sizes.get(first))
        if "cell" in values or (any(repeats) if isinstance(repeats, tuple) else repeats):
            values["periodic"] = repeats
            if not sizes and isinstance(repeats, tuple) and len(repeats) == 2:
                sizes["periodic"] = 2
    elif "cell" in values:
        values["periodic"] = tuple(bool(edge.any()) for edge in values["cell"])
    return {name: _locked(value) if isinstance(value, np.ndarray) else value for name, value in values.items()}, sizes


def text_of_domain(
    box: Union[None, str, Float64Array], cell: Optional[Float64Array], origin: Optional[Float64Array], walls: int,
    periodic: Iterable[bool],
) -> str:  # fmt: skip
    def text(vector: Float64Array) -> str:
        return f"({', '.join(f'{x:g}' for x in vector)})"

    if cell is not None:
        where = f"cell {', '.join(text(edge) for edge in cell)} at {text(np.zeros(3) if origin is None else origin)}"
    elif isinstance(box, str):
        where = "convex hull" if box == "hull" else "domain without end"
    elif box is None:
        where = "box"
    else:
        where = "domain without end" if np.isinf(box).all() else f"box {text(box[0])} to {text(box[1])}"
    if walls:
        where += f" cut by {walls} wall{'s' if walls > 1 else ''}"
    axes = "".join(axis for axis, repeats in zip("xyz" if cell is None else "abc", periodic) if repeats)
    return where + (f", periodic {axes}" if axes else "")


class Domain:
    """The part of space that the cells fill, as a value: it never changes, compares by content, and can be pickled.

    ``Domain.box``, ``cell``, ``hull``, ``space`` and ``mesh`` make one. Each function that takes a domain also takes its
    short forms, the arguments of this class, and makes the same value of them::

        vt.tessellate(points, vt.Domain.box((0, 0, 0, 1, 1, 1), periodic="xy"))
        vt.tessellate(points, box=(0, 0, 0, 1, 1, 1), periodic="xy")

    Numbers of two components make a domain of the plane, see the page "Two dimensions".

    Parameters
    ----------
    box : (x0, y0, z0, x1, y1, z1), ((x0, y0, z0), (x1, y1, z1)) or ((x0, x1), (y0, y1), (z0, z1)). A bound may be infinite,
        and "none" stands for all of space. Cells that reach infinity then have volume inf and centroid nan; rows with walls
        list infinity as -1, and polygons have -1 there. "hull" stands for the convex hull of the points, as ``walls``; no
        point is outside, not even by rounding. Default, without another domain: the bounds of the points, each side moved
        out by half of (longest side / cbrt(N)); for a :class:`Diagram` all of space.
    periodic : True, axes such as "xy", or three flags. The box must be given, and points outside are wrapped into it.
        x, y, z mean the edges of a ``cell``. Default: a box is not periodic, a cell is along all edges except those that
        are 0.
    cell, origin : a triclinic box instead of ``box``: its edges as rows, and its corner. Along an edge without period its
        faces are walls. Along an edge that is 0 it has no end.
    walls : (M, 4) rows nx, ny, nz, d: walls that keep n.x <= d, with the ids -7, -8, ...; not in a periodic domain.
    mesh : a closed triangle mesh: (vertices, triangles), or a mesh of trimesh, PyVista, meshio or Open3D. Each cell is its part
        inside, see the page "Domains". Points may lie outside. Refused with walls and outside. In the plane polygons with
        holes: GeoJSON as a dict, an object with ``__geo_interface__`` as of Shapely, or (vertices, edges) with the domain
        on the left of each edge. Not in a ``cell`` there. Where parts of a mesh or polygons overlap, places count as often
        as they lie in one.
    mesh_repair : "merge" makes vertices of the mesh at equal places one, as meshes from STL files need. Default: none.
    mesh_tolerance : with "merge", vertices at most this far apart become one too. A share of the longest side of the
        mesh's bounds, at most 0.01; 1e-9 closes meshes whose corners differ by rounding. ``stats.moved_vertices`` and
        ``stats.moved_distance`` report what moved.
    outside : "error" or "drop" or "keep"; points outside the domain: an error; or dropped, which leaves an empty
        cell with the status `outside`; or kept, which gives each the part of its cell inside the domain, or the status
        `empty`.

    Raises
    ------
    ValueError, TypeError, VotessError : arguments of wrong form or of different dimensions, and those that exclude each other.
        Periodic axes without a box, edges of a cell in one plane, and a mesh that reaches out of its box are refused when
        cells are made.

    >>> slab = vt.Domain(box=box, periodic="xy")
    >>> vt.tessellate(points, slab).domain == slab
    True
    """

    __slots__ = ("_values", "_sizes")
    _values: Dict[str, Any]
    _sizes: Dict[str, int]

    @with_short_forms
    def __init__(self, **keywords: Unpack[DomainKeywords]) -> None:
        self._set(keywords)
        self._check()

    def _set(self, keywords: Mapping[str, Any]) -> None:
        values, sizes = _checked(keywords)
        object.__setattr__(self, "_values", values)
        object.__setattr__(self, "_sizes", sizes)

    def _check(self) -> None:
        """Refuses what no points could mend. Periodic axes without a box pass, because files may state them."""
        d = self.dimensions or 3
        options = _c_api.Options()
        raise_on_failure(lib.votess_options_init(options, ctypes.sizeof(options)))
        options.planar = d == 2
        self._fill(options, np.eye(d + 1, d))
        if not self._has_ends:
            options.periodic[:] = (False,) * 3
        raise_on_failure(lib.votess_options_implied_want(options, ctypes.c_uint32()))

    @classmethod
    def box(
        cls,
        limits: npt.ArrayLike,
        *,
        periodic: Union[bool, str, Iterable[bool]] = False,
        walls: npt.ArrayLike = (),
        outside: OutsideWord = "error",
    ) -> Domain:
        """Returns a box, see ``box`` above. Bounds may be infinite.

        >>> vt.Domain.box((0, 0, 0, 2, 1, 1), periodic=True)
        <pyvotess.Domain: box (0, 0, 0) to (2, 1, 1), periodic xyz>
        """
        return cls(box=as_box(limits, "limits").ravel(), periodic=periodic, walls=walls, outside=outside)

    @classmethod
    def cell(
        cls,
        vectors: npt.ArrayLike,
        *,
        origin: Optional[npt.ArrayLike] = None,
        periodic: Union[None, bool, str, Iterable[bool]] = None,
        outside: OutsideWord = "error",
    ) -> Domain:
        """Returns a triclinic box with these edges as rows, and its corner at ``origin``.

        >>> vt.Domain.cell([(1, 0, 0), (0.5, 1, 0), (0, 0, 2)])
        <pyvotess.Domain: cell (1, 0, 0), (0.5, 1, 0), (0, 0, 2) at (0, 0, 0), periodic abc>
        """
        return cls(cell=as_cell(vectors, "vectors"), origin=origin, periodic=periodic, outside=outside)

    @classmethod
    def hull(cls) -> Domain:
        """Returns the convex hull of the points, which are those of each call.

        >>> vt.tessellate(points, vt.Domain.hull(), want="volumes").stats.box_volume < 1
        True
        """
        return cls(box="hull")

    @classmethod
    def space(cls) -> Domain:
        """Returns all of space, or all of the plane for points (N, 2).

        >>> int(vt.tessellate(points, vt.Domain.space(), want="volumes").open_cells.sum())
        34
        """
        return cls(box="none")

    @classmethod
    def mesh(
        cls,
        mesh: Any,
        *,
        repair: Optional[RepairWord] = None,
        tolerance: float = 0.0,
        within: Optional[Domain] = None,
    ) -> Domain:
        """Returns the inside of a closed triangle mesh, in the plane of polygons, see ``mesh`` above.

        within : a box or cell around it, which may be periodic.

        >>> corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        >>> vt.Domain.mesh((corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]))
        <pyvotess.Domain: mesh of 4 triangles in a default box>
        """
        around = as_domain(within, {}, "within")
        return around.replace(mesh=as_mesh(mesh), mesh_repair=repair, mesh_tolerance=tolerance)

    @with_short_forms
    def replace(self, **keywords: Unpack[DomainKeywords]) -> Domain:
        """Returns the domain with other values of these arguments of :class:`Domain`. None takes one away.

        >>> vt.Domain.box(box).replace(periodic="x")
        <pyvotess.Domain: box (0, 0, 0) to (1, 1, 1), periodic x>
        """
        return Domain(**{**self._keywords(), **keywords})

    def _keywords(self) -> Any:
        """Returns the short forms of the domain, without an origin of 0, which no cell needs."""
        values = dict(self._values)
        if self.origin is not None and not self.origin.any():
            del values["origin"]
        if self.limits is not None:
            values["box"] = self.limits.ravel()  # (2, 2) could be read in two ways
        return values

    @property
    def dimensions(self) -> Optional[int]:
        """2 or 3; None for a domain in which points of either are right."""
        return next(iter(self._sizes.values()), None)

    @property
    def periodic(self) -> Tuple[bool, ...]:
        """Whether it repeats along x, y, z, or along the edges of a cell. Two flags in the plane."""
        repeats = self._values.get("periodic", False)
        return (repeats,) * (self.dimensions or 3) if isinstance(repeats, bool) else repeats

    @property
    def walls(self) -> Float64Array:
        """(M, 4) float64 rows nx, ny, nz, d, in the plane (M, 3) rows nx, ny, d. Those of a hull depend on the points."""
        walls: Optional[Float64Array] = self._values.get("walls")
        return np.empty((0, (self.dimensions or 3) + 1)) if walls is None else walls

    @property
    def outside(self) -> OutsideWord:
        """What happens to points outside: "error", "drop" or "keep"."""
        word: OutsideWord = self._values.get("outside", "error")
        return word

    @property
    def limits(self) -> Optional[Float64Array]:
        """(2, 3) float64, lower and upper corner of a box, in the plane (2, 2); None for other domains."""
        box = self._values.get("box")
        return None if isinstance(box, str) else box

    @property
    def vectors(self) -> Optional[Float64Array]:
        """(3, 3) float64, the edges of a triclinic box as rows, in the plane (2, 2); None for other domains."""
        return self._values.get("cell")

    @property
    def origin(self) -> Optional[Float64Array]:
        """(3,) float64, the corner of a triclinic box, in the plane (2,); None for other domains."""
        return self._values.get("origin")

    @property
    def surface(self) -> Optional[Tuple[Float64Array, Int32Array]]:
        """(V, 3) float64 vertices and (T, 3) int32 triangles of the mesh, in the plane (V, 2) and (E, 2) edges; else None."""
        return self._values.get("mesh")

    @property
    def is_hull(self) -> bool:
        """Whether it is the convex hull of the points."""
        box = self._values.get("box")
        return isinstance(box, str) and box == "hull"

    @property
    def _has_ends(self) -> bool:
        """Whether a box or a cell is given; else the box is the default one around the points."""
        return "box" in self._values or "cell" in self._values

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a Domain does not change: use replace() instead of setting {name}")

    def __reduce__(self) -> Any:
        return domain_of, (self._keywords(),)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Domain):
            return NotImplemented
        ours, theirs = self._values, other._values
        return ours.keys() == theirs.keys() and all(_equal(value, theirs[name]) for name, value in ours.items())

    def __hash__(self) -> int:
        box = self.limits
        return hash((frozenset(self._values), self.periodic, self.outside, None if box is None else tuple(box.ravel().tolist())))

    def _text(self) -> str:
        box = self._values.get("box")
        where = text_of_domain(box, self.vectors, self.origin, len(self.walls), self.periodic)
        if not self._has_ends:
            where = "default " + where
        if self.surface is not None:
            parts = "triangles" if self.surface[1].shape[1] == 3 else "edges"
            where = f"mesh of {len(self.surface[1])} {parts} in a {where}"
        return where + ("" if self.outside == "error" else f", outside {self.outside}")

    def __repr__(self) -> str:
        return f"<pyvotess.Domain: {self._text()}>"

    def _fill(self, options: _c_api.Struct, points: Optional[npt.NDArray[Any]]) -> None:
        """Sets the domain in the options, whose ``planar`` is set.

        ``points``: all of them, None if they come in parts. Then the caller makes the walls of a hull.
        """
        d = 2 if options.planar else 3
        for name, size in self._sizes.items():
            if size != d:
                raise ValueError(f"{name} has {size} dimensions, but points have {d}: give both the same")
        box, walls = self._values.get("box"), self._values.get("walls")
        if box is not None and not self.is_hull:
            lower, upper = ((-np.inf,) * d, (np.inf,) * d) if isinstance(box, str) else box.tolist()
            options.has_box, options.box_lower[:d], options.box_upper[:d] = 1, lower, upper
        repeats = self._values.get("periodic", False)
        flags = (repeats,) * d if isinstance(repeats, bool) else repeats
        if self.vectors is None:
            options.periodic[: len(flags)] = flags
        else:
            options.has_cell, options.cell_periodic[:] = 1, (False,) * 3
            options.cell_periodic[: len(flags)] = flags
            for edge, vector in zip((options.cell_a, options.cell_b, options.cell_c), self.vectors.tolist()):
                edge[:d] = vector
            options.cell_origin[:d] = self._values["origin"].tolist()
        if walls is not None:
            options.walls, options.wall_count = np.insert(walls, 2, 0.0, axis=1) if d == 2 else walls, len(walls)
        if self.surface is not None:
            vertices, triangles = self.surface
            options.has_mesh = 1
            options.mesh_vertices, options.mesh_vertex_count = vertices, len(vertices)
            options.mesh_triangles, options.mesh_triangle_count = triangles, len(triangles)
            options.mesh_merge = int("mesh_repair" in self._values)
            options.mesh_tolerance = self._values.get("mesh_tolerance", 0.0)
        options.outside = _c_api.OUTSIDE[self.outside]
        if self.is_hull and points is not None:
            given = np.require(points, np.float64, ["C_CONTIGUOUS", "ALIGNED"])
            hull = Handle("hull")
            run(lib.votess_hull_new, given, len(given), options, hull, options=options)
            facets = hull.array("walls")
            options.walls, options.wall_count = facets, len(facets)


def domain_of(keywords: Any) -> Domain:
    """Returns the domain of these short forms, which is checked when cells are made."""
    domain = Domain.__new__(Domain)
    domain._set(keywords)
    return domain


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return np.array_equal(a, b)
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(_equal(*pair) for pair in zip(a, b))
    return type(a) is type(b) and bool(a == b)


DomainLike = Union[Domain, "npt.ArrayLike"]  # a domain, or a box


def as_domain(domain: Any, keywords: Any, name: str = "domain") -> Domain:
    """Returns the domain of a call: the given one, a given box with short forms, or that of the short forms alone."""
    if domain is None:
        return domain_of(keywords)
    if not isinstance(domain, Domain):
        if not isinstance(domain, (list, tuple, np.ndarray)):
            raise TypeError(f"{name} is {shown(domain)}: give a pyvotess.Domain, a box, or box=, cell= or mesh=")
        if keywords.get("box") is not None:
            raise ValueError(f"box and {name} are both given: leave one out")
        return domain_of({**keywords, "box": as_box(domain, name).ravel()})
    _checked(keywords)
    for short, value in keywords.items():
        if value is not None:
            raise ValueError(f"{short} and domain are both given: put {short} into the domain, or leave domain out")
    return domain


def take_domain(options: Dict[str, Any]) -> Domain:
    """Takes the domain and the short forms out of the options, and returns the domain of the call."""
    short = {name: options.pop(name) for name in SHORT_FORMS if name in options}
    return as_domain(options.pop("domain", None), short)
