"""Checks arguments of users and converts them to the form that the library reads."""

from __future__ import annotations

import os
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Iterator, Mapping, Optional, Tuple, Union

import numpy as np

from ._arguments import as_flag, counted, shown

if TYPE_CHECKING:
    import numpy.typing as npt

    from . import _c_api
    from ._types import Float64Array


#: DLPack's types of memory that a program on the CPU reads: its own, pinned for CUDA or ROCm, and managed by CUDA.
_HOST = (1, 3, 11, 13)


def _of_pandas(values: Any) -> Any:
    """Returns an array of a frame or column of pandas with nullable or Arrow types, other values as they are.

    NumPy would make objects of them. Missing numbers become NaN.
    """
    if not type(values).__module__.startswith("pandas") or not hasattr(values, "to_numpy"):
        return values
    types = list(values.dtypes) if values.ndim == 2 else [values.dtype]
    kinds = {kind.kind for kind in types}
    if all(isinstance(kind, np.dtype) for kind in types) or not kinds:
        return values
    missing = bool(np.any(values.isna()))
    if not missing and (kinds <= {"i"} or kinds == {"u"} or kinds == {"b"}):
        return values.to_numpy(dtype={"i": np.int64, "u": np.uint64, "b": np.bool_}[kinds.pop()])
    if kinds <= set("fiu"):
        return values.to_numpy(dtype=np.float64, na_value=np.nan)
    return values


def as_array(values: Any, name: str) -> npt.NDArray[Any]:
    """Returns an array, without a copy of one that has the interface of NumPy or DLPack. Refuses masked values."""
    if np.ma.is_masked(values):
        raise ValueError(f"{name} has masked values: remove these points from all arrays, as in {name}[~mask]")
    if getattr(values, "requires_grad", False) is True:  # of PyTorch
        raise ValueError(f"{name} requires gradients: give {name}.detach(), or use pyvotess.autodiff.torch")
    values = _of_pandas(values)
    known = ("__array__", "__array_interface__", "__array_struct__")
    if not hasattr(values, "__dlpack__") or any(hasattr(values, attribute) for attribute in known):
        try:
            return np.asarray(values)
        except ValueError as error:
            raise ValueError(f"{name} is not an array of numbers: {error}") from error
    memory = int(values.__dlpack_device__()[0])
    if memory not in _HOST:
        raise ValueError(f"{name} is in memory of a device, type {memory} of DLPack: copy it to the CPU")
    try:
        return np.from_dlpack(values)
    except (AttributeError, BufferError, RuntimeError) as error:  # NumPy before 1.23 has no from_dlpack
        raise ValueError(f"{name} cannot be read by DLPack: {error}") from error


def as_float64_or_float32(values: Any, name: str) -> npt.NDArray[Any]:
    """Returns the values as C-contiguous float64 or float32, without a copy if they are that already.

    Raises ValueError where the conversion would change a value.
    """
    array = as_array(values, name)
    if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
        raise ValueError(f"{name} has dtype {array.dtype}: give float64, float32 or integers")
    if array.dtype.kind in "iu" and array.dtype.itemsize == 8:
        inexact = array > 2**53
        if array.dtype.kind == "i":
            inexact |= array < -(2**53)
        if inexact.any():
            index = tuple(int(i) for i in np.argwhere(inexact)[0])
            place = "".join(f"[{i}]" for i in index)
            raise ValueError(
                f"{name}{place} is {array[index]}: float64 cannot hold all integers beyond 2**53; give float64"
            )
    dtype = np.float32 if array.dtype == np.float32 else np.float64
    return np.require(array, dtype, ["C_CONTIGUOUS", "ALIGNED"])


