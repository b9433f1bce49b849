"""lloyd(): energies compared with closed forms and gradients, steps with one dimension, arguments."""

import dataclasses
import sys
import unittest
from unittest import mock

import numpy as np
from helpers import CELL, CUBE, ELL, UNIT_BOX, lattice, uniform

import pyvotess as vt

SEEDS = 60
TETRAHEDRON = [(1, 1, 1, 1)]  # a wall that keeps a corner of the unit box


def domains():
    """Returns seeds and a domain of each kind."""
    points = uniform(SEEDS, seed=6)
    cell = np.asarray(CELL, float)
    yield points, {"box": UNIT_BOX}
    yield points, {"box": UNIT_BOX, "periodic": True}
    yield points, {"box": UNIT_BOX, "periodic": "xy"}
    yield points @ cell + 5, {"cell": cell, "origin": (5, 5, 5)}
    yield points @ cell, {"cell": cell, "periodic": "z"}
    yield points / 3, {"box": UNIT_BOX, "walls": TETRAHEDRON}
    yield points / 3, {"walls": vt.walls.sphere((0.15, 0.15, 0.15), 0.4, 30)}
    yield points * (1, 2, 1), {"mesh": ELL}


def energy(points, density=None, **domain):
    return vt.lloyd(points, steps=0, density=density, **domain).energies[0]


class Energy(unittest.TestCase):
    def test_energies_by_moments_are_those_by_polygons(self):
        module = sys.modules["pyvotess.fields.lloyd"]
        for points, domain in domains():
            relaxed = vt.lloyd(points, steps=5, **domain)
            with mock.patch.object(module, "_MAX_RATIO", 0):
                expected = vt.lloyd(points, steps=5, **domain)
            np.testing.assert_array_equal(relaxed.points, expected.points)
            np.testing.assert_allclose(relaxed.energies, expected.energies, rtol=1e-11)

    def test_one_seed(self):
        p = np.array([0.3, 0.1, 0.9])
        self.assertAlmostEqual(energy([p], box=UNIT_BOX), 3 / 12 + ((p - 0.5) ** 2).sum(), places=14)
        # A seed may be its own neighbor: the images of one seed form a lattice, here face-centered cubic.
        cell = np.array([(0, 1, 1), (1, 0, 1), (1, 1, 0)])
        self.assertAlmostEqual(energy([p], cell=cell), 3 * 2 ** (-11 / 3) * 2 ** (5 / 3), places=13)

    def test_lattices(self):
        """Normalized second moments of cells (Conway and Sloane 1982)."""
        cubes = lattice(4)
        self.assertAlmostEqual(energy(cubes, box=(0, 0, 0, 4, 4, 4)), 64 / 4, places=12)
        bcc = np.concatenate((cubes, cubes + 0.5))
        moment = 19 / (192 * 2 ** (1 / 3))
        expected = 3 * moment * 128 * 0.5 ** (5 / 3)
        self.assertAlmostEqual(energy(bcc, box=(0, 0, 0, 4, 4, 4), periodic=True), expected, places=12)

    def test_gradient(self):
        """The gradient by a seed is twice the mass times its distance from the centroid (Du, Faber, Gunzburger 1999)."""
        direction = np.random.default_rng(4).normal(size=(SEEDS, 3))
        for points, domain in domains():
            if "box" not in domain and "cell" not in domain:
                domain["box"] = vt.tessellate(points, **domain).box
            t = vt.tessellate(points, want="volumes,centroids", **domain)
            gradient = 2 * t.volumes[:, None] * (t.wrapped_points - t.centroids)
            step = 1e-6
            numeric = (energy(points + step * direction, **domain) - energy(points - step * direction, **domain)) / (2 * step)
            self.assertAlmostEqual(numeric / (gradient * direction).sum(), 1, places=6, msg=str(domain))

    def test_blocks(self):
        points = uniform(SEEDS)
        for density in (None, lambda x: 1 + x[:, 0]):
            expected = vt.lloyd(points, steps=1, density=density, box=UNIT_BOX)
            with mock.patch("pyvotess.fields.simplices._FACES", 7):
                pieces = vt.lloyd(points, steps=1, density=density, box=UNIT_BOX)
            np.testing.assert_allclose(pieces.energies, expected.energies, rtol=1e-13)
            np.testing.assert_allclose(pieces.points, expected.points, rtol=1e-12)


