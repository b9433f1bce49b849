"""alpha_complex(): arrays, order, faces, slabs, GUDHI where installed, bad input. C++ has the exact ones (tests/cases/alpha.cpp)."""

import pickle
import unittest

import numpy as np
from helpers import UNIT_BOX, have, lattice, uniform

import pyvotess as vt


class AlphaComplex(unittest.TestCase):
    def check_order(self, a):
        """Checks that rows ascend, and that faces are there, once, with values that are not larger."""
        for k in range(4):
            rows = a.simplices[k]
            self.assertEqual((rows.dtype, rows.shape[1]), (np.int32, k + 1))
            self.assertEqual((a.values[k].dtype, a.gabriel[k].dtype), (np.float64, bool))
            self.assertTrue((np.diff(rows) > 0).all())
            self.assertEqual(list(map(tuple, rows.tolist())), sorted(set(map(tuple, rows.tolist()))))
        for k in range(1, 4):
            values = {tuple(s): v for s, v in zip(a.simplices[k - 1].tolist(), a.values[k - 1])}
            for s, v in zip(a.simplices[k].tolist(), a.values[k]):
                for i in range(k + 1):
                    self.assertLessEqual(values[tuple(s[:i] + s[i + 1 :])], v)

    def test_space(self):
        a = vt.tessellate(uniform(200), box="none", want="faces").alpha_complex()
        self.check_order(a)
        self.assertIsNone(a.shifts)
        copied = pickle.loads(pickle.dumps(a))
        np.testing.assert_array_equal(copied.values[2], a.values[2])
        self.assertIn("200, ", repr(a))

    def test_filtration(self):
        a = vt.tessellate(lattice(3), want="faces", box="none").alpha_complex()
        dimensions, rows = a.filtration()
        self.assertEqual(len(dimensions), sum(map(len, a.simplices)))
        seen = {()}
        last = -np.inf
        for k, row in zip(dimensions.tolist(), rows.tolist()):
            s = tuple(a.simplices[k][row].tolist())
            self.assertTrue(all(s[:i] + s[i + 1 :] in seen for i in range(k + 1)))
            self.assertNotIn(s, seen)
            self.assertGreaterEqual(a.values[k][row], last)
            last = a.values[k][row]
            seen.add(s)

    def test_slab(self):
        """The complex of a slab is that of its images, around one of them."""
        points = np.floor(uniform(14, seed=3) * 2**20) / 2**20
        edges = np.array([(1, 0, 0), (0.5, 1, 0.125), (0, 0, 0)])
        for lattice, domain in (
            (np.diag((1, 0, 0)), {"box": ((0, 1), (-1, 2), (-1, 2)), "periodic": "x"}),
            (edges, {"cell": edges}),
            (edges, {"cell": edges + [(0, 0, 0), (0, 0, 0), (0.25, 0, 9)], "origin": (0, 0, -4), "periodic": "xy"}),
        ):
            t = vt.tessellate(points, **domain)
            a = t.alpha_complex(3)
            along_b = 3 if t.periodic[1] else 1
            self.assertEqual(a.replicate, (3, along_b, 1))
            shifts = np.array([(i, j, 0) for i in range(-3, 4) for j in (range(-3, 4) if along_b == 3 else (0,))])
            images = np.concatenate([t.wrapped_points + s @ lattice for s in shifts])
            all_space = vt.tessellate(images, box="none").alpha_complex()

            def named(members):
                """Returns the members of a simplex up to a translation."""
                first = [shift for seed, shift in members if seed == min(m[0] for m in members)]
                return min(tuple(sorted((seed, *(shift - f).tolist()) for seed, shift in members)) for f in first)

            for k in range(4):
                place = a.simplices[k] // 14
                copy = np.stack((place // along_b, place % along_b, 0 * place), axis=-1)
                copy += a.replicate * a.shifts[k].astype(int)
                seeds = a.simplices[k] % 14
                ours = {
                    named([(int(s), c) for s, c in zip(*row)]): (round(float(value), 9), bool(gabriel))
                    for *row, value, gabriel in zip(seeds, copy, a.values[k], a.gabriel[k])
                }
                middle = 14 * (len(shifts) // 2)
                theirs = {
                    named([(int(s) % 14, shifts[s // 14]) for s in row]): (round(float(value), 9), bool(gabriel))
                    for row, value, gabriel in zip(all_space.simplices[k], all_space.values[k], all_space.gabriel[k])
                    if ((row >= middle) & (row < middle + 14)).any()
                }
                self.assertEqual(ours, theirs, (k, domain))
                self.assertEqual(len(a.simplices[k]), 3 * along_b * len(ours))

    def test_layer(self):
        """Seeds in one plane have the complex of the plane."""
        points = uniform(14, seed=4) * (1, 1, 0)
        a = vt.tessellate(points, box=((0, 1), (0, 1), (-np.inf, np.inf)), periodic="xy").alpha_complex(3)
        count = [len(simplices) for simplices in a.simplices]
        self.assertEqual(count, [9 * 14, 9 * 3 * 14, 9 * 2 * 14, 0])

    def test_double_edges_on_a_periodic_line(self):
        """Added points span space there, and may hide an edge."""
        options = dict(box=(0, 0, 0, 64, 10, 10), periodic="x", want="faces")
        pair = vt.tessellate([(10, 5, 5), (19, 5, 5)], **options)
        one = vt.tessellate([(10, 5, 5)], **options)
        for t, replicate, message in (
            (pair, 1, "two edges join seeds 0 and 1"), (one, 1, "an edge joins seed 0 to its own image"),
            (one, (2, 1, 1), "two edges join copies of seed 0: .*, replicate it 3 times or more"),
        ):  # fmt: skip
            with self.assertRaisesRegex(ValueError, message):
                t.alpha_complex(replicate=replicate)
        self.assertEqual(sorted(pair.alpha_complex(replicate=(2, 1, 1)).values[1]), [20.25, 20.25, 756.25, 756.25])
        self.assertEqual(one.alpha_complex(replicate=(3, 1, 1)).values[1].tolist(), [1024.0] * 3)

    def test_bad_input(self):
        small = vt.tessellate(uniform(12), box=UNIT_BOX, periodic=True)
        with self.assertRaisesRegex(ValueError, "two edges join seeds .* replicate it 2 times or more"):
            small.alpha_complex()
        for replicate in (0, (1, -(2**40), 1)):
            with self.assertRaisesRegex(ValueError, "at least 1"):
                small.alpha_complex(replicate)
        for replicate in (1.5, (2, 2), "2"):
            with self.assertRaisesRegex(ValueError, "replicate is"):
                small.alpha_complex(replicate)
        with self.assertRaisesRegex(ValueError, "not periodic"):
            vt.tessellate(uniform(12)).alpha_complex(2)
        with self.assertRaisesRegex(ValueError, "along axis 2, along which it does not repeat"):
            vt.tessellate(uniform(12), box=UNIT_BOX, periodic="xy").alpha_complex((2, 2, 2))
        with self.assertRaisesRegex(ValueError, "leave out only="):
            vt.tessellate(uniform(12), only=[3]).alpha_complex()

    @have("gudhi")
    def test_gudhi(self):
        import gudhi

        for points, weights in (
            (uniform(150), None),
            (uniform(150), uniform(150, seed=3)[:, 0] * 0.02 - 0.01),
            (uniform(150) * (1, 1, 0), None),
            (lattice(3), None),
        ):
            options = {} if weights is None else {"weights": weights}
            tree = vt.tessellate(points, **options).alpha_complex().to_gudhi()
            expected = gudhi.AlphaComplex(points, precision="exact", **options).create_simplex_tree()
            if len(points) != 27:  # GUDHI cuts ties in another way
                values = {tuple(s): v for s, v in expected.get_simplices()}
                own = {tuple(s): v for s, v in tree.get_simplices()}
                self.assertEqual(own.keys(), values.keys())
                np.testing.assert_allclose([own[s] for s in values], list(values.values()), rtol=1e-9, atol=1e-12)
            for t in (tree, expected):
                self.assertFalse(t.make_filtration_non_decreasing())
                t.persistence(min_persistence=1e-9)
            for k in range(3):
                ours, theirs = (np.sort(t.persistence_intervals_in_dimension(k), axis=0) for t in (tree, expected))
                np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-12)


if __name__ == "__main__":
    unittest.main()
