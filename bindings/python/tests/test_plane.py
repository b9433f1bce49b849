"""Two dimensions: points of shape (N, 2)."""

import os
import pickle
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
import plane_oracle
from helpers import have

import pyvotess as vt

POINTS = np.random.default_rng(5).random((400, 2))
BOX = (0, 0, 1, 1)
EVERYTHING = "neighbors,volumes,centroids,counts,areas,normals,surfaces,radii,faces"


def area_and_centroid(polygon):
    area, x, y, _ = plane_oracle.moments(polygon.tolist())
    return area, np.array((x, y)) / area


OBLIQUE = ((1, 0), (0.375, 1.25))


def random_cases(trials, first=0):
    """Yields points and the domain of random sets: lattices, fractions of 2^-8 and any; with weights or without."""
    for number in range(first, first + trials):
        random = np.random.default_rng(number)
        count = int(random.integers(1, 20))
        side = random.choice([4, 8, 256, 2**40])
        points = random.integers(0, side, (count, 2)) / side
        domains = [
            {"box": "none"},
            {"box": BOX},
            {"box": BOX, "periodic": True},
            {"box": BOX, "periodic": "y"},
            {"cell": OBLIQUE, "periodic": True},
        ]
        domain = domains[number % len(domains)]
        if number % 7 == 3:
            points[:, 1] = points[0, 1]  # on a line
        if "cell" in domain:
            points = points @ OBLIQUE
        if number % 3 == 1:
            domain = {**domain, "weights": random.integers(0, 8, count) / 64}
        yield number, points, domain


