"""Results: known answers, want, rows, the mesh."""

import typing
import unittest
import warnings

import numpy as np
from helpers import EVERYTHING, UNIT_BOX, lattice, uniform

import pyvotess as vt  # noqa: E402
from pyvotess import _c_api
from pyvotess.export.columns import color_values

try:
    import scipy.sparse  # noqa: F401

    HAVE_SCIPY = True
except ImportError:
    HAVE_SCIPY = False


class KnownAnswers(unittest.TestCase):
    def test_two_points(self):
        t = vt.tessellate([[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]], box=UNIT_BOX, want=EVERYTHING)
        np.testing.assert_array_equal(t.neighbors.indptr, [0, 1, 2])
        np.testing.assert_array_equal(t.neighbors.indices, [1, 0])
        np.testing.assert_allclose(t.volumes, [0.5, 0.5], rtol=1e-13)
        np.testing.assert_allclose(t.centroids, [[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]], rtol=1e-13)
        np.testing.assert_array_equal(t.face_counts, [6, 6])
        np.testing.assert_array_equal(t.edge_counts, [12, 12])
        np.testing.assert_array_equal(t.vertex_counts, [8, 8])
        np.testing.assert_array_equal(t.status, [vt.CellStatus.CERTIFIED] * 2)
        self.assertIsNone(t.duplicate_of)
        np.testing.assert_array_equal(t.box, [[0, 0, 0], [1, 1, 1]])
        self.assertEqual(len(t), 2)

    def test_one_point_fills_the_box(self):
        t = vt.tessellate([[0.1, 0.2, 0.3]], box=(0, 0, 0, 1, 2, 3), want=EVERYTHING)
        self.assertEqual(len(t.neighbors[0]), 0)
        np.testing.assert_allclose(t.volumes, [6.0], rtol=1e-13)
        np.testing.assert_allclose(t.centroids, [[0.5, 1.0, 1.5]], rtol=1e-13)

    def test_corners_of_a_cube(self):
        t = vt.tessellate(lattice(2), box=(0, 0, 0, 2, 2, 2), want=EVERYTHING)
        for i, row in enumerate(t.neighbors):
            np.testing.assert_array_equal(row, sorted([i ^ 1, i ^ 2, i ^ 4]))
        np.testing.assert_allclose(t.volumes, np.ones(8), rtol=1e-13)
        np.testing.assert_allclose(t.centroids, lattice(2), rtol=1e-13)

    def test_cubic_lattice_has_six_neighbors_inside(self):
        n = 5
        t = vt.tessellate(lattice(n), box=(0, 0, 0, n, n, n), want=EVERYTHING)
        for i in range(1, n - 1):
            for j in range(1, n - 1):
                for k in range(1, n - 1):
                    c = (i * n + j) * n + k
                    expected = sorted([c - n * n, c + n * n, c - n, c + n, c - 1, c + 1])
                    np.testing.assert_array_equal(t.neighbors[c], expected)
        np.testing.assert_array_equal(t.face_counts, np.full(n**3, 6))
        np.testing.assert_array_equal(t.vertex_counts, np.full(n**3, 8))
        self.assertTrue(t.verify())

    def test_walls(self):
        points = [[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]]
        t = vt.tessellate(points, box=UNIT_BOX, list_walls=True)
        np.testing.assert_array_equal(t.neighbors[0], [-6, -5, -4, -3, -1, 1])
        np.testing.assert_array_equal(t.neighbors[1], [-6, -5, -4, -3, -2, 0])
        self.assertTrue(t.lists_walls)
        self.assertFalse(vt.tessellate(points, box=UNIT_BOX).lists_walls)

    def test_uniform_points_verify(self):
        t = vt.tessellate(uniform(2000), want=EVERYTHING)
        report = t.verify(sample=32, rng_seed=7)
        self.assertTrue(report.passed, report.failure)
        self.assertTrue(report)
        self.assertEqual(report.failure, "")
        self.assertEqual(report.skipped, ())
        self.assertEqual(t.neighbors.indptr[-1], len(t.neighbors.indices))
        for row in t.neighbors[:50]:
            self.assertTrue(np.all(np.diff(row) > 0))

    def test_default_box(self):
        points = uniform(1000)
        box = vt.tessellate(points).box
        margin = np.ptp(points, axis=0).max() / 1000 ** (1 / 3) / 2
        np.testing.assert_allclose(box, [points.min(axis=0) - margin, points.max(axis=0) + margin], rtol=1e-12)

    def test_box_forms(self):
        points = uniform(20)
        flat = vt.tessellate(points, box=(0, 0, 0, 1, 2, 3))
        for box in (((0, 0, 0), (1, 2, 3)), np.array([[0, 0, 0], [1, 2, 3.0]]), flat.box):
            t = vt.tessellate(points, box=box)
            np.testing.assert_array_equal(t.box, flat.box)
            np.testing.assert_array_equal(t.neighbors.indices, flat.neighbors.indices)

    def test_tuning_never_changes_the_answer(self):
        points = uniform(3000)
        expected = vt.tessellate(points, threads=1)
        for options in (
            {"threads": 2},
            {"grid_resolution": 1},
            {"grid_resolution": 40},
            {"device": "cpu"},
            {"k_init": 1},
            {"k_init": 1024, "chunk_size": 500},
            {"chunk_size": 2**32 - 1},
            {"precision": "double", "device": "cpu"},
            {"instructions": "baseline"},
        ):
            t = vt.tessellate(points, **options)
            np.testing.assert_array_equal(t.neighbors.indptr, expected.neighbors.indptr, str(options))
            np.testing.assert_array_equal(t.neighbors.indices, expected.neighbors.indices, str(options))

    def test_empty_input(self):
        for dtype in (np.float64, np.float32, np.int32):
            t = vt.tessellate(np.empty((0, 3), dtype), want=EVERYTHING)
            self.assertEqual(len(t), 0)
            self.assertEqual(len(t.neighbors), 0)
            np.testing.assert_array_equal(t.neighbors.indptr, [0])
            self.assertEqual(t.volumes.shape, (0,))
            self.assertEqual(t.centroids.shape, (0, 3))
            self.assertEqual(t.status.shape, (0,))
            self.assertIsNone(t.duplicate_of)
            self.assertEqual(list(t.neighbors), [])

    def test_duplicates(self):
        points = np.concatenate((uniform(10), uniform(10)[3:5]))
        t = vt.tessellate(points, want=EVERYTHING)
        np.testing.assert_array_equal(t.duplicate_of, [-1] * 10 + [3, 4])
        np.testing.assert_array_equal(t.status == vt.CellStatus.DUPLICATE, [False] * 10 + [True] * 2)
        self.assertEqual(len(t.neighbors[11]), 0)
        self.assertEqual(t.volumes[10], 0)
        self.assertTrue(np.isnan(t.centroids[10]).all())
        self.assertEqual(t.stats.duplicates, 2)
        self.assertIn("of 12 seeds, 2 duplicates, in a box", repr(t))
        self.assertIn("of 11 seeds, 1 duplicate, in a box", repr(vt.tessellate(points[:11])))
        self.assertRegex(t._repr_html_(), "duplicates</th><td[^>]*>2<")
        report = t.verify()
        self.assertTrue(report, report.failure)
        alone = vt.tessellate(points[:10])
        np.testing.assert_array_equal(t.neighbors.indices, alone.neighbors.indices)


