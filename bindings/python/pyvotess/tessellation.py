"""The result: arrays in the library's memory, and what is known about them."""

from __future__ import annotations

import ctypes
import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Mapping, Optional, Tuple, Union

import numpy as np

from ._c_api import ErrorCode
from ._call import Handle, VotessError, array_of, raise_on_failure
from ._input import Domain
from ._library import lib
from ._run import new_options, tessellate_points
from ._state import SeedCells, read_result, same_arrays
from .mesh import Delaunay, make_delaunay
from .pairs import Pairs, make_derivatives, make_pairs
from .stats import VerifyReport, verify

if TYPE_CHECKING:
    import numpy.typing as npt


class Tessellation(SeedCells):
    """The cells of N seeds; rows follow the input order.

    Arrays are read-only and lie in the library's memory, which lives as long as any of them. An array that was not
    wanted raises AttributeError.
    """

    def __copy__(self) -> Tessellation:
        """Shares all arrays, which are read-only."""
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)
        return other

    def _handle(self) -> Handle:
        """The library's object; of an unpickled result it is made anew, with the same arrays."""
        if self._result is None:
            result, differs = self._tessellated_again()
            if differs:
                raise VotessError(
                    f"this result was unpickled, and its points give other {differs} when they are tessellated again",
                    ErrorCode.INVALID_USE,
                )
            self._result = result
        return self._result

    def _tessellated_again(self) -> Tuple[Handle, str]:
        """The library's object for the same points, from the CPU, and the name of an array that differs, or ""."""
        options = new_options("cpu", 0)
        box = self.box if self._domain_given and self.cell is None else None
        domain = Domain(box, self.periodic, self.weights, None, self.cell, self.origin, self.walls, outside="drop")
        want: Any = self.wanted
        result, _, wanted = tessellate_points(
            None, options, self.points, domain, want, self.lists_walls, "merge", None, 0.0, self.least_face
        )
        return result, same_arrays(self._data, read_result(result, wanted))

    def __repr__(self) -> str:
        wanted = ", ".join(self._wanted) or "status only"
        copies = self.stats.duplicates
        seeds = f"{len(self)} seeds" + (f", {copies} duplicate{'s' if copies > 1 else ''}," if copies else "")
        tiny = f"; {self.stats.tiny_faces} tiny faces, see min_face" if self.stats.tiny_faces else ""
        return f"<pyvotess.Tessellation of {seeds} in a {self._domain()}: {wanted}{tiny}>"

    def _repr_html_(self) -> str:
        """For notebooks: a table, and a picture of a section when the faces were wanted."""
        from .export.html import as_html

        return as_html(self)

    def delaunay(self) -> Delaunay:
        """The dual Delaunay complex. Needs "faces" in want.

        After ``min_face`` or ``min_area`` the corners that dropped faces joined are one, so that a rounded lattice has
        the polytopes of the lattice. ValueError where a face that was not dropped would shrink too, or a corner would
        meet its own image: then give a smaller ``min_face``.
        """
        handle = Handle(lib.votess_delaunay_free)
        raise_on_failure(lib.votess_delaunay_new(self._handle().pointer, ctypes.byref(handle.pointer)))
        return make_delaunay(
            lambda name, dtype: array_of(handle, name, dtype, prefix="votess_delaunay_"), self.shifts is not None
        )

    def pairs(self) -> Pairs:
        """All entries of the rows but walls, so that each pair of neighbors is there from both sides."""
        return make_pairs(self)

    def derivatives(self, of: str = "volumes", by: str = "points") -> Any:
        """How volumes or face areas change with the seeds: a ``scipy.sparse.csr_matrix``. Needs "faces" in want.

        ``of="volumes"`` has N rows, ``of="areas"`` one for each entry of ``neighbors.indices``. ``by="points"`` has 3 N
        columns, 3 j + axis for that coordinate of seed j; ``by="weights"`` has N, at the weights that there are, 0 in a
        Voronoi diagram. Walls stay where they are, the vectors of a periodic domain too. In closed form, from areas,
        centroids and edges of faces; where more cells meet than in general position, as in a lattice, areas have no
        derivative, and the one of the polygons at hand is given.
        """
        return make_derivatives(self, of, by)

    def plot(
        self,
        slice: Optional[Tuple[str, float]] = None,
        color: Union[str, npt.ArrayLike] = "volume",
        ax: Any = None,
        **style: Any,
    ) -> Any:
        """Shows the cells; needs "faces" in want, and volumes unless another color is given.

        ``slice=("z", 0.5)`` draws the section by that plane with matplotlib, into ``ax`` or a new figure, and returns
        the axes. Without a slice PyVista, where it is installed, shows the cells in space without those of one octant,
        and the plotter is returned (``t.plot().show()``); else the section through the middle is drawn.
        ``color``: "volume", "neighbors", "area", "x", "y", "z", or one value for each cell. ``style`` goes to
        matplotlib's PolyCollection or to PyVista's add_mesh, such as ``cmap="magma"``.
        """
        from .export.plot import plot

        return plot(self, slice, color, ax, **style)

    def save(
        self,
        path: Union[str, os.PathLike[str]],
        columns: Optional[Mapping[str, npt.ArrayLike]] = None,
        color: Any = None,
        colormap: str = "tide",
    ) -> None:
        """Writes the result into a file, whole or not at all, as its extension says; names are those of clvotess.

        ``.npz``, ``.h5``, ``.hdf5`` hold the arrays that were wanted, the domain and the version. The others need
        "faces" in want: ``.vtu`` polyhedra with id, volume, neighbors, centroid and status, without empty cells and
        ascending by their number of vertices, as meshio needs them, so that ``id`` tells the seed; ``.ply`` and ``.obj`` the
        faces, each once, in ``.ply`` with its two cells; ``.glb`` solids in colors, about 830 bytes a cell of random
        points and 4 GiB at most.

        ``columns``: further values of the cells by name, (N,) or (N, k), for .npz, .h5 and .vtu.
        ``color``: for .ply, which then holds triangles, and .glb: a column of :meth:`to_dataframe`, (N,) values, or
        (N, 3) red, green and blue as uint8 or from 0 to 1. Default: none, and the volumes in .glb.
        ``colormap``: "tide", "ember" or "gray".
        """
        from .export.save import save

        save(self, path, columns, color, colormap)

    def to_dataframe(self) -> Any:
        """A pandas.DataFrame, a row a seed: x, y, z, and a column for each number that is known of its cell."""
        from .export.packages import to_dataframe

        return to_dataframe(self)

    def to_scipy(self) -> Any:
        """The same as ``neighbors.to_scipy()``."""
        return self.neighbors.to_scipy()

    def to_networkx(self) -> Any:
        """A networkx.Graph of the seeds, which have the columns of :meth:`to_dataframe`, and pairs of neighbors.

        An edge has the least ``distance`` of the seeds' images that touch, their number of ``faces``, and the sum of
        their ``area`` where "areas" was wanted. A seed that touches its own image has an edge to itself.
        """
        from .export.packages import to_networkx

        return to_networkx(self)

    def to_freud(self) -> Any:
        """A freud.locality.NeighborList, float32, an entry for each of :meth:`pairs`. Needs "areas" in want.

        Its vectors and distances are those of the pairs, its weights the areas of the faces.
        """
        from .export.packages import to_freud

        return to_freud(self)

    def to_pyvista(self, columns: Optional[Mapping[str, npt.ArrayLike]] = None) -> Any:
        """A pyvista.UnstructuredGrid, cell i the polyhedron of seed i, or an empty cell. Needs "faces" in want.

        Its cell data are those of the .vtu file of :meth:`save`, and ``columns``.
        """
        from .export.packages import to_pyvista

        return to_pyvista(self, columns)

    def verify(self, sample: Optional[int] = None, rng_seed: int = 1) -> VerifyReport:
        """Checks this result against its points.

        Volumes sum to the box (relative 1e-9; 1e-4 when ``stats.precision`` is "single"), neighbor lists are symmetric,
        Euler's formula holds, and ``sample`` cells drawn with ``rng_seed`` equal cells cut anew by every seed; None takes
        as many as take about a second, at least 64 or all, a number that depends on the input alone. Checks whose
        arrays were not wanted are skipped. ``tiny_faces`` of the report counts faces far smaller than the mean, see
        :class:`Stats`; where they are not known, the points are tessellated again. A result that was unpickled is compared with its points tessellated again.
        """
        points = np.ascontiguousarray(self._points, dtype=np.float64)
        try:
            handle = self._handle()
        except VotessError as error:
            if error.code != ErrorCode.INVALID_USE:
                raise
            return VerifyReport(False, str(error), ())
        seeds = (handle.pointer, points.ctypes.data, len(points))
        report = verify(lib.votess_verify, seeds, sample, rng_seed)
        tiny = ctypes.c_uint64()
        raise_on_failure(lib.votess_count_tiny_faces(*seeds, ctypes.byref(tiny)))
        return replace(report, tiny_faces=tiny.value)
