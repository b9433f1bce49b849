"""trace(): arguments and results. The cells themselves are tested in C++ (tests/cases/query/trace.cpp)."""

import unittest

import numpy as np
from helpers import UNIT_BOX, uniform

import pyvotess as vt


class Rays(unittest.TestCase):
    def test_integrals_of_columns(self):
        d = vt.Diagram(uniform(300, seed=3), box=UNIT_BOX)
        cells = d.trace([(0.5, 0.5, 0.5), (2, 2, 2), (0.1, 0.1, 0.1)], [(1, 0, 0)] * 3, np.inf)
        self.assertEqual(cells.offsets[1], cells.offsets[2])  # begins outside
        self.assertEqual((len(cells), repr(cells)), (3, f"<pyvotess.RayCells: 3 rays through {len(cells.seeds)} cells>"))
        values = uniform(300, seed=5)[:, :2]
        both = cells.integrate(values)
        self.assertEqual(both.shape, (3, 2))
        np.testing.assert_array_equal(both[1], 0)
        np.testing.assert_array_equal(both[:, 1], cells.integrate(values[:, 1]))
        first = slice(0, cells.offsets[1])
        self.assertAlmostEqual(both[0, 0], values[cells.seeds[first], 0] @ cells.lengths[first], 13)
        self.assertAlmostEqual(cells.lengths[first].sum(), 0.5, 14)
        self.assertEqual(d.trace(np.zeros((0, 3)), np.zeros((0, 3))).integrate(values).shape, (0, 2))
        self.assertEqual(cells.integrate(values[:, :0]).shape, (3, 0))
        none = vt.Diagram(np.empty((0, 3)), box=UNIT_BOX).trace([(0, 0, 0)], [(1, 1, 1)])
        self.assertEqual([none.integrate(np.empty(0)).tolist(), none.integrate(np.empty((0, 2))).tolist()], [[0.0], [[0.0, 0.0]]])
        self.assertEqual(d.trace(np.zeros((0, 3)), np.zeros((0, 3))).integrate(values[:, 0]).dtype, np.float64)

    def test_gradients(self):
        points = uniform(50, seed=7)
        origins, directions = uniform(40, seed=8).reshape(2, 20, 3)
        values, gradients = uniform(50, seed=9)[:, :2], uniform(100, seed=10).reshape(50, 2, 3)
        cells = vt.Diagram(points, box=UNIT_BOX, periodic=True).trace(origins, directions, 3.0, middles=True)
        self.assertEqual(cells.middles.shape, (len(cells.seeds), 3))
        both = cells.integrate(values, gradients)
        self.assertEqual(both.shape, (20, 2))
        np.testing.assert_allclose(both[:, 1], cells.integrate(values[:, 1], gradients[:, 1]), rtol=1e-14)
        with self.assertRaisesRegex(ValueError, r"gradients has shape \(50, 3\): values need \(50, 2, 3\)"):
            cells.integrate(values, gradients[:, 0])
        for wrong in (values[:-1], np.concatenate((values, values[:1])), values[0, 0]):
            with self.assertRaisesRegex(ValueError, r"values has shape .*: give \(50,\) or \(50, m\)"):
                cells.integrate(wrong)
        with self.assertRaisesRegex(ValueError, r"use trace\(..., middles=True\)"):
            vt.Diagram(points).trace(origins, directions).integrate(values, gradients)

    def test_refusals(self):
        d = vt.Diagram(uniform(300, seed=3), box=UNIT_BOX, periodic=True)
        at, along = [(0.5, 0.5, 0.5)], [(1, 0, 0)]
        for arguments, message in (
            ((at, [(0, 0, 0)]), "ray 0: its direction is 0"),
            ((at, [(np.nan, 0, 0)]), "not finite"),
            ((at, along, -1), "its length -1 is not 0 or more"),
            ((at, along, np.inf), "no wall ends it"),
            ((at, along * 2), "1 origins, but 2 directions"),
            ((at, along, [1, 2]), "lengths has shape"),
        ):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                d.trace(*arguments)


if __name__ == "__main__":
    unittest.main()