class Complexes(unittest.TestCase):
    def test_random_sets_are_those_of_rational_arithmetic(self):
        polygons = alphas = 0
        for number, points, domain in random_cases(25):
            with self.subTest(number):
                t = vt.tessellate(points, want="faces", device="cpu", **domain)
                polygons += plane_oracle.check_delaunay(t, points)[1]
                plane_oracle.check_network(t, points)
                if domain.get("periodic") == "y":
                    continue
                if "box" in domain and "periodic" not in domain and "weights" in domain:
                    continue  # whose hidden seeds are those of the box
                try:
                    plane_oracle.check_alpha(t, points)
                    alphas += 1
                except ValueError as error:
                    self.assertIn("too small", str(error))
        self.assertGreater(polygons, 20)
        self.assertGreater(alphas, 6)

    def test_a_box_has_the_triangles_with_centers_inside(self):
        points = POINTS[:60]
        whole = vt.tessellate(points, box="none", want="faces")
        d = whole.delaunay()
        centers = whole.vertices[d.centers]
        inside = ((centers > 0) & (centers < 1)).all(axis=1)
        self.assertEqual((len(d.polytopes), d.shifts), (0, None))
        ours = vt.tessellate(points, box=BOX, want="faces").delaunay()
        self.assertEqual(set(map(tuple, ours.triangles.tolist())), set(map(tuple, d.triangles[inside].tolist())))
        self.assertEqual(repr(d), f"<pyvotess.Delaunay: {len(d.triangles)} triangles, 0 polygons>")
        with self.assertRaisesRegex(AttributeError, "tetrahedra"):
            vt.tessellate(np.random.default_rng(1).random((9, 3)), want="faces").delaunay().triangles  # noqa: B018

    def test_few_seeds(self):
        for points, triangles in ((POINTS[:0], 0), (POINTS[:1], 0), (POINTS[:2], 0), (POINTS[:3], 1),
                                  (np.outer(np.arange(5.0), (1, 2)), 0)):  # fmt: skip
            t = vt.tessellate(points, box="none", want="faces")
            d, n, a = t.delaunay(), t.network(), t.alpha_complex()
            self.assertEqual((d.triangles.shape, len(d.polytopes)), ((triangles, 3), 0))
            self.assertEqual(n.points.shape, (triangles, 2))
            self.assertEqual([len(rows) for rows in a.simplices], [len(points), max(len(points) - 1, 0) + triangles, triangles])

    def test_lattices(self):
        axis = np.arange(6) + 0.5
        square = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
        turn = np.array([(0.36, 0.48), (-0.48, 0.36)]) / 0.6
        for points, options in ((square, {"box": (0, 0, 6, 6)}), (square @ turn, {"cell": 6 * turn, "min_face": 1e-6})):
            t = vt.tessellate(points, periodic=True, want="faces", **options)
            d, n = t.delaunay(), t.network()
            self.assertEqual((len(d.triangles), len(d.polytopes), d.polytope_shifts.shape), (0, 36, (144, 2)))
            self.assertTrue((np.diff(d.polytopes.indptr) == 4).all())
            self.assertEqual((len(n.points), n.edges.shape, n.shifts.shape), (36, (72, 2), (72, 2)))
            np.testing.assert_allclose(n.vertex_radii, 0.5**0.5, atol=1e-12)
            np.testing.assert_allclose(n.edge_radii, 0.5, atol=1e-12)
            for axis in (None, 0, 1):
                self.assertAlmostEqual(n.largest_free(axis).radius, 0.5)
            with self.assertRaisesRegex(ValueError, "give 0 or 1"):
                n.largest_free(2)
        t = vt.tessellate(POINTS, box=BOX, periodic=True, want="faces", min_face=0.9)
        with self.assertRaisesRegex(ValueError, "edges below a length of .* were dropped.*min_face"):
            t.delaunay()

    def test_after_min_face_the_complex_still_fills_the_plane(self):
        found = 0
        for share in (0.01, 0.03, 0.1):
            t = vt.tessellate(POINTS, box=BOX, periodic=True, want="faces,areas", min_face=share)
            try:
                d = t.delaunay()
            except ValueError:
                continue
            found += 1
            n = t.network()
            self.assertEqual(len(n.points), len(d.triangles) + len(d.polytopes))
            self.assertEqual(len(n.points) - len(n.edges) + len(t), 0)
            self.assertEqual(len(n.edges), np.sum(t.indices >= 0) // 2)
            area = 0
            for members, _ in plane_oracle.simplices_of(d):
                x, y = (POINTS[[m[0] for m in members]] + [m[1] for m in members]).T
                area += (x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2
            self.assertAlmostEqual(area, 1)
        self.assertGreater(found, 0)

    def test_alpha_of_copies(self):
        points = POINTS[:5]
        t = vt.tessellate(points, box=BOX, periodic=True, want="faces")
        with self.assertRaisesRegex(ValueError, "replicate it 2 times or more"):
            t.alpha_complex()
        a = t.alpha_complex((3, 4))
        self.assertEqual(a.replicate, (3, 4))
        self.assertEqual([len(rows) for rows in a.simplices], [60, 180, 120])
        with self.assertRaisesRegex(ValueError, "give two whole numbers"):
            t.alpha_complex((3, 3, 3))

    def test_alpha_of_a_plane_in_space(self):
        a = vt.tessellate(POINTS, box="none", want="faces").alpha_complex()
        b = vt.tessellate(np.insert(POINTS, 2, 0.0, axis=1), box="none", want="faces").alpha_complex()
        for k in range(3):
            np.testing.assert_array_equal(a.simplices[k], b.simplices[k])
            np.testing.assert_array_equal(a.values[k], b.values[k])
            np.testing.assert_array_equal(a.gabriel[k], b.gabriel[k])

    def test_other_packages(self):
        n = vt.tessellate(POINTS[:20], box=BOX, periodic=True, want="faces").network()
        try:
            graph = n.to_networkx()
        except ImportError:
            self.skipTest("no networkx")
        self.assertEqual(set(graph.nodes[0]), {"x", "y", "radius"})


class Densities(unittest.TestCase):
    def density(self, t, points, masses):
        """Returns a function of places: the density by definition, linear in triangles and in fans of polygons."""
        size = np.zeros(len(points))
        parts = []  # corners with shifts, places, density at each
        edges = t.cell if t.cell is not None else np.diag(t.box[1] - t.box[0])
        for members, _ in plane_oracle.simplices_of(t.delaunay()):
            seeds, shifts = np.array([m[0] for m in members]), np.array([m[1] for m in members])
            corners = points[seeds] + shifts @ edges
            own = np.eye(len(seeds))
            fans = [(corners, own)]
            if len(seeds) > 3:  # around the center
                n = len(seeds)
                fans = [(np.array([corners.mean(0), corners[k], corners[(k + 1) % n]]), np.array([np.full(n, 1 / n), own[k], own[(k + 1) % n]]))
                        for k in range(n)]  # fmt: skip
            for x, weights in fans:
                area = np.linalg.det(x[1:] - x[0]) / 2
                np.add.at(size, seeds, area * weights.sum(axis=0))
                parts.append((seeds, x, weights))
        at_seeds = 3 * masses / size

        def at(places):
            values = np.full(len(places), np.nan)
            for seeds, x, weights in parts:
                inverse = np.linalg.inv(x[1:] - x[0])
                for move in np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1]), axis=-1).reshape(-1, 2):
                    part = (places + move @ edges - x[0]) @ inverse
                    inside = (part >= -1e-12).all(axis=1) & (part.sum(axis=1) <= 1 + 1e-12)
                    shares = np.column_stack((1 - part.sum(axis=1), part))
                    values[inside] = (shares @ weights @ at_seeds[seeds])[inside]
            return values

        return at

    def test_averages_of_densities(self):
        axis = (np.arange(4) + 0.5) / 4
        lattice = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
        for points, domain in ((POINTS[:30], {"box": BOX}), (lattice, {"box": BOX}),
                               (POINTS[:30] @ OBLIQUE, {"cell": OBLIQUE}), (POINTS[:3], {"box": (0, 0, 1, 1)})):  # fmt: skip
            masses = np.linspace(1, 2, len(points))
            t = vt.tessellate(points, periodic=True, want="faces", **domain)
            d = vt.Diagram(points, periodic=True, **domain)
            shape = (5, 3)
            grid = d.to_grid(masses, shape, method="dtfe")
            edges = t.cell if t.cell is not None else np.diag(t.box[1] - t.box[0])
            area = abs(np.linalg.det(edges))
            self.assertAlmostEqual(grid.mean() * area, masses.sum(), delta=1e-12 * masses.sum())
            fine = 24  # samples along each axis of a grid cell
            steps = [(np.arange(n * fine) + 0.5) / (n * fine) for n in shape]
            places = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 2) @ edges
            values = self.density(t, points, masses)(places).reshape(shape[0], fine, shape[1], fine)
            np.testing.assert_allclose(grid, values.mean(axis=(1, 3)), rtol=5e-3)
            if "box" in domain:
                np.testing.assert_allclose(d.to_grid(masses, shape, method="dtfe", project=0), grid.mean(axis=0), rtol=1e-12)

    def test_a_box_with_ends(self):
        grid = vt.Diagram(POINTS, box=BOX).to_grid(np.ones(400), 8, method="dtfe")
        self.assertAlmostEqual(grid.mean(), 400, delta=1e-9)
        with self.assertWarnsRegex(UserWarning, "dtfe omitted the mass of 2 of 2 seeds, which are in no triangle"):
            vt.Diagram(POINTS[:2], box=BOX).to_grid(np.ones(2), 8, method="dtfe")


