"""fit_volumes(), lloyd() with volumes and transport_cost(): exact cases, other tessellations, bad input."""

import decimal
import itertools
import math
import pickle
import unittest

import numpy as np
from helpers import CELL, CUBE, ELL, UNIT_BOX, lattice, uniform

import pyvotess as vt

SEEDS = 300
OCTAHEDRON = [(*signs, 1) for signs in itertools.product((-1, 1), repeat=3)]


def shares(count, kind, seed=1):
    random = np.random.default_rng(seed)
    values = {
        "equal": lambda: np.ones(count),
        "lognormal": lambda: np.exp(random.normal(0, 0.6, count)),
        "wide": lambda: 10.0 ** np.linspace(-6, 0, count),
    }[kind]()
    return values / values.sum()


def domains():
    """Yields seeds, their domain and its volume."""
    points, cell = uniform(SEEDS, seed=3), np.asarray(CELL)
    inside = 2 * uniform(8 * SEEDS, seed=4) - 1
    inside = inside[np.abs(inside).sum(axis=1) < 1][:SEEDS]
    yield points, {"box": UNIT_BOX}, 1
    yield points, {"box": UNIT_BOX, "periodic": True}, 1
    yield points * 1e9 + (5e8, 7e9, 0), {"box": (0, 0, 0, 1e9, 1e9, 1e9), "periodic": "xy"}, 1e27
    yield points @ cell + 5, {"cell": cell, "origin": (5, 5, 5)}, 1
    yield points @ (cell * [[1], [1], [0.2]]), {"cell": cell * [[1], [1], [0.2]], "periodic": "xy"}, 0.2
    yield inside, {"walls": OCTAHEDRON}, 4 / 3


def residual(points, weights, targets, **domain):
    """Returns the largest relative error of a volume, from another tessellation."""
    t = vt.tessellate(points, weights=weights, want="volumes", threads=1, **domain)
    return np.abs(t.volumes / targets - 1).max()


class Exact(unittest.TestCase):
    def test_two_seeds(self):
        """The plane between them is at x = 0.1, where |x - p|^2 - w are equal."""
        points = [(0.25, 0.5, 0.5), (0.75, 0.5, 0.5)]
        fit = vt.fit_volumes(points, (0.1, 0.9), box=UNIT_BOX, tolerance=1e-13)
        self.assertAlmostEqual(fit.weights[1] - fit.weights[0], 0.65**2 - 0.15**2, delta=1e-12)
        self.assertAlmostEqual(fit.weights.sum(), 0, delta=1e-12)

    def test_lattice(self):
        for periodic in (True, False):
            fit = vt.fit_volumes(lattice(4), np.ones(64), box=(0, 0, 0, 4, 4, 4), periodic=periodic)
            self.assertEqual(np.ptp(fit.weights), 0)
            self.assertEqual((fit.steps, fit.tessellations), (0, 2))

    def test_mirror(self):
        points, targets = uniform(SEEDS), shares(SEEDS, "lognormal")
        one, other = (
            vt.fit_volumes(p, targets, box=UNIT_BOX, tolerance=1e-12).weights for p in (points, points * (-1, 1, 1) + (1, 0, 0))
        )
        self.assertLess(np.abs(one - other).max(), 1e-10 * SEEDS ** (-2 / 3))

    def test_one_and_none(self):
        fit = vt.fit_volumes([(0.2, 0.3, 0.4)], [1], box=UNIT_BOX, periodic=True)
        self.assertEqual((fit.weights[0], fit.steps), (0, 0))
        self.assertEqual(len(vt.fit_volumes(np.empty((0, 3)), [], box=UNIT_BOX).weights), 0)


