"""Voronoi and Delaunay with scipy's attributes: compared with scipy if it is installed, and checked by themselves."""

import copy
import pickle
import sys
import unittest
from fractions import Fraction
from unittest import mock

import numpy as np
import pyvotess.compat.scipy
from helpers import lattice, uniform
from pyvotess.compat import _points
from pyvotess.compat.scipy import Delaunay, QhullError, Voronoi

try:
    import scipy.interpolate
    import scipy.spatial as peer
except ImportError:
    peer = None

needs_scipy = unittest.skipUnless(peer, "SciPy is not installed")


def turned(points, seed=4):
    axes, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return points @ axes


def face_centered(n):
    return np.concatenate([lattice(n) + shift for shift in ((0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5))])


def on_sphere(count):
    points = np.random.default_rng(6).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1)[:, None]


def ring(ids):
    """Returns the polygon from its smallest corner, in either direction."""
    first = ids.index(min(ids))
    ids = ids[first:] + ids[:first]
    return min(tuple(ids), (ids[0], *ids[:0:-1]))


def sets(rows):
    return {tuple(sorted(row)) for row in rows.tolist()}


CLOUDS = {
    "uniform": uniform(400),
    "one tetrahedron": np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]),
    "cube": lattice(2),
    "octahedron": np.concatenate((np.eye(3), -np.eye(3))),
    "lattice": lattice(5),
    "lattice in any order": np.random.default_rng(2).permutation(lattice(5)),
    "body-centered": np.concatenate((lattice(4), lattice(4) + 0.5)),
    "face-centered": np.random.default_rng(3).permutation(face_centered(4)),
    "face-centered, turned": turned(face_centered(3)),
    "almost a lattice": lattice(5) + 1e-10 * uniform(125),
    "as close to a lattice as can be": lattice(4) + 2e-16 * uniform(64),
    "sphere": on_sphere(150),
    "thin": uniform(300) * (1, 1, 1e-6),
    "needle": uniform(300) * (1, 1e-6, 1e-6),
    "far away": uniform(200) + 1e6,
    "small": uniform(200) * 1e-9,
}


