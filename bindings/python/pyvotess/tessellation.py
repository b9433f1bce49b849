"""The result of a run: arrays in the library's memory, files, pictures and further computations."""

from __future__ import annotations

import os
from functools import partial
from typing import TYPE_CHECKING, Any, Dict, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from ._arguments import as_flag, as_number, counted
from ._c_api import ErrorCode
from ._call import Handle, Progress, VotessError, watched
from ._input import as_labels, as_one_each
from ._library import lib
from ._run import new_options, tessellate_points
from ._state import SeedCells, differing_array, read_result
from .alpha import AlphaComplex, make_alpha
from .derivatives import make_derivatives
from .groups import Groups, read_groups
from .masses import Masses, masses_of
from .mesh import Delaunay, make_delaunay
from .network import Network, make_network
from .pairs import Pairs, make_pairs
from .pieces import Pieces, make_pieces
from .stats import MeshQuality, VerifyReport, as_sample, verify
from .zones import Zones, read_zones

if TYPE_CHECKING:
    import numpy.typing as npt

    from .export.image import Image
    from .fields.shapes import Shapes
    from .export.viewer import View


class Tessellation(SeedCells):
    """The cells of N seeds, in the input order.

    Arrays are read-only views of the library's memory, which lives as long as any of them. An array that is not in
    ``want`` raises AttributeError.
    """

    def __copy__(self) -> Tessellation:
        """Returns a copy that shares all arrays."""
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)
        return other

    def _handle(self) -> Handle:
        """Returns the library's object. For an unpickled result it tessellates the points again."""
        if self._result is None:
            result, differs = self._tessellated_again()
            if differs:
                raise VotessError(
                    f"this result was unpickled, and tessellating its points again gives different {differs}",
                    ErrorCode.INVALID_USE,
                )
            self._result = result
        return self._result

    def _arguments(self, **changed: Any) -> Dict[str, Any]:
        """Returns the arguments of the run, by name."""
        given: Dict[str, Any] = dict(
            points=self.points, domain=self.domain, weights=self.weights if self.ids is None else self._seed_weights,
            radii=None, only=self.ids, want=self.wanted,
            list_walls=self.lists_walls, min_area=self.least_face, progress=None,
        )  # fmt: skip
        given.update(changed)
        return given

    def _tessellated_again(self) -> Tuple[Handle, str]:
        """Returns a new object of the library for the same points, and the name of an array that differs, or ""."""
        result, _, wanted, *_ = tessellate_points(None, new_options(device="cpu"), self._arguments())
        places = self.wrapped_points if self.ids is None else self.wrapped_points[self.ids]
        return result, differing_array(self._data, read_result(result, wanted), places)

    def _with_all_faces(self) -> Tessellation:
        """Returns the result without ``min_face`` and ``min_area``."""
        made = tessellate_points(None, new_options(device="cpu"), self._arguments(min_area=0.0))
        return type(self)(*made)

    def __repr__(self) -> str:
        wanted = ", ".join(self._wanted) or "status only"
        copies = self.stats.duplicates
        seeds = counted(len(self), 'seed') + (f", {copies} duplicate{'s' if copies > 1 else ''}," if copies else "")
        tiny = f"; {self.stats.tiny_faces} tiny faces, see min_face" if self.stats.tiny_faces else ""
        return f"<pyvotess.Tessellation of {seeds} in a {self._where()}: {wanted}{tiny}>"

    def _repr_html_(self) -> str:
        """Returns a table for notebooks, and with faces a picture of a section."""
        from .export.html import as_html

        return as_html(self)

    def delaunay(self) -> Delaunay:
        """Returns the dual Delaunay complex. Needs "faces" in want.

        In the plane it has triangles and polygons.

        With ``min_face`` or ``min_area`` the corners of a dropped face become one, so a rounded lattice has the polytopes
        of the lattice. Raises ValueError if this would collapse a face that was kept, or join a corner with its own
        image: then give a smaller ``min_face``.

        >>> t.delaunay().tetrahedra.shape[1]
        4
        """
        handle = Handle.made("delaunay", lib.votess_delaunay_new, self._handle())
        return make_delaunay(handle, self.box.shape[1], self.shifts is not None)

    def network(self) -> Network:
        """Returns the vertices and edges of the diagram with the room that they have between seeds. Needs "faces" in want.

        It is a network of pores, as Zeo++ makes it of crystals: give the atoms' ``radii``. Vertices that are equal in exact
        arithmetic are one. With ``min_face`` or ``min_area`` those of a dropped face are too, as in :meth:`delaunay`. Edges
        to infinity are left out.

        Raises ValueError for negative weights, with ``only``, and where :meth:`delaunay` refuses dropped faces.

        >>> t.network()
        <pyvotess.Network: 558 vertices, 1112 edges>
        """
        return make_network(self, self._handle())

    def pieces(
        self, gap: float = 0.0, threads: int = 0, progress: Union[None, bool, Progress] = None
    ) -> Pieces:
        """Returns the connected parts of the cells as closed triangle meshes. Needs ``mesh``.

        gap : moves the planes of each cell inward by half of this length, so that pieces are this far apart. The surface
            of the mesh stays.
        threads, progress : as for :func:`tessellate`.

        Without a gap, volumes of the pieces sum to those of the cells. Raises ValueError without ``mesh`` and for a negative
        gap.

        >>> corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        >>> solid = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        >>> pieces = vt.tessellate(points, mesh=solid, want="volumes").pieces()
        >>> round(float(pieces.volumes.sum()), 6)
        0.166667
        """
        return make_pieces(self, self._handle(), gap, threads, progress)

    def alpha_complex(self, replicate: Union[int, Sequence[int]] = 1) -> AlphaComplex:
        """Returns the alpha complex of the seeds: Delaunay simplices with the squared radii at which they appear.

        Seeds lie in whole space or the whole plane, which repeats along the periodic axes. Other bounds, walls and
        ``min_face`` change nothing.
        With ``weights`` or ``radii`` values are power distances: seed i appears at minus its weight. Duplicates, dropped
        seeds, and seeds that weights hide are left out. ``box="none"`` or a periodic box, with "faces" in want, saves
        tessellating again.

        replicate : one number for the vectors that repeat, or one for each: how many copies of a periodic box to take. Copy (i, j, k) of seed
            s has the id ``s + N * ((i * replicate[1] + j) * replicate[2] + k)``. The seed itself, as it lies inside the box,
            is copy (0, 0, 0).

        Raises ValueError if two edges join the same seeds, or one joins a seed to its own image: then give ``replicate``,
        mostly 2 or 3. Also with ``only`` or a mesh.

        >>> a = vt.tessellate(points, box="none", want="faces").alpha_complex()
        >>> len(a.simplices[0]), a.simplices[3].shape[1]
        (100, 4)
        """
        return make_alpha(self, self._handle(), replicate)

    def pairs(self) -> Pairs:
        """Returns all entries of the rows except walls. Each pair of neighbors occurs from both sides.

        >>> pairs = t.pairs()
        >>> bool(np.isclose(pairs.distance, np.linalg.norm(pairs.vector, axis=1)).all())
        True
        """
        self._check_whole()
        return make_pairs(self)

    def watershed(self, values: npt.ArrayLike, maxima: bool = False) -> Zones:
        """Returns the zones of values of the cells, as ZOBOV makes them from densities. Needs "neighbors" in want.

        Steps from each cell lead to its lowest neighbor until they reach a minimum. The cells that reach the same one are a
        zone. Equal values are ordered by seed, so threads never change the answer.

        values : (N,) numbers. Infinity keeps a cell from being a minimum, unless all of its neighbors have it too. Values
            of seeds without a cell are ignored.
        maxima : steps lead to the highest neighbor.

        Raises ValueError for NaN, which names its row, for another number of values, and with ``only``.

        >>> t.watershed(t.volumes)
        <pyvotess.Zones: 10 zones of 100 cells>
        """
        self._check_wanted("neighbors")
        array = as_one_each(values, "values", len(self), "cells")
        falls = as_flag(maxima, "maxima")
        handle = Handle.made("zones", lib.votess_zones_new, self._handle(), array, len(array), falls)
        return read_zones(handle, self.lists_walls, falls)

    def groups(self, labels: npt.ArrayLike) -> Groups:
        """Returns sums of the cells by group: molecules, residues, grains, clusters. Needs "neighbors" in want.

        Each group has the groups that it touches, with the number of faces between them and their area. Faces between cells of
        one group are inside it, also across a periodic boundary.

        labels : (N,) whole numbers, one for each cell. Equal numbers make a group.

        ``areas`` needs "areas" in want, ``surface_areas`` needs "areas,surfaces", and ``volumes`` "volumes". Raises
        ValueError for another number of labels, and with ``only``.

        >>> groups = t.groups(np.arange(100) // 10)
        >>> round(float(groups.volumes.sum()), 6)
        1.0
        """
        self._check_wanted("neighbors")
        array = as_labels(labels, "labels", len(self), "cells")
        return read_groups(Handle.made("groups", lib.votess_groups_new, self._handle(), array, len(array)))

    def masses(self, density: npt.ArrayLike, threads: int = 0) -> Masses:
        """Returns masses, centers of mass and second moments of the cells under a density. Needs "faces" in want.

        The integrals are exact up to rounding: the grid cuts the cells, nothing is sampled. :func:`fit_volumes` finds cells of
        given masses.

        density : (nx, ny, nz) array of numbers >= 0, in the plane (nx, ny): constant in the boxes of a grid over the domain, as
            that of :meth:`Diagram.to_grid`, with x first. Turn an image whose rows run down by ``image[::-1].T``.
        threads : as for :func:`tessellate`.

        Raises ValueError in a mesh, and for cells that reach infinity.

        >>> print(t.masses(np.arange(8).reshape(2, 2, 2)).masses.sum().round(6))
        3.5
        """
        if not self.in_mesh:
            self._check_wanted("faces")
        whole = self if self.least_face == 0 else self._with_all_faces()
        return masses_of(whole._handle(), 2 if self.planar else 3, density, threads)

    def shapes(self, open: Optional[str] = None) -> Shapes:
        """Returns sphericity, aspect ratio and axes of each cell. Needs "faces" in want, but not in a mesh.

        The axes are those of the ellipsoid with the same second moments, in the plane of the ellipse. In a mesh they are those
        of the part of the cell inside. Cells that reach infinity are refused; ``open="skip"`` leaves their rows nan. Corners are
        rounded as ``vertices``, so a cell much smaller than its coordinates has fewer digits than in ``volumes``.

        >>> shapes = t.shapes()
        >>> bool((shapes.sphericity < 1).all())
        True
        """
        from .fields.shapes import make_shapes

        return make_shapes(self if self.least_face == 0 else self._with_all_faces(), open)

    def mesh_quality(self, open: Optional[str] = None, min_edge: float = 0.0) -> MeshQuality:
        """Returns how well the cells suit solvers, as OpenFOAM's checkMesh measures it. Needs "faces" in want, except in a mesh.

        ``open``: "skip" leaves out cells that reach infinity, which else are refused. ``min_edge``: as for :meth:`save`. In a
        mesh these are the numbers of its pieces. Raises ValueError in the plane, with ``only``, and where ``min_face`` or
        ``min_area`` dropped faces.

        >>> t.mesh_quality().wrong_cells
        0
        """
        self._check_whole()
        from .export.geometry import mesh_of
        from .export.mesh_file import mesh_quality

        if self.in_mesh and not self.planar:
            return self.pieces().mesh_quality(min_edge)
        mesh_of(self, "mesh_quality()", False, True, open)
        return mesh_quality(self, open is not None, as_number(min_edge, "min_edge"))

    def derivatives(self, of: str = "volumes", by: str = "points", open: Optional[str] = None) -> Any:
        """Returns derivatives of volumes or face areas as a ``scipy.sparse.csr_matrix``. Needs "faces" in want.

        Derivatives of volumes by weights need only "areas".

        Rows: N with ``of="volumes"``; one for each entry of ``neighbors.indices`` with ``of="areas"``. Columns: 3 N with
        ``by="points"``, column 3 j + axis for a coordinate of seed j, in the plane 2 N; N with ``by="weights"``. In a
        Voronoi diagram the weights are 0. Walls and the vectors of a periodic domain are fixed. The derivatives are in closed form. Where
        more cells meet than in general position, as in a lattice, areas have no derivative; those of the present
        polygons are returned.

        Cells that reach infinity are refused. ``open="skip"`` leaves their rows empty, and those of their faces;
        ``open_cells`` names them.

        In a ``mesh`` those of volumes follow from :meth:`pieces`, without "faces". The surface stays where it is. A domain
        that repeats has those by weights only, and "areas" in want.

        >>> t.derivatives(by="points").shape
        (100, 300)
        """
        self._check_whole()
        return make_derivatives(self, of, by, open)

    def plot(
        self,
        slice: Optional[Tuple[str, float]] = None,
        color: Union[str, npt.ArrayLike] = "volume",
        ax: Any = None,
        **style: Any,
    ) -> Any:
        """Plots the cells. Needs "faces" in want, and "volumes" unless another color is given.

        Cells of the plane need "vertices" instead, and are drawn with matplotlib.

        ``slice=("z", 0.5)`` draws a plane section with matplotlib, into ``ax`` or a new figure, and returns the axes.
        Without a slice, PyVista shows the cells in space, without those of one octant, and the plotter is returned
        (``t.plot().show()``). Without PyVista the section through the middle is drawn. In a ``mesh`` PyVista shows the
        pieces, and a slice those that it cuts.

        ``color``: "volume", "neighbors", "area", "x", "y", "z", or (N,) values.
        ``style``: arguments of matplotlib's PolyCollection or PyVista's add_mesh, such as ``cmap="magma"``.

        >>> axes = t.plot(slice=("z", 0.5))
        >>> axes.figure.savefig("section.png")
        """
        self._check_whole()
        from .export.plot import plot

        return plot(self, slice, color, ax, **style)

    def image(
        self,
        file: Union[None, str, os.PathLike[str]] = None,
        *,
        color: Union[str, npt.ArrayLike] = "volume",
        colormap: str = "tide",
        slice: Optional[Tuple[str, float]] = None,
        cut: str = "corner",
        view: Tuple[float, float] = (36.0, 27.0),
        size: Tuple[int, int] = (800, 600),
        limits: Optional[Tuple[float, float]] = None,
        seeds: bool = False,
        gap: float = 0.0,
        open: Optional[str] = None,
        threads: int = 0,
    ) -> Image:
        """Returns a picture that the library draws: the cells cut open, a section, or in a ``mesh`` or polygons the pieces.

        Needs "faces" in want, except in a mesh, and "volumes" unless another color is given. Notebooks show the picture; its
        ``pixels`` are an array.

        file : a ``.png`` to write.
        color : "volume", "neighbors", "area", "x", "y", "z", or (N,) values; NaN is gray.
        colormap : "tide", "ember" or "gray".
        slice : ``("z", 0.5)`` draws a plane section with axes. Cells of the plane are drawn so without it.
        cut : the part that is cut away: the "corner" or "half" in front, whole "cells" in that corner, or "none".
        view : azimuth and elevation of the camera in degrees.
        size : width and height in pixels, 64 to 16384 each.
        limits : of the colors; default: those of nearly all cells shown.
        seeds : with a slice or in the plane, draw the points near it as dots.
        gap : between the pieces of cells in a mesh, as for :meth:`pieces`.
        open : "skip" leaves out cells that reach infinity, which else are refused; ``left_out`` of the picture counts them.
        threads : 0 for all. Pixels do not depend on it.

        Raises ValueError for missing arrays and values that do not fit; OSError when the file cannot be written.

        >>> t.image(slice=("z", 0.5), size=(200, 150))
        <pyvotess image of 200 x 150 pixels>
        """
        self._check_whole()
        from .export.image import image, png_path

        path = None if file is None else png_path(file, "file")
        look = dict(colormap=colormap, cut=cut, view=view, size=size, limits=limits, threads=threads)
        picture = image(self, self._handle(), color, slice, seeds, gap, open, **look)
        if path is not None:
            picture.save(path)
        return picture

    def view(
        self,
        *,
        color: Any = None,
        colormap: str = "tide",
        columns: Optional[Mapping[str, npt.ArrayLike]] = None,
        open: Optional[str] = None,
    ) -> View:
        """Returns a page that shows the cells in a browser, where the reader turns, cuts and colors them. Needs "faces" in want.

        Notebooks show it. ``t.view().html`` is the page, one file without a server and network. It needs WebGL 2. The menu
        of colors has all columns of :meth:`to_dataframe`. In a ``mesh`` the page shows the pieces.

        color : the color at the start: a column, (N,) values, or (N, 3) red, green and blue as uint8 or from 0 to 1. Default:
            the volumes, or what there is.
        colormap : "tide", "ember" or "gray".
        columns : further values of the cells by name, (N,).
        open : "skip" leaves out cells that reach infinity, which else are refused.

        Raises ValueError for missing arrays and values that do not fit.

        >>> t.view().save("cells.html")
        """
        self._check_whole()
        from .export.viewer import view

        return view(self, columns, color, colormap, open)

    def save(
        self,
        path: Union[str, os.PathLike[str]],
        columns: Optional[Mapping[str, npt.ArrayLike]] = None,
        color: Any = None,
        colormap: str = "tide",
        open: Optional[str] = None,
        min_edge: float = 0.0,
    ) -> None:
        """Writes the result to a file in the format of its extension. The file is written whole or not at all.

        ``.npz``, ``.h5``, ``.hdf5`` hold the arrays of ``want``, the domain and the version, with the names of clvotess,
        also of some cells. The other formats need the cells of all points and "faces" in want:

        - ``.vtu``: polyhedra, in the plane polygons, with id, volume, neighbors, centroid and status, without empty cells. They ascend by their
          number of vertices, as meshio needs; ``id`` is the seed.
        - ``.ply``: the faces, each once, with its two cells.
        - ``.obj``: a group for each cell, named by its seed, with its faces counterclockwise seen from outside.
        - ``.glb``: solids in colors, about 830 bytes for a cell of random points, at most 4 GiB.
        - ``.stl``: text, a solid for each cell, named by its seed. Two cells have the same triangles between them.
        - ``.foam``: a mesh of OpenFOAM. The file is empty, as ParaView wants it; the mesh is in the folder
          ``constant/polyMesh`` beside it. Each wall is a patch, and a periodic boundary a pair of cyclic patches.
        - ``.tess``: a tessellation of Neper with seeds and weights; not of a periodic domain.
        - ``.msh``: surfaces in triangles, each once, which Gmsh meshes into tetrahedra. Each cell is a physical volume, each
          pair of cells and each wall a physical surface.
        - ``.cgns``: CGNS 3.4 in HDF5, a zone of NGON_n and NFACE_n, with the row of each cell. Each wall is a boundary
          condition, and a periodic boundary a pair of connections. It needs no h5py.
          In a mesh .foam, .msh and .cgns hold the pieces of :meth:`pieces`, and the surface is a patch.
        - ``.html``: the page of :meth:`view`, about 350 bytes for a cell of random points.

        ``columns``: further values of the cells by name, (N,) or (N, k), for .npz, .h5 and .vtu; (N,) for .html.
        ``color``: for .glb, .html, and for .ply, which then holds triangles. A column of :meth:`to_dataframe`, (N,) values, or
        (N, 3) red, green and blue as uint8 or from 0 to 1. Default: the volumes in .glb, none in .ply.
        ``colormap``: "tide", "ember" or "gray".
        ``min_edge``: in .foam, .tess, .msh, .cgns and .stl the ends of edges below this length become one vertex, and faces with two
        corners vanish. Cells stay closed, and vertices on their walls. Warns about edges that stay, because a cell would not
        remain a polyhedron of about its volume, or a vertex would leave its walls.
        ``open``: "skip" leaves cells that reach infinity out of the other formats, which else refuse them; ``open_cells``
        names them.

        Raises ValueError for an unknown extension, missing arrays, wrong columns or colors, a .glb above 4 GiB, and for
        .foam, .tess, .msh, .cgns and .stl where ``min_face`` or ``min_area`` dropped faces;
        ImportError without h5py for .h5; OSError when the file cannot be written.

        >>> t.save("cells.npz")
        >>> t.save("cells.vtu", columns={"mass": np.ones(100)})
        """
        from .export.save import save

        save(self, path, columns, color, colormap, open, min_edge)

    def to_dataframe(self) -> Any:
        """Returns a pandas.DataFrame with one row for each cell: x, y, z, and a column for each number of it.

        The index is the seed.

        >>> t.to_dataframe().shape[0]
        100
        """
        from .export.packages import to_dataframe

        return to_dataframe(self)

    def to_scipy(self) -> Any:
        """Returns ``neighbors.to_scipy()``.

        >>> t.to_scipy().shape
        (100, 100)
        """
        self._check_whole()
        return self.neighbors.to_scipy()

    def to_networkx(self) -> Any:
        """Returns a networkx.Graph of the seeds, with the columns of :meth:`to_dataframe`, and an edge for each pair.

        An edge has the smallest ``distance`` of touching images, their number of ``faces``, and with "areas" in want the
        sum of their ``area``. A seed that touches its own image has an edge to itself.

        >>> len(t.to_networkx())
        100
        """
        self._check_whole()
        from .export.packages import to_networkx

        return to_networkx(self)

    def to_freud(self) -> Any:
        """Returns a freud.locality.NeighborList in float32, with an entry for each of :meth:`pairs`. Needs "areas" in want.

        The weights are the areas of the faces, in the plane the lengths of the edges.

        >>> len(t.to_freud()) == len(t.pairs())
        True
        """
        self._check_whole()
        from .export.packages import to_freud

        return to_freud(self)

    def to_pyvista(self, columns: Optional[Mapping[str, npt.ArrayLike]] = None) -> Any:
        """Returns a pyvista.UnstructuredGrid. Cell i is the polyhedron of seed i, in the plane its polygon, or empty. Needs
        "faces" in want.

        Its cell data are those of .vtu in :meth:`save`, and ``columns``.

        >>> t.to_pyvista().n_cells
        100
        """
        self._check_whole()
        from .export.packages import to_pyvista

        return to_pyvista(self, columns)

    def verify(self, sample: Optional[int] = None, rng_seed: int = 1) -> VerifyReport:
        """Verifies this result against its points.

        Volumes must sum to the box (relative 1e-9; 1e-4 if ``stats.precision`` is "single"), neighbor lists must be
        symmetric, and Euler's formula must hold. Without ``sample``, exact signs around each cell prove that all lists,
        shifts and statuses are right, and ``proven`` of the report is true. Sizes, counts and polygons must be those of the
        proven cells. With ``sample``, so many cells drawn with ``rng_seed`` must equal cells that are clipped again by every
        seed. There is no proof in a mesh; ``unproven`` says so.
        Checks without their arrays are skipped. In a mesh all this holds for the whole cells; the parts must equal
        those of a second run on the CPU, and have the volumes of their pieces. With ``only=`` all seeds clip the cells,
        rows must be symmetric among those that are there, and "volumes" is skipped. Without neighbors, after ``min_face``
        or ``min_area``, and with ``only=`` of thousands, a run of all cells is proven instead, and each array must equal
        its part of that. ``tiny_faces`` of the report counts faces far smaller than the mean, see :class:`Stats`. For it, and for an unpickled result, the
        points may be tessellated again.

        >>> report = t.verify()
        >>> report.passed, report.proven
        (True, True)
        """
        drawn = as_sample(sample, rng_seed)
        points = np.ascontiguousarray(self._points, dtype=np.float64)
        try:
            handle = self._handle()
        except ValueError as error:
            return VerifyReport(False, f"this result was unpickled, and its points do not tessellate again: {error}", ())
        except VotessError as error:
            if error.code != ErrorCode.INVALID_USE:
                raise
            return VerifyReport(False, str(error), ())
        return verify(partial(watched, lib.votess_verify), handle, points, len(points), *drawn)