def as_points(points: Any, name: str = "points", planar: bool = False) -> npt.NDArray[Any]:
    """Returns (N, 3) points. With ``planar`` they may have the shape (N, 2) instead."""
    if isinstance(points, (str, os.PathLike)):
        raise TypeError(f"{name} is {shown(str(points))}: give an array, or read a file with vt.read_frames()")
    if callable(getattr(points, "tessellate", None)):
        raise TypeError(f"{name} is {shown(points)}: it has a method tessellate()")
    array = as_float64_or_float32(points, name)
    if array.ndim != 2 or array.shape[1] not in (3, 3 - planar):
        raise ValueError(f"{name} has shape {array.shape}: it must be (N, 3)" + (" or (N, 2)" if planar else ""))
    return array


_BOX = "(x0, y0, z0, x1, y1, z1), ((x0, y0, z0), (x1, y1, z1)) or ((x0, x1), (y0, y1), (z0, z1))"


def as_box(box: Any, name: str = "box") -> Float64Array:
    """Returns (2, 3) float64, the lower and the upper corner, in the plane (2, 2)."""
    array = as_float64_or_float32(box, name).astype(np.float64)
    if array.shape in ((6,), (2, 3), (3, 2)):
        return np.ascontiguousarray(array.T) if array.shape == (3, 2) else array.reshape(2, 3)
    if array.shape not in ((4,), (2, 2)):
        raise ValueError(f"{name} has shape {array.shape}: give {_BOX}; in the plane (x0, y0, x1, y1) or two pairs of these")
    corners = array.reshape(2, 2)
    if array.ndim == 2 and np.all(corners[:, 0] < corners[:, 1]):  # limits of x and y
        if np.all(corners[0] < corners[1]) and corners[0, 1] != corners[1, 0]:
            raise ValueError(
                f"{name} is {corners.tolist()}, which may be two corners or the limits of x and of y: give (x0, y0, x1, y1)"
            )
        corners = np.ascontiguousarray(corners.T)
    return corners


def as_cell(cell: Any, name: str = "cell") -> Float64Array:
    """Returns (3, 3) float64 edges as rows, in the plane (2, 2)."""
    array = as_float64_or_float32(cell, name).astype(np.float64)
    if array.size not in (4, 9):
        raise ValueError(
            f"{name} has shape {array.shape}: give three vectors ((ax, ay, az), (bx, ...), (cx, ...)), in the plane "
            "((ax, ay), (bx, by))"
        )
    return array.reshape((3, 3) if array.size == 9 else (2, 2))


def as_origin(origin: Any) -> Float64Array:
    """Returns (3,) float64, in the plane (2,)."""
    array = as_float64_or_float32(origin, "origin").astype(np.float64)
    if array.size not in (2, 3):
        raise ValueError(f"origin has shape {array.shape}: give (x, y, z), in the plane (x, y)")
    return array.ravel()


def as_walls(walls: Any) -> Float64Array:
    """Returns (M, 4) float64 rows nx, ny, nz, d, in the plane (M, 3) rows nx, ny, d."""
    array = np.atleast_1d(as_float64_or_float32(walls, "walls")).astype(np.float64)
    if array.size == 0:
        return np.empty((0, 4))
    if array.ndim != 2 or array.shape[1] not in (3, 4):
        raise ValueError(f"walls has shape {array.shape}: give (M, 4) rows nx, ny, nz, d, in the plane (M, 3) rows nx, ny, d")
    return array


def as_one_each(values: Any, name: str, count: int, of: str) -> Float64Array:
    """Returns (count,) float64, one number for each point or query."""
    array = as_float64_or_float32(values, name)
    if array.shape != (count,):
        raise ValueError(f"{name} has shape {array.shape} for {count} {of}: it must be ({count},)")
    return array.astype(np.float64, copy=False)