class Residuals(unittest.TestCase):
    def test_domains(self):
        for points, domain, volume in domains():
            for kind in ("equal", "lognormal", "wide"):
                with self.subTest(domain=domain, kind=kind):
                    targets = shares(SEEDS, kind) * volume
                    fit = vt.fit_volumes(points, targets, want="faces,volumes", **domain)
                    self.assertLessEqual(fit.residual, 1e-9)
                    self.assertLessEqual(residual(points, fit.weights, targets, **domain), 1.001e-9)
                    self.assertTrue((fit.tessellation.weights == fit.weights).all())
                    self.assertTrue(fit.tessellation.verify())

    def test_the_result_is_that_of_tessellate(self):
        """Every array, its order and its digits."""
        for points, domain, volume in domains():
            fit = vt.fit_volumes(points, shares(len(points), "lognormal") * volume, want="faces,volumes,areas,centroids", list_walls=True, **domain)
            again = vt.tessellate(points, weights=fit.weights, want="faces,volumes,areas,centroids", list_walls=True, **domain)
            for name, array in again._data.arrays.items():
                np.testing.assert_array_equal(fit.tessellation._data.arrays[name], array, name)

    def test_mesh(self):
        points = 2 * uniform(4 * SEEDS, seed=5) * (1, 1, 0.5)
        points = points[(points[:, :2] < 1).any(axis=1)][:SEEDS]
        for kind in ("equal", "lognormal"):
            targets = 3 * shares(len(points), kind)
            fit = vt.fit_volumes(points, targets, mesh=ELL)
            self.assertLessEqual(residual(points, fit.weights, targets, mesh=ELL), 1.001e-9)
            self.assertTrue(fit.tessellation.in_mesh)
        points, targets = uniform(50), shares(50, "lognormal")
        in_box = vt.fit_volumes(points, targets, box=UNIT_BOX, tolerance=1e-12)
        in_mesh = vt.fit_volumes(points, targets, mesh=CUBE, tolerance=1e-12)
        self.assertLess(np.abs(in_mesh.weights - in_box.weights).max(), 1e-11)
        points[7] = 3, 3, 3
        with self.assertRaisesRegex(ValueError, r"points\[7\]: \(3, 3, 3\) has no cell, move it into the mesh"):
            vt.fit_volumes(points, targets, mesh=CUBE)
        with self.assertRaisesRegex(ValueError, "but the domain has 3: correct them"):
            vt.fit_volumes(points, targets, mesh=ELL)

    def test_plane(self):
        """Seeds in a plane with targets that differ by up to 1e6: small cells between large ones."""
        for seed in range(20):
            points = uniform(16, seed=seed) * (0.6, 0.6, 0) + (0.2, 0.2, 0.5)
            targets = shares(16, "wide", seed)
            fit = vt.fit_volumes(points, targets, box=UNIT_BOX)
            self.assertLessEqual(residual(points, fit.weights, targets, box=UNIT_BOX), 1.001e-9, f"seed {seed}")

    def test_tight_cluster(self):
        """Volumes at the start differ by a factor of up to 1e16."""
        for seed, size in enumerate((1e-2, 1e-3, 1e-4, 1e-5)):
            points = 0.3 + size * np.random.default_rng(seed).normal(size=(40, 3))
            for kind in ("equal", "wide"):
                for periodic in (False, True):
                    targets = shares(40, kind)
                    fit = vt.fit_volumes(points, targets, box=UNIT_BOX, periodic=periodic)
                    error = residual(points, fit.weights, targets, box=UNIT_BOX, periodic=periodic)
                    self.assertLessEqual(error, 1.001e-9, f"size {size}, {kind}, periodic {periodic}")

    def test_targets_over_decades(self):
        """On a line, where some cells are a million times larger than others: steps need the digits of the linear solver."""
        for number in range(4):
            random = np.random.default_rng(number)
            points = random.random((int(random.integers(30, 60)), 2))
            points[:, 1] = 0.5
            targets = 10.0 ** random.uniform(-6, 0, len(points))
            fit = vt.fit_volumes(points, targets, box=(0, 0, 1, 1), periodic=True, normalize=True, tolerance=1e-6)
            self.assertLess(fit.steps, 100)

    def test_start(self):
        points, targets = uniform(SEEDS), shares(SEEDS, "lognormal")
        fit = vt.fit_volumes(points, targets, box=UNIT_BOX)
        again = vt.fit_volumes(points, targets, box=UNIT_BOX, weights=fit.weights + 3)
        self.assertEqual(again.steps, 0)
        self.assertTrue((again.weights == fit.weights + 3).all())
        # These weights leave most cells empty.
        far = vt.fit_volumes(points, targets, box=UNIT_BOX, weights=np.arange(SEEDS))
        self.assertLess(np.abs(far.weights - fit.weights).max(), 1e-8)

    def test_few_seeds(self):
        """Some of which are neighbors of their own images."""
        for case in range(100):
            periodic = case % 10 == 0
            count = 2 if periodic else 2 + case % 4
            points, targets = np.random.default_rng(case).random((count, 3)), shares(count, "lognormal", case)
            fit = vt.fit_volumes(points, targets, box=UNIT_BOX, periodic=periodic, tolerance=1e-13)
            self.assertLess(residual(points, fit.weights, targets, box=UNIT_BOX, periodic=periodic), 1e-12, f"case {case}")

    def test_normalize(self):
        points = uniform(50)
        fit = vt.fit_volumes(points, np.full(50, 7), box=UNIT_BOX, normalize=True)
        self.assertLess(np.abs(fit.tessellation.volumes * 50 - 1).max(), 1.001e-9)