class VoronoiTest(unittest.TestCase):
    def compare(self, points):
        ours, theirs = Voronoi(points), peer.Voronoi(points)
        self.assertEqual(len(ours.vertices), len(theirs.vertices))
        place = peer.cKDTree(ours.vertices).query(theirs.vertices)[1]
        self.assertEqual(len(set(place)), len(place))
        size = 1 + np.linalg.norm(theirs.vertices, axis=1)
        self.assertLess((np.linalg.norm(ours.vertices[place] - theirs.vertices, axis=1) / size).max(), 1e-9)
        place = np.append(place, -1).tolist()

        expected = {tuple(sorted(key)): ring([place[v] for v in row]) for key, row in theirs.ridge_dict.items()}
        found = {key: ring(row) for key, row in ours.ridge_dict.items()}
        self.assertEqual({key: found[key] for key in expected}, expected)
        # Qhull omits ridges with a single vertex.
        self.assertTrue(all(len(found[key]) == 2 and -1 in found[key] for key in set(found) - set(expected)))
        for point in range(len(points)):
            row = theirs.regions[theirs.point_region[point]]
            self.assertEqual(ours.regions[ours.point_region[point]], sorted(place[v] for v in row))

    @needs_scipy
    def test_equals_scipy(self):
        for count in (4, 5, 6, 20, 500, 3000):
            self.compare(uniform(count, seed=count))
        self.compare(uniform(300) * (5, 1, 0.2) - 3)

    @needs_scipy
    def test_attributes(self):
        points = uniform(50).astype(np.float32)
        ours, theirs = Voronoi(points), peer.Voronoi(points)
        for name in ("points", "min_bound", "max_bound"):
            np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))
        for name in ("ndim", "npoints", "furthest_site"):
            self.assertEqual(getattr(ours, name), getattr(theirs, name))
        for name in ("points", "vertices", "ridge_points", "point_region"):
            self.assertEqual(getattr(ours, name).dtype, getattr(theirs, name).dtype, name)
        for name in ("regions", "ridge_vertices"):
            self.assertIs(type(getattr(ours, name)), list)
            self.assertIs(type(getattr(ours, name)[3]), list)
            self.assertIs(type(getattr(ours, name)[3][-1]), int)
            self.assertIs(getattr(ours, name), getattr(ours, name))

    def test_one_run_in_a_large_box_gives_the_same(self):
        for name, points in CLOUDS.items():
            with self.subTest(name):
                ours = Voronoi(points)
                reach = 1e40 if name == "as close to a lattice as can be" else 1e24
                whole = Voronoi(points, box=np.stack((points.min(axis=0) - reach, points.max(axis=0) + reach)))
                self.assertLess(np.abs(whole.vertices).max(), reach / 2)
                self.assertEqual(len(ours.vertices), len(whole.vertices))
                self.assertEqual(sets(ours.ridge_points), sets(whole.ridge_points))
                self.assertEqual(sorted(map(len, ours.ridge_vertices)), sorted(map(len, whole.ridge_vertices)))
                self.assertEqual([len(row) for row in ours.regions], [len(row) for row in whole.regions])
                self.assertEqual([-1 in row for row in ours.regions], [-1 in row for row in whole.regions])

    def test_vertices_are_as_far_from_all_cells_around(self):
        points = uniform(3000, seed=9)
        vor = Voronoi(points)
        self.assertGreater(np.abs(vor.vertices).max(), 50)
        distances = [[] for _ in vor.vertices]
        for point, region in enumerate(vor.regions):
            for vertex in region:
                if vertex >= 0:
                    distances[vertex].append(np.linalg.norm(points[point] - vor.vertices[vertex]))
        for row in distances:
            self.assertEqual(len(row), 4)
            self.assertLess(np.ptp(row), 1e-9 * row[0])

    def test_steps_of_the_manual_on_a_lattice(self):
        # 3 x 3 x 3 points: the middle one has the only finite region, with all 8 vertices.
        points = lattice(3)
        vor = Voronoi(points)
        self.assertEqual(sorted(vor.vertices.tolist()), sorted((lattice(2) + 0.5).tolist()))
        finite = [row for row in vor.regions if row and -1 not in row]
        self.assertEqual(finite, [list(range(8))])
        self.assertEqual(vor.regions[vor.point_region[13]], list(range(8)))
        closed = [pair for pair, row in vor.ridge_dict.items() if -1 not in row]
        self.assertEqual(sorted(closed), sorted(tuple(sorted((13, 13 + step))) for step in (-9, -3, -1, 1, 3, 9)))
        # A ridge is in the plane halfway between its points.
        for (i, j), row in vor.ridge_dict.items():
            inner = vor.vertices[[v for v in row if v >= 0]]
            np.testing.assert_allclose((inner - (points[i] + points[j]) / 2) @ (points[j] - points[i]), 0, atol=1e-14)
        self.assertEqual(len(vor.ridge_vertices), 54)

    def test_box(self):
        points = uniform(200)
        whole, cut = Voronoi(points), Voronoi(points, box=(0, 0, 0, 1, 1, 1))
        inside = ((whole.vertices > 0) & (whole.vertices < 1)).all(axis=1)
        self.assertEqual(len(cut.vertices), np.count_nonzero(inside))
        self.assertTrue(sets(cut.ridge_points) <= sets(whole.ridge_points))
        self.assertGreater(sum(-1 in row for row in cut.regions), sum(-1 in row for row in whole.regions))

    def test_equal_points(self):
        points = np.concatenate((uniform(50), uniform(50)[7:9]))
        vor = Voronoi(points)
        self.assertEqual(vor.point_region[-2:].tolist(), [7, 8])
        self.assertEqual(vor.regions[-2:], [[], []])
        self.assertEqual(vor.regions[:50], Voronoi(points[:50]).regions)

    def test_what_is_refused(self):
        points = uniform(50)
        for make in (Voronoi, Delaunay):
            for flat in (points * (1, 1, 0), points * (1, 0, 0), points[:3], points[:0], points * 0, lattice(3)[:9]):
                with self.assertRaises(QhullError):
                    make(flat)
            with self.assertRaisesRegex(ValueError, "NaN"):
                make(np.where(points == points[0], np.nan, points))
            with self.assertRaisesRegex(ValueError, "shape"):
                make(points[:, :1])
            with self.assertRaisesRegex(NotImplementedError, "furthest_site"):
                make(points, furthest_site=True)
            with self.assertRaisesRegex(NotImplementedError, "incremental"):
                make(points, incremental=True)
            with self.assertRaisesRegex(NotImplementedError, "incremental"):
                make(points, qhull_options="Qbb").add_points(points)
            make(points, threads=1).close()

    @needs_scipy
    def test_error_is_that_of_scipy(self):
        self.assertIs(QhullError, peer.QhullError)
        with self.assertRaises(peer.QhullError):
            Voronoi(uniform(9) * (1, 1, 0))

    def test_error_without_scipy(self):
        _points.qhull_error.cache_clear()
        self.addCleanup(_points.qhull_error.cache_clear)
        with mock.patch.dict(sys.modules, {"scipy.spatial": None}):
            self.assertIs(pyvotess.compat.scipy.QhullError, _points.QhullError)
            with self.assertRaisesRegex(_points.QhullError, "one plane"):
                Delaunay(uniform(9) * (1, 1, 0))
            self.assertIs(Delaunay(uniform(9)).__class__, Delaunay)
        with self.assertRaisesRegex(AttributeError, "no attribute 'ConvexHull'"):
            pyvotess.compat.scipy.ConvexHull