class Steps(unittest.TestCase):
    def test_energy_falls(self):
        for points, domain in domains():
            for over_relaxation in (0.5, 1.0, 1.9):
                r = vt.lloyd(points, steps=12, over_relaxation=over_relaxation, **domain)
                self.assertEqual((len(r.energies), len(r.moved)), (13, 12))
                self.assertLess(np.diff(r.energies).max(), 0, f"{over_relaxation} {domain}")
                self.assertTrue(r.tessellation.in_mesh or r.tessellation.verify())
                np.testing.assert_array_equal(r.tessellation.points, r.points)

    def test_a_step_goes_to_the_centroids(self):
        for points, domain in domains():
            before = points.copy()
            r = vt.lloyd(points, steps=1, **domain)
            t = vt.tessellate(points, want="volumes,centroids", **domain)
            way = t.centroids - t.wrapped_points
            np.testing.assert_allclose(r.points - points, way, atol=1e-14)
            spacing = np.cbrt(t.volumes.sum() / SEEDS)
            self.assertAlmostEqual(r.moved[0], np.linalg.norm(way, axis=1).max() / spacing, places=12)
            np.testing.assert_array_equal(points, before)

    def test_ways_are_not_wrapped(self):
        points = uniform(SEEDS)
        r = vt.lloyd(points, steps=5, box=UNIT_BOX, periodic=True)
        moved = vt.lloyd(points + (3, -2, 0), steps=5, box=UNIT_BOX, periodic=True)
        np.testing.assert_allclose(moved.points - (3, -2, 0), r.points, atol=1e-12)
        np.testing.assert_allclose(moved.energies, r.energies, rtol=1e-12)
        self.assertLess(np.abs(r.points - points).max(), 0.5)

    def test_over_relaxation_stays_inside(self):
        seed = np.array([[0.9, 0.05, 0.04]])
        for over_relaxation, expected in ((1.9, np.full(3, 0.25)), (1.2, seed[0] + 1.2 * (0.25 - seed[0]))):
            r = vt.lloyd(seed, steps=1, box=UNIT_BOX, walls=TETRAHEDRON, over_relaxation=over_relaxation)
            np.testing.assert_allclose(r.points[0], expected, atol=1e-14)
        # Across the edges of a cell, and across a wall that is not normalized.
        points, cell = uniform(8, seed=2), np.array([(1, 0, 0), (-0.9, 1, 0), (0, 0, 1)])
        for start, domain in (
            (points @ cell + 5, {"cell": cell, "origin": (5, 5, 5), "periodic": "z"}),
            (points / 3, {"box": UNIT_BOX, "walls": [(70, 70, 70, 70)]}),
        ):
            vt.lloyd(start, steps=30, over_relaxation=1.99, **domain)
            # With this small over-relaxation no seed leaves the domain.
            t = vt.tessellate(start, want="centroids", **domain)
            r = vt.lloyd(start, steps=1, over_relaxation=1.01, **domain)
            np.testing.assert_allclose(r.points - start, 1.01 * (t.centroids - t.wrapped_points), atol=1e-13)

    def test_outside(self):
        """Seeds outside with a cell move into the domain; the others and dropped ones stay."""
        points = 1.6 * uniform(SEEDS) - 0.3
        inside = ((points > 0) & (points < 1)).all(axis=1)
        r = vt.lloyd(points, steps=12, box=UNIT_BOX, outside="keep")
        first = vt.tessellate(points, box=UNIT_BOX, outside="keep", want="centroids")
        with_cell = first.status == 0
        self.assertTrue(0 < (with_cell & ~inside).sum() and (~with_cell).any())
        self.assertLess(np.diff(r.energies).max(), 0)
        moved = r.points[with_cell]
        self.assertTrue(((moved > 0) & (moved < 1)).all())
        step = vt.lloyd(points, steps=1, box=UNIT_BOX, outside="keep").points
        np.testing.assert_array_equal(step[~with_cell], points[~with_cell])
        np.testing.assert_allclose(step[with_cell], first.centroids[with_cell], atol=1e-14)
        r = vt.lloyd(points, steps=5, box=UNIT_BOX, outside="drop")
        np.testing.assert_array_equal(r.points[~inside], points[~inside])
        np.testing.assert_array_equal(r.points[inside], vt.lloyd(points[inside], steps=5, box=UNIT_BOX).points)
        for outside in ("keep", "drop"):
            r = vt.lloyd(points, steps=2, box=UNIT_BOX, outside=outside, volumes=np.ones(SEEDS), normalize=True)
            kept = inside if outside == "drop" else np.ones(SEEDS, bool)
            np.testing.assert_allclose(r.tessellation.volumes[kept], 1 / kept.sum(), rtol=1e-8)
        with self.assertRaisesRegex(ValueError, "the function is read between seeds and faces"):
            vt.lloyd(points, steps=1, density=lambda x: x[:, 0], box=UNIT_BOX, outside="keep")

    def test_fixed(self):
        points = uniform(SEEDS)
        mask = np.arange(SEEDS) % 3 == 0
        for fixed in (mask, np.flatnonzero(mask), np.flatnonzero(mask).tolist()):
            r = vt.lloyd(points, steps=10, box=UNIT_BOX, fixed=fixed)
            np.testing.assert_array_equal(r.points[mask], points[mask])
            self.assertTrue((r.points[~mask] != points[~mask]).any(axis=1).all())
            self.assertLess(np.diff(r.energies).max(), 0)
        r = vt.lloyd(points, steps=10, box=UNIT_BOX, fixed=np.ones(SEEDS, bool))
        self.assertEqual((r.moved.tolist(), len(r.energies)), ([0.0], 2))

    def test_tolerance(self):
        r = vt.lloyd(uniform(SEEDS), steps=500, box=UNIT_BOX, tolerance=0.02)
        self.assertLessEqual(r.moved[-1], 0.02)
        self.assertGreater(r.moved[:-1].min(), 0.02)
        self.assertEqual(len(r.energies), len(r.moved) + 1)
        # The result does not depend on the unit.
        large = vt.lloyd(1000 * uniform(SEEDS), steps=500, box=1000 * np.array(UNIT_BOX), tolerance=0.02)
        self.assertEqual(len(large.moved), len(r.moved))
        # A lattice is centroidal.
        self.assertEqual(len(vt.lloyd(lattice(3), steps=9, box=(0, 0, 0, 3, 3, 3), tolerance=1e-12).moved), 1)

    def test_duplicates_part(self):
        points = np.concatenate((uniform(20), uniform(1)))
        one = vt.lloyd(points, steps=1, box=UNIT_BOX)
        np.testing.assert_array_equal(one.points[20], points[20])
        self.assertEqual(vt.CellStatus(one.tessellation.status[20]), vt.CellStatus.CERTIFIED)
        self.assertLess(np.diff(vt.lloyd(points, steps=5, box=UNIT_BOX).energies).max(), 0)

    def test_the_box_of_the_start_stays(self):
        points = uniform(SEEDS)
        r = vt.lloyd(points, steps=3)
        np.testing.assert_array_equal(r.tessellation.box, vt.tessellate(points).box)

    def test_none(self):
        r = vt.lloyd(np.empty((0, 3)), steps=3)
        self.assertEqual((r.points.shape, r.energies.tolist()), ((0, 3), [0.0, 0.0]))