def as_density(density: Any, dimensions: int) -> Float64Array:
    """Returns the values of a density on a grid, (nx, ny, nz) float64, in the plane (nx, ny)."""
    array = as_float64_or_float32(density, "density").astype(np.float64, copy=False)
    if array.ndim != dimensions or array.size == 0:
        raise ValueError(
            f"density has shape {array.shape}: it must be {'(nx, ny)' if dimensions == 2 else '(nx, ny, nz)'}, with x first"
        )
    wrong = np.argwhere(~((array >= 0) & (array < np.inf)))
    if len(wrong):
        index = tuple(int(i) for i in wrong[0])
        raise ValueError(f"density{list(index)} is {array[index]}: it must be finite and not negative")
    return array


def as_labels(values: Any, name: str, count: int, of: str) -> npt.NDArray[np.int64]:
    """Returns (count,) int64, one whole number for each point."""
    array = as_array(values, name)
    if array.dtype.kind not in "iu" and array.size:
        raise ValueError(f"{name} has dtype {array.dtype}: give whole numbers")
    if array.shape != (count,):
        raise ValueError(f"{name} has shape {array.shape} for {count} {of}: it must be ({count},)")
    if array.size and int(array.max()) >= 2**63:
        raise ValueError(f"{name} holds {int(array.max())}: numbers below 2**63 are possible")
    return np.ascontiguousarray(array, dtype=np.int64)


def as_only(values: Any, count: int) -> Optional[npt.NDArray[np.int64]]:
    """Returns (M,) int64 from indices or a mask of ``count`` flags."""
    if values is None:
        return None
    array = as_array(values, "only")
    if array.dtype == bool:
        if array.shape != (count,):
            raise ValueError(f"only is a mask of shape {array.shape} for {count} points: it must be ({count},)")
        return np.flatnonzero(array).astype(np.int64)
    if array.size == 0:
        array = array.astype(np.int64)
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise ValueError(f"only has shape {array.shape} and type {array.dtype}: give indices, or one flag for each point")
    return np.ascontiguousarray(array, dtype=np.int64)


def _rings_of(geometry: Any, place: str = "") -> Iterator[Tuple[Any, bool, str]]:
    """Returns the rings of the polygons in GeoJSON, whether each is a hole, and its place, as "feature 2, ring 0"."""
    kind = geometry.get("type")
    if kind == "Feature":
        if geometry.get("geometry") is not None:
            yield from _rings_of(geometry["geometry"], place)
    elif kind in ("FeatureCollection", "GeometryCollection"):
        member, name = ("features", "feature") if kind == "FeatureCollection" else ("geometries", "geometry")
        for k, part in enumerate(geometry[member]):
            yield from _rings_of(part, f"{place}{name} {k}, ")
    elif kind in ("Polygon", "MultiPolygon"):
        polygons = geometry["coordinates"]
        for number, polygon in enumerate([polygons] if kind == "Polygon" else polygons):
            outer = place if kind == "Polygon" else f"{place}polygon {number}, "
            for k, ring in enumerate(polygon):
                yield ring, k > 0, f"{outer}ring {k}"
    else:
        raise ValueError(f"mesh holds a geometry of the type {shown(kind)}: give polygons")


def _turns_left(ring: Float64Array) -> bool:
    """Returns whether a ring of places runs counterclockwise. Fractions decide where rounding may."""
    if not np.isfinite(ring).all():
        return True  # refused later
    size = np.abs(ring).max() or 1.0
    x, y = (ring / size - ring[0] / size).T
    terms = x * np.roll(y, -1) - y * np.roll(x, -1)
    if abs(terms.sum()) > 1e-12 * np.abs(terms).sum() + 1e-13 * np.abs(np.diff(ring / size, axis=0)).sum():
        return bool(terms.sum() > 0)
    places = [(Fraction(a), Fraction(b)) for a, b in ring.tolist()]
    return sum((a * d - b * c for (a, b), (c, d) in zip(places, places[1:] + places[:1])), Fraction(0)) > 0


