"""masses(), and fit_volumes(), lloyd() and transport_cost() under a density: fractions, 50 digits, differences, bad input."""

import decimal
import itertools
import unittest
from decimal import Decimal
from fractions import Fraction

import numpy as np
from helpers import CELL, CUBE, UNIT_BOX, lattice, uniform
from plane_oracle import cut, moments
from test_fit import clipped, cube, dot, measured, minus

import pyvotess as vt

SQUARE = (0, 0, 1, 1)


def image(shape, seed=1, black=0.4):
    """Returns random values, some of which are 0."""
    random = np.random.default_rng(seed)
    return random.random(shape) * (random.random(shape) > black)


def exact_masses(points, weights, values, periodic):
    """Returns mass, integrals of x and y, and second moment of each cell of the unit square, in fractions."""
    seeds = [tuple(map(Fraction, p)) for p in points.tolist()]
    w = list(map(Fraction, weights.tolist()))
    images = list(itertools.product((-1, 0, 1), repeat=2)) if periodic else [(0, 0)]
    nx, ny = values.shape
    lower, upper = (Fraction(-1), Fraction(2)) if periodic else (Fraction(0), Fraction(1))
    result = []
    for i, (x, y) in enumerate(seeds):
        cell = [(lower, lower), (upper, lower), (upper, upper), (lower, upper)]
        for j, (p, q) in enumerate(seeds):
            for s, t in images:
                if (i, s, t) != (j, 0, 0):
                    a, b = p + s - x, q + t - y
                    cell = cut(cell, a, b, ((p + s) ** 2 + (q + t) ** 2 - w[j] - x * x - y * y + w[i]) / 2)
        sums = [Fraction(0)] * 4
        for u, v in itertools.product(range(int(lower) * nx, int(upper) * nx), range(int(lower) * ny, int(upper) * ny)):
            value = Fraction(float(values[u % nx, v % ny]))
            part = cut(cut(cell, -1, 0, Fraction(-u, nx)), 1, 0, Fraction(u + 1, nx)) if value else []
            part = cut(cut(part, 0, -1, Fraction(-v, ny)), 0, 1, Fraction(v + 1, ny))
            sums = [s + value * m for s, m in zip(sums, moments(part))]
        result.append(sums)
    return result


def polytope_moments(faces):
    """Returns the integrals of 1, x, y, z and |x|^2 over a polytope, by tetrahedra from one corner."""
    sums = [Decimal(0)] * 5
    apex = faces[0][1][0]
    for _, corners in faces:
        for b, c in zip(corners[1:], corners[2:]):
            four = (apex, corners[0], b, c)
            u, v, w = (minus(x, apex) for x in four[1:])
            cross = (v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0])
            volume = abs(dot(u, cross)) / 6
            total = tuple(sum(x) for x in zip(*four))
            sums[0] += volume
            for k in range(3):
                sums[1 + k] += volume * total[k] / 4
            sums[4] += volume / 20 * (dot(total, total) + sum(dot(x, x) for x in four))
    return sums