class DelaunayTest(unittest.TestCase):
    def test_simplices_fill_the_hull(self):
        for name, points in CLOUDS.items():
            with self.subTest(name):
                tri = Delaunay(points)
                corners = points[tri.simplices]
                volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
                self.assertGreater(volumes.min(), -1e-9 * volumes.max())  # rounding of flat simplices
                # The volume inside of the surface is that of the simplices.
                base = points.mean(axis=0)
                inside = np.linalg.det(points[tri.convex_hull] - base).sum() / 6
                self.assertAlmostEqual(volumes.sum() / inside, 1, delta=1e-9)
                # No face has three simplices, and the faces with one form a sphere.
                opposite = [(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)]
                faces = np.sort(tri.simplices[:, opposite].reshape(-1, 3), axis=1)
                _, counts = np.unique(faces, axis=0, return_counts=True)
                self.assertLessEqual(counts.max(), 2)
                self.assertEqual(np.count_nonzero(counts == 1), len(tri.convex_hull))
                hull = tri.convex_hull
                sides = np.sort(hull[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2))
                edges, counts = np.unique(sides, axis=0, return_counts=True)
                self.assertTrue((counts == 2).all())
                self.assertEqual(len(np.unique(hull)) - len(edges) + len(hull), 2)
                self.assertEqual(len(np.unique(tri.simplices)), len(points))
                if peer and name not in ("thin", "needle"):
                    self.assertAlmostEqual(volumes.sum() / peer.ConvexHull(points).volume, 1, delta=1e-9)

    def test_neighbors(self):
        tri = Delaunay(uniform(300))
        for simplex, row in enumerate(tri.neighbors.tolist()):
            for corner, neighbor in enumerate(row):
                if neighbor >= 0:
                    shared = set(tri.simplices[simplex]) & set(tri.simplices[neighbor])
                    self.assertEqual(shared, set(np.delete(tri.simplices[simplex], corner)))
        # Three large ids do not fit into one number, and are sorted differently.
        other = Delaunay(uniform(300))
        other.npoints = 2**21
        np.testing.assert_array_equal(other.neighbors, tri.neighbors)

    @needs_scipy
    def test_equals_scipy(self):
        for count in (4, 5, 30, 600):
            points = uniform(count, seed=count)
            ours, theirs = Delaunay(points), peer.Delaunay(points)
            self.assertEqual(sets(ours.simplices), sets(theirs.simplices))
            self.assertEqual(sets(ours.convex_hull), sets(theirs.convex_hull))
            self.assertEqual((ours.nsimplex, ours.npoints, ours.ndim), (theirs.nsimplex, theirs.npoints, theirs.ndim))
            (indptr, indices), (their_indptr, their_indices) = (t.vertex_neighbor_vertices for t in (ours, theirs))
            for point in range(count):
                row = their_indices[their_indptr[point] : their_indptr[point + 1]]
                self.assertEqual(indices[indptr[point] : indptr[point + 1]].tolist(), sorted(row))
            queries = uniform(500, seed=1) * 1.4 - 0.2
            mine, other = ours.find_simplex(queries), theirs.find_simplex(queries)
            np.testing.assert_array_equal(mine >= 0, other >= 0)
            inside = mine >= 0
            corners = np.sort(ours.simplices[mine[inside]]), np.sort(theirs.simplices[other[inside]])
            np.testing.assert_array_equal(*corners)
            for name in ("points", "simplices", "neighbors", "convex_hull", "coplanar", "vertex_to_simplex"):
                self.assertEqual(getattr(ours, name).dtype, getattr(theirs, name).dtype, name)
            for name in ("min_bound", "max_bound"):
                np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))

    @needs_scipy
    def test_paraboloid_of_scipy(self):
        for points in (uniform(60, seed=3), 5 * uniform(40) - 90, 1e-3 * uniform(5)):
            ours, theirs = Delaunay(points), peer.Delaunay(points)
            for name in ("paraboloid_scale", "paraboloid_shift"):
                np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), rtol=1e-12)
            row = {tuple(sorted(simplex)): k for k, simplex in enumerate(ours.simplices.tolist())}
            order = [row[tuple(sorted(simplex))] for simplex in theirs.simplices.tolist()]
            size = np.abs(points).max()
            np.testing.assert_allclose(ours.equations[order, :4], theirs.equations[:, :4], rtol=0, atol=1e-10)
            np.testing.assert_allclose(ours.equations[order, 4], theirs.equations[:, 4], rtol=0, atol=1e-10 * size)
            queries = points.mean(axis=0) + 1.5 * (points[:4].reshape(2, 2, 3) - points.mean(axis=0))
            np.testing.assert_allclose(ours.lift_points(queries), theirs.lift_points(queries), rtol=1e-12)
            distances = ours.plane_distance(queries)[..., order]
            np.testing.assert_allclose(distances, theirs.plane_distance(queries), rtol=0, atol=1e-10 * size)

    @needs_scipy
    def test_linear_interpolator_of_scipy(self):
        for name in ("uniform", "face-centered, turned", "almost a lattice", "thin", "far away"):
            points = CLOUDS[name]
            ours = Delaunay(points)
            self.assertIsInstance(ours, peer.Delaunay)
            low, size = points.min(axis=0), np.ptp(points, axis=0)
            queries = low + (uniform(400, seed=7) * 1.2 - 0.1) * size
            # Qhull may triangulate a sphere differently; linear fields are equal.
            values = [(points - low) / size @ (1, 2, -3)]
            if name == "uniform":
                values.append(np.sin(np.arange(len(points))))
            values = np.column_stack(values)
            found = scipy.interpolate.LinearNDInterpolator(ours, values)(queries)
            expected = scipy.interpolate.LinearNDInterpolator(peer.Delaunay(points), values)(queries)
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9, err_msg=name)
            self.assertTrue(np.isfinite(found).any() and np.isnan(found).any())

    def test_copies(self):
        tri = Delaunay(uniform(20))
        for other in (copy.copy(tri), copy.deepcopy(tri), pickle.loads(pickle.dumps(tri))):
            self.assertIs(type(other), Delaunay)
            np.testing.assert_array_equal(other.equations, tri.equations)

    def test_edges_of_cut_polytopes(self):
        tri = Delaunay(lattice(3))
        indptr, indices = tri.vertex_neighbor_vertices
        edges = {(i, int(j)) for i in range(27) for j in indices[indptr[i] : indptr[i + 1]]}
        expected = {(int(a), int(b)) for row in tri.simplices for a in row for b in row if a != b}
        self.assertEqual(edges, expected)

    def test_find_simplex(self):
        for name in ("uniform", "face-centered", "almost a lattice", "sphere", "thin"):
            with self.subTest(name):
                points = CLOUDS[name]
                tri = Delaunay(points)
                queries = points.min(axis=0) + (uniform(300, seed=8) * 1.2 - 0.1) * np.ptp(points, axis=0)
                found = tri.find_simplex(queries)
                self.assertTrue((found >= 0).any() and (found < 0).any())
                # The least barycentric coordinate over all simplices tells inside from outside.
                corners = points[tri.simplices]
                inverse = np.linalg.inv(corners[:, :3] - corners[:, 3:])
                for query, simplex in zip(queries, found):
                    first = np.einsum("tk,tki->ti", query - corners[:, 3], inverse)
                    least = np.minimum(first.min(axis=1), 1 - first.sum(axis=1))
                    self.assertEqual(simplex >= 0, least.max() >= 0)
                    if simplex >= 0:
                        self.assertGreater(least[simplex], -1e-6)

    def test_find_simplex_shapes(self):
        tri = Delaunay(uniform(40))
        self.assertEqual(tri.find_simplex((0.5, 0.5, 0.5)).shape, ())
        self.assertEqual(tri.find_simplex(np.full((2, 5, 3), 0.5)).shape, (2, 5))
        self.assertEqual(tri.find_simplex(np.zeros((0, 3))).shape, (0,))
        nowhere = [(np.nan, 0, 0), (np.inf, 0, 0), (9, 9, 9), (1e300, 0, 0)]
        self.assertEqual(tri.find_simplex(nowhere).tolist(), [-1] * 4)
        with self.assertRaisesRegex(ValueError, "shape"):
            tri.find_simplex(np.zeros((3, 2)))
        for point, simplex in enumerate(tri.find_simplex(tri.points)):
            self.assertIn(point, tri.simplices[simplex])
        corner = Delaunay(lattice(2))
        self.assertEqual(corner.find_simplex((0.5, 1, 1.5 + 1e-15)) >= 0, True)
        self.assertEqual(corner.find_simplex((0.5, 1, 1.5 + 1e-9)), -1)
        self.assertEqual(corner.find_simplex((0.5, 1, 1.5 + 1e-9), tol=1e-6) >= 0, True)

    def test_steps_of_the_manual(self):
        # Two tetrahedra on one triangle are neighbors, each opposite to its own corner.
        points = np.array([(0, 0, 0), (1, 0, 0), (0, 1.1, 0), (0.2, 0.2, 1), (0.2, 0.2, -1)])
        tri = Delaunay(points)
        self.assertEqual(sets(tri.simplices), {(0, 1, 2, 3), (0, 1, 2, 4)})
        for simplex in range(2):
            (corner,) = np.flatnonzero(tri.neighbors[simplex] >= 0)
            self.assertEqual(tri.neighbors[simplex, corner], 1 - simplex)
            self.assertIn(tri.simplices[simplex, corner], (3, 4))
        queries = np.array([(0.1, 0.2, 0.3), (1.5, 0.5, 0), (0.2, 0.2, -0.9)])
        found = tri.find_simplex(queries)
        self.assertEqual(found[1], -1)
        self.assertEqual([set(tri.simplices[k]) for k in found[[0, 2]]], [{0, 1, 2, 3}, {0, 1, 2, 4}])
        matrix = tri.transform[found[0]]
        first = matrix[:3].dot(queries[0] - matrix[3])
        weights = np.append(first, 1 - first.sum())
        np.testing.assert_allclose(weights @ points[tri.simplices[found[0]]], queries[0], atol=1e-15)

    def test_equal_points(self):
        points = np.concatenate((uniform(50), uniform(50)[7:9]))
        tri = Delaunay(points)
        self.assertEqual(tri.coplanar[:, [0, 2]].tolist(), [[50, 7], [51, 8]])
        self.assertEqual(tri.vertex_to_simplex[50], tri.vertex_to_simplex[7])
        self.assertTrue(all(7 in tri.simplices[k] for k in tri.coplanar[:1, 1]))
        np.testing.assert_array_equal(tri.simplices, Delaunay(points[:50]).simplices)


