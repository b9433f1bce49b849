"""surface(), lloyd_on_surface() and remesh(): fractions, the plane, sharp edges, bad input."""

import types
import unittest

import numpy as np
from helpers import CUBE, enclosed, is_closed
from surface_oracle import Oracle

import pyvotess as vt

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]


def grating(cells, thickness):
    """Returns a closed plate of unit squares with (cells // 2)^2 square holes."""
    solid = np.pad(np.ones((cells, cells), bool), 1)
    solid[2:-1:2, 2:-1:2] = False
    squares = []
    for i, j in np.argwhere(solid):
        a, b, c, d = (i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)
        squares += [[(*p, 1) for p in (a, b, c, d)], [(*p, 0) for p in (d, c, b, a)]]
        for p, q, beyond in ((a, b, (i, j - 1)), (b, c, (i + 1, j)), (c, d, (i, j + 1)), (d, a, (i - 1, j))):
            if not solid[beyond]:
                squares.append([(*q, 1), (*p, 1), (*p, 0), (*q, 0)])
    corners, at = np.unique(np.array(squares).reshape(-1, 3), axis=0, return_inverse=True)
    return corners * (1, 1, thickness), at.reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def sphere(n):
    """Returns points of a sphere, by a spiral, and the triangles between the rings of another."""
    z, turn = 1 - (2 * np.arange(n) + 1) / n, 2.399963229728653 * np.arange(n)
    r = np.sqrt(1 - z * z)
    return np.stack((r * np.cos(turn), r * np.sin(turn), z), axis=1)


def globe(rings, sides):
    """Returns a sphere of triangles."""
    a = np.pi * np.arange(1, rings) / rings
    b = 2 * np.pi * np.arange(sides) / sides
    inner = np.stack([np.outer(np.sin(a), np.cos(b)), np.outer(np.sin(a), np.sin(b)), np.outer(np.cos(a), np.ones(sides))], -1)
    vertices = np.concatenate(([(0, 0, 1)], inner.reshape(-1, 3), [(0, 0, -1)]))
    at = 1 + np.arange((rings - 1) * sides).reshape(rings - 1, sides)
    right, last = np.roll(at, -1, axis=1), len(vertices) - 1
    triangles = [(0, at[0, j], right[0, j]) for j in range(sides)] + [(last, right[-1, j], at[-1, j]) for j in range(sides)]
    for i in range(rings - 2):
        for j in range(sides):
            triangles += [(at[i, j], at[i + 1, j], right[i + 1, j]), (at[i, j], right[i + 1, j], right[i, j])]
    return vertices, np.array(triangles)


def random_case(seed):
    """Returns points, vertices, triangles and weights: lattices, decimals, mirrors, surfaces that are not manifold."""
    rng = np.random.default_rng(seed)
    kind = seed % 4
    draw = [
        lambda m: rng.integers(0, 3, (m, 3)) / 2,
        lambda m: np.round(rng.random((m, 3)), 1),
        lambda m: rng.random((m, 3)),
        lambda m: rng.integers(0, 3, (m, 3)) * [1.0, 1.0, 0.0],
    ][kind]
    vertices, points = draw(int(rng.integers(4, 7))), draw(int(rng.integers(2, 6)))
    triangles = rng.integers(0, len(vertices), (int(rng.integers(2, 6)), 3))
    weights = rng.integers(0, 3, len(points)) / 4 if seed % 3 == 0 else None
    return points, vertices, triangles, weights