class Areas(unittest.TestCase):
    DOMAINS = (
        {"box": BOX},
        {"box": BOX, "periodic": True},
        {"box": BOX, "periodic": "x", "walls": ()},
        {"cell": OBLIQUE, "periodic": "xy"},
        {"box": BOX, "walls": [(1, 1, 1.5)]},
    )

    def sets(self, count=60):
        for number, domain in enumerate(self.DOMAINS):
            points = np.random.default_rng(number).random((count, 2))
            if "cell" in domain:
                points = points @ OBLIQUE
            if domain.get("walls"):
                points = points[points.sum(axis=1) < 1.5]
            yield points, domain

    def test_fits_reach_their_areas(self):
        for points, domain in self.sets():
            with self.subTest(**domain):
                whole = vt.tessellate(points, **domain).volumes.sum()
                targets = np.exp(np.random.default_rng(7).normal(0, 0.7, len(points)))
                targets *= whole / targets.sum()
                fit = vt.fit_volumes(points, targets, **domain)
                self.assertLess(np.abs(fit.tessellation.volumes / targets - 1).max(), 1.001e-9)
                again = vt.tessellate(points, weights=fit.weights, **domain)
                np.testing.assert_array_equal(again.volumes, fit.tessellation.volumes)
                self.assertTrue(fit.tessellation.planar)

    def test_costs_are_second_moments_of_the_polygons(self):
        for points, domain in self.sets():
            t = vt.tessellate(points, want="faces", weights=np.linspace(0, 1e-3, len(points)), **domain)
            total = 0
            for polygon, place in zip(t.polygons, t.wrapped_points):
                total += plane_oracle.moments((polygon - place).tolist())[3]
            self.assertAlmostEqual(vt.transport_cost(t), total, delta=1e-13)
        dropped = vt.tessellate(POINTS, box=BOX, want="faces", min_face=0.2)
        whole = vt.tessellate(POINTS, box=BOX, want="faces")
        self.assertAlmostEqual(vt.transport_cost(dropped), vt.transport_cost(whole), delta=1e-15)

    def test_lloyd(self):
        one = vt.lloyd([(0.25, 0.125)], box=BOX)
        np.testing.assert_allclose(one.points, [(0.5, 0.5)], atol=1e-14)
        self.assertAlmostEqual(one.energies[-1], 1 / 6)
        for points, domain in self.sets(30):
            result = vt.lloyd(points, steps=12, over_relaxation=1.5, **domain)
            self.assertTrue((np.diff(result.energies) <= 1e-15).all())
            self.assertLess(result.energies[-1], result.energies[0])
            self.assertEqual(result.points.shape, points.shape)
            constant = vt.lloyd(points, steps=2, density=lambda x: np.full(len(x), 2.0), **domain)
            np.testing.assert_allclose(constant.energies, 2 * vt.lloyd(points, steps=2, **domain).energies, rtol=1e-12)
        fitted = vt.lloyd(POINTS[:20], steps=3, volumes=np.full(20, 1.0), normalize=True, box=(-0.5, 0, 1, 1))
        np.testing.assert_allclose(fitted.tessellation.volumes, 1.5 / 20, rtol=1e-8)

    def test_a_linear_density(self):
        """The rule of three points is exact: centroids are those of the polygon's third moments."""
        result = vt.lloyd([(0.25, 0.5)], steps=1, density=lambda x: x[:, 0], box=BOX)
        np.testing.assert_allclose(result.points, [(2 / 3, 0.5)], atol=1e-14)
        with self.assertRaisesRegex(ValueError, r"density is -1.0 at \(0"):
            vt.lloyd(POINTS, steps=1, density=lambda x: -np.ones(len(x)), box=BOX)

    def test_refusals(self):
        for call in (lambda: vt.fit_volumes(POINTS, np.ones(400), box="none", normalize=True), lambda: vt.lloyd(POINTS, steps=2, box="none")):
            with self.assertRaisesRegex(ValueError, "end|infinit|finite"):
                call()
        with self.assertRaisesRegex(ValueError, "the domain has 1:"):
            vt.fit_volumes(POINTS, np.ones(400), box=BOX)