SQUARES = np.stack(np.meshgrid(np.arange(6.0), np.arange(5.0)), axis=-1).reshape(-1, 2)
SIDES = np.array([(3, 4), (4, 3), (5, 0), (0, 5)])
CIRCLE = np.unique(np.concatenate([SIDES * signs for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1))]), axis=0)

IN_PLANE = {
    "uniform": uniform(150)[:, :2],
    "one triangle": np.array([(0, 0), (1, 0), (0, 1)]),
    "square": SQUARES[[0, 1, 6, 7]],
    "lattice": SQUARES,
    "lattice in any order": np.random.default_rng(5).permutation(SQUARES),
    "hexagons": np.concatenate((SQUARES * (1, 3**0.5), (SQUARES + 0.5) * (1, 3**0.5))),
    "turned lattice": SQUARES @ turned(np.eye(3))[:2, :2],
    "almost a lattice": SQUARES + 1e-15 * uniform(30)[:, :2],
    "on a circle": CIRCLE,
    "around a circle": on_sphere(60)[:, :2] / np.linalg.norm(on_sphere(60)[:, :2], axis=1)[:, None],
    "clusters": np.concatenate([k + 0.02**k * uniform(40, seed=k)[:, :2] for k in range(3)]),
    "tiny clusters": np.concatenate([k + 1e-5**k * uniform(40, seed=k)[:, :2] for k in range(3)]),
    "thin": uniform(100)[:, :2] * (1, 1e-7),
    "far away": uniform(100)[:, :2] + 1e8,
    "small": uniform(100)[:, :2] * 1e-30,
}