class Want(unittest.TestCase):
    def test_names_of_arrays(self):
        """want accepts names of arrays. An array adds its group and the groups that it implies."""
        words = {"indptr": "neighbors", "face_normals": "normals", "security_radii": "radii", "edge_counts": "counts",
                 "cell_vertices": "vertices", "face_offsets": "faces"}  # fmt: skip
        for name, word in words.items():
            t = vt.tessellate(uniform(10), want=name)
            self.assertEqual(t.wanted, vt.tessellate(uniform(10), want=[word]).wanted)
            self.assertGreater(len(getattr(t, name)), 0)
        everything = vt.tessellate(uniform(10), want=[*_c_api.WANT_BITS, "status"], list_walls=True)
        for name in typing.get_args(_c_api.WantName):
            t = vt.tessellate(uniform(10), want=f" {name} , status", list_walls=True)
            if name in ("ids", "cell_vertices") or name in _c_api.WANT_BITS:
                continue
            np.testing.assert_equal(getattr(t, name), getattr(everything, name), name)
        names = set(everything._data.arrays)
        self.assertLessEqual(names, set(typing.get_args(_c_api.WantName)))
        self.assertEqual(vt.tessellate(uniform(3), want="status").wanted, ())
        with self.assertRaisesRegex(ValueError, "'face_area': did you mean face_areas[?] Else give groups of neighbors"):
            vt.tessellate(uniform(3), want="face_area")
        with self.assertRaisesRegex(TypeError, "want has 3"):
            vt.tessellate(uniform(3), want=["volumes", 3])

    def test_words_are_no_attributes(self):
        t = vt.tessellate(uniform(10), want="surfaces")
        rows = []
        vt.tessellate_stream([uniform(10)], rows.append, memory=1_000_000)
        for name, right in (("normals", "face_normals"), ("radii", "security_radii"), ("surfaces", "surface_areas")):
            for result in (t, rows[0], vt.Diagram(uniform(10)).probe(uniform(2))):
                with self.assertRaisesRegex(AttributeError, f"'{name}': the name is {right}"):
                    getattr(result, name)
        with self.assertRaisesRegex(AttributeError, "surface_areas$"):
            t.surfaces
        with self.assertRaisesRegex(AttributeError, "edge_counts or vertex_counts; put 'counts' into want"):
            t.counts
        with self.assertRaisesRegex(AttributeError, "face_vertices was not computed: put 'faces' into want"):
            t.face_vertices
        self.assertIsNone(t.ids)  # of a subset
        with self.assertRaisesRegex(AttributeError, "surface_areas"):
            color_values(t, "surfaces")

    def test_default(self):
        t = vt.tessellate(uniform(10))
        self.assertEqual(len(t.volumes), 10)
        for name in ("centroids", "face_counts", "edge_counts", "vertex_counts"):
            with self.assertRaisesRegex(AttributeError, name):
                getattr(t, name)
        self.assertFalse(hasattr(t, "centroids"))

    def test_each_alone(self):
        everything = vt.tessellate(uniform(100), want=EVERYTHING)
        for word, names in {
            "volumes": ["volumes"],
            "centroids": ["centroids"],
            "counts": ["face_counts", "edge_counts", "vertex_counts"],
        }.items():
            t = vt.tessellate(uniform(100), want=[word])
            for name in names:
                np.testing.assert_array_equal(getattr(t, name), getattr(everything, name))
            with self.assertRaisesRegex(AttributeError, "'neighbors'"):
                t.neighbors
        t = vt.tessellate(uniform(100), want="areas")
        np.testing.assert_array_equal(t.face_areas, everything.face_areas)
        np.testing.assert_array_equal(t.neighbors.indices, everything.neighbors.indices)
        t = vt.tessellate(uniform(100), want="neighbors")
        self.assertFalse(hasattr(t, "face_areas"))
        np.testing.assert_array_equal(t.neighbors.indices, everything.neighbors.indices)

    def test_areas(self):
        t = vt.tessellate(lattice(4), box=(0, 0, 0, 4, 4, 4), want="areas", list_walls=True)
        np.testing.assert_array_equal(t.face_areas, np.ones(6 * 64))
        t = vt.tessellate(lattice(4), box=(0, 0, 0, 4, 4, 4), want="areas")
        np.testing.assert_array_equal(t.face_areas, np.ones(6 * 64 - 6 * 16))
        # A closed surface: normals times areas sum to zero.
        points = uniform(500)
        t = vt.tessellate(points, want="areas,volumes")
        for i in range(500):
            row = slice(t.neighbors.indptr[i], t.neighbors.indptr[i + 1])
            to = points[t.neighbors[i]] - points[i]
            if len(to) == 0 or np.abs(points[i] - 0.5).max() > 0.2:
                continue
            length = np.linalg.norm(to, axis=1)
            area = t.face_areas[row]
            np.testing.assert_allclose((to / length[:, None] * area[:, None]).sum(axis=0), 0, atol=1e-12)
            self.assertAlmostEqual((area * length).sum() / 6, t.volumes[i], places=13)

    def test_text_with_commas_and_nothing(self):
        t = vt.tessellate(uniform(10), want="centroids, counts")
        self.assertEqual(t.centroids.shape, (10, 3))
        t = vt.tessellate(uniform(10), want=())
        self.assertEqual(t.status.shape, (10,))
        self.assertIn("10 seeds", repr(t))

    def test_skipped_checks_are_named(self):
        report = vt.tessellate(uniform(50), want="volumes").verify()
        self.assertTrue(report, report.failure)
        self.assertIn("symmetry", report.skipped)
        self.assertIn("euler", report.skipped)
        self.assertNotIn("volumes", report.skipped)


