"""Results: known answers, want, rows, the mesh."""

import dataclasses
import importlib
import pkgutil
import typing
import unittest
import warnings

import numpy as np
from helpers import EVERYTHING, UNIT_BOX, uniform

import pyvotess as vt  # noqa: E402
from pyvotess import _arrays
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
        everything = vt.tessellate(uniform(10), want=[*_arrays.WANT_BITS, "status"], list_walls=True)
        for name in typing.get_args(_arrays.WantName):
            t = vt.tessellate(uniform(10), want=f" {name} , status", list_walls=True)
            if name in ("ids", "cell_vertices") or name in _arrays.WANT_BITS:
                continue
            np.testing.assert_equal(getattr(t, name), getattr(everything, name), name)
        names = set(everything._data.arrays)
        self.assertLessEqual(names, set(typing.get_args(_arrays.WantName)))
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
        for result in (t, rows[0], vt.Diagram(uniform(10)).probe(uniform(2))):
            for name, right in (("volume", "volumes"), ("centroid", "centroids"), ("surface_area", "surface_areas"), ("neighbours", "neighbors")):
                if hasattr(type(result), right):
                    with self.assertRaisesRegex(AttributeError, f"'{name}': did you mean '{right}'[?]$"):
                        getattr(result, name)
            with self.assertRaisesRegex(AttributeError, "'qqqq'$"):
                result.qqqq
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

    def test_text_with_commas_and_nothing(self):
        t = vt.tessellate(uniform(10), want="centroids, counts")
        self.assertEqual(t.centroids.shape, (10, 3))
        t = vt.tessellate(uniform(10), want=())
        self.assertEqual(t.status.shape, (10,))
        self.assertIn("10 seeds", repr(t))

    def test_skipped_checks_are_named(self):
        t = vt.tessellate(uniform(50), want="volumes")
        report = t.verify()
        self.assertTrue(report.proven, report.failure)
        self.assertEqual(report.skipped, ("euler",))  # of a run of all cells, with rows
        self.assertEqual(t.verify(sample=9).skipped, ("symmetry", "euler"))


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
        with self.assertRaisesRegex(ValueError, 'set want="faces"'):
            t.delaunay()

    def test_equality(self):
        """Records with arrays are compared by identity, as arrays have no single truth value; others by their values."""
        records = set()
        for module in pkgutil.walk_packages(vt.__path__, "pyvotess."):
            if module.name == "pyvotess.__main__":
                continue
            try:
                found = vars(importlib.import_module(module.name)).values()
            except ImportError:  # without their packages
                self.assertRegex(module.name, r"^pyvotess\.(mpi|autodiff\.(torch|jax))")
                continue
            records.update(kind for kind in found if isinstance(kind, type) and dataclasses.is_dataclass(kind))
        self.assertGreater(len(records), 30)
        for kind in records:
            held = " ".join(str(field.type) for field in dataclasses.fields(kind))
            self.assertEqual(kind.__dataclass_params__.eq, "Array" not in held, kind)
        fit = vt.fit_volumes(uniform(9), np.full(9, 1 / 9), box=UNIT_BOX)
        self.assertEqual([fit == fit, fit == 3, fit in [3, fit], len({fit, fit})], [True, False, True, 1])


if __name__ == "__main__":
    unittest.main()