class Meshes(unittest.TestCase):
    def test_cube(self):
        points = uniform(SEEDS)
        for density in (None, lambda x: 1 + x[:, 0]):
            r, expected = (vt.lloyd(points, steps=4, density=density, **domain) for domain in ({"mesh": CUBE}, {"box": UNIT_BOX}))
            np.testing.assert_allclose(r.points, expected.points, atol=1e-13)
            # The rule is not exact for the energy of this density, and the tetrahedra differ.
            np.testing.assert_allclose(r.energies, expected.energies, rtol=1e-13 if density is None else 1e-4)
        volumes = np.linspace(1, 2, SEEDS)
        r, expected = (
            vt.lloyd(points, steps=2, volumes=volumes, normalize=True, **domain) for domain in ({"mesh": CUBE}, {"box": UNIT_BOX})
        )
        np.testing.assert_allclose(r.points, expected.points, atol=1e-9)
        self.assertAlmostEqual(vt.transport_cost(r.tessellation), r.energies[-1], places=14)

    def test_whole_periodic_domain(self):
        """A mesh that is the whole domain changes nothing. Pieces end where the density jumps."""
        cell = np.asarray(CELL, float)
        for edges, domain in ((np.eye(3), {"box": UNIT_BOX, "periodic": True}), (cell, {"cell": cell})):
            points = uniform(SEEDS, seed=8) @ edges
            for density in (None, lambda x: 1 + x[:, 0] * x[:, 1]):
                r, expected = (
                    vt.lloyd(points, steps=3, density=density, **domain, **more) for more in ({"mesh": (CUBE[0] @ edges, CUBE[1])}, {})
                )
                np.testing.assert_allclose(r.energies, expected.energies, rtol=5e-3 if density else 1e-12)
                np.testing.assert_allclose(r.points, expected.points, atol=1e-2 if density else 1e-12)

    def test_two_boxes(self):
        """The mesh is their union. Seeds outside of it have cells too."""
        points = 2 * uniform(SEEDS, seed=7) * (1, 1, 0.5)
        r = vt.lloyd(points, steps=1, mesh=ELL)
        mass, moment, total = 0, 0, 0
        for box in ((0, 0, 0, 2, 1, 1), (0, 1, 0, 1, 2, 1)):
            t = vt.tessellate(points, box=box, outside="keep", want="faces,volumes,centroids")
            total += vt.transport_cost(t)
            mass, moment = mass + t.volumes, moment + np.nan_to_num(t.volumes[:, None] * t.centroids)
        centroids = np.where(mass > 0, moment.T / np.where(mass > 0, mass, 1), points.T).T
        np.testing.assert_allclose(r.points, centroids, atol=1e-12)
        self.assertAlmostEqual(r.energies[0], total, places=12)
        self.assertLess(r.energies[1], r.energies[0])
        r = vt.lloyd(points, steps=5, density=lambda x: 1 + x[:, 0] ** 2, mesh=ELL)
        self.assertLess(np.diff(r.energies).max(), 0)

    def test_blocks(self):
        points = uniform(SEEDS)
        expected = vt.lloyd(points, steps=1, mesh=CUBE)
        with mock.patch("pyvotess.fields.simplices._TRIANGLES", 7):
            np.testing.assert_allclose(vt.lloyd(points, steps=1, mesh=CUBE).energies, expected.energies, rtol=1e-13)


