"""What the tests share: the package of this tree, points, and words."""

import importlib.util
import os
import pathlib
import sys

import numpy as np

PACKAGE_PARENT = str(pathlib.Path(__file__).resolve().parents[1])
if "VOTESS_TEST_INSTALLED" in os.environ:  # the package that pip has installed
    PACKAGE_PARENT = str(pathlib.Path(importlib.util.find_spec("pyvotess").origin).parents[1])
sys.path.insert(0, PACKAGE_PARENT)

UNIT_BOX = (0, 0, 0, 1, 1, 1)
EVERYTHING = ("neighbors", "volumes", "centroids", "counts", "areas")


def uniform(count, seed=1):
    return np.random.default_rng(seed).random((count, 3))


def lattice(n):
    """Centers of n^3 cubes of side 1 in the box (0, n)^3; the row of seed (i, j, k) is (i * n + j) * n + k."""
    axis = np.arange(n) + 0.5
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)


def long_run_points():
    """Enough points for about a second of one thread."""
    return uniform(int(os.environ.get("VOTESS_TEST_LONG_RUN", "200000")), seed=3)
