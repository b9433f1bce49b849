"""The network of vertices and edges, see :meth:`pyvotess.Tessellation.network`."""

from __future__ import annotations

import ctypes
import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Tuple, Union

import numpy as np

from ._arguments import as_axis, as_number, counted
from ._call import Handle, WithHandle, raise_on_failure, watched
from ._input import as_one_each
from ._library import lib
from .pairs import edges_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._state import SeedCells
    from ._types import BoolArray, Float64Array, Int8Array, Int32Array
    from .export.image import Image


class IncludedSphere(NamedTuple):
    """A sphere at a vertex."""

    radius: float  #: of the sphere
    vertex: int  #: its center, a row of ``points``


class FreeSphere(NamedTuple):
    """A sphere that moves along edges to an image of itself, and beyond."""

    radius: float  #: of the sphere
    edge: int  #: where it has least room, a row of ``edges``
    included: IncludedSphere  #: the largest sphere at the vertices that it reaches


@dataclass(frozen=True, eq=False)
class Network(WithHandle):
    """V vertices and E edges of a diagram. In a periodic domain each occurs once, not for each image.

    The radius of a place is its distance to the nearest seed. With ``radii`` or ``weights`` seeds are spheres, and
    distances end at their surfaces. If radii differ, the places with most room are near vertices and edges of the power
    diagram, not on them: largest spheres are lower bounds then. Inside of spheres distances are negative; where several
    overlap, it is that of a seed whose cell is there.
    """

    points: Float64Array  #: (V, 3) the vertices, (V, 2) in the plane; beyond the box where a cell reaches beyond it
    vertices: Int32Array  #: (V,) ascending rows of ``t.vertices``: the first that each one stands for
    vertex_radii: Float64Array  #: (V,) radius of the largest sphere at each vertex
    at_walls: BoolArray  #: (V,) True for a vertex on a wall
    edges: Int32Array  #: (E, 2) vertices, the lower one first; in ascending order
    shifts: Optional[Int8Array]  #: (E, 3) box vectors from the second vertex to where the edge ends; None unless periodic
    vectors: Float64Array  #: (E, 3) from the first vertex to the other end
    edge_radii: Float64Array  #: (E,) smallest radius along each edge: of the largest sphere that can pass it
    _handle: Optional[Handle] = field(repr=False, compare=False)

    def __repr__(self) -> str:
        return f"<pyvotess.Network: {len(self.points)} {'vertex' if len(self.points) == 1 else 'vertices'}, {counted(len(self.edges), 'edge')}>"

    def _repr_html_(self) -> str:
        """Returns a table for notebooks, and a small picture."""
        from .export.html import html_of_network

        return html_of_network(self)

    @property
    def lengths(self) -> Float64Array:
        """(E,) lengths of the edges, as a new array."""
        lengths: Float64Array = np.sqrt(np.einsum("ek,ek->e", self.vectors, self.vectors))
        return lengths

    def largest_included(self) -> IncludedSphere:
        """Returns the largest sphere that fits between the seeds. Twice its radius is Di of Zeo++.

        Raises ValueError for an empty network.

        >>> sphere = t.network().largest_included()
        >>> 0 < sphere.radius < 1
        True
        """
        radius, vertex = ctypes.c_double(), ctypes.c_int32()
        raise_on_failure(watched(lib.votess_network_largest_included, self._pointer("network()"), radius, vertex))
        if vertex.value < 0:
            raise ValueError("the network has no vertices, so no sphere")
        return IncludedSphere(radius.value, vertex.value)

    def largest_free(self, axis: Optional[int] = None) -> FreeSphere:
        """Returns the largest sphere that can travel without end. Twice its radius is Df of Zeo++; twice that of
        ``included`` is Dif.

        axis : 0, 1 or, in space, 2: only travels along this box vector count. Default: any travel counts.

        A negative radius means that spheres close all ways. Raises ValueError for another axis, and where no way goes on
        without end: along an axis that is not periodic.

        >>> n = vt.tessellate(points, box=box, periodic=True, want="faces").network()
        >>> n.largest_free().radius <= n.largest_included().radius
        True
        """
        radius, edge, included, vertex = ctypes.c_double(), ctypes.c_int32(), ctypes.c_double(), ctypes.c_int32()
        out = (radius, edge, included, vertex)
        raise_on_failure(watched(lib.votess_network_largest_free, self._pointer("network()"), as_axis(axis, "axis"), *out))
        if edge.value < 0:
            along = "" if axis is None else f" along axis {axis}"
            raise ValueError(f"no edges lead to an image of themselves{along}: give a domain that is periodic there")
        return FreeSphere(radius.value, edge.value, IncludedSphere(included.value, vertex.value))

    def image(
        self,
        file: Union[None, str, os.PathLike[str]] = None,
        *,
        color: Union[str, npt.ArrayLike] = "radius",
        width: Optional[float] = None,
        colormap: str = "tide",
        cut: str = "none",
        view: Tuple[float, float] = (36.0, 27.0),
        size: Tuple[int, int] = (800, 600),
        limits: Optional[Tuple[float, float]] = None,
        threads: int = 0,
    ) -> Image:
        """Returns a picture of the edges that the library draws. Other arguments are those of :meth:`Tessellation.image`.

        color : "radius", the smallest radius along each edge, or (E,) values; NaN is gray.
        width : of an edge, a length. Default: a 150th of the network's longest side.

        Raises ValueError in the plane, without edges, and for values that do not fit; OSError when the file cannot be
        written.

        >>> t.network().image(size=(200, 150))
        <pyvotess image of 200 x 150 pixels>
        """
        from .export.image import image_of_pieces
        from .export.tubes import tubes

        if self.points.shape[1] == 2:
            raise ValueError("image() works in three dimensions only: draw the edges with matplotlib")
        if not len(self.edges):
            raise ValueError("image(): the network has no edges to draw")
        radius = isinstance(color, str) and color == "radius"
        if isinstance(color, str) and not radius:
            raise ValueError(f"color is {color!r}: give 'radius', or a value for each of the {len(self.edges)} edges")
        values = as_one_each(self.edge_radii if radius else color, "color", len(self.edges), "edges")
        begin = self.points[self.edges[:, 0]]
        across = float(np.ptp(np.concatenate([begin, begin + self.vectors]), axis=0).max()) / 150
        thick = across if width is None else as_number(width, "width")
        if not 0 < thick < np.inf:
            raise ValueError(f"width is {thick}: give a length above 0")
        look = dict(colormap=colormap, cut=cut, view=view, size=size, limits=limits, threads=threads)
        return image_of_pieces(tubes(begin, self.vectors, thick), values, "radius" if radius else "", file, False, **look)

    def to_networkx(self) -> Any:
        """Returns a networkx.MultiGraph. Vertices have ``x``, ``y``, in space ``z``, and ``radius``; edges ``radius``, ``length``, ``shift``.

        A shift counts from the lower vertex to the higher one, and is missing unless periodic. A vertex with an edge to
        its own image has an edge to itself.

        >>> n = t.network()
        >>> n.to_networkx().number_of_edges() == len(n.edges)
        True
        """
        from .export.packages import network_to_networkx

        return network_to_networkx(self)

    def to_openpnm(self) -> Any:
        """Returns an openpnm.network.Network: pores are vertices, throats are edges.

        It has ``pore.inscribed_diameter`` and ``throat.inscribed_diameter``, twice the radii and at least 0;
        ``throat.length``; and the labels ``pore.surface`` for vertices on walls and ``throat.periodic`` for edges across
        the boundary.

        >>> n = t.network()
        >>> n.to_openpnm().Np == len(n.points)
        True
        """
        from .export.packages import network_to_openpnm

        return network_to_openpnm(self)


def make_network(t: SeedCells, result: Handle) -> Network:
    points = np.ascontiguousarray(t.points, dtype=np.float64)
    handle = Handle.made("network", lib.votess_network_new, result, points, len(points))
    places, edges = handle.array("points"), handle.array("edges")
    vectors = places[edges[:, 1]] - places[edges[:, 0]]
    shifts = None
    if any(t.periodic):
        shifts = handle.array("shifts")
        moved = shifts.any(axis=1)
        vectors[moved] += shifts[moved] @ edges_of(t)
    return Network(
        **handle.arrays("vertices", "vertex_radii", "edge_radii"),
        points=places,
        at_walls=handle.array("at_walls").view(np.bool_),
        edges=edges,
        shifts=shifts,
        vectors=vectors,
        _handle=handle,
    )
