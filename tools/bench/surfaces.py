#!/usr/bin/env python3
"""Cells on surfaces and new meshes of them, beside GEOGRAM and pyacvd. See README.md.

    pip install numpy trimesh pyacvd geogram; build the library of GEOGRAM's part as README.md says
    PYTHONPATH=bindings/python tools/bench/surfaces.py cells --geogram libsurface_geogram.so bunny.ply
    PYTHONPATH=bindings/python tools/bench/surfaces.py remesh --geogram libsurface_geogram.so MODEL...
"""

import argparse
import ctypes
import time
from pathlib import Path

import numpy as np
import pyvotess as vt


def load(path):
    """Returns vertices and triangles, with vertices at equal places made one and without triangles of no area."""
    import trimesh

    mesh = trimesh.load(path, force="mesh", process=False)
    places, same = np.unique(np.asarray(mesh.vertices, float) + 0.0, axis=0, return_inverse=True)
    triangles = same.reshape(-1)[np.asarray(mesh.faces)]
    x = places[triangles]
    return places, triangles[np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) > 0].astype(np.int32)


class Geogram:
    def __init__(self, path):
        self.peer = ctypes.CDLL(path)
        for name in ("geogram_cells", "geogram_remesh"):
            getattr(self.peer, name).restype = ctypes.c_double

    def cells(self, points, vertices, triangles, what):
        areas = np.zeros(len(points))
        seconds = self.peer.geogram_cells(points.ctypes, len(points), vertices.ctypes, len(vertices), triangles.ctypes,
                                          len(triangles), what, areas.ctypes)
        return areas, seconds

    def remesh(self, vertices, triangles, count):
        v, t = ctypes.c_int(), ctypes.c_int()
        seconds = self.peer.geogram_remesh(count, vertices.ctypes, len(vertices), triangles.ctypes, len(triangles),
                                           ctypes.byref(v), ctypes.byref(t))
        made, corners = np.empty((v.value, 3)), np.empty((t.value, 3), np.int32)
        self.peer.geogram_take(made.ctypes, corners.ctypes)
        return made, corners, seconds


def acvd(vertices, triangles, count):
    import pyacvd
    import pyvista as pv

    began = time.process_time()
    clustering = pyacvd.Clustering(pv.PolyData.from_regular_faces(vertices, triangles))
    while len(clustering.mesh.points) < 10 * count:
        clustering.subdivide(1)
    clustering.cluster(count)
    made = clustering.create_mesh()
    return np.asarray(made.points, float), made.regular_faces, time.process_time() - began


def edges_of(triangles):
    edges = np.sort(triangles[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2), axis=1)
    counts = np.unique(edges, axis=0, return_counts=True)[1]
    return int((counts == 1).sum()), int((counts > 2).sum())


def angles_of(vertices, triangles):
    x = vertices[triangles]
    a, b = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=2), (a * b).sum(axis=2))).min(axis=1)


def random_places(vertices, triangles, count):
    import trimesh

    return np.array(trimesh.sample.sample_surface(trimesh.Trimesh(vertices, triangles, process=False), count, seed=1)[0])


def spread(vertices, triangles, count):
    """Returns random places on triangles, and their vertices."""
    return np.concatenate((random_places(vertices, triangles, count), vertices))


def hausdorff(one, other):
    """Returns the larger of both one-sided distances, of random places and all vertices."""
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

    largest = 0.0
    for places, (vertices, triangles) in ((spread(*one, 20000), other), (spread(*other, 20000), one)):
        mesh, points, cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(vertices), deep=1))
        starts, corners = np.arange(0, 3 * len(triangles) + 1, 3), np.ascontiguousarray(triangles.ravel())
        cells.SetData(*(numpy_to_vtkIdTypeArray(numbers.astype(np.int64), deep=1) for numbers in (starts, corners)))
        mesh.SetPoints(points)
        mesh.SetPolys(cells)
        locator = vtk.vtkStaticCellLocator()
        locator.SetDataSet(mesh)
        locator.BuildLocator()
        near, cell, number, square = [0.0, 0.0, 0.0], vtk.reference(0), vtk.reference(0), vtk.reference(0.0)
        for place in places:
            locator.FindClosestPoint(place, near, cell, number, square)
            largest = max(largest, float(square))
    return largest**0.5


def compare_cells(arguments):
    geogram = Geogram(arguments.geogram)
    for path in arguments.models:
        vertices, triangles = load(path)
        points = random_places(vertices, triangles, arguments.n)
        print(f"{Path(path).name}: {len(triangles)} triangles, {len(points)} seeds; seconds of the CPU")
        # The same in both: areas; areas and centroids; polygons; polygons and the dual of connected parts.
        for what, want in enumerate(("areas", "nearest", "polygons", "all"), 1):
            ours, theirs = [], []
            for _ in range(arguments.repeats):  # in turns
                began = time.process_time()
                cells = vt.surface(points, (vertices, triangles), want=want, threads=1)
                ours.append(time.process_time() - began)
                areas, seconds = geogram.cells(points, vertices, triangles, what)
                theirs.append(seconds)
            print(f"  {want:8s} votess {min(ours):.3f}, geogram {min(theirs):.3f}, {min(theirs) / min(ours):.2f} times as long",
                  end="")
            off = np.abs(areas - cells.areas).max() / cells.areas.mean()
            print(f"; areas differ by up to {off:.1e} of the mean" if what < 3 else "", flush=True)


def compare_meshes(arguments):
    makers = {"votess": remesh, "pyacvd": acvd}
    if arguments.geogram:
        makers["geogram"] = Geogram(arguments.geogram).remesh
    print("model, triangles, border and crowded edges | program: vertices, triangles, border and crowded edges, smallest angle, "
          "mean of the smallest, Hausdorff distance / diagonal, seconds of the CPU")
    for path in arguments.models:
        vertices, triangles = load(path)
        print(f"{Path(path).name}: {len(triangles)}, {edges_of(triangles)}", flush=True)
        diagonal = np.linalg.norm(np.ptp(vertices, axis=0))
        for name, make in makers.items():
            made, corners, seconds = make(vertices, triangles, arguments.n)
            angles = angles_of(made, corners)
            far = hausdorff((vertices, triangles), (made, corners)) / diagonal
            print(f"  {name:8s} {len(made):6d} {len(corners):6d} {str(edges_of(corners)):12s} {angles.min():6.2f} "
                  f"{angles.mean():5.1f} {far:.5f} {seconds:6.2f}", flush=True)


def remesh(vertices, triangles, count):
    began = time.process_time()
    mesh = vt.remesh((vertices, triangles), count, threads=1)
    return mesh.vertices, mesh.triangles, time.process_time() - began


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("cells", "remesh"))
    parser.add_argument("models", nargs="+")
    parser.add_argument("--geogram", help="the library made of peers/surface_geogram.cpp")
    parser.add_argument("--n", type=int, help="seeds, or vertices of a new mesh; default 100000, or 5000")
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    arguments.n = arguments.n or (100_000 if arguments.what == "cells" else 5000)
    (compare_cells if arguments.what == "cells" else compare_meshes)(arguments)


if __name__ == "__main__":
    main()