class Exact(unittest.TestCase):
    def test_plane(self):
        for case in range(6):
            periodic = case % 2 == 1
            random = np.random.default_rng(case)
            points = random.random((6 if periodic else 9, 2))
            weights = random.random(len(points)) * 0.03
            values = image((3, 2) if periodic else (5, 4), case)
            t = vt.tessellate(points, box=SQUARE, periodic=periodic, weights=weights, want="faces,volumes")
            found = t.masses(values)
            for i, (mass, x, y, second) in enumerate(exact_masses(points, weights, values, periodic)):
                self.assertAlmostEqual(found.masses[i], float(mass), delta=1e-15)
                if mass > 1e-6:
                    np.testing.assert_allclose(found.centroids[i], (float(x / mass), float(y / mass)), atol=1e-12)
                    central = float(second - (x * x + y * y) / mass)
                    self.assertAlmostEqual(found.second_moments[i], central, delta=1e-14)
                elif mass == 0:
                    self.assertTrue(np.isnan(found.centroids[i]).all())

    def test_space(self):
        with decimal.localcontext(decimal.Context(prec=50)):
            for case in range(4):
                random = np.random.default_rng(case)
                points, weights = random.random((5, 3)), random.random(5) * 0.02
                values = image((2, 3, 2), case)
                t = vt.tessellate(points, box=UNIT_BOX, weights=weights, want="faces,areas,volumes")
                found = t.masses(values)
                for i in range(5):
                    p, wp = tuple(map(Decimal, points[i].tolist())), Decimal(float(weights[i]))
                    cell = cube(Decimal(0), Decimal(1))
                    for j in range(5):
                        q = tuple(map(Decimal, points[j].tolist()))
                        if j != i:
                            offset = (dot(q, q) - Decimal(float(weights[j])) - dot(p, p) + wp) / 2
                            cell = clipped(cell, minus(q, p), offset, (j, None))
                    sums, faces = [Decimal(0)] * 5, {}
                    for voxel in np.ndindex(values.shape):
                        value, part = Decimal(float(values[voxel])), cell
                        for k, n in itertools.product(range(3), (-1, 1)):
                            normal = tuple(n if k == axis else 0 for axis in range(3))
                            at = Decimal(int(voxel[k] + (n > 0))) / values.shape[k]
                            if any(dot(normal, x) > n * at + Decimal("1e-40") for _, corners in part for x in corners):
                                part = clipped(part, normal, n * at, None)
                        if not part:
                            continue
                        sums = [s + value * m for s, m in zip(sums, polytope_moments(part))]
                        for other, area in measured(part)[1].items():
                            faces[other[0]] = faces.get(other[0], Decimal(0)) + value * area
                    mass = sums[0]
                    self.assertAlmostEqual(found.masses[i], float(mass), delta=1e-15)
                    if mass > Decimal("1e-6"):
                        center = [s / mass for s in sums[1:4]]
                        np.testing.assert_allclose(found.centroids[i], [float(x) for x in center], atol=1e-12)
                        self.assertAlmostEqual(found.second_moments[i], float(sums[4] - mass * dot(center, center)), delta=1e-14)
                    row = slice(t.neighbors.indptr[i], t.neighbors.indptr[i + 1])
                    for other, mass in zip(t.neighbors.indices[row], found.face_masses[row]):
                        if other >= 0:
                            self.assertAlmostEqual(mass, float(faces[other]), delta=1e-14)

    def test_layers(self):
        """Faces between boxes of the grid have the mean of both sides."""
        t = vt.tessellate([(0.25, 0.5), (0.75, 0.5)], box=SQUARE, want="faces,volumes")
        found = t.masses([[2, 6], [4, 0]])
        np.testing.assert_allclose(found.masses, [2, 1])
        of_neighbor = t.neighbors.indices >= 0
        np.testing.assert_allclose(found.face_masses[of_neighbor], 3)