class Densities(unittest.TestCase):
    def test_constant(self):
        for points, domain in domains():
            plain = vt.lloyd(points, steps=3, **domain)
            weighted = vt.lloyd(points, steps=3, density=lambda x: np.full(len(x), 2.0), **domain)
            np.testing.assert_allclose(weighted.points, plain.points, atol=1e-12)
            np.testing.assert_allclose(weighted.energies, 2 * plain.energies, rtol=1e-12)

    def test_line(self):
        """Seeds in a row stay in it. With density x the centroid of a cell from a to b is 2/3 (b^3 - a^3) / (b^2 - a^2)."""
        x = np.sort(uniform(7, seed=3)[:, 0])
        r = vt.lloyd(np.column_stack((x, np.full((7, 2), 0.5))), steps=60, density=lambda p: p[:, 0], box=UNIT_BOX)
        for _ in range(60):
            ends = np.concatenate(([0], (x[1:] + x[:-1]) / 2, [1]))
            x = 2 / 3 * np.diff(ends**3) / np.diff(ends**2)
        np.testing.assert_allclose(r.points[:, 0], x, rtol=1e-12)
        np.testing.assert_allclose(r.points[:, 1:], 0.5, rtol=1e-12)
        self.assertGreater(x[0], 1 - x[-1])  # seeds are sparse where the density is low
        self.assertLess(np.diff(r.energies).max(), 0)

    def test_energy(self):
        # In a cube around its seed the slope of the density does not change the energy.
        expected = 0.5 * 64 * 0.25**5 / 4
        self.assertAlmostEqual(energy(lattice(4) / 4, lambda p: p[:, 0], box=UNIT_BOX) / expected, 1, places=2)

    def test_energy_falls(self):
        def bump(p):
            return 0.05 + np.exp(-20 * ((p - 0.5) ** 2).sum(axis=1))

        for domain in ({}, {"periodic": True}):
            points = uniform(200)
            r = vt.lloyd(points, steps=15, density=bump, box=UNIT_BOX, **domain)
            self.assertLess(np.diff(r.energies).max(), 0)
            away = [np.linalg.norm(p - 0.5, axis=1) for p in (points, r.points)]
            self.assertGreater(np.mean(away[1] < 0.3), 1.5 * np.mean(away[0] < 0.3))

    def test_points_of_the_density_lie_in_the_domain(self):
        for points, domain in domains():
            seen = []

            def density(x):
                seen.append(x)
                return np.ones(len(x))

            r = vt.lloyd(points, steps=1, density=density, **domain)
            x = np.concatenate(seen)
            t = r.tessellation
            origin, edges = (t.box[0], np.diag(t.box[1] - t.box[0])) if t.cell is None else (t.origin, t.cell)
            shares = (x - origin) @ np.linalg.inv(edges)
            self.assertTrue(((shares > -1e-12) & (shares < 1 + 1e-12)).all(), str(domain))
            self.assertTrue((x @ t.walls[:, :3].T <= t.walls[:, 3] + 1e-12).all())

    def test_no_mass(self):
        points = np.array([[0.1, 0.5, 0.5], [0.9, 0.5, 0.5]])
        r = vt.lloyd(points, steps=1, density=lambda x: np.where(x[:, 0] > 0.5, 1.0, 0.0), box=UNIT_BOX)
        np.testing.assert_allclose(r.points, [[0.1, 0.5, 0.5], [0.75, 0.5, 0.5]], atol=1e-14)

    def test_refused(self):
        with self.assertRaisesRegex(ValueError, "too large for energies in float64: give lengths in another unit"):
            vt.lloyd(uniform(5) * 1e105, box=np.asarray(UNIT_BOX) * 1e105, steps=1)
        for density, says in (
            (lambda x: x, r"shape \(\d+, 3\) for \d+ points"),
            (lambda x: 1.0, r"shape \(\) for"),
            (lambda x: x[:, 0] - 0.5, r"density is -0\.\d+ at \(0\.\d+, "),
            (lambda x: np.full(len(x), np.nan), "density is nan"),
            (lambda x: np.full(len(x), np.inf), "density is inf"),
        ):
            with self.assertRaisesRegex(ValueError, says):
                vt.lloyd(uniform(5), steps=1, density=density, box=UNIT_BOX)
        with self.assertRaisesRegex(TypeError, "function of points or an array, not int"):
            vt.lloyd(uniform(5), steps=1, density=1, box=UNIT_BOX)
        with self.assertRaisesRegex(ZeroDivisionError, "mine"):
            vt.lloyd(uniform(5), steps=1, density=mock.Mock(side_effect=ZeroDivisionError("mine")), box=UNIT_BOX)