def _mesh_of_polygons(geometry: Any) -> Tuple[Float64Array, npt.NDArray[np.int32]]:
    """Returns (V, 2) vertices and (E, 2) edges of GeoJSON: outlines run counterclockwise, holes clockwise."""
    vertices, edges, count = [], [], 0
    try:
        rings = list(_rings_of(geometry))
    except (AttributeError, KeyError, TypeError) as error:
        raise ValueError("mesh is not GeoJSON of polygons: give a geometry, a feature or a collection") from error
    except RecursionError:
        raise ValueError("mesh holds collections that lie in each other too deep") from None
    for ring, is_hole, where in rings:
        places = as_float64_or_float32(ring, f"{where} of mesh").astype(np.float64)
        if places.ndim != 2 or places.shape[1] not in (2, 3):
            raise ValueError(f"{where} of mesh has shape {places.shape}: give (V, 2) places")
        places = places[:, :2]
        if len(places) > 1 and (places[0] == places[-1]).all():
            places = places[:-1]
        if len(places) < 3:
            raise ValueError(f"{where} of mesh has {counted(len(places), 'place')}: give at least 3")
        if _turns_left(places) == is_hole:
            places = places[::-1]
        own = np.arange(len(places), dtype=np.int32)
        vertices.append(places)
        edges.append(count + np.stack([own, np.roll(own, -1)], axis=1))
        count += len(places)
    if not vertices:
        raise ValueError("mesh holds no polygon: give at least one")
    return np.concatenate(vertices), np.concatenate(edges)


def as_mesh(mesh: Any) -> Tuple[Float64Array, npt.NDArray[np.int32]]:
    """Returns (V, 3) float64 vertices and (T, 3) int32 triangles of a pair, or of a mesh of trimesh, PyVista, meshio or Open3D.

    In the plane (V, 2) vertices and (E, 2) edges: of a pair, of GeoJSON, or of an object with ``__geo_interface__``.
    """
    if isinstance(mesh, (str, os.PathLike)):
        raise ValueError(f"mesh is {shown(str(mesh))}: give what trimesh.load_mesh(file), pyvista.read(file) or json.load(file) returns")
    if hasattr(mesh, "__geo_interface__"):  # Shapely, GeoPandas
        return _mesh_of_polygons(mesh.__geo_interface__)
    if isinstance(mesh, Mapping):
        return _mesh_of_polygons(mesh)
    kind = type(mesh).__name__
    if isinstance(mesh, (list, tuple)) and any(isinstance(part, Mapping) or hasattr(part, "__geo_interface__") for part in mesh):
        raise ValueError(f"mesh is a {kind} of polygons: give a MultiPolygon or a GeometryCollection")
    if hasattr(mesh, "is_all_triangles") and hasattr(mesh, "points"):  # PyVista; regular_faces raises for mixed faces
        if not mesh.is_all_triangles:
            raise ValueError("mesh has faces that are not triangles: give mesh.triangulate()")
        pair: Tuple[Any, ...] = (mesh.points, mesh.regular_faces)
    elif hasattr(mesh, "extract_geometry"):  # the other data sets of PyVista
        combined = "combine()." if hasattr(mesh, "combine") else ""
        raise ValueError(f"mesh is a {kind}: give its surface, mesh.{combined}extract_geometry().triangulate()")
    elif hasattr(mesh, "GetPolys") or hasattr(mesh, "GetCells"):  # VTK
        raise ValueError(f"mesh is a {kind}: give pyvista.wrap(mesh).extract_geometry().triangulate()")
    elif hasattr(mesh, "points") and hasattr(mesh, "cells_dict"):  # meshio
        kinds = set(mesh.cells_dict) - {"vertex", "line"}  # which bound nothing
        if kinds != {"triangle"}:
            raise ValueError(f"mesh has cells of the kinds {sorted(kinds)}: give (mesh.points, triangles) of its surface")
        pair = (mesh.points, mesh.cells_dict["triangle"])
    elif hasattr(mesh, "vertices") and hasattr(mesh, "faces"):  # trimesh
        pair = (mesh.vertices, mesh.faces)
    elif hasattr(mesh, "vertices") and hasattr(mesh, "triangles"):  # Open3D
        pair = (mesh.vertices, mesh.triangles)
    elif hasattr(mesh, "geometry") and hasattr(mesh, "graph"):  # a scene of trimesh
        whole = mesh.to_mesh() if hasattr(mesh, "to_mesh") else mesh.dump(concatenate=True)
        pair = (whole.vertices, whole.faces)
    elif hasattr(mesh, "vertex") and hasattr(mesh, "triangle"):  # tensors of Open3D
        pair = tuple(x.cpu().numpy() for x in (mesh.vertex.positions, mesh.triangle.indices))
    else:
        try:
            pair = tuple(mesh)
        except TypeError:
            pair = ()
    if len(pair) != 2:
        raise ValueError(
            f"mesh is a {kind}: give (vertices, triangles), or a mesh with both; in the plane (vertices, edges) or polygons"
        )
    vertices = np.ascontiguousarray(as_float64_or_float32(pair[0], "vertices of mesh"), np.float64)
    triangles = as_array(pair[1], "triangles of mesh")
    if vertices.ndim != 2 or vertices.shape[1] not in (2, 3):
        raise ValueError(f"vertices of mesh have shape {vertices.shape}: it must be (V, 3), in the plane (V, 2)")
    d = vertices.shape[1]
    what, shape = ("edge", "(E, 2)") if d == 2 else ("triangle", "(T, 3)")
    if triangles.ndim != 2 or triangles.shape[1] != d or triangles.dtype.kind not in "iu":
        raise ValueError(
            f"{what}s of mesh have shape {triangles.shape} and type {triangles.dtype}: give {shape} indices of vertices"
        )
    wrong = (triangles < 0) | (triangles >= len(vertices))  # before int32 could wrap them
    if wrong.any():
        row, column = np.argwhere(wrong)[0]
        raise ValueError(
            f"mesh: {what} {row} names vertex {triangles[row, column]}, but there are {len(vertices)}: "
            "give indices from 0 on"
        )
    return vertices, np.ascontiguousarray(triangles, np.int32)