class Surface(unittest.TestCase):
    def check_against_fractions(self, points, vertices, triangles, weights):
        o = Oracle(points, vertices, [tuple(map(int, t)) for t in triangles], weights)
        if not o.parts:
            with self.assertRaisesRegex(ValueError, "surface: its triangles have no area"):
                vt.surface(points, (vertices, triangles), weights=weights)
            return
        c = vt.surface(points, (vertices, triangles), weights=weights)
        total = sum(o.area_of.values())
        self.assertAlmostEqual(c.areas.sum() / total, 1, delta=1e-13)
        np.testing.assert_allclose(c.areas, o.areas, rtol=0, atol=1e-13 * total)
        np.testing.assert_allclose(c.borders, o.borders, rtol=0, atol=1e-12)
        self.assertEqual((c.pieces.tolist(), c.euler.tolist()), (o.pieces, o.euler))
        keys = list(zip(c.polygon_triangles.tolist(), c.polygon_seeds.tolist()))
        self.assertEqual(keys, sorted(o.polygons))
        np.testing.assert_allclose(c.polygon_areas, [o.polygons[key] for key in keys], rtol=0, atol=1e-13 * total)
        rows = {}
        for i in range(len(c)):
            for k in range(c.indptr[i], c.indptr[i + 1]):
                rows[i, int(c.indices[k])] = (c.lengths[k], c.curves[k], c.loops[k])
            if o.areas[i] > 1e-3 * total:
                np.testing.assert_allclose(c.centroids[i], o.centroids[i], rtol=0, atol=1e-11)
        self.assertEqual(rows.keys(), o.rows.keys())
        for key, (length, curves, loops) in rows.items():
            self.assertAlmostEqual(length, o.rows[key][0], delta=1e-12)
            self.assertEqual((curves, loops), o.rows[key][1:])
            self.assertEqual(length, rows[key[::-1]][0])
        self.assertEqual({tuple(sorted(t)): n for t, n in zip(c.dual.tolist(), c.dual_counts)}, {t: len(m) for t, m in o.dual.items()})
        for t in c.dual.tolist():
            self.assertEqual(tuple(t), o.dual[tuple(sorted(t))][0])

    def test_fractions(self):
        for seed in range(24):
            with self.subTest(seed=seed):
                self.check_against_fractions(*random_case(seed))

    def test_plane(self):
        points = np.random.default_rng(1).random((400, 2))
        t = vt.tessellate(points, box=(0, 0, 1, 1), want="volumes,areas,centroids")
        c = vt.surface(np.c_[points, np.zeros(400)], SQUARE)
        np.testing.assert_array_equal(c.indices, t.indices)
        np.testing.assert_allclose(c.areas, t.volumes, rtol=1e-11)
        np.testing.assert_allclose(c.lengths, t.face_areas, rtol=0, atol=1e-13)
        np.testing.assert_allclose(c.centroids[:, :2], t.centroids, rtol=0, atol=1e-13)
        np.testing.assert_array_equal(c.nearest[:, 2], 0)
        np.testing.assert_allclose(c.borders.sum(), 4, rtol=1e-13)
        self.assertEqual(len(c.faults), 0)
        # Polygons are counterclockwise, and share their corners.
        for p in range(len(c.polygon_seeds)):
            x, y, _ = c.vertices[c.corners[c.polygon_offsets[p] : c.polygon_offsets[p + 1]]].T
            self.assertAlmostEqual((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2, c.polygon_areas[p], delta=1e-15)
        self.assertEqual(len(np.unique(c.vertices, axis=0)), len(c.vertices))

    def test_faults(self):
        # Two seeds on a tube share two curves, one far above a plate none, and the cap of a globe is bounded by a loop.
        a = 2 * np.pi * np.arange(12) / 12
        ring = np.stack((np.cos(a), np.sin(a), 0 * a), axis=1)
        tube = np.concatenate((ring, ring + [0, 0, 1]))
        i, j = np.arange(12), np.roll(np.arange(12), -1)
        triangles = np.concatenate((np.stack((i, j, j + 12), 1), np.stack((i, j + 12, i + 12), 1)))
        c = vt.surface([(1, 0.1, 0.5), (-1, 0.1, 0.5), (0, 0, 9)], (tube, triangles))
        self.assertEqual((c.curves.tolist(), c.loops.tolist(), c.faults.tolist()), ([2, 2], [0, 0], [0, 1]))
        self.assertEqual((c.pieces.tolist(), c.euler.tolist()), ([1, 1, 0], [1, 1, 0]))
        c = vt.surface([(0, 0, 0.5), (0, 0, 1)], globe(6, 8))
        self.assertEqual((c.curves.tolist(), c.loops.tolist(), c.euler.tolist()), ([1, 1], [1, 1], [1, 1]))
        # One seed in the middle of a tube has its whole waist: a ring.
        c = vt.surface([(0, 0, 0.5)], (tube, triangles))
        self.assertEqual((c.pieces.tolist(), c.euler.tolist(), c.faults.tolist()), ([1], [0], [0]))
        np.testing.assert_allclose(c.perimeters, 2 * 24 * np.sin(np.pi / 12), rtol=1e-13)

    def test_merge(self):
        vertices, triangles = CUBE
        soup = np.asarray(vertices)[triangles].reshape(-1, 3)
        rows = np.arange(len(soup)).reshape(-1, 3)
        whole, merged = vt.surface(vertices[:2] * 0.9, (vertices, triangles)), vt.surface(vertices[:2] * 0.9, (soup, rows), merge=True)
        np.testing.assert_array_equal(whole.areas, merged.areas)
        np.testing.assert_array_equal(merged.borders, 0)
        self.assertGreater(vt.surface(vertices[:2] * 0.9, (soup, rows)).borders.min(), 0)

    def test_lloyd(self):
        relaxed = vt.lloyd_on_surface(sphere(40) * 1.5 + 0.2, globe(20, 30), steps=20, fixed=[0])
        self.assertTrue((np.diff(relaxed.energies) <= 1e-12).all())
        np.testing.assert_array_equal(relaxed.points[0], sphere(40)[0] * 1.5 + 0.2)
        np.testing.assert_allclose(np.linalg.norm(relaxed.points[1:], axis=1), 1, atol=0.03)
        self.assertLess(relaxed.cells.areas[1:].std(), 0.35 * relaxed.cells.areas[1:].mean())
        early = vt.lloyd_on_surface(sphere(40), globe(20, 30), steps=50, tolerance=0.05)
        self.assertLess(len(early.moved), 50)

    def test_remesh(self):
        vertices, triangles = CUBE
        mesh = vt.remesh((vertices, triangles), 300)
        self.assertTrue(is_closed(mesh.triangles))
        self.assertEqual(len(mesh.cells.faults), 0)
        for corner in vertices:
            self.assertTrue((mesh.vertices == corner).all(axis=1).any())
        self.assertAlmostEqual(enclosed(mesh.vertices[mesh.triangles]), 1, delta=1e-3)
        self.assertGreater(mesh.angles.min(), 15)
        self.assertEqual((mesh.border_edges, mesh.crowded_edges, len(mesh.faults)), (0, 0, 0))
        self.assertAlmostEqual(mesh.min_angle, mesh.angles.min(), places=9)
        self.assertAlmostEqual(mesh.mean_min_angle, mesh.angles.min(axis=1).mean(), places=9)
        self.assertLess(mesh.distance, 0.05)  # about 0: its triangles lie in the faces
        # A plate thinner than its triangles: cells hold both of its sides, which the mesh keeps apart.
        thin = vt.remesh((vertices * (1, 1, 0.01), triangles), 300, steps=15)
        self.assertTrue(is_closed(thin.triangles))
        self.assertEqual((thin.border_edges, thin.crowded_edges, len(thin.faults)), (0, 0, 0))
        self.assertLess(len(thin.points), 0.7 * len(thin.vertices))
        # An open square: its border is kept.
        flat = vt.remesh(SQUARE, 60, rng_seed=0)
        x = flat.vertices[flat.triangles]
        np.testing.assert_allclose(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])[:, 2].sum() / 2, 1, rtol=1e-12)
        np.testing.assert_array_equal(flat.vertices, vt.remesh(SQUARE, 60, rng_seed=0, threads=1).vertices)

    def test_meshes_of_other_packages(self):
        vertices, triangles = globe(6, 8)
        remeshed = vt.remesh((vertices, triangles), 30, steps=2)
        of_trimesh = types.SimpleNamespace(vertices=vertices, faces=triangles)
        of_open3d = types.SimpleNamespace(vertices=vertices, triangles=triangles)
        for mesh in (of_trimesh, of_open3d):
            np.testing.assert_array_equal(vt.remesh(mesh, 30, steps=2).vertices, remeshed.vertices)
            relaxed = vt.lloyd_on_surface(vertices[:3], mesh, steps=1)
            self.assertAlmostEqual(vt.surface(vertices[:3], mesh).areas.sum(), relaxed.cells.areas.sum())
        self.assertGreater(vt.remesh(remeshed, 20, steps=2).angles.min(), 0)

    def test_remesh_is_like_the_surface(self):
        # Bars thinner than the triangles are long: cells go around them, and mix their sides.
        for cells in (1, 3, 5, 7):
            for thickness in (0.01, 0.3, 1.0):
                surface = grating(cells, thickness)
                if cells == 1:  # a bar
                    surface = surface[0] * (1, 0.01, 1), surface[1]
                for n in (40, 200):
                    mesh = vt.remesh(surface, n, steps=8)
                    case = cells, thickness, n
                    self.assertTrue(is_closed(mesh.triangles), case)
                    used = len(np.unique(mesh.triangles))
                    self.assertEqual(used - len(mesh.triangles) // 2, 2 - 2 * (cells // 2) ** 2, case)
                    self.assertEqual((mesh.border_edges, mesh.crowded_edges), (0, 0), case)
                    self.assertTrue(len(mesh.faults) == 0 or n == 40, case)  # 40 may be too few for all corners
                    self.assertEqual(used, len(mesh.vertices), case)
                    # Each vertex is on the surface.
                    a, b, c = np.moveaxis(surface[0][surface[1]], 1, 0)
                    normals = np.cross(b - a, c - a)
                    off = np.abs(((mesh.vertices[:, None] - a) * normals).sum(axis=2) / np.linalg.norm(normals, axis=1))
                    self.assertLess(off.min(axis=1).max(), 1e-12, case)

    def test_remesh_flips_flat_triangles(self):
        lens, better = globe(8, 12), 0
        for seed in range(10):
            mesh = vt.remesh((np.asarray(lens[0]) * (1, 0.1, 0.5), lens[1]), 70, steps=8, rng_seed=seed)
            self.assertTrue(is_closed(mesh.triangles))
            self.assertEqual((len(mesh.triangles), len(mesh.faults)), (2 * len(mesh.vertices) - 4, 0))
            dual = mesh.vertices[mesh.cells.piece_dual]
            a, b = np.roll(dual, -1, axis=1) - dual, np.roll(dual, 1, axis=1) - dual
            before = np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=2), (a * b).sum(axis=2))).min()
            self.assertGreaterEqual(mesh.min_angle, before - 1e-9)
            better += mesh.min_angle > before + 1
        self.assertGreater(better, 2)

    def test_no_triangle_names_a_vertex_twice(self):
        corners, sides = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
        for n in range(1, 7):
            for seed in range(8):
                a, b, c = vt.remesh((corners, sides), n, rng_seed=seed).triangles.T
                self.assertFalse(((a == b) | (b == c) | (c == a)).any(), (n, seed))

    def test_right_meshes_of_few_points_have_no_faults(self):
        for n in (2, 3, 4):
            mesh = vt.remesh(([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]), n)
            a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
            self.assertAlmostEqual(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2, 0.5)
            self.assertEqual((len(mesh.faults), mesh.border_edges), (0, len(mesh.vertices)))

    def test_one_cell_after_the_other(self):
        # Weights, even such as change no sign, clip triangles to one cell after the other; without them cells are made together.
        rng = np.random.default_rng(8)
        flat = np.array([(0, 0, 0), (1, 0, 0), (0.2, 0.9, 0.4), (2, 2, 2)]), np.array([(0, 1, 2), (1, 3, 2)])
        for points, (vertices, triangles) in (
            (1.1 * sphere(300), globe(5, 7)),
            (sphere(20), globe(20, 30)),
            (rng.random((400, 3)) * [1, 1, 0.1], flat),
            (rng.random((40, 3)) ** 8, flat),
        ):
            together = vt.surface(points, (vertices, triangles))
            weights = np.zeros(len(points))
            weights[0] = 1e-250
            each = vt.surface(points, (vertices, triangles), weights=weights)
            total = each.areas.sum()
            np.testing.assert_allclose(together.areas, each.areas, rtol=0, atol=1e-14 * total)
            np.testing.assert_allclose(together.lengths, each.lengths, rtol=0, atol=1e-12)
            sums = [np.add.reduceat(c.vertices[c.corners], c.polygon_offsets[:-1]) for c in (together, each)]
            np.testing.assert_allclose(*sums, rtol=0, atol=1e-10)
            for name in ("indptr", "indices", "dual", "polygon_triangles", "polygon_seeds", "polygon_offsets", "pieces", "euler"):
                np.testing.assert_array_equal(getattr(together, name), getattr(each, name), err_msg=name)

    def test_want(self):
        points, (vertices, triangles) = sphere(60), globe(8, 12)
        whole = vt.surface(points, (vertices, triangles))
        made = 0
        for want in ("areas", "nearest", "polygons", "all"):
            cells = vt.surface(points, (vertices, triangles), want=want)
            self.assertGreater(len(vars(cells)), made)
            made = len(vars(cells))
            for name, array in vars(cells).items():
                np.testing.assert_array_equal(array, getattr(whole, name), name)
        self.assertEqual(made, len(vt.SurfaceCells.__dataclass_fields__))
        cells = vt.surface(points, (vertices, triangles), want="areas")
        self.assertIn("60 cells>", repr(cells))
        with self.assertRaisesRegex(AttributeError, "dual was not computed: give want='all' to surface()"):
            cells.dual

    def test_remesh_in_any_unit(self):
        vertices, triangles = np.asarray(globe(8, 12)[0], float), globe(8, 12)[1]
        one = vt.remesh((vertices, triangles), 100, steps=5)
        seeds = sphere(30)
        relaxed = vt.lloyd_on_surface(seeds, (vertices, triangles), steps=3)
        for unit in (2.0**300, 2.0**-300):
            with self.assertWarnsRegex(RuntimeWarning, "energies of cells are beyond float64"):
                mesh = vt.remesh((vertices * unit, triangles), 100, steps=5)
            with self.assertWarnsRegex(RuntimeWarning, "energies of cells are beyond float64"):
                far = vt.lloyd_on_surface(seeds * unit, (vertices * unit, triangles), steps=3)
            np.testing.assert_array_equal(far.points, relaxed.points * unit)
            np.testing.assert_array_equal(far.moved, relaxed.moved)
            np.testing.assert_array_equal(mesh.vertices, one.vertices * unit)
            np.testing.assert_array_equal(mesh.cells.areas, one.cells.areas * unit**2)
            self.assertEqual((mesh.distance, mesh.min_angle), (one.distance * unit, one.min_angle))
        # The distance is that of places on the surface, also beside other sheets.
        a, b, c = np.moveaxis(vertices[triangles], 1, 0)
        normals = np.cross(b - a, c - a)
        off = np.abs(((one.vertices[:, None] - a) * normals).sum(axis=2) / np.linalg.norm(normals, axis=1)).min(axis=1)
        self.assertLess(off.max(), 1e-12)

    def test_remesh_keeps_small_parts_or_reports_them(self):
        corners, sides = CUBE
        vertices = np.concatenate((corners, 0.05 * corners + [1.2, 0.3, 0.3]))
        mesh = vt.remesh((vertices, np.concatenate((sides, np.add(sides, len(corners))))), 200)
        self.assertEqual((len(mesh.faults), mesh.border_edges, mesh.crowded_edges), (0, 0, 0))
        self.assertAlmostEqual(mesh.vertices[mesh.triangles, 0].max(), 1.25)
        ribbon = [(0, 0, 0), (10, 0, 0), (10, 0.1, 0), (0, 0.1, 0)]
        for count in (20, 100):
            mesh = vt.remesh((ribbon, [(0, 1, 2), (0, 2, 3)]), count)
            a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
            area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
            self.assertTrue(area > 0.9 or len(mesh.faults) > 0, (count, area))

    def test_remesh_keeps_corners_and_borders(self):
        def fan(x, y):
            n = len(x)
            vertices = np.append(np.stack((x, y, np.zeros(n)), axis=1), [(np.mean(x), np.mean(y), 0)], axis=0)
            return vertices, np.array([(i, (i + 1) % n, n) for i in range(n)]), n

        turn = np.pi * np.arange(10) / 5
        star = np.where(np.arange(10) % 2, 0.38, 1.0)
        ell = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)]
        corners, sides = CUBE
        for vertices, triangles, kept in (
            (*SQUARE, 4),
            (ell, [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)], 6),
            fan(star * np.cos(turn), star * np.sin(turn)),
            fan((0, 1, 1), (0, 0, 0.02)),  # a tip of one degree
            ([(0, 0, 0), (1, 0, 0), (1, 0.01, 0), (0, 0.01, 0)], [(0, 1, 2), (0, 2, 3)], 4),
            (corners, sides[:-2], 8),  # a box without a lid
        ):
            given = np.asarray(vertices, float)
            a, b, c = np.moveaxis(given[np.asarray(triangles)], 1, 0)
            area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
            for n, seeds in ((kept, 6), (2 * kept, 6), (60, 12)):
                for rng_seed in range(seeds):
                    mesh = vt.remesh((given, triangles), n, rng_seed=rng_seed)
                    case = kept, n, rng_seed, len(mesh.vertices)
                    if len(mesh.faults) > 0 and n < 60:
                        continue
                    self.assertEqual((len(mesh.faults), mesh.crowded_edges), (0, 0), case)
                    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
                    made = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
                    self.assertAlmostEqual(made / area, 1, delta=1e-9, msg=case)
                    used = {tuple(x) for x in mesh.vertices[np.unique(mesh.triangles)]}
                    self.assertLessEqual({tuple(x) for x in given[:kept]}, used, case)
        # Too many corners for so few vertices.
        mesh = vt.remesh(fan(star * np.cos(turn), star * np.sin(turn))[:2], 3)
        self.assertGreater(len(mesh.faults), 0)

    def test_remesh_keeps_openings(self):
        angles = 2 * np.pi * np.arange(12) / 12
        ring = np.stack((0.05 * np.cos(angles), 0.05 * np.sin(angles)), axis=1)
        tube = np.concatenate([np.insert(ring, 2, z, axis=1) for z in np.linspace(0, 1, 21)])
        at = np.arange(len(tube)).reshape(21, 12)
        a, b, c, d = at[:-1], np.roll(at, -1, 1)[:-1], np.roll(at, -1, 1)[1:], at[1:]
        triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
        for seed in range(3):
            mesh = vt.remesh((tube, triangles), 20, rng_seed=seed)
            self.assertTrue(mesh.border_edges >= 6 or len(mesh.faults) > 0, (seed, mesh.border_edges))

    def test_bad_input(self):
        points, (vertices, triangles) = np.zeros((1, 3)), SQUARE
        for message, call in (
            ("points has shape", lambda: vt.surface(np.zeros((1, 2)), (vertices, triangles))),
            ("there are no points", lambda: vt.surface(np.zeros((0, 3)), (vertices, triangles))),
            ("triangles of mesh have shape", lambda: vt.surface(points, (vertices, [0, 1, 2]))),
            ("triangles of mesh have .* float64: give", lambda: vt.surface(points, (vertices, np.zeros((1, 3))))),
            ("a surface lies in space", lambda: vt.surface(points, ([(0, 0), (1, 0)], [(0, 1)]))),
            ("mesh: triangle 0 names vertex 4, but there are 4", lambda: vt.surface(points, (vertices, [(0, 1, 4)]))),
            ("surface: vertex 3: y = nan is not finite", lambda: vt.surface(points, ([*vertices[:3], (0, np.nan, 0)], triangles))),
            (r"^weights\[0\] = inf is not finite", lambda: vt.surface(points, (vertices, triangles), weights=[np.inf])),
            ("weights has shape", lambda: vt.surface(points, (vertices, triangles), weights=[1, 2])),
            ("n is 0", lambda: vt.remesh((vertices, triangles), 0)),
            ("n is 2147483647: give 1 to 268435456", lambda: vt.remesh((vertices, triangles), 2**31 - 1)),
            ("sharp is nan", lambda: vt.remesh((vertices, triangles), 5, sharp=np.nan)),
            ("its triangles have no area", lambda: vt.remesh((vertices, [(0, 1, 1)]), 5)),
            ("tolerance is -1", lambda: vt.lloyd_on_surface(points, (vertices, triangles), tolerance=-1)),
        ):
            with self.assertRaisesRegex(ValueError, message):
                call()
        with self.assertRaises(vt.VotessError):
            vt.surface(np.random.default_rng(0).random((3000, 3)), globe(60, 60), progress=lambda fraction: False)


if __name__ == "__main__":
    unittest.main()
