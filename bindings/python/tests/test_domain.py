"""Domains: periodic and triclinic boxes, walls, weights."""

import unittest

import numpy as np
import pyvotess as vt

UNIT = (0, 0, 0, 1, 1, 1)


def points(n, seed=1):
    return np.random.default_rng(seed).random((n, 3))


class Domains(unittest.TestCase):
    def test_one_seed_in_a_periodic_cube(self):
        t = vt.tessellate([[0.1, 0.7, 0.3]], box=UNIT, periodic=True, device="cpu")
        self.assertEqual(t.neighbors[0].tolist(), [0] * 6)
        self.assertEqual(t.shifts.dtype, np.int8)
        self.assertEqual(sorted(map(tuple, t.shifts.tolist())), sorted(
            (sign if k == 0 else 0, sign if k == 1 else 0, sign if k == 2 else 0) for k in range(3) for sign in (-1, 1)
        ))
        self.assertAlmostEqual(t.volumes[0], 1, places=13)

    def test_periodic_axes_by_word_and_by_flags(self):
        a = vt.tessellate(points(200), box=UNIT, periodic="xz", list_walls=True, device="cpu")
        b = vt.tessellate(points(200), box=UNIT, periodic=(True, False, True), list_walls=True, device="cpu")
        np.testing.assert_array_equal(a.neighbors.indices, b.neighbors.indices)
        np.testing.assert_array_equal(a.shifts, b.shifts)
        self.assertEqual(set(a.neighbors.indices[a.neighbors.indices < 0]), {-3, -4})
        self.assertTrue(a.verify())

    def test_lists_are_symmetric_with_opposite_shifts(self):
        t = vt.tessellate(points(300), cell=[(1, 0, 0), (0.4, 1, 0), (-0.3, 0.2, 1)], origin=(1, 2, 3), device="cpu")
        rows = np.repeat(np.arange(len(t)), np.diff(t.neighbors.indptr))
        faces = set(zip(rows.tolist(), t.neighbors.indices.tolist(), map(tuple, t.shifts.tolist())))
        for i, j, shift in faces:
            self.assertIn((j, i, tuple(-s for s in shift)), faces)
        self.assertAlmostEqual(t.stats.volume_sum, 1, places=12)
        self.assertTrue(t.verify())

    def test_shifts_exist_in_periodic_domains_only(self):
        self.assertIsNone(vt.tessellate(points(10)).shifts)

    def test_weights_and_radii(self):
        radii = np.random.default_rng(2).random(500) * 0.1
        a = vt.tessellate(points(500), radii=radii, device="cpu")
        b = vt.tessellate(points(500), weights=radii**2, device="cpu")
        np.testing.assert_array_equal(a.neighbors.indices, b.neighbors.indices)
        np.testing.assert_array_equal(a.weights, b.weights)
        self.assertGreater(a.stats.empty_cells, 0)
        empty = a.status == vt.CellStatus.EMPTY
        self.assertEqual(int(empty.sum()), a.stats.empty_cells)
        self.assertTrue((a.volumes[empty] == 0).all())
        self.assertTrue(a.verify())

    def test_walls(self):
        p = points(500)
        t = vt.tessellate(p, box=UNIT, walls=[(1, 1, 1, 1.5)], outside="drop", list_walls=True, device="cpu")
        np.testing.assert_array_equal(t.status == vt.CellStatus.OUTSIDE, p.sum(axis=1) > 1.5)
        self.assertIn(-7, t.neighbors.indices)
        self.assertAlmostEqual(t.stats.box_volume, 0.5, places=12)
        self.assertTrue(t.verify())
        np.testing.assert_array_equal(t.walls, [(1, 1, 1, 1.5)])
        self.assertEqual(t.periodic, (False, False, False))

    def test_the_result_tells_its_domain(self):
        cell = [(1, 0, 0), (0.4, 1, 0), (-0.3, 0.2, 1)]
        t = vt.tessellate(points(10), cell=cell, origin=(1, 2, 3), device="cpu")
        np.testing.assert_array_equal(t.cell, cell)
        np.testing.assert_array_equal(t.origin, (1, 2, 3))
        np.testing.assert_allclose(t.box, [(0.7, 2, 3), (2.4, 3.2, 4)])
        self.assertEqual(t.periodic, (True, True, True))
        self.assertEqual(t.walls.shape, (0, 4))
        self.assertIsNone(t.weights)
        t = vt.tessellate(points(10), box=UNIT, periodic="xz", radii=np.arange(10) / 100, device="cpu")
        self.assertEqual(t.periodic, (True, False, True))
        self.assertIsNone(t.cell)
        self.assertIsNone(t.origin)
        np.testing.assert_array_equal(t.weights, (np.arange(10) / 100) ** 2)
        for array in (t.weights, t.walls, t.box):
            self.assertFalse(array.flags.writeable)

    def test_a_cell_repeats_along_all_axes(self):
        for periodic in (False, True, "xyz", (True, True, True)):
            self.assertEqual(vt.tessellate(points(9), cell=np.eye(3), periodic=periodic).periodic, (True,) * 3)
        for periodic in ("x", "yz", (True, False, False)):
            with self.assertRaisesRegex(ValueError, "cell and periodic contradict each other"):
                vt.tessellate(points(9), cell=np.eye(3), periodic=periodic)

    def test_what_is_refused(self):
        for message, arguments in [
            ("periodic is 'xx'", {"periodic": "xx"}),
            ("one for each axis", {"periodic": (True, False)}),
            ("cell has shape", {"cell": (1, 2, 3)}),
            ("one plane", {"cell": ((1, 0, 0), (2, 0, 0), (0, 0, 1))}),
            ("origin goes with cell", {"origin": (0, 0, 0)}),
            ("box and cell", {"box": UNIT, "cell": np.eye(3)}),
            ("walls has shape", {"walls": [(1, 0, 0)]}),
            ("normal is 0", {"walls": [(0, 0, 0, 1)]}),
            ("walls and a periodic domain", {"box": UNIT, "periodic": True, "walls": [(1, 0, 0, 1)]}),
            ("point 0.*outside wall 0", {"walls": [(1, 0, 0, 0)]}),
            ("weights has shape", {"weights": [1, 2]}),
            ("weights and radii", {"weights": np.zeros(10), "radii": np.zeros(10)}),
            ("radius 3 = -1 is negative", {"radii": [0, 0, 0, -1, 0, 0, 0, 0, 0, 0]}),
            ("weight 2 = nan", {"weights": [0, 0, float("nan"), 0, 0, 0, 0, 0, 0, 0]}),
            ("outside is 'keep'", {"outside": "keep"}),
            ("min_face", {"min_face": -1}),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                vt.tessellate(points(10), **arguments)


if __name__ == "__main__":
    unittest.main()