class Invariants(unittest.TestCase):
    def test_domains(self):
        """A constant density changes nothing, a linear function of space has the moments of cells."""
        random = np.random.default_rng(5)
        for points, domain in (
            (uniform(60), {"box": UNIT_BOX, "periodic": "xy"}),
            (uniform(60) @ CELL + 3, {"cell": CELL, "origin": (3, 3, 3), "periodic": True}),
            (uniform(60) @ np.array(CELL)[[1, 0, 2]], {"cell": np.array(CELL)[[1, 0, 2]]}),
            (uniform(40) * 0.4 + 0.3, {"box": UNIT_BOX, "walls": [(1, 1, 1, 2.2), (1, -1, 0, 0.4)]}),
            (uniform(60)[:, :2] * 1e-9, {"box": (0, 0, 1e-9, 1e-9), "periodic": "x"}),
            (uniform(60)[:, :2] @ [(1, 0.3), (0, 1)], {"cell": [(1, 0.3), (0, 1)], "periodic": True}),
        ):
            with self.subTest(domain=domain):
                t = vt.tessellate(points, want="faces,areas,volumes,centroids", weights=random.random(len(points)) * 1e-4, **domain)
                shape = (7, 5, 3)[: points.shape[1]]
                one = t.masses(np.full(shape, 2.0))
                np.testing.assert_allclose(one.masses, 2 * t.volumes, rtol=1e-14)
                np.testing.assert_allclose(one.face_masses, 2 * t.face_areas, rtol=1e-13)
                np.testing.assert_allclose(one.centroids, t.centroids, rtol=1e-11, atol=1e-24)
                fine = t.masses(np.full(tuple(2 * n + 1 for n in shape), 2.0))
                np.testing.assert_allclose(fine.second_moments, one.second_moments, rtol=1e-10)
                values = image(shape, 3)
                of = t.masses(values)
                repeated = t.masses(np.kron(values, np.ones((2,) * values.ndim)), threads=2)  # each box as 2 or 2^3
                for name in ("masses", "centroids", "second_moments", "face_masses"):
                    np.testing.assert_allclose(getattr(repeated, name), getattr(of, name), rtol=1e-9, atol=1e-14 * of.masses.max())
                if "walls" not in domain:
                    self.assertAlmostEqual(of.masses.sum() / (values.mean() * t.volumes.sum()), 1, places=13)

    def test_faces_in_planes_of_the_grid(self):
        """Rounding then decides on which side corners lie. Boxes in which it does, and a grid with thrice the lines."""
        for seed in range(60):
            random = np.random.default_rng(seed)
            size, count = random.choice([1.0, 1.3, 1.9, 1e3], 3), int(random.integers(1, 5))
            points = (lattice(count) - random.choice([0, 0.25])) / count * size
            points += random.choice([0, 1e-16, 1e-12]) * random.normal(size=points.shape) * size
            points = points[random.random(len(points)) < 0.8] % size
            t = vt.tessellate(points, box=(0, 0, 0, *size), periodic=bool(seed % 2), want="faces,volumes")
            shape = random.choice([1, 2, 4, 5], 3)
            np.testing.assert_allclose(t.masses(np.ones(shape)).masses, t.volumes, rtol=1e-9)
            values = image(shape, seed)
            finer = values.repeat(3, axis=0).repeat(3, axis=1).repeat(3, axis=2)
            atol = 1e-9 * size.prod() / max(len(points), 1)
            np.testing.assert_allclose(t.masses(values).masses, t.masses(finer).masses, rtol=0, atol=atol)

    def test_cost(self):
        points = uniform(50)
        t = vt.tessellate(points, box=UNIT_BOX, periodic=True, want="faces,volumes")
        self.assertAlmostEqual(vt.transport_cost(t, np.full((4, 3, 5), 3.0)) / vt.transport_cost(t) / 3, 1, places=12)
        flat = vt.tessellate(points[:, :2], box=SQUARE, want="faces,volumes")
        self.assertAlmostEqual(vt.transport_cost(flat, np.ones((7, 3))) / vt.transport_cost(flat), 1, places=12)
        dropped = vt.tessellate(points, box=UNIT_BOX, periodic=True, want="faces,volumes", min_face=0.2)
        values = image((4, 4, 4))
        self.assertAlmostEqual(vt.transport_cost(dropped, values), vt.transport_cost(t, values), places=14)

    def test_derivatives(self):
        """Differences of masses are those of the masses of faces over twice the distance."""
        for dimensions in (2, 3):
            points = uniform(30)[:, :dimensions]
            values = image((6,) * dimensions, 2)
            domain = {"box": np.repeat((0, 1), dimensions), "periodic": True, "want": "faces,areas,volumes"}
            t = vt.tessellate(points, **domain)
            way = np.random.default_rng(3).normal(size=30)
            i = np.repeat(np.arange(30), np.diff(t.neighbors.indptr))
            j = t.neighbors.indices
            distance = np.linalg.norm(points[j] + t.shifts - points[i], axis=1)
            expected = np.bincount(i, t.masses(values).face_masses / (2 * distance) * (way[i] - way[j]))
            h = 1e-7
            more, less = (vt.tessellate(points, weights=s * h * way, **domain).masses(values).masses for s in (1, -1))
            np.testing.assert_allclose((more - less) / (2 * h), expected, atol=2e-6 * np.abs(expected).max())