class BadInput(unittest.TestCase):
    def refused(self, says, points=None, volumes=None, **options):
        points = uniform(10) if points is None else points
        with self.assertRaisesRegex(ValueError, says):
            vt.fit_volumes(points, np.full(len(points), 0.1) if volumes is None else volumes, box=UNIT_BOX, **options)

    def test_polygons_afterwards(self):
        """The message about missing polygons shows how to make the same cells without another fit."""
        t = vt.fit_volumes(uniform(50), np.full(50, 0.02), box=UNIT_BOX).tessellation
        with self.assertRaisesRegex(ValueError, "After a fit: ") as caught:
            t.save("cells.vtu")
        code = str(caught.exception).split("After a fit: ")[1].split(" makes")[0]
        again = eval(code, {"vt": vt, "t": t})
        self.assertIn("faces", again.wanted)
        np.testing.assert_array_equal(again.volumes, t.volumes)

    def test_targets(self):
        self.refused(r"sum to 1\.1.*domain has 1:.*normalize", volumes=np.full(10, 0.11))
        self.refused("it must be \\(10,\\)", volumes=np.full(9, 0.1))
        for value, text in ((0, "0"), (-1, "-1"), (math.nan, "nan"), (math.inf, "inf")):
            volumes = np.full(10, 0.1)
            volumes[4] = value
            for normalize in (False, True):
                self.refused(rf"volumes\[4\] is {text}: it must be positive", volumes=volumes, normalize=normalize)
        self.refused("tolerance is 0", tolerance=0)
        self.refused("tolerance is nan", tolerance=math.nan)

    def test_points(self):
        points = np.round(uniform(10) * 64) / 64
        points[7] = points[2]
        self.refused(r"points\[7\].*duplicate of point 2", points)
        points[7] = points[2] + (1, 0, 0)
        self.refused(r"points\[7\].*duplicate of point 2", points, periodic=True)
        self.refused(r"points\[7\]: x = 1.* outside", points)

    def test_steps(self):
        points, targets = uniform(SEEDS), shares(SEEDS, "wide")
        with self.assertRaisesRegex(vt.FitError, "after 3 steps .*max_steps") as caught:
            vt.fit_volumes(points, targets, box=UNIT_BOX, max_steps=3)
        error = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual((error.code, error.steps), (vt.ErrorCode.NOT_CONVERGED, 3))
        self.assertAlmostEqual(residual(points, error.weights, targets, box=UNIT_BOX) / error.residual, 1, places=6)
        fit = vt.fit_volumes(points, targets, box=UNIT_BOX, weights=error.weights)
        self.assertLess(residual(points, fit.weights, targets, box=UNIT_BOX), 1.001e-9)
        with self.assertRaisesRegex(vt.FitError, "raise tolerance="):
            vt.fit_volumes(points, targets, box=UNIT_BOX, tolerance=1e-30)

    def test_cancelled(self):
        with self.assertRaises(vt.VotessError) as caught:
            vt.fit_volumes(uniform(3000), shares(3000, "equal"), box=UNIT_BOX, progress=lambda fraction: fraction < 0.1)
        self.assertEqual(caught.exception.code, vt.ErrorCode.CANCELLED)


