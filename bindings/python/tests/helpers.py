"""Shared by the tests: the package of this tree, points, results and folders."""

import importlib.util
import os
import pathlib
import signal
import sys
import tempfile
import unittest

import numpy as np

PACKAGE_PARENT = str(pathlib.Path(__file__).resolve().parents[1])
if "VOTESS_TEST_INSTALLED" in os.environ:  # the package that pip installed
    PACKAGE_PARENT = str(pathlib.Path(importlib.util.find_spec("pyvotess").origin).parents[1])
sys.path.insert(0, PACKAGE_PARENT)

import pyvotess as vt  # noqa: E402

# A shell makes background processes ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)

UNIT_BOX = (0, 0, 0, 1, 1, 1)
EVERYTHING = ("neighbors", "volumes", "centroids", "counts", "areas")
CELL = [(1, 0, 0), (0.3, 1, 0), (0.2, 0.4, 1)]
CUBE = (
    np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float),
    np.array([
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]),
)  # fmt: skip


def _ell():
    """Returns a closed mesh: a box of 2 x 2 x 1 without a quarter."""
    outline = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], float)
    count = len(outline)
    vertices = np.concatenate([np.insert(outline, 2, z, axis=1) for z in (0, 1)])
    top = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]) + count
    i = np.arange(count)
    j = np.roll(i, -1)
    sides = [np.stack([i, j, j + count], 1), np.stack([i, j + count, i + count], 1)]
    return vertices, np.concatenate([top, top[:, ::-1] - count, *sides])


ELL = _ell()


def uniform(count, seed=1):
    return np.random.default_rng(seed).random((count, 3))


def lattice(n):
    """Returns centers of n^3 unit cubes in the box (0, n)^3. The row of seed (i, j, k) is (i * n + j) * n + k."""
    axis = np.arange(n) + 0.5
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)


def long_run_points():
    """Returns points for about a second of one thread."""
    return uniform(int(os.environ.get("VOTESS_TEST_LONG_RUN", "200000")), seed=3)


def have(*modules):
    """Skips a test unless all of these packages are installed."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    return unittest.skipIf(missing, f"{', '.join(missing)} is not installed")


def cells(count=60, **options):
    """Returns cells with two duplicates at the end."""
    points = uniform(count)
    options.setdefault("box", UNIT_BOX)
    options.setdefault("want", "faces,volumes,centroids,areas")
    return vt.tessellate(np.concatenate((points, points[:2])), **options)


def once(t):
    """Returns each face once: corners, cell, neighbor. Computed without the code under test."""
    faces = []
    for i, row in enumerate(t.neighbors):
        for k, j in zip(range(t.neighbors.indptr[i], t.neighbors.indptr[i + 1]), row.tolist()):
            if j < 0 or i < j or (i == j and tuple(t.shifts[k].tolist()) > (0, 0, 0)):
                faces.append((t.faces[k].tolist(), i, j))
    return faces


def is_closed(triangles):
    """Returns whether each edge of rows of corners occurs once in each direction."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forth, counts = np.unique(edges, axis=0, return_counts=True)
    return bool((counts == 1).all()) and np.array_equal(forth, np.unique(edges[:, ::-1], axis=0))


def enclosed(places):
    """Returns the volume inside closed triangles, (T, 3, 3) places of their corners."""
    a, b, c = np.moveaxis(places - places[0, 0], 1, 0)
    return np.einsum("tk,tk->", a, np.cross(b, c)) / 6


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def path(self, name):
        return str(self.folder / name)