def as_vector(values: Any, name: str) -> Float64Array:
    array = as_float64_or_float32(values, name).astype(np.float64)
    if array.size != 3:
        raise ValueError(f"{name} has shape {array.shape}: give (x, y, z)")
    return np.ascontiguousarray(array.reshape(3))


def as_periodic(periodic: Any, dimensions: Optional[int]) -> Union[bool, Tuple[bool, ...]]:
    """Returns a flag for each axis, or one for all if the dimensions are unknown. Three flags in the plane name z."""
    if isinstance(periodic, str):
        if len(set(periodic)) != len(periodic) or not set(periodic) <= set("xyz"):
            raise ValueError(f"periodic is {periodic!r}: give axes, such as 'xyz' or 'xy', or False")
        flags = [axis in periodic for axis in "xyz"]
    else:
        try:
            given = list(periodic)
        except TypeError:
            every = as_flag(periodic, "periodic")
            return every if dimensions is None else (every,) * dimensions
        flags = [as_flag(flag, "periodic") for flag in given]
    if dimensions == 2 and len(flags) == 3 and not flags[2]:
        flags.pop()
    if len(flags) != 3 and not (len(flags) == 2 and dimensions != 3):
        raise ValueError(f"periodic holds {len(flags)} values: give one for each axis, or True for all")
    return tuple(flags)


def fill_weights(options: _c_api.Struct, weights: Any, radii: Any, count: int) -> Optional[Float64Array]:
    """Sets weights and radii of the points. Returns the weights, None without any."""
    found = None
    for name, values in (("weights", weights), ("radii", radii)):
        if values is not None:
            found = as_one_each(values, name, count, "points")
            setattr(options, name, found)
    return np.square(found) if found is not None and radii is not None else found
