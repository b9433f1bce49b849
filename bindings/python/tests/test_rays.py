"""trace(): arguments and results. The cells themselves are tested in C++ (tests/cases/query/trace.cpp)."""

import unittest

import numpy as np
from helpers import UNIT_BOX, uniform

import pyvotess as vt


class Rays(unittest.TestCase):
    def test_locate_agrees_in_the_middle_of_pieces(self):
        points = uniform(300, seed=3)
        origins, ends = uniform(200, seed=4).reshape(2, 100, 3)
        length = np.linalg.norm(ends - origins, axis=1)
        for periodic in (False, True):
            d = vt.Diagram(points, box=UNIT_BOX, periodic=periodic)
            cells = d.trace(origins, ends - origins)
            self.assertEqual(len(cells), 100)
            self.assertEqual(repr(cells), f"<pyvotess.RayCells: 100 rays through {len(cells.seeds)} cells>")
            np.testing.assert_allclose(cells.integrate(np.ones(300)), length, rtol=1e-13)
            rays = np.repeat(np.arange(100), np.diff(cells.offsets))
            passed = np.cumsum(cells.lengths)
            passed -= np.append(0, passed)[cells.offsets[rays]]
            middle = (passed - 0.5 * cells.lengths) / length[rays]
            found = d.locate(origins[rays] + middle[:, None] * (ends - origins)[rays])
            long = cells.lengths > 1e-9
            np.testing.assert_array_equal(found[long], cells.seeds[long])
            self.assertGreater(long.sum(), 500)

    def test_integrals_of_columns(self):
        d = vt.Diagram(uniform(300, seed=3), box=UNIT_BOX)
        cells = d.trace([(0.5, 0.5, 0.5), (2, 2, 2), (0.1, 0.1, 0.1)], [(1, 0, 0)] * 3, np.inf)
        self.assertEqual(cells.offsets[1], cells.offsets[2])  # begins outside
        values = uniform(300, seed=5)[:, :2]
        both = cells.integrate(values)
        self.assertEqual(both.shape, (3, 2))
        np.testing.assert_array_equal(both[1], 0)
        np.testing.assert_array_equal(both[:, 1], cells.integrate(values[:, 1]))
        first = slice(0, cells.offsets[1])
        self.assertAlmostEqual(both[0, 0], values[cells.seeds[first], 0] @ cells.lengths[first], 13)
        self.assertAlmostEqual(cells.lengths[first].sum(), 0.5, 14)
        self.assertEqual(d.trace(np.zeros((0, 3)), np.zeros((0, 3))).integrate(values).shape, (0, 2))

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