D = decimal.Decimal


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def cube(lower, upper):
    """Returns the polygons of a cube and their neighbors: a list of (None, corners)."""
    faces = []
    for axis, end in itertools.product(range(3), (lower, upper)):
        a, b = [k for k in range(3) if k != axis]
        corners = []
        for u, v in ((lower, lower), (upper, lower), (upper, upper), (lower, upper)):
            corner = [end, end, end]
            corner[a], corner[b] = u, v
            corners.append(tuple(corner))
        faces.append((None, corners))
    return faces


def clipped(faces, normal, offset, neighbor):
    """Returns the polytope's part with normal.x <= offset. Its new face has the neighbor."""
    tie = D("1e-40")  # far above rounding, far below lengths
    result, cut = [], []
    for other, corners in faces:
        kept = []
        heights = [dot(normal, x) - offset for x in corners]
        for k, x in enumerate(corners):
            y, h, g = corners[k - 1], heights[k], heights[k - 1]
            if (h > tie and g < -tie) or (h < -tie and g > tie):
                kept.append(tuple(p + (q - p) * (g / (g - h)) for p, q in zip(y, x)))
                cut.append(kept[-1])
            if h <= tie:
                kept.append(x)
            if abs(h) <= tie:
                cut.append(x)
        if len(kept) > 2:
            result.append((other, kept))
    if len(cut) > 2:
        middle = tuple(sum(x) / len(cut) for x in zip(*cut))
        a = max((minus(x, middle) for x in cut), key=lambda v: dot(v, v))
        b = cross(normal, a)
        around = sorted((math.atan2(dot(b, minus(x, middle)), dot(a, minus(x, middle))), x) for x in cut)
        result.append((neighbor, [x for k, (angle, x) in enumerate(around) if k == 0 or angle - around[k - 1][0] > 1e-12]))
    return result


def measured(faces):
    """Returns the volume, and the area toward each neighbor."""
    volume, areas = D(0), {}
    inside = faces[0][1][0]
    for neighbor, corners in faces:
        parts = [cross(minus(y, corners[0]), minus(z, corners[0])) for y, z in zip(corners[1:], corners[2:])]
        area = tuple(sum(x) / 2 for x in zip(*parts))
        volume += abs(dot(area, minus(corners[0], inside))) / 3
        if neighbor is not None:
            areas[neighbor] = areas.get(neighbor, D(0)) + dot(area, area).sqrt()
    return volume, areas