class Plane(unittest.TestCase):
    def test_measures_are_those_of_the_polygons(self):
        for domain in ({"box": BOX}, {"box": BOX, "periodic": True}, {"box": BOX, "periodic": "y"}, {}):
            with self.subTest(**domain):
                t = vt.tessellate(POINTS, want=EVERYTHING, list_walls=True, **domain)
                self.assertTrue(t.planar)
                self.assertEqual((t.centroids.shape, t.vertices.shape[1], t.box.shape), ((400, 2), 2, (2, 2)))
                self.assertEqual(t.face_normals.shape, (len(t.indices), 2))
                for i, polygon in enumerate(t.polygons):
                    area, centroid = area_and_centroid(polygon)
                    self.assertAlmostEqual(area, t.volumes[i], delta=1e-12)
                    np.testing.assert_allclose(centroid, t.centroids[i], atol=1e-9)
                    sides = np.linalg.norm(polygon - np.roll(polygon, -1, axis=0), axis=1)
                    self.assertAlmostEqual(sides.sum(), t.surface_areas[i], delta=1e-12)
                    self.assertEqual(len(polygon), t.face_counts[i])
                self.assertTrue(t.verify())

    def test_domains(self):
        oblique = POINTS @ [[1, 0], [0.3, 1]]
        t = vt.tessellate(oblique, cell=((1, 0), (0.3, 1)))
        self.assertEqual((t.cell.shape, t.origin.shape, t.periodic), ((2, 2), (2,), (True, True)))
        self.assertAlmostEqual(t.volumes.sum(), 1, delta=1e-12)
        t = vt.tessellate(oblique, cell=((1, 0), (0.3, 1)), origin=(0.25, -0.5), periodic="x", outside="drop")
        self.assertEqual(t.periodic, (True, False))
        t = vt.tessellate(POINTS, box=BOX, walls=[(1, 1, 1.5)], outside="drop", list_walls=True)
        self.assertAlmostEqual(t.volumes.sum(), 1 - 0.125, delta=1e-12)
        np.testing.assert_array_equal(t.walls, [(1, 1, 1.5)])
        self.assertEqual(min(row.min() for row in t.neighbors if len(row)), -7)
        t = vt.tessellate(np.float32(POINTS), box=BOX, periodic=(True, False), radii=np.full(400, 0.01))
        self.assertAlmostEqual(t.volumes.sum(), 1, delta=1e-12)

    def test_kept_objects_and_files(self):
        with vt.Tessellator(device="cpu") as tessellator:
            first = tessellator.tessellate(POINTS, box=BOX, periodic=True, want="neighbors,volumes,vertices")
            solid = tessellator.tessellate(np.random.default_rng(1).random((50, 3)))
            again = tessellator.tessellate(POINTS, box=BOX, periodic=True, want="neighbors,volumes,vertices")
        self.assertFalse(solid.planar)
        np.testing.assert_array_equal(first.indices, again.indices)
        copy = pickle.loads(pickle.dumps(first))
        np.testing.assert_array_equal(copy.volumes, first.volumes)
        self.assertTrue(copy.verify())
        moved = POINTS + [3, -2]
        t = vt.tessellate(moved, box=BOX, periodic=True)
        np.testing.assert_allclose(t.wrapped_points, POINTS, atol=1e-15)
        pairs = t.pairs()
        self.assertEqual(pairs.vector.shape[1], 2)
        self.assertLess(pairs.distance.max(), 0.5)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "plane.npz")
            first.save(path)
            with np.load(path) as arrays:
                self.assertEqual((arrays["box"].shape, arrays["vertices"].shape[1]), ((2, 2), 2))

    def test_files_of_clvotess_are_the_same(self):
        program = os.environ.get("VOTESS_CLI")
        if not program:
            self.skipTest("VOTESS_CLI names no clvotess")
        cases = (
            (["--box", "0,0,1,1", "--periodic", "y"], {"box": BOX, "periodic": "y"}),
            (["--cell", "1,0,0.25,1", "--origin", "0.5,-1"], {"cell": ((1, 0), (0.25, 1)), "origin": (0.5, -1)}),
            (["--box", "0,0,1,1", "--wall", "1,1,1.5", "--outside", "keep"], {"box": BOX, "walls": [(1, 1, 1.5)], "outside": "keep"}),
            ([], {}),
        )
        with tempfile.TemporaryDirectory() as folder:
            np.save(Path(folder, "points.npy"), POINTS)
            for options, domain in cases:
                with self.subTest(**domain):
                    vt.tessellate(POINTS, want=EVERYTHING, list_walls=True, device="cpu", **domain).save(Path(folder, "ours.npz"))
                    command = [program, "points.npy", *options, "-x", "cpu", "--list-walls", "--want", EVERYTHING, "-o", "theirs.npz", "-q"]
                    subprocess.run(command, cwd=folder, check=True)
                    with np.load(Path(folder, "ours.npz")) as ours, np.load(Path(folder, "theirs.npz")) as theirs:
                        self.assertEqual(set(ours.files), set(theirs.files))
                        for name in set(ours.files) - {"domain_from", "periodic_from"}:
                            np.testing.assert_array_equal(ours[name], theirs[name], name)
                            self.assertEqual(ours[name].dtype, theirs[name].dtype, name)

    def test_frames_of_files(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "plane.npz")
            t = vt.tessellate(POINTS, cell=((1, 0), (0.25, 1)), origin=(0.5, -1), periodic="x", outside="drop")
            t.save(path, columns={"points": POINTS})
            frame, = vt.read_frames(path, columns=())
            np.testing.assert_array_equal(frame.points, POINTS)
            self.assertEqual(frame.domain.periodic, (True, False))
            again = frame.tessellate(outside="drop")
            self.assertTrue(again.planar)
            np.testing.assert_array_equal(again.volumes, t.volumes)
            path = Path(folder, "plane.txt")
            path.write_text("".join(f"{x!r} {y!r}\n" for x, y in POINTS.tolist()))
            np.testing.assert_array_equal(next(vt.read_frames(path)).points, POINTS)

    @have("matplotlib")
    def test_a_plot_fills_the_box(self):
        import matplotlib

        matplotlib.use("Agg")
        axes = vt.tessellate(POINTS, box=BOX, periodic=True, want="volumes,vertices").plot()
        polygons = [path.vertices[:-1] for path in axes.collections[0].get_paths()]
        inside = [np.clip(polygon, 0, 1) for polygon in polygons]
        self.assertGreater(len(polygons), 400)
        self.assertGreaterEqual(sum(abs(area_and_centroid(p)[0]) for p in inside if np.ptp(p, axis=0).min() > 0), 1 - 1e-9)
        with self.assertRaisesRegex(ValueError, "vertices"):
            vt.tessellate(POINTS, box=BOX).plot()

    def test_boxes_as_limits(self):
        """((x0, x1), (y0, y1)) as in space; what may also be two corners is refused."""
        points = np.array([(0.25, 2.25), (0.75, 2.75), (0.5, 2.5)])
        for box, corners in (
            (((0, 1), (2, 3)), None),
            (((0, 2), (1, 3)), None),  # area 1 as corners, 4 as limits
            (((0, 2), (1, 4)), None),
            (((0, 2), (2, 3)), (0, 2, 2, 3)),
            (((0, 1), (1, 3)), (0, 1, 1, 3)),  # the same in both ways
            (((0, 2), (2.0, 3)), (0, 2, 2, 3)),
            (((-1, 2), (-1, 3)), (-1, -1, 2, 3)),
            (((-1, -1), (1, 3)), (-1, -1, 1, 3)),
            ((-1, -1, 1, 3), (-1, -1, 1, 3)),
            (((0, 4), (1.5, 3)), (0, 1.5, 4, 3)),
        ):
            with self.subTest(box):
                if corners is None:
                    with self.assertRaisesRegex(ValueError, r"may be two corners or the limits.*\(x0, y0, x1, y1\)"):
                        vt.tessellate(points, box=box)
                    continue
                t = vt.tessellate(points, box=box, outside="keep")
                x0, y0, x1, y1 = corners
                self.assertAlmostEqual(t.volumes.sum(), (x1 - x0) * (y1 - y0))

    def test_refusals(self):
        for text, arguments in (
            ("box has 3 dimensions, but points have 2", {"box": (0, 0, 0, 1, 1, 1)}),
            ("cell has 3", {"cell": np.eye(3)}),
            ("walls has 3", {"walls": [(1, 0, 0, 1)]}),
            ("z repeats", {"box": BOX, "periodic": "xz"}),
        ):
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                vt.tessellate(**{"points": POINTS, **arguments})
        t = vt.tessellate(POINTS, box=BOX, want="faces,volumes,areas")
        for call in (t.voronoi_indices, lambda: t.save("x.ply")):
            with self.subTest(call), self.assertRaisesRegex(ValueError, "three dimensions"):
                call()
        with self.assertRaises(AttributeError):
            vt.tessellate(np.zeros((1, 3))).polygons  # noqa: B018