class Fits(unittest.TestCase):
    def fitted(self, points, targets, values, tolerance=1e-9, **domain):
        fit = vt.fit_volumes(points, targets, density=values, normalize=True, want="faces,volumes", tolerance=tolerance, **domain)
        masses = vt.tessellate(points, weights=fit.weights, want="faces,volumes", **domain).masses(values).masses
        self.assertLess(np.abs(masses / (targets / targets.sum() * masses.sum()) - 1).max(), 1.1 * tolerance)
        return fit

    def test_constant(self):
        """As without a density."""
        points, targets = uniform(100), np.exp(uniform(100)[:, 0])
        for p, box in ((points, UNIT_BOX), (points[:, :2], SQUARE)):
            one = vt.fit_volumes(p, targets, box=box, normalize=True, tolerance=1e-12).weights
            other = self.fitted(p, targets, np.full((3, 4, 5)[: p.shape[1]], 7.0), 1e-12, box=box).weights
            self.assertLess(np.abs(one - other).max(), 1e-11)

    def test_images(self):
        """A disk on black, two blobs far apart, a line of pixels; seeds lie in the dark too."""
        x, y = np.meshgrid((np.arange(40) + 0.5) / 40, (np.arange(30) + 0.5) / 30, indexing="ij")
        disk = ((x - 0.3) ** 2 + (y - 0.4) ** 2 < 0.04).astype(float)
        blobs = np.exp(-((x - 0.2) ** 2 + (y - 0.2) ** 2) * 200) + 3 * np.exp(-((x - 0.8) ** 2 + (y - 0.7) ** 2) * 200)
        blobs[blobs < 0.01] = 0
        line = (x == x[7, 0]) * 1.0
        points = uniform(300, seed=4)[:, :2]
        for values in (disk, blobs, line):
            for periodic in (False, True):
                for targets in (np.ones(300), np.exp(2 * uniform(300)[:, 2])):
                    fit = self.fitted(points, targets, values, box=SQUARE, periodic=periodic)
                    self.assertLessEqual(fit.steps, 25)

    def test_domains_of_the_plane(self):
        """The fit makes cells of their neighbors, masses() takes the polygons of rows. Both have equal masses."""
        points, skew = uniform(80)[:, :2], np.array([(1, 0.3), (0.1, 0.8)])
        values = image((7, 5), 2)
        slanted = [(1, 1, 1.5), (-2, 1, 0.5)]
        for p, domain in (
            (points, {"box": SQUARE, "periodic": "x"}),
            (points @ skew + 3, {"cell": skew, "origin": (3, 3), "periodic": True}),
            (points @ skew[::-1], {"cell": skew[::-1]}),
            (points @ skew, {"cell": skew, "periodic": "y"}),
            (points * 0.4 + 0.2, {"box": SQUARE, "walls": slanted}),
            (points * 3 - 1, {"box": SQUARE, "walls": slanted, "outside": "keep"}),
            (points[:3], {"box": SQUARE, "periodic": True}),  # neighbors of themselves
            (points * (1e-9, 1), {"box": (0, 0, 1e-9, 1)}),
            (points * 1e100, {"box": (0, 0, 1e100, 1e100)}),
        ):
            with self.subTest(domain=domain):
                self.fitted(p, np.exp(uniform(80)[: len(p), 2]), values, 1e-11, **domain)

    def test_far_cells(self):
        """Most cells of the image lie far from their seeds, and some seeds have no cell at the start."""
        y, x = np.mgrid[0:128, 0:128] / 127
        values = np.exp(-30 * ((x - 0.3) ** 2 + (y - 0.4) ** 2)) + np.exp(-60 * ((x - 0.7) ** 2 + (y - 0.7) ** 2))
        values[values < 0.1] = 0
        fit = self.fitted(np.random.default_rng(1).random((2000, 2)), np.ones(2000), values.T, box=SQUARE)
        self.assertLessEqual(fit.steps, 12)

    def test_space(self):
        values = image((6, 5, 4), 7, 0.7)
        for domain in ({"box": UNIT_BOX}, {"box": UNIT_BOX, "periodic": True}):
            self.fitted(uniform(200), np.ones(200), values, **domain)
        self.fitted(uniform(100) @ CELL, np.ones(100), values, cell=CELL, periodic=True)
        self.fitted(uniform(100), np.ones(100), values, box=(0, 0, 0, 1, 1, 0.6), outside="keep", walls=[(1, 1, 0, 1.5)])

    def test_start_and_threads(self):
        points, values = uniform(200)[:, :2], image((9, 9))
        fit = self.fitted(points, np.ones(200), values, box=SQUARE)
        again = vt.fit_volumes(points, np.ones(200), box=SQUARE, density=values, normalize=True, weights=fit.weights, threads=2)
        self.assertEqual(again.steps, 0)

    def test_transport_is_the_best(self):
        """The cost is least at the weights found, by duality: cost less all other potentials."""
        points, values = uniform(30)[:, :2], image((5, 5))
        fit = self.fitted(points, np.ones(30), values, box=SQUARE, tolerance=1e-12)
        target = values.mean() / 30
        cost = vt.transport_cost(fit.tessellation, values)
        for seed in range(5):
            weights = fit.weights + np.random.default_rng(seed).normal(size=30) * 1e-3
            t = vt.tessellate(points, weights=weights, box=SQUARE, want="faces,volumes")
            masses = t.masses(values)
            dual = masses.cost(points) - weights @ masses.masses + target * weights.sum()
            self.assertLess(dual, cost + 1e-15)
            self.assertLess(cost - dual, 1e-2 * cost + 1e-3)

    def test_lloyd(self):
        points = uniform(40)[:, :2]
        values = image((8, 8), 9, 0.2)
        for more in ({}, {"volumes": np.ones(40), "normalize": True}):
            relaxed = vt.lloyd(points, box=SQUARE, density=values, steps=8, **more)
            self.assertTrue((np.diff(relaxed.energies) < 0).all(), relaxed.energies)
        masses = relaxed.tessellation.masses(values).masses
        np.testing.assert_allclose(masses, values.mean() / 40, rtol=1.1e-9)
        one = vt.lloyd(points, box=SQUARE, density=np.ones((3, 3)), steps=3)
        np.testing.assert_allclose(one.points, vt.lloyd(points, box=SQUARE, steps=3).points, atol=1e-13)