class Rows(unittest.TestCase):
    def setUp(self):
        self.neighbors = vt.tessellate(uniform(30)).neighbors

    def test_indexing(self):
        n = self.neighbors
        self.assertEqual(len(n), 30)
        np.testing.assert_array_equal(n[-1], n[29])
        np.testing.assert_array_equal(n[np.int64(4)], n[4])
        for index in (30, -31):
            with self.assertRaisesRegex(IndexError, "30 rows"):
                n[index]
        with self.assertRaises(TypeError):
            n[1.5]
        rows = n[10:20:3]
        self.assertEqual(len(rows), 4)
        np.testing.assert_array_equal(rows[1], n[13])

    def test_iteration_and_types(self):
        self.assertEqual(sum(len(row) for row in self.neighbors), len(self.neighbors.indices))
        self.assertEqual(self.neighbors.indptr.dtype, np.int64)
        self.assertEqual(self.neighbors.indices.dtype, np.int32)
        self.assertIn("30 rows", repr(self.neighbors))

    def test_int32(self):
        points = np.concatenate((uniform(50), uniform(50)[:2]))
        for options in ({"box": UNIT_BOX, "list_walls": True}, {"box": UNIT_BOX, "periodic": True}):
            t = vt.tessellate(points, **options)
            adjacency, offsets, status = t.rows()
            for array, expected in ((adjacency, t.indices), (offsets, t.indptr), (status, t.status)):
                np.testing.assert_array_equal(array, expected)
                self.assertEqual(array.dtype, np.int32)
            self.assertTrue(np.shares_memory(adjacency, t.indices))
            self.assertEqual(status[-1], vt.CellStatus.DUPLICATE)

    @unittest.skipUnless(HAVE_SCIPY, "SciPy is not installed")
    def test_to_scipy(self):
        matrix = self.neighbors.to_scipy()
        self.assertEqual(matrix.shape, (30, 30))
        self.assertEqual((matrix != matrix.T).nnz, 0)
        walled = vt.tessellate(uniform(30), list_walls=True).neighbors.to_scipy()
        self.assertEqual((matrix != walled).nnz, 0)


