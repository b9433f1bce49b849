"""Voronoi with freud's attributes, compared with freud."""

import unittest

import numpy as np
from helpers import have, uniform


@have("freud")
class Freud(unittest.TestCase):
    def compare(self, box, points):
        import freud
        from pyvotess.compat.freud import Voronoi

        ours, theirs = Voronoi().compute((box, points)), freud.locality.Voronoi().compute((box, points))
        np.testing.assert_allclose(ours.volumes, theirs.volumes, rtol=1e-4)
        self.assertAlmostEqual(ours.volumes.sum(), box.volume, delta=1e-5 * box.volume)
        weights = []
        for nlist in (ours.nlist, theirs.nlist):
            sums = {}
            for pair, weight in zip(nlist[:].tolist(), nlist.weights.tolist()):
                sums[tuple(pair)] = sums.get(tuple(pair), 0) + weight
            weights.append(sums)
        for pair, weight in weights[1].items():
            self.assertAlmostEqual(weights[0].get(pair, 0), weight, delta=1e-4)
        # freud drops faces whose normal it cannot compute.
        self.assertLess(len(weights[0].keys() - weights[1].keys()), 30)
        same = 0
        for mine, other in zip(ours.polytopes, theirs.polytopes):
            self.assertEqual(mine.shape[1], 3)
            if len(mine) == len(other):  # freud drops short edges
                same += 1
                far = np.linalg.norm(mine[:, None] - other, axis=2).min(axis=1)
                self.assertLess(far.max(), 1e-3)
        self.assertGreater(same, 0.9 * len(points))
        return ours

    def test_space(self):
        import freud

        box = freud.box.Box(3, 4, 5, xy=0.3, xz=-0.2, yz=0.4)
        points = box.make_absolute(uniform(200)) + [3, -8, 5]  # outside of the box
        ours = self.compare(box, points)
        self.assertIsNone(ours.plot())
        # A cell is around its point as given.
        self.assertLess(max(np.linalg.norm(row.mean(axis=0) - p) for row, p in zip(ours.polytopes, points)), 1.5)

    def test_plane(self):
        import freud

        box = freud.box.Box(3, 4, xy=0.5)
        points = box.make_absolute(uniform(200) * (1, 1, 0))
        points[:, 2] = 0
        ours = self.compare(box, points)
        first = ours.nlist
        self.assertEqual([len(row) for row in ours.polytopes], first.neighbor_counts.tolist())
        ours.compute((box, points[:50]))
        self.assertEqual((len(ours.polytopes), ours.nlist.num_points, first.num_points), (50, 50, 200))

    def test_refusals(self):
        import freud
        from pyvotess.compat.freud import Voronoi

        vor = Voronoi(threads=1)
        for name in ("volumes", "polytopes", "nlist"):
            with self.assertRaisesRegex(AttributeError, "compute"):
                getattr(vor, name)
        with self.assertRaisesRegex(ValueError, "duplicate"):
            vor.compute((freud.box.Box.cube(1), np.zeros((2, 3))))


if __name__ == "__main__":
    unittest.main()