class Calls(unittest.TestCase):
    def test_refused(self):
        points = uniform(5)
        for options, says in (
            ({"steps": -1}, "steps is -1"),
            ({"tolerance": -1e-9}, "tolerance is -1e-09"),
            ({"tolerance": np.nan}, "tolerance is nan"),
            ({"normalize": True}, "normalize= goes with volumes= only"),
            ({"density": lambda x: np.zeros(len(x))}, "the density is 0 at all places where it was read"),
            ({"density": np.zeros((2, 2, 2))}, "the density is 0 in all cells"),
            ({"over_relaxation": 2.0}, "over_relaxation is 2.0"),
            ({"over_relaxation": 0}, "over_relaxation is 0"),
            ({"fixed": [True, False]}, r"fixed has shape \(2,\) for 5 points"),
            ({"fixed": [1, 5]}, r"fixed\[1\] is 5: indices of 5 points are 0 to 4"),
            ({"fixed": [-1]}, r"fixed\[0\] is -1"),
            ({"fixed": [0.5]}, "fixed has dtype float64"),
            ({"box": (0, 0, 0, 0.1, 0.1, 0.1)}, "point"),
            ({"periodic": True}, "box"),
        ):
            with self.assertRaisesRegex(ValueError, says):
                vt.lloyd(points, **options)

    def test_progress(self):
        shares = []
        vt.lloyd(uniform(50), steps=4, box=UNIT_BOX, progress=shares.append)
        self.assertEqual((shares[0], shares[-1]), (0.0, 1.0))
        self.assertEqual(shares, sorted(shares))
        self.assertGreaterEqual(len(shares), 5)
        with self.assertRaises(vt.VotessError) as caught:
            vt.lloyd(uniform(50), steps=4, box=UNIT_BOX, progress=lambda share: share < 0.5)
        self.assertEqual(caught.exception.code, vt.ErrorCode.CANCELLED)

    def test_result(self):
        r = vt.lloyd(uniform(50).astype(np.float32), steps=2, box=UNIT_BOX, threads=1, device="cpu")
        self.assertEqual(r.points.dtype, np.float64)
        self.assertIn("50 seeds, 2 steps", repr(r))
        np.testing.assert_allclose(r.tessellation.volumes.sum(), 1)
        with self.assertRaises(dataclasses.FrozenInstanceError):
            r.points = None


if __name__ == "__main__":
    unittest.main()