class Mesh(unittest.TestCase):
    BOX = (0, 0, 0, 1, 1, 1)

    def test_arrays_fit_each_other(self):
        points = uniform(500)
        t = vt.tessellate(points, box=self.BOX, want="faces,areas,normals,surfaces,radii,counts", device="cpu")
        entries = len(t.neighbors.indices)
        self.assertTrue(t.lists_walls)
        self.assertEqual(len(t.faces), entries)
        self.assertEqual(t.face_normals.shape, (entries, 3))
        self.assertIsNone(t.shifts)
        np.testing.assert_allclose(np.linalg.norm(t.face_normals, axis=1), 1, rtol=1e-15)
        starts = t.neighbors.indptr[:-1]
        closed = np.add.reduceat(t.face_areas[:, None] * t.face_normals, starts)
        self.assertLess(np.abs(closed).max(), 1e-12)
        np.testing.assert_allclose(np.add.reduceat(t.face_areas, starts), t.surface_areas, rtol=1e-13)
        for i in (0, 17, 499):
            own = t.cell_vertices[i]
            self.assertEqual(len(own), t.vertex_counts[i])
            row = range(t.neighbors.indptr[i], t.neighbors.indptr[i + 1])
            self.assertEqual(set(own.tolist()), {v for k in row for v in t.faces[k].tolist()})
            reach = np.linalg.norm(t.vertices[own] - points[i], axis=1).max()
            self.assertAlmostEqual(t.security_radii[i], 2 * reach, delta=1e-12)
        self.assertTrue(t.verify())
        with self.assertRaises(ValueError):
            t.vertices[0, 0] = 1

    def test_delaunay(self):
        points = uniform(400)
        d = vt.tessellate(points, box=self.BOX, want="faces", device="cpu").delaunay()
        corners = points[d.tetrahedra]
        edges = corners[:, 1:] - corners[:, :1]
        self.assertGreater(np.linalg.det(edges).min(), 0)
        self.assertEqual((len(d.polytopes), d.shifts, d.polytope_shifts), (0, None, None))
        grid = np.stack(np.meshgrid(*[np.arange(4.0)] * 3), -1).reshape(-1, 3)
        t = vt.tessellate(grid, want="faces", device="cpu")
        d = t.delaunay()
        self.assertEqual((len(d.tetrahedra), len(d.polytopes)), (0, 27))
        self.assertEqual(sorted(grid[d.polytopes[0]].mean(axis=0).tolist()), sorted(t.vertices[d.polytope_centers[0]]))
        with self.assertRaisesRegex(ValueError, 'set want="faces"'):
            vt.tessellate(points).delaunay()

    def test_min_face(self):
        points = uniform(500)
        t = vt.tessellate(points, box=self.BOX, want="faces", min_face=0.1, device="cpu")
        self.assertGreater(t.least_face, 0)
        self.assertEqual(len(t.faces), len(t.face_areas))
        rows = [set(row.tolist()) for row in t.neighbors]
        self.assertTrue(all(i in rows[j] for i, row in enumerate(rows) for j in row if j >= 0))
        self.assertGreater(len(vt.tessellate(points, box=self.BOX, want="faces").faces), len(t.faces))
        with self.assertRaisesRegex(ValueError, "min_face"):
            vt.tessellate(points, min_face=-1)

    def test_tiny_faces(self):
        basis = np.array([[0, 0, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]])
        atoms = np.concatenate([basis + step for step in np.ndindex(3, 3, 3)])
        turn = np.linalg.qr(np.array([[1.0, 2, 3], [3, 1, 2], [2, 2, 1]]))[0] * 4.05
        given = {"cell": 3 * turn, "origin": -0.0625 * turn.sum(axis=0), "device": "cpu"}
        t = vt.tessellate(atoms @ turn, want="faces", **given)
        areas = vt.tessellate(atoms @ turn, want="areas", **given).areas
        tiny = int((areas < 1e-9 * areas.mean()).sum())
        self.assertGreater(tiny, 0)
        self.assertEqual(t.stats.tiny_faces, tiny)
        self.assertIn(f"{tiny} tiny faces", repr(t))
        self.assertEqual(t.verify(sample=1).tiny_faces, tiny)
        with self.assertWarnsRegex(UserWarning, f"^{tiny} of .*min_face"):
            t.voronoi_indices()
        lists = vt.tessellate(atoms @ turn, want="neighbors", **given)
        self.assertEqual((lists.stats.tiny_faces, lists.verify(sample=1).tiny_faces), (None, tiny))
        lattice = vt.tessellate(atoms @ turn, want="faces", min_face=1e-6, **given)
        self.assertEqual(lattice.stats.tiny_faces, 0)
        self.assertNotIn("tiny", repr(lattice))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = lattice.voronoi_indices(edge_threshold=1e-6)
        self.assertTrue((found[:, 1] == 12).all() and (found.sum(axis=1) == 12).all())
        d = lattice.delaunay()
        self.assertEqual((len(d.tetrahedra), len(d.polytopes)), (2 * len(atoms), len(atoms)))
        self.assertEqual(set(np.diff(d.polytopes.indptr).tolist()), {6})

    def test_not_wanted(self):
        t = vt.tessellate(uniform(10))
        for name in ("faces", "vertices", "cell_vertices", "face_normals", "surface_areas", "security_radii"):
            with self.assertRaisesRegex(AttributeError, name):
                getattr(t, name)


if __name__ == "__main__":
    unittest.main()
