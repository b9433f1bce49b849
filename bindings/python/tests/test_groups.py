"""groups(): known sums, bad input. C++ compares them with plain code (tests/cases/groups.cpp)."""

import unittest

import numpy as np
from helpers import UNIT_BOX, uniform

import pyvotess as vt

WANT = "neighbors,volumes,areas,surfaces"


class GroupsTest(unittest.TestCase):
    def test_grains_of_a_lattice(self):
        """Halves of a cube: volumes, the area between them, and their surfaces are known."""
        axis = np.arange(6) + 0.5
        points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
        t = vt.tessellate(points, box=(0, 0, 0, 6, 6, 6), want=WANT)
        g = t.groups((points[:, 0] > 2).astype(int) + 5)
        self.assertEqual((g.labels.tolist(), g.volumes.tolist(), g.areas.tolist(), g.counts.tolist()),
                         ([5, 6], [72.0, 144.0], [36.0, 36.0], [36, 36]))  # fmt: skip
        np.testing.assert_array_equal(g.members[1], np.flatnonzero(points[:, 0] > 2))
        np.testing.assert_allclose(g.surface_areas, [2 * (36 + 12 + 12), 2 * (36 + 24 + 24)], rtol=1e-12)
        whole = vt.tessellate(points, box=(0, 0, 0, 6, 6, 6), periodic=True, want=WANT).groups(np.zeros(216, int))
        self.assertEqual((len(whole.neighbors[0]), abs(whole.surface_areas[0]) < 1e-9), (0, True))
        alone = vt.tessellate(uniform(1), box=UNIT_BOX, want=WANT).groups([3])
        self.assertEqual(alone.surface_areas.tolist(), [6.0])

    def test_arrays_that_were_not_wanted(self):
        g = vt.tessellate(uniform(30)).groups(np.arange(30))
        self.assertIsNone(g.areas)
        self.assertIsNone(g.surface_areas)
        self.assertEqual(len(vt.tessellate(np.empty((0, 3)), want=WANT).groups([])), 0)

    def test_bad_input(self):
        t = vt.tessellate(uniform(20))
        for call, message in (
            (lambda: t.groups(np.zeros(19, int)), r"labels has shape \(19,\) for 20 cells"),
            (lambda: t.groups(np.zeros(20)), "labels has dtype float64: give whole numbers"),
            (lambda: t.groups(np.full(20, 2**64 - 1, np.uint64)), "labels holds 18446744073709551615"),
            (lambda: vt.tessellate(uniform(20), only=[1, 2]).groups([1, 2]), "only="),
        ):
            with self.assertRaisesRegex(ValueError, message):
                call()
        with self.assertRaises(AttributeError):
            vt.tessellate(uniform(20), want="volumes").groups(np.zeros(20, int))


if __name__ == "__main__":
    unittest.main()
