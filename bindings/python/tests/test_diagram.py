"""Diagram: which cell holds a point."""

import copy
import pickle
import threading
import unittest

import numpy as np
from helpers import CELL, UNIT_BOX, lattice, uniform

import pyvotess as vt  # noqa: E402


def nearest(points, queries, weights=None, shifts=((0, 0, 0),)):
    """By all distances; general position, so that rounding decides nothing."""
    least = np.full((len(queries), len(points)), np.inf)
    for shift in shifts:
        square = ((queries[:, None, :] - points[None, :, :] - np.asarray(shift)) ** 2).sum(axis=2)
        least = np.minimum(least, square if weights is None else square - weights)
    return least.argmin(axis=1)


def images(vectors):
    steps = (-2, -1, 0, 1, 2)
    return [i * vectors[0] + j * vectors[1] + k * vectors[2] for i in steps for j in steps for k in steps]


class Diagrams(unittest.TestCase):
    def test_locate(self):
        points, queries = uniform(2000), uniform(3000, seed=2)
        d = vt.Diagram(points, box=UNIT_BOX)
        self.assertEqual(len(d), 2000)
        found = d.locate(queries)
        self.assertEqual((found.dtype, found.shape), (np.int32, (3000,)))
        np.testing.assert_array_equal(found, nearest(points, queries))
        np.testing.assert_array_equal(d.locate(points), np.arange(2000))
        self.assertEqual(d.locate(np.empty((0, 3))).shape, (0,))
        np.testing.assert_array_equal(d.locate([(0.5, 0.5, 1.5), (2, 0, 0)]), (-1, -1))

    def test_domains(self):
        points, queries = uniform(40), uniform(400, seed=2)
        box = np.eye(3)
        np.testing.assert_array_equal(
            vt.Diagram(points, UNIT_BOX, periodic=True).locate(queries + (1, -2, 0)),
            nearest(points, queries, shifts=images(box)),
        )
        cell = np.asarray(CELL, float)
        np.testing.assert_array_equal(
            vt.Diagram(points @ cell, cell=cell).locate(queries @ cell),
            nearest(points @ cell, queries @ cell, shifts=images(cell)),
        )
        radii = 0.2 * uniform(40, seed=3)[:, 0]
        expected = nearest(points, queries, radii**2)
        np.testing.assert_array_equal(vt.Diagram(points, UNIT_BOX, radii=radii).locate(queries), expected)
        np.testing.assert_array_equal(vt.Diagram(points, UNIT_BOX, weights=radii**2).locate(queries), expected)
        walls = [(1, 1, 1, 1.5)]
        kept = points.sum(axis=1) <= 1.5
        inside = queries.sum(axis=1) <= 1.5
        found = vt.Diagram(points, UNIT_BOX, walls=walls, outside="drop").locate(queries)
        expected = np.flatnonzero(kept)[nearest(points[kept], queries)]
        np.testing.assert_array_equal(found, np.where(inside, expected, -1))

    def test_ties_go_to_the_lowest(self):
        points = lattice(4)
        d = vt.Diagram(points, (0, 0, 0, 4, 4, 4))
        np.testing.assert_array_equal(d.locate([(1, 1, 1), (2, 0.5, 0.5), (4, 4, 4), (0, 0, 3)]), (0, 16, 63, 2))

    def test_threads(self):
        points, queries = uniform(5000), uniform(20000, seed=2)
        d = vt.Diagram(points, UNIT_BOX, threads=2)
        expected, found = d.locate(queries), [None] * 4

        def ask(k):
            found[k] = d.locate(queries)

        threads = [threading.Thread(target=ask, args=(k,)) for k in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for one in found:
            np.testing.assert_array_equal(one, expected)

    def test_refused(self):
        points = uniform(5)
        d = vt.Diagram(points, UNIT_BOX)
        for queries, says in [
            ([(0.5, np.nan, 0.5)], "query 0"),
            ([0.5, 0.5, 0.5], "queries has shape"),
            (np.zeros((2, 2)), "queries has shape"),
        ]:
            with self.assertRaisesRegex(ValueError, says):
                d.locate(queries)
        with self.assertRaisesRegex(ValueError, "point 0"):
            vt.Diagram([(2, 0, 0)], UNIT_BOX)
        with self.assertRaisesRegex(ValueError, "weights"):
            vt.Diagram(points, UNIT_BOX, weights=[1, 2])
        for copied in (copy.copy, copy.deepcopy, pickle.dumps):
            with self.assertRaises(TypeError):
                copied(d)


if __name__ == "__main__":
    unittest.main()