class Queries(unittest.TestCase):
    """A Diagram of the plane: vectors of two components everywhere."""

    def test_grids_in_polygons_cover_the_default_box(self):
        square = {"type": "Polygon", "coordinates": [[(0, 0), (1, 0), (1, 1), (0, 1)]]}
        for n in (1, 4, 100):
            box = vt.tessellate(POINTS[:n], mesh=square).box
            grid = vt.Diagram(POINTS[:n], mesh=square).to_grid(np.ones(n), (8, 8))
            self.assertAlmostEqual(grid.mean() * np.prod(box[1] - box[0]), 1, delta=1e-12)

    def test_vectors_have_two_components(self):
        """The numbers themselves are tested in C++ (tests/cases/query/plane.cpp)."""
        diagram, queries = vt.Diagram(POINTS, box=BOX, periodic="x"), np.random.default_rng(6).random((50, 2))
        self.assertTrue(diagram.planar)
        self.assertFalse(vt.Diagram(np.zeros((1, 3))).planar)
        probes = diagram.probe(queries, want=EVERYTHING)
        self.assertTrue(probes.planar)
        self.assertEqual((probes.centroids.shape, probes.shifts.shape[1], probes.box.shape), ((50, 2), 2, (2, 2)))
        self.assertAlmostEqual(area_and_centroid(probes.polygons[7])[0], probes.volumes[7], delta=1e-12)
        found = diagram.natural_neighbors(queries, gradient=True)
        self.assertEqual(found.gradients.shape, (len(found.weights), 2))
        field = POINTS @ [[2, 1], [-3, 0]]
        for beyond in ("nan", "nearest"):
            value, slope = vt.Diagram(POINTS).interpolate(field, queries, gradient=True, beyond=beyond)
            self.assertEqual((value.shape, slope.shape), ((50, 2), (50, 2, 2)))
        self.assertEqual(diagram.to_grid(field, (5, 4)).shape, (5, 4, 2))
        self.assertEqual(diagram.to_grid(field, (5, 4), project=1).shape, (5, 2))
        rays = diagram.trace(queries, queries - 0.5, middles=True)
        self.assertEqual(rays.middles.shape, (len(rays.seeds), 2))
        along = rays.integrate(POINTS @ [1, 2], np.broadcast_to([1.0, 2.0], (400, 2)))
        ends = queries + (queries - 0.5)
        inside = (np.abs(ends - 0.5) < 0.5).all(axis=1)  # no ray passes a wall or the period
        middles = (queries + ends)[inside] / 2
        np.testing.assert_allclose(along[inside], middles @ [1, 2] * np.linalg.norm(queries - 0.5, axis=1)[inside], rtol=1e-12)

    def test_refusals(self):
        diagram = vt.Diagram(POINTS, box=BOX)
        for says, call in (
            (r"queries has shape \(1, 3\): the seeds need \(Q, 2\)", lambda: diagram.locate([(0, 0, 0)])),
            (r"directions has shape .* need \(R, 2\)", lambda: diagram.trace([(0, 0)], [(1, 0, 0)])),
            (r"the seeds need \(Q, 3\)", lambda: vt.Diagram(np.zeros((1, 3))).locate([(0, 0)])),
            ("give two whole numbers", lambda: diagram.to_grid(np.ones(400), (2, 2, 2))),
            ("project", lambda: diagram.to_grid(np.ones(400), 2, project=2)),
            (r"need \(400, 2\)", lambda: diagram.trace([(0, 0)], [(1, 0)], middles=True).integrate(np.ones(400), np.ones((400, 3)))),
        ):
            with self.subTest(says), self.assertRaisesRegex(ValueError, says):
                call()


if __name__ == "__main__":
    unittest.main()
