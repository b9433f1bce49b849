"""groups(): sums by plain code, symmetry, bad input."""

import unittest
from collections import defaultdict

import numpy as np
from helpers import ELL, UNIT_BOX, uniform

import pyvotess as vt

WANT = "neighbors,volumes,areas,surfaces"


class GroupsTest(unittest.TestCase):
    def check(self, t, labels):
        g = t.groups(labels)
        names = np.unique(labels)
        np.testing.assert_array_equal(g.labels, names)
        counts, areas, surfaces = defaultdict(int), defaultdict(float), defaultdict(float)
        for i in range(len(t)):
            for k in range(t.indptr[i], t.indptr[i + 1]):
                j = t.indices[k]
                other = j if j < 0 else np.searchsorted(names, labels[j])
                own = np.searchsorted(names, labels[i])
                if other != own:
                    counts[own, other] += 1
                    areas[own, other] += t.face_areas[k]
                    surfaces[own] += t.face_areas[k]
        for a in range(len(g)):
            np.testing.assert_array_equal(g.members[a], np.flatnonzero(labels == names[a]))
            row = slice(g.neighbors.indptr[a], g.neighbors.indptr[a + 1])
            self.assertEqual(g.neighbors[a].tolist(), sorted(b for own, b in counts if own == a))
            self.assertEqual(g.counts[row].tolist(), [counts[a, b] for b in g.neighbors[a]])
            np.testing.assert_allclose(g.areas[row], [areas[a, b] for b in g.neighbors[a]], rtol=1e-12)
            np.testing.assert_allclose(g.volumes[a], t.volumes[labels == names[a]].sum(), rtol=1e-12)
            if t.lists_walls or all(t.periodic):
                on_mesh = 0 if g.mesh_areas is None else t.mesh_areas[labels == names[a]].sum()
                np.testing.assert_allclose(g.surface_areas[a], surfaces[a] + on_mesh, rtol=1e-12, atol=1e-12)
            for b, area in zip(g.neighbors[a], g.areas[row]):
                if b >= 0:
                    back = g.areas[g.neighbors.indptr[b] : g.neighbors.indptr[b + 1]][g.neighbors[b] == a]
                    self.assertEqual(back.tolist(), [area], "the same from both sides")
        return g

    def test_plain_code(self):
        points = np.concatenate((uniform(80), uniform(2)))
        labels = np.random.default_rng(2).integers(-3, 9, 82) * 2**40
        for options in (
            {}, {"periodic": True}, {"periodic": "y"}, {"list_walls": True}, {"want": WANT + ",faces"},
            {"radii": uniform(82)[:, 0] / 4},
        ):  # fmt: skip
            self.check(vt.tessellate(points, **{"box": UNIT_BOX, "want": WANT, **options}), labels)
        self.check(vt.tessellate(points[:, :2], box=(0, 0, 1, 1), periodic=True, want=WANT), labels)
        g = self.check(vt.tessellate(uniform(82) * [2, 2, 1], mesh=ELL, want=WANT), labels)
        np.testing.assert_allclose(g.mesh_areas.sum(), 14, rtol=1e-12)

    def test_grains_of_a_lattice(self):
        """Halves of a cube: volumes, the area between them, and their surfaces are known."""
        axis = np.arange(6) + 0.5
        points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
        t = vt.tessellate(points, box=(0, 0, 0, 6, 6, 6), want=WANT)
        g = t.groups((points[:, 0] > 2).astype(int) + 5)
        self.assertEqual((g.labels.tolist(), g.volumes.tolist(), g.areas.tolist(), g.counts.tolist()),
                         ([5, 6], [72.0, 144.0], [36.0, 36.0], [36, 36]))  # fmt: skip
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
