"""What the tests of files share: results to save, their faces made in another way, a folder."""

import importlib.util
import pathlib
import tempfile
import unittest

import numpy as np
from helpers import UNIT_BOX, uniform

import pyvotess as vt

CELL = [(1, 0, 0), (0.3, 1, 0), (0.2, 0.4, 1)]


def have(*modules):
    """Whether all of these packages are installed, the reason to skip for unittest otherwise."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    return unittest.skipIf(missing, f"{', '.join(missing)} is not installed")


def cells(count=60, **options):
    """Cells with two duplicates at the end."""
    points = uniform(count)
    options.setdefault("box", UNIT_BOX)
    options.setdefault("want", "faces,volumes,centroids,areas")
    return vt.tessellate(np.concatenate((points, points[:2])), **options)


def once(t):
    """The faces, each once, as lists of corners with their two cells, made without the code under test."""
    faces = []
    for i, row in enumerate(t.neighbors):
        for k, j in zip(range(t.neighbors.indptr[i], t.neighbors.indptr[i + 1]), row.tolist()):
            if j < 0 or i < j or (i == j and tuple(t.shifts[k].tolist()) > (0, 0, 0)):
                faces.append((t.faces[k].tolist(), i, j))
    return faces


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def path(self, name):
        return str(self.folder / name)