class BadInput(unittest.TestCase):
    def test_refused(self):
        points = uniform(5)
        t = vt.tessellate(points, box=UNIT_BOX, want="faces")
        for density, says in (
            (np.ones((2, 2)), r"density has shape \(2, 2\): it must be \(nx, ny, nz\)"),
            (np.ones((2, 0, 2)), r"shape \(2, 0, 2\)"),
            (np.full((1, 1, 2), (1, -0.5)), r"density\[0, 0, 1\] is -0.5: it must be finite and not negative"),
            (np.full((1, 1, 1), np.nan), r"density\[0, 0, 0\] is nan"),
        ):
            with self.assertRaisesRegex(ValueError, says):
                t.masses(density)
            with self.assertRaisesRegex(ValueError, says):
                vt.fit_volumes(points, np.ones(5), box=UNIT_BOX, density=density)
        nothing = np.zeros((2, 2, 2))
        self.assertEqual(t.masses(nothing).masses.tolist(), [0] * 5)
        with self.assertRaisesRegex(ValueError, "all values are 0: there is no mass to divide"):
            vt.fit_volumes(points, np.ones(5), box=UNIT_BOX, density=nothing)
        ones = np.ones((2, 2, 2))
        with self.assertRaisesRegex(ValueError, r"sum to 5.*has the mass 1.*: correct them, or set normalize"):
            vt.fit_volumes(points, np.ones(5), box=UNIT_BOX, density=ones)
        with self.assertRaisesRegex(ValueError, "in a mesh"):
            vt.fit_volumes(points, np.ones(5), mesh=CUBE, density=ones)
        with self.assertRaisesRegex(ValueError, "in a mesh"):
            vt.lloyd(points, steps=1, mesh=CUBE, density=ones)
        with self.assertRaisesRegex(ValueError, "masses.*mesh"):
            vt.tessellate(points, mesh=CUBE).masses(ones)
        with self.assertRaisesRegex(ValueError, "infinity"):
            vt.tessellate(points, box="none", want="faces").masses(ones)
        with self.assertRaisesRegex(AttributeError, "faces"):
            vt.tessellate(points, box=UNIT_BOX).masses(ones)
        with self.assertRaisesRegex(ValueError, "give the density as an array"):
            vt.lloyd(points, steps=1, density=lambda x: np.ones(len(x)), box=UNIT_BOX, volumes=np.ones(5))


if __name__ == "__main__":
    unittest.main()
