"""derivatives(): volumes and areas compared with central differences, in every kind of domain."""

import tracemalloc
import unittest

import numpy as np
from helpers import CELL, CUBE, UNIT_BOX, have, uniform

import pyvotess as vt

SEEDS = 200
WANT = "faces,volumes,areas"
TOLERANCE = 1e-6  # relative to the largest derivative


class Derivatives(unittest.TestCase):
    @have("scipy")
    def test_units(self):
        points = uniform(20)
        near = vt.tessellate(points, box=UNIT_BOX, want="faces")
        in_mesh = vt.tessellate(points, mesh=CUBE, want="volumes")
        for unit in (2.0**-500, 2.0**-270, 2.0**300, 2.0**500):
            far = vt.tessellate(points * unit, box=np.asarray(UNIT_BOX) * unit, want="faces")
            for of, by, power in (("volumes", "points", 2), ("volumes", "weights", 1), ("areas", "points", 1), ("areas", "weights", 0)):
                found, expected = far.derivatives(of, by).toarray() / unit**power, near.derivatives(of, by).toarray()
                np.testing.assert_allclose(found, expected, atol=1e-9)
            if abs(np.log2(unit)) < 340:  # the volumes of parts are in range
                far = vt.tessellate(points * unit, mesh=(np.asarray(CUBE[0]) * unit, CUBE[1]), want="volumes")
                np.testing.assert_allclose(far.derivatives().toarray() / unit**2, in_mesh.derivatives().toarray(), atol=1e-9)

    def compare(self, points, weights=None, **domain):
        """Compares derivatives along random directions of all seeds or weights, and of one seed."""
        rng = np.random.default_rng(4)

        def run(moved, heavier):
            added = None if weights is None and not np.any(heavier) else (0 if weights is None else weights) + heavier
            return vt.tessellate(points + moved, weights=added, want=WANT, list_walls=True, **domain)

        t = run(0, 0)
        single = np.zeros((SEEDS, 3))
        single[17] = 1, -2, 0.5
        for by, directions, step in (
            ("points", (rng.normal(size=(SEEDS, 3)), single), 1e-7),
            ("weights", (rng.normal(size=SEEDS),), 1e-8),
        ):
            for direction in directions:
                change = step * direction
                after, before = (run(s * change, 0) if by == "points" else run(0, s * change) for s in (1, -1))
                for of, name in (("volumes", "volumes"), ("areas", "face_areas")):
                    np.testing.assert_array_equal(after.neighbors.indices, before.neighbors.indices)
                    numeric = (getattr(after, name) - getattr(before, name)) / (2 * step)
                    matrix = t.derivatives(of, by=by)
                    closed = matrix @ direction.ravel()
                    self.assertEqual(matrix.shape, (len(closed), direction.size))
                    error = np.abs(numeric - closed).max() / np.abs(closed).max()
                    self.assertLess(error, TOLERANCE, f"{of} by {by}, {domain}")
        return t

    @have("scipy")
    def test_central_differences(self):
        points = uniform(SEEDS, seed=6)
        weights = 0.004 * uniform(SEEDS, seed=7)[:, 0]
        inside = 0.95 * points
        cell = np.asarray(CELL, float)
        for given in (None, weights):
            self.compare(points, given, box=UNIT_BOX)
            self.compare(points, given, box=UNIT_BOX, periodic=True)
            self.compare(points, given, box=UNIT_BOX, periodic="xy")
            self.compare(points @ cell, given, cell=cell)
            self.compare(inside, given, box=UNIT_BOX, walls=[(1, 1, 1, 2.86), (-1, 2, 0, 1.92)])
        # Seeds beyond the box.
        self.compare(points + (3, -2, 0), None, box=UNIT_BOX, periodic=True)

    @have("scipy")
    def test_cells_that_reach_infinity(self):
        points = uniform(SEEDS, seed=6)
        direction = np.random.default_rng(4).normal(size=(SEEDS, 3))
        slab = ((0, 1), (0, 1), (-np.inf, np.inf))
        for size, domain in ((3, {"box": "none"}), (3, {"box": slab, "periodic": "xy"}), (2, {"box": "none"})):
            chosen, change = points[:, :size], direction[:, :size]
            want = "faces,volumes,areas" if size == 3 else "faces,volumes"
            t, after, before = (vt.tessellate(chosen + s * 1e-7 * change, want=want, **domain) for s in (0, 1, -1))
            closed = ~t.open_cells
            for words in ("volumes", "faces", "areas"):  # without walls, rows with areas do not tell
                other = vt.tessellate(chosen, want=words, list_walls=words == "areas", **domain)
                np.testing.assert_array_equal(other.open_cells, ~closed)
            with self.assertRaisesRegex((AttributeError, ValueError), "faces"):
                vt.tessellate(chosen, want="areas", **domain).derivatives(by="weights")
            self.assertTrue(0 < closed.sum() < SEEDS)
            np.testing.assert_array_equal(t.open_cells, np.isinf(t.volumes))
            with self.assertRaisesRegex(ValueError, "open='skip'"):
                t.derivatives()
            matrix = t.derivatives(open="skip")
            numeric = (after.volumes[closed] - before.volumes[closed]) / 2e-7
            found = matrix @ change.ravel()
            self.assertLess(np.abs(numeric - found[closed]).max(), TOLERANCE * np.abs(found).max(), domain)
            self.assertEqual(np.diff(matrix.indptr)[~closed].sum(), 0)
            if size == 3:
                of_areas = t.derivatives("areas", open="skip")
                rows = np.repeat(closed, np.diff(t.neighbors.indptr))
                numeric = (after.face_areas[rows] - before.face_areas[rows]) / 2e-7
                found = of_areas @ change.ravel()
                self.assertLess(np.abs(numeric - found[rows]).max(), 10 * TOLERANCE * np.abs(found).max(), domain)
                self.assertEqual(np.diff(of_areas.indptr)[~rows].sum(), 0)

    @have("scipy")
    def test_areas_suffice_for_weights(self):
        points, weights = uniform(SEEDS), 0.01 * np.random.default_rng(4).random(SEEDS)
        for periodic in (False, True):
            of_areas, of_faces = (
                vt.tessellate(points, box=UNIT_BOX, periodic=periodic, weights=weights, want=want).derivatives(by="weights")
                for want in ("areas", "faces")
            )
            self.assertLess(np.abs(of_areas - of_faces).max(), 1e-12)

    @have("scipy")
    def test_duplicates_and_none(self):
        points = uniform(20)
        points[7] = points[3]
        t = vt.tessellate(points, box=UNIT_BOX, want="faces")
        self.assertEqual(t.derivatives()[7].nnz, 0)
        empty = vt.tessellate(np.empty((0, 3)), box=UNIT_BOX, want="faces")
        self.assertEqual(empty.derivatives().shape, (0, 0))

    @have("scipy")
    def test_fewer_seeds_than_walls(self):
        ball = vt.walls.sphere((0.5, 0.5, 0.5), 0.5, 60)
        domains = (
            (dict(box=UNIT_BOX), 1),
            (dict(box=UNIT_BOX, periodic="xy"), 1),
            (dict(cell=CELL, periodic="z"), np.asarray(CELL)),
            (dict(walls=ball), 0.5),
        )
        direction = np.random.default_rng(8)
        for options, scale in domains:
            for count in (1, 2, 3, 5):
                points = uniform(count, seed=count)
                points = points @ scale if np.ndim(scale) else 0.5 + scale * (points - 0.5)
                way = 1e-6 * direction.normal(size=points.shape)
                t, after, before = (
                    vt.tessellate(points + s * way, want=WANT, list_walls=True, **options) for s in (0, 1, -1)
                )
                for of, name in (("volumes", "volumes"), ("areas", "face_areas")):
                    numeric = (getattr(after, name) - getattr(before, name)) / 2
                    closed = t.derivatives(of) @ way.ravel()
                    self.assertLess(np.abs(numeric - closed).max(), 1e-5 * np.abs(way).max(), f"{of}, {count}, {options}")
                    self.assertEqual(t.derivatives(of, by="weights").shape, (len(closed), count))

    @have("scipy")
    def test_memory(self):
        """Temporary arrays are smaller than a few copies of the matrix."""
        count = 1500
        t = vt.tessellate(uniform(count), box=UNIT_BOX, want="faces,areas")
        t.derivatives("areas")  # imports
        tracemalloc.start()
        matrix = t.derivatives("areas")
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        size = matrix.data.nbytes + matrix.indices.nbytes + matrix.indptr.nbytes
        self.assertLess(peak, 4 * size + 5_000_000)

    @have("scipy")
    def test_in_mesh(self):
        """A block with a hollow, where seeds lie inside and outside."""
        corners, triangles = CUBE
        mesh = (np.concatenate((corners, corners * 0.4 + 0.3)), np.concatenate((triangles, triangles[:, ::-1] + 8)))
        points, rng = 1.2 * uniform(60, seed=9) - 0.1, np.random.default_rng(5)
        weights = 0.01 * uniform(60, seed=10)[:, 0]

        def volumes(moved, heavier):
            return vt.tessellate(points + moved, weights=weights + heavier, mesh=mesh, device="cpu").volumes

        t = vt.tessellate(points, weights=weights, mesh=mesh, want="volumes", device="cpu")
        with_areas = vt.tessellate(points, weights=weights, mesh=mesh, want="volumes,areas", device="cpu")
        change, step = rng.normal(size=(60, 3)), 1e-7
        numeric = (volumes(step * change, 0) - volumes(-step * change, 0)) / (2 * step)
        np.testing.assert_allclose(t.derivatives() @ change.ravel(), numeric, atol=1e-6 * np.abs(numeric).max())
        change = change[:, 0]
        numeric = (volumes(0, step * change) - volumes(0, -step * change)) / (2 * step)
        for result in (t, with_areas):
            closed = result.derivatives(by="weights") @ change
            np.testing.assert_allclose(closed, numeric, atol=1e-6 * np.abs(numeric).max())
        with self.assertRaisesRegex(ValueError, "in a mesh give 'volumes'"):
            t.derivatives("areas")
        again = vt.tessellate(points, box=UNIT_BOX, periodic=True, mesh=CUBE, device="cpu")
        with self.assertRaisesRegex(ValueError, "leave out periodic= or mesh="):
            again.derivatives()

    @have("scipy")
    def test_refused(self):
        t = vt.tessellate(uniform(20), box=UNIT_BOX, want="faces")
        for arguments, says in ((("centroids",), "of is 'centroids': the words are volumes, areas"), (("areas", "radii"), "by is 'radii'")):
            with self.assertRaisesRegex(ValueError, says):
                t.derivatives(*arguments)
        with self.assertRaises(AttributeError):
            vt.tessellate(uniform(20), box=UNIT_BOX).derivatives()
        with self.assertRaisesRegex(ValueError, "whole cells"):
            vt.tessellate(uniform(20), box=UNIT_BOX, want="faces", min_face=0.5).derivatives()


if __name__ == "__main__":
    unittest.main()