class Transport(unittest.TestCase):
    def test_cost(self):
        """Two halves of the box, each moved to a point."""
        points = [(0.1, 0.5, 0.5), (0.3, 0.5, 0.5)]
        t = vt.fit_volumes(points, (0.5, 0.5), box=UNIT_BOX, tolerance=1e-13, want="faces").tessellation
        along = sum((b - p) ** 3 - (a - p) ** 3 for a, b, p in ((0, 0.5, 0.1), (0.5, 1, 0.3))) / 3
        self.assertAlmostEqual(vt.transport_cost(t), along + 2 / 12, places=12)
        with self.assertRaisesRegex(ValueError, "transport_cost.*faces"):
            vt.transport_cost(vt.tessellate(points, box=UNIT_BOX))

    def test_cost_in_a_mesh_in_skewed_cells(self):
        """A lattice of whole numbers has one cost, however skewed its cell is, and costs no more time."""
        mesh = (0.25 + 0.5 * CUBE[0]) / 512, CUBE[1]
        points = np.random.default_rng(5).random((12, 3))
        box = vt.tessellate(points, box=UNIT_BOX, periodic=True, want="volumes", device="cpu", mesh=mesh)
        expected = vt.transport_cost(box)
        self.assertGreater(expected, 0)
        for s in (1, 7, 30):
            # The place f0 a + f1 b + f2 c of the mesh, from 0.25 to 0.75 of 1/512 along each axis, lies in the cell.
            cell = np.array([(1, 0, 0), (-s, 1, 0), (-s, 0, 1)])
            t = vt.tessellate(points, cell=cell, want="volumes", device="cpu", mesh=mesh)
            np.testing.assert_allclose(t.volumes, box.volumes, rtol=1e-9, atol=1e-20)
            self.assertAlmostEqual(vt.transport_cost(t) / expected, 1, places=9)

    def test_dropped_faces(self):
        """Small faces belong to the cells, also where they were dropped."""
        points, weights = uniform(30), 0.01 * uniform(10).ravel()
        slab = ((0, 0, 1, 0.9), (0, 1, 0, 0.8))
        inside = points * (1, 0.8, 0.9)
        domains = (
            dict(box=UNIT_BOX), dict(box=UNIT_BOX, periodic=True), dict(), dict(box=UNIT_BOX, weights=weights),
            dict(cell=((1, 0, 0), (0.3, 1, 0), (0, 0.2, 1)), weights=weights), dict(walls=slab),
        )  # fmt: skip
        for domain in domains:
            chosen = inside if "walls" in domain else points
            whole = vt.transport_cost(vt.tessellate(chosen, want="faces", **domain))
            for dropped in (dict(min_face=0.1), dict(min_face=1.0), dict(min_area=0.02)):
                t = vt.tessellate(chosen, want="faces", **domain, **dropped)
                self.assertGreater(t.least_face, 0)
                self.assertAlmostEqual(vt.transport_cost(t), whole, places=14, msg=str(domain))
        with self.assertRaisesRegex(ValueError, "transport_cost.*faces"):
            vt.transport_cost(vt.tessellate(points, box=UNIT_BOX, min_face=0.1))

    def test_derivative(self):
        """Moving a seed changes the cost by 2 V (p - c): the weights do not move it (Kantorovich duality)."""
        points, targets = uniform(40), shares(40, "lognormal")
        way = np.random.default_rng(2).normal(size=points.shape)

        def cost(p):
            return vt.transport_cost(vt.fit_volumes(p, targets, box=UNIT_BOX, periodic=True, tolerance=1e-11, want="faces").tessellation)

        t = vt.fit_volumes(points, targets, box=UNIT_BOX, periodic=True, tolerance=1e-11, want="volumes,centroids").tessellation
        expected = (2 * targets[:, None] * (t.wrapped_points - t.centroids) * way).sum()
        numeric = (cost(points + 1e-6 * way) - cost(points - 1e-6 * way)) / 2e-6
        self.assertAlmostEqual(numeric / expected, 1, places=6)

    def test_lloyd(self):
        points, targets = uniform(60), shares(60, "lognormal")
        relaxed = vt.lloyd(points, steps=5, box=UNIT_BOX, periodic=True, volumes=targets)
        self.assertTrue((np.diff(relaxed.energies) < 0).all(), relaxed.energies)
        t = relaxed.tessellation
        self.assertLess(np.abs(t.volumes / targets - 1).max(), 1.001e-9)
        self.assertLess(residual(relaxed.points, t.weights, targets, box=UNIT_BOX, periodic=True), 1.001e-9)
        with self.assertRaisesRegex(ValueError, "give the density as an array"):
            vt.lloyd(points, steps=1, density=lambda x: np.ones(len(x)), box=UNIT_BOX, volumes=targets)


if __name__ == "__main__":
    unittest.main()