def exact(rows):
    return [[Fraction(x) for x in row] for row in rows.tolist()]


def determinant(rows):
    if not rows:
        return 1
    return sum((-1) ** k * x * determinant([row[:k] + row[k + 1 :] for row in rows[1:]]) for k, x in enumerate(rows[0]))


def left_turn(a, b, c):
    """Returns a number of the sign of the area of the triangle."""
    return determinant([[q - p for p, q in zip(a, x)] for x in (b, c)])


def in_circle(a, b, c, d):
    """Returns a positive number if d is inside of the circle through a counterclockwise triangle."""
    rows = [[p - q for p, q in zip(x, d)] for x in (a, b, c)]
    return determinant([[x, y, x * x + y * y] for x, y in rows])


class PlaneTest(unittest.TestCase):
    def test_triangles_are_those_of_delaunay(self):
        for name, points in IN_PLANE.items():
            with self.subTest(name):
                tri = Delaunay(points)
                places, hull = exact(np.asarray(points, dtype=float)), tri.convex_hull.tolist()
                self.assertEqual(tri.simplices.shape, (2 * len(points) - 2 - len(hull), 3))
                areas = [left_turn(*(places[k] for k in row)) for row in tri.simplices.tolist()]
                self.assertGreater(min(areas), 0)
                # The edges of the hull are one convex ring around the triangles.
                after = dict(hull)
                self.assertEqual(sorted(after), sorted(after.values()))
                self.assertTrue(all(left_turn(places[a], places[b], places[after[b]]) >= 0 for a, b in hull))
                self.assertEqual(sum(areas), sum(left_turn([0, 0], places[a], places[b]) for a, b in hull))
                # No corner of a neighbor is inside of the circle of a triangle: so no other point is either.
                for simplex, row in zip(tri.simplices.tolist(), tri.neighbors.tolist()):
                    for corner, neighbor in zip(simplex, row):
                        if neighbor >= 0:
                            other = set(tri.simplices[neighbor].tolist())
                            self.assertEqual(len(other & (set(simplex) - {corner})), 2)
                            (beyond,) = other - set(simplex)
                            self.assertLessEqual(in_circle(*(places[k] for k in (*simplex, beyond))), 0)

    def test_diagram(self):
        for name, points in IN_PLANE.items():
            with self.subTest(name):
                vor = Voronoi(points)
                count = len(vor.vertices)
                self.assertEqual(vor.vertices.shape, (count, 2))
                # All vertices, infinity too, all ridges and regions are a map on a sphere.
                self.assertEqual(count + 1 - len(vor.ridge_points) + len(points), 2)
                self.assertTrue(all(len(row) == 2 and row == sorted(row) for row in vor.ridge_vertices))
                # Around a region two vertices, one after the other, are the ends of a ridge.
                ridges = [[] for _ in points]
                for (i, j), row in vor.ridge_dict.items():
                    ridges[i].append(tuple(row))
                    ridges[j].append(tuple(row))
                for point, region in enumerate(vor.regions):
                    around = [tuple(sorted(pair)) for pair in zip(region, region[1:] + region[:1])]
                    self.assertEqual(sorted(around), sorted(ridges[point]))
                    self.assertEqual(region[0] == -1, -1 in region)
        middles = SQUARES[(SQUARES < (5, 4)).all(axis=1)] + 0.5
        self.assertEqual(sorted(Voronoi(SQUARES).vertices.tolist()), sorted(middles.tolist()))
        self.assertEqual(len(Voronoi(CIRCLE).vertices), 1)

    def test_vertices_are_as_far_from_all_cells_around(self):
        points = uniform(5000, seed=9)[:, :2]  # so many that cells at infinity are made apart
        vor = Voronoi(points)
        vertex = np.concatenate(vor.regions)
        cell = np.repeat(np.arange(5000), [len(row) for row in vor.regions])[vertex >= 0]
        vertex = vertex[vertex >= 0]
        distance = np.linalg.norm(points[cell] - vor.vertices[vertex], axis=1)
        largest, least = np.zeros(len(vor.vertices)), np.full(len(vor.vertices), np.inf)
        np.maximum.at(largest, vertex, distance)
        np.minimum.at(least, vertex, distance)
        self.assertTrue((np.bincount(vertex) == 3).all())
        self.assertLess((largest / least).max(), 1 + 1e-9)

    def test_find_simplex(self):
        for name in ("uniform", "lattice", "on a circle", "clusters"):
            with self.subTest(name):
                tri = Delaunay(IN_PLANE[name])
                low, high = tri.min_bound, tri.max_bound
                queries = low + (uniform(200, seed=8)[:, :2] * 1.2 - 0.1) * (high - low)
                places, asked = exact(tri.points), exact(queries)
                for query, simplex in zip(asked, tri.find_simplex(queries, tol=0).tolist()):
                    if simplex >= 0:
                        a, b, c = (places[k] for k in tri.simplices[simplex])
                        self.assertTrue(all(left_turn(*side, query) >= 0 for side in ((a, b), (b, c), (c, a))))
                    else:
                        turns = [left_turn(places[a], places[b], query) for a, b in tri.convex_hull]
                        self.assertLess(min(turns), 0)
        self.assertEqual(Delaunay(SQUARES).find_simplex(np.full((2, 5, 2), 0.5)).shape, (2, 5))
        with self.assertRaisesRegex(ValueError, "shape"):
            Delaunay(SQUARES).find_simplex(np.zeros((3, 3)))

    def test_planes_and_coordinates_of_triangles(self):
        tri = Delaunay(IN_PLANE["uniform"])
        weights = np.random.default_rng(3).dirichlet((1, 1, 1), tri.nsimplex)
        places = np.einsum("tk,tkx->tx", weights, tri.points[tri.simplices])
        first = np.einsum("tij,tj->ti", tri.transform[:, :2], places - tri.transform[:, 2])
        np.testing.assert_allclose(first, weights[:, :2], atol=1e-9)
        # The plane of a triangle contains its lifted corners, and all others are on one side.
        distances = tri.plane_distance(tri.points)
        self.assertEqual(distances.shape, (150, tri.nsimplex))
        np.testing.assert_allclose(np.take_along_axis(distances, tri.simplices.T, axis=0), 0, atol=1e-12)
        self.assertLess(distances.max(), 1e-12)

    def test_equal_points(self):
        points = IN_PLANE["uniform"]
        more = np.concatenate((points, points[7:9]))
        tri, vor = Delaunay(more), Voronoi(more)
        self.assertEqual(tri.coplanar[:, [0, 2]].tolist(), [[150, 7], [151, 8]])
        np.testing.assert_array_equal(tri.simplices, Delaunay(points).simplices)
        self.assertEqual(vor.regions[-2:], [[], []])
        self.assertEqual(vor.regions[:150], Voronoi(points).regions)

    def test_box(self):
        points = IN_PLANE["uniform"]
        whole, cut = Voronoi(points), Voronoi(points, box=(0, 0, 1, 1))
        inside = ((whole.vertices > 0) & (whole.vertices < 1)).all(axis=1)
        self.assertEqual(len(cut.vertices), np.count_nonzero(inside))
        self.assertTrue(sets(cut.ridge_points) <= sets(whole.ridge_points))

    def test_find_simplex_of_no_points(self):
        mesh = Delaunay(IN_PLANE["uniform"])
        for no_points in (1, mesh):
            with self.assertRaisesRegex(IndexError, r"shape \(\)"):
                mesh.find_simplex(no_points)

    def test_gaps_at_a_box(self):
        # A cell with a vertex at its left and right leaves a low box above and below.
        points = np.array([(0, 0), (-1, 0.5), (-1, -0.5), (1, 0.5), (1, -0.5)])
        vor = Voronoi(points, box=(-2, -1, 2, 1))
        region, = (row for row in vor.regions if row.count(-1) == 2)
        self.assertEqual((region, vor.regions[0]), ([-1, region[1], -1, region[3]], region))
        self.assertEqual(sorted(vor.vertices[region[1::2], 0]), [-0.625, 0.625])
        # Consecutive vertices of a region are the ends of a ridge.
        points = IN_PLANE["uniform"]
        vor = Voronoi(points, box=(0.2, 0.3, 0.9, 0.8), outside="keep")
        ends = {tuple(row) for row in vor.ridge_vertices}
        for region in vor.regions:
            for pair in zip(region, region[1:] + region[:1]):
                if min(pair) >= 0:
                    self.assertIn(tuple(sorted(pair)), ends)
        self.assertGreater(sum(-1 in row and len(row) > 2 for row in vor.regions), 20)

    def test_what_is_refused(self):
        points = uniform(50)[:, :2]
        for make in (Voronoi, Delaunay):
            for flat in (points * (1, 0), points[:2], points[:0], points * 0, SQUARES[:6]):
                with self.assertRaisesRegex(QhullError, "three, or all in one line"):
                    make(flat)

    @needs_scipy
    def test_equals_scipy(self):
        for name in ("uniform", "one triangle", "clusters", "thin", "small"):
            points = IN_PLANE[name]
            ours, theirs = Delaunay(points), peer.Delaunay(points)
            self.assertEqual(sets(ours.simplices), sets(theirs.simplices))
            self.assertEqual(sets(ours.convex_hull), sets(theirs.convex_hull))
            for attribute in ("points", "simplices", "neighbors", "convex_hull", "coplanar", "vertex_to_simplex"):
                self.assertEqual(getattr(ours, attribute).dtype, getattr(theirs, attribute).dtype, attribute)
            row = {tuple(sorted(simplex)): k for k, simplex in enumerate(ours.simplices.tolist())}
            order = [row[tuple(sorted(simplex))] for simplex in theirs.simplices.tolist()]
            np.testing.assert_allclose(ours.equations[order], theirs.equations, rtol=0, atol=1e-6)
            ours, theirs = Voronoi(points), peer.Voronoi(points)
            place = peer.cKDTree(ours.vertices).query(theirs.vertices)[1]
            self.assertEqual(sorted(place), list(range(len(ours.vertices))))
            place = np.append(place, -1).tolist()
            expected = {tuple(sorted(key)): sorted(place[v] for v in row) for key, row in theirs.ridge_dict.items()}
            self.assertEqual(ours.ridge_dict, expected)
            for point, region in enumerate(ours.regions):
                self.assertEqual(ring(region), ring([place[v] for v in theirs.regions[theirs.point_region[point]]]))

    @needs_scipy
    def test_interpolators_of_scipy(self):
        points = IN_PLANE["uniform"]
        values = np.sin(9 * points[:, 0]) * points[:, 1]
        queries = uniform(300, seed=7)[:, :2] * 1.2 - 0.1
        for make in (scipy.interpolate.LinearNDInterpolator, scipy.interpolate.CloughTocher2DInterpolator):
            found = make(Delaunay(points), values)(queries)
            np.testing.assert_allclose(found, make(peer.Delaunay(points), values)(queries), rtol=0, atol=1e-9)


if __name__ == "__main__":
    unittest.main()
