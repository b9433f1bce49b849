"""Tests of pyvotess against the built library. Needs only NumPy."""

import _thread
import contextlib
import copy
import ctypes
import dataclasses
import gc
import io
import os
import pathlib
import pickle
import re
import signal
import subprocess
import sys
import threading
import time
import types
import unittest
import weakref

import numpy as np

PACKAGE_PARENT = str(pathlib.Path(__file__).resolve().parents[1])
sys.path.insert(0, PACKAGE_PARENT)

import pyvotess as vt  # noqa: E402
from pyvotess import _c_api, _library, tessellation  # noqa: E402

UNIT_BOX = (0, 0, 0, 1, 1, 1)
EVERYTHING = ("neighbors", "volumes", "centroids", "counts", "areas")

try:
    import scipy.sparse  # noqa: F401

    HAVE_SCIPY = True
except ImportError:
    HAVE_SCIPY = False


def uniform(count, seed=1):
    return np.random.default_rng(seed).random((count, 3))


def lattice(n):
    """Centers of n^3 cubes of side 1 in the box (0, n)^3; the row of seed (i, j, k) is (i * n + j) * n + k."""
    axis = np.arange(n) + 0.5
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)


def long_run_points():
    """Enough points for about a second of one thread."""
    return uniform(int(os.environ.get("VOTESS_TEST_LONG_RUN", "200000")), seed=3)


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
        t = vt.tessellate(points, box=UNIT_BOX, walls=True)
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
            {"kernel": "subgroup"},
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
        report = t.verify()
        self.assertTrue(report, report.failure)
        alone = vt.tessellate(points[:10])
        np.testing.assert_array_equal(t.neighbors.indices, alone.neighbors.indices)


class Want(unittest.TestCase):
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
        t = vt.tessellate(lattice(4), box=(0, 0, 0, 4, 4, 4), want="areas", walls=True)
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

    @unittest.skipUnless(HAVE_SCIPY, "SciPy is not installed")
    def test_to_scipy(self):
        matrix = self.neighbors.to_scipy()
        self.assertEqual(matrix.shape, (30, 30))
        self.assertEqual((matrix != matrix.T).nnz, 0)
        walled = vt.tessellate(uniform(30), walls=True).neighbors.to_scipy()
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
        with self.assertRaisesRegex(ValueError, "want.faces"):
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

    def test_not_wanted(self):
        t = vt.tessellate(uniform(10))
        for name in ("faces", "vertices", "cell_vertices", "face_normals", "surface_areas", "security_radii"):
            with self.assertRaisesRegex(AttributeError, name):
                getattr(t, name)


class Input(unittest.TestCase):
    def setUp(self):
        self.points = uniform(200)
        self.expected = vt.tessellate(self.points)

    def assert_same(self, points):
        t = vt.tessellate(points)
        np.testing.assert_array_equal(t.neighbors.indptr, self.expected.neighbors.indptr)
        np.testing.assert_array_equal(t.neighbors.indices, self.expected.neighbors.indices)
        np.testing.assert_array_equal(t.volumes, self.expected.volumes)
        return t

    def test_float64_in_c_order_is_not_copied(self):
        t = self.assert_same(self.points)
        self.assertTrue(np.shares_memory(t.points, self.points))
        self.assertEqual(t.points.ctypes.data, self.points.ctypes.data)

    def test_what_needs_a_copy(self):
        wide = np.zeros((200, 6))
        wide[:, ::2] = self.points
        raw = np.frombuffer(b"\0" + self.points.tobytes(), np.uint8)[1:].view(np.float64).reshape(200, 3)  # not aligned
        for points in (
            np.asfortranarray(self.points),
            wide[:, ::2],
            self.points.tolist(),
            self.points.astype(">f8"),
            raw,
            np.ma.array(self.points),
        ):
            self.assert_same(points)
        frozen = self.points.copy()
        frozen.flags.writeable = False
        self.assert_same(frozen)

    def test_array_likes(self):
        class ArrayLike:
            def __array__(_, dtype=None, copy=None):
                return self.points

        self.assert_same(ArrayLike())

    def test_float32(self):
        narrow = self.points.astype(np.float32)
        t = vt.tessellate(narrow)
        wide = vt.tessellate(narrow.astype(np.float64))
        self.assertEqual(t.points.ctypes.data, narrow.ctypes.data)
        np.testing.assert_array_equal(t.neighbors.indices, wide.neighbors.indices)
        np.testing.assert_array_equal(t.volumes, wide.volumes)
        self.assertTrue(t.verify())

    def test_narrow_numbers_are_widened(self):
        integers = np.array([[0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 10], [3, 4, 5]])
        expected = vt.tessellate(integers.astype(float))
        for dtype in (np.int8, np.uint16, np.int32, np.int64, np.uint64, np.float16):
            t = vt.tessellate(integers.astype(dtype))
            np.testing.assert_array_equal(t.neighbors.indices, expected.neighbors.indices)
            np.testing.assert_array_equal(t.volumes, expected.volumes)


class BadInput(unittest.TestCase):
    def refused(self, pattern, points, error=ValueError, **options):
        with self.assertRaisesRegex(error, pattern) as caught:
            vt.tessellate(points, **options)
        text = str(caught.exception)
        self.assertNotIn("\n", text)
        self.assertTrue(text)

    def test_coordinates_that_are_not_finite(self):
        for value, text in ((np.nan, "nan"), (np.inf, "inf"), (-np.inf, "-inf")):
            for dtype in (np.float64, np.float32):
                points = uniform(10).astype(dtype)
                points[7, 1] = value
                points[8, 0] = np.nan
                self.refused(f"(?i)7.*{text}", points)

    def test_point_outside_the_box(self):
        points = uniform(10)
        points[4, 2] = 1.5
        points[6, 2] = -3
        self.refused(r"4.*1\.5", points, box=UNIT_BOX)

    def test_boxes(self):
        points = uniform(4)
        self.refused("(?i)box", points, box=(0, 0, 0, 1, 0, 1))
        self.refused("(?i)box", points, box=(0, 0, 0, 1, -1, 1))
        self.refused("(?i)box.*nan", points, box=(0, 0, 0, 1, np.nan, 1))
        self.refused("(?i)box.*inf", points, box=(0, 0, 0, 1, np.inf, 1))
        self.refused(r"box has shape \(3, 2\)", points, box=np.zeros((3, 2)))
        self.refused(r"box has shape \(5,\)", points, box=np.zeros(5))
        self.refused("box has dtype", points, box="unit")

    def test_shapes(self):
        for shape in ((3,), (4, 2), (4, 4), (2, 2, 3), (0,), ()):
            self.refused(f"points has shape .*{len(shape) and shape[0] or ''}", np.zeros(shape))
        self.refused(r"\(4, 2\).*\(N, 3\)", np.zeros((4, 2)))
        self.refused("points", [[1.0, 2.0, 3.0], [1.0, 2.0]])

    def test_types(self):
        self.refused("complex128", np.zeros((2, 3), complex))
        self.refused("object", np.zeros((2, 3), object))
        self.refused("bool", np.zeros((2, 3), bool))
        self.refused("dtype", [["a", "b", "c"]])
        self.refused("dtype", None)
        if np.dtype(np.longdouble).itemsize > 8:
            self.refused("dtype", np.zeros((2, 3), np.longdouble))
        self.refused("masked", np.ma.array(uniform(2), mask=[[0, 0, 1], [0, 0, 0]]))

    def test_integers_that_float64_cannot_hold(self):
        for value in (2**53 + 1, -(2**53) - 1):
            points = np.zeros((4, 3), np.int64)
            points[2, 1] = value
            self.refused(rf"points\[2\]\[1\] is {value}", points)
        self.refused("18446744073709551615", np.full((1, 3), 2**64 - 1, np.uint64))
        vt.tessellate(np.array([[2**53, 0, 0], [0, 0, -(2**53)]]))

    def test_options(self):
        points = uniform(4)
        self.refused("'edges'.*neighbors, volumes", points, want=["edges"])
        self.refused("'keep'.*merge, error", points, duplicates="keep")
        self.refused("threads is -1", points, threads=-1)
        self.refused("grid_resolution is 4294967296", points, grid_resolution=2**32)
        self.refused("threads.*100000", points, threads=100000)
        self.refused("grid.resolution.*2147483648", points, grid_resolution=2**31)
        self.refused("k_init is -1", points, k_init=-1)
        self.refused("k_init is 4294967296", points, k_init=2**32)
        self.refused("k_init.*1025.*1024", points, k_init=1025)
        self.refused("chunk_size is -1", points, chunk_size=-1)
        self.refused("chunk_size is 4294967296", points, chunk_size=2**32)
        self.refused("'sse'.*baseline, avx2 or avx512", points, instructions="sse")
        self.refused("instructions.*zero character", points, instructions="avx2\0")
        self.refused("instructions", points, instructions=None, error=TypeError)
        self.refused("'half'.*single, double", points, precision="half")
        self.refused("precision is 1", points, precision=1)
        self.refused("precision is None", points, precision=None)
        self.refused("'warp'.*automatic, invocation, subgroup", points, kernel="warp")
        self.refused("", points, threads=1.5, error=TypeError)
        self.refused("", points, k_init=1.5, error=TypeError)
        self.refused("device", points, device=0, error=TypeError)
        self.refused("zero character", points, device="cpu\0")
        self.refused("progress", points, progress=1, error=TypeError)
        with self.assertRaisesRegex(TypeError, "tilted"):
            vt.tessellate(points, tilted=True)

    def test_unknown_device(self):
        for device in ("abacus", "", "GPU", "-1", "1000000", "cpu\n"):
            self.refused("auto, cpu, gpu, lavapipe", uniform(4), device=device)

    def test_device_that_may_be_missing(self):
        for device in ("gpu", "lavapipe", "0", "999999"):
            try:
                self.assertEqual(len(vt.tessellate(uniform(4), device=device)), 4)
            except vt.VotessError as error:
                self.assertEqual(error.code, vt.ErrorCode.UNSUPPORTED)

    def test_duplicates_refused(self):
        points = uniform(10)
        points[8] = points[3]
        self.refused("(?s)(8.*3|3.*8)", points, duplicates="error")
        vt.tessellate(uniform(10), duplicates="error")


class Memory(unittest.TestCase):
    def arrays(self, t):
        return {
            "indptr": t.neighbors.indptr,
            "indices": t.neighbors.indices,
            "face_areas": t.face_areas,
            "volumes": t.volumes,
            "centroids": t.centroids,
            "face_counts": t.face_counts,
            "edge_counts": t.edge_counts,
            "vertex_counts": t.vertex_counts,
            "status": t.status,
            "duplicate_of": t.duplicate_of,
        }

    def test_arrays_lie_in_the_librarys_memory(self):
        t = vt.tessellate(np.concatenate((uniform(50), uniform(1))), want=EVERYTHING)
        for name, array in self.arrays(t).items():
            length = ctypes.c_size_t()
            address = getattr(_library.lib, "votess_result_" + name)(t._result.pointer, ctypes.byref(length))
            self.assertEqual(array.ctypes.data, address, name)
            self.assertEqual(array.size, length.value, name)
            self.assertFalse(array.flags.owndata, name)
        self.assertIs(t.volumes, t.volumes)
        self.assertTrue(np.shares_memory(t.neighbors[3], t.neighbors.indices))

    def test_arrays_are_read_only(self):
        t = vt.tessellate(np.concatenate((uniform(50), uniform(1))), want=EVERYTHING)
        for name, array in (*self.arrays(t).items(), ("box", t.box), ("row", t.neighbors[0])):
            with self.assertRaises(ValueError, msg=name):
                array.flat[0] = 0
        with self.assertRaises(ValueError):
            t.volumes.flags.writeable = True
        with self.assertRaises(AttributeError):
            t.volumes = None

    def test_any_array_keeps_the_memory(self):
        points = uniform(20000)
        for name in ("indptr", "indices", "volumes", "centroids", "status"):
            t = vt.tessellate(points, want=EVERYTHING)
            array = self.arrays(t)[name]
            view = array[5:]
            expected = np.array(view)
            result = weakref.ref(t._result)
            del t, array
            gc.collect()
            self.assertIsNotNone(result())
            vt.tessellate(points[::-1].copy(), want=EVERYTHING)  # would reuse freed memory
            np.testing.assert_array_equal(view, expected, name)
            del view
            gc.collect()
            self.assertIsNone(result(), name)

    def test_rows_keep_the_memory(self):
        row = vt.tessellate(uniform(1000)).neighbors[17]
        gc.collect()
        np.testing.assert_array_equal(row, vt.tessellate(uniform(1000)).neighbors[17])

    def test_no_cycle_delays_the_release(self):
        gc.disable()
        try:
            t = vt.tessellate(uniform(10), progress=lambda fraction: True)
            result = weakref.ref(t._result)
            del t
            self.assertIsNone(result())
        finally:
            gc.enable()

    def test_copies(self):
        t = vt.tessellate(uniform(10))
        np.testing.assert_array_equal(copy.copy(t).volumes, t.volumes)
        self.assertTrue(copy.deepcopy(t.volumes).flags.owndata)
        for function in (copy.deepcopy, pickle.dumps):
            with self.assertRaisesRegex(TypeError, "pickled"):
                function(t)
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(t.volumes)), t.volumes)


class Running(unittest.TestCase):
    def test_gil_is_released(self):
        points = long_run_points()
        ticks = [0]
        done = threading.Event()

        def tick():
            while not done.is_set():
                ticks[0] += 1
                time.sleep(0.001)

        thread = threading.Thread(target=tick)
        thread.start()
        try:
            before = ticks[0]
            start = time.perf_counter()
            vt.tessellate(points, threads=1)
            seconds = time.perf_counter() - start
            during = ticks[0] - before
        finally:
            done.set()
            thread.join()
        # Held, the GIL would let through a tick or two per progress call.
        self.assertGreater(during, 60 * seconds, f"{during} ticks in {seconds:.2f} s")

    def test_progress(self):
        fractions = []
        vt.tessellate(long_run_points(), threads=1, progress=fractions.append)
        self.assertTrue(fractions)
        self.assertTrue(all(0 <= f <= 1 for f in fractions), fractions)
        self.assertEqual(fractions, sorted(fractions))

    def test_returning_false_cancels(self):
        with self.assertRaises(vt.VotessError) as caught:
            vt.tessellate(long_run_points(), threads=1, progress=lambda fraction: np.bool_(False))
        self.assertEqual(caught.exception.code, vt.ErrorCode.CANCELLED)
        self.assertTrue(str(caught.exception))

    def test_exception_in_progress_cancels_and_is_raised(self):
        class Mine(Exception):
            pass

        def progress(fraction):
            raise Mine("stop here")

        with self.assertRaisesRegex(Mine, "stop here"):
            vt.tessellate(long_run_points(), threads=1, progress=progress)

    def test_cancel_from_another_thread(self):
        caught = []

        def work():
            try:
                vt.tessellate(long_run_points(), threads=1, progress=lambda fraction: False)
            except vt.VotessError as error:
                caught.append(error.code)

        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
        self.assertEqual(caught, [vt.ErrorCode.CANCELLED])

    def test_keyboard_interrupt(self):
        points = np.concatenate([long_run_points()] * 4)
        points += 1e-3 * uniform(len(points), seed=9)
        handler = signal.getsignal(signal.SIGINT)
        errors = io.StringIO()
        for progress in (None, lambda fraction: True):
            timer = threading.Timer(0.2, _thread.interrupt_main)
            start = time.perf_counter()
            timer.start()
            try:
                with contextlib.redirect_stderr(errors), self.assertRaises(KeyboardInterrupt):
                    vt.tessellate(points, threads=1, progress=progress)
            finally:
                timer.join()
            self.assertLess(time.perf_counter() - start, 5)
            self.assertIs(signal.getsignal(signal.SIGINT), handler)
        self.assertEqual(errors.getvalue(), "")

    def test_own_interrupt_handler_that_does_not_raise(self):
        calls = []
        before = signal.signal(signal.SIGINT, lambda number, frame: calls.append(number))
        timer = threading.Timer(0.1, _thread.interrupt_main)
        try:
            timer.start()
            t = vt.tessellate(long_run_points(), threads=1)
            timer.join()
            time.sleep(0.01)
        finally:
            signal.signal(signal.SIGINT, before)
        self.assertEqual(calls, [signal.SIGINT])
        self.assertEqual(t.stats.points, len(t))

    def test_many_threads_at_once(self):
        points = [uniform(2000, seed) for seed in range(6)]
        expected = [vt.tessellate(p).neighbors.indices for p in points]
        results = [None] * len(points)

        def work(i):
            results[i] = vt.tessellate(points[i]).neighbors.indices

        threads = [threading.Thread(target=work, args=(i,)) for i in range(len(points))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for result, right in zip(results, expected):
            np.testing.assert_array_equal(result, right)

    def test_messages_belong_to_their_thread(self):
        texts = {}
        barrier = threading.Barrier(2)

        def work(index):
            points = uniform(10)
            points[index, 0] = np.nan
            barrier.wait()
            for _ in range(200):
                try:
                    vt.tessellate(points)
                except ValueError as error:
                    texts.setdefault(index, set()).add(str(error))

        threads = [threading.Thread(target=work, args=(i,)) for i in (2, 7)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual({len(found) for found in texts.values()}, {1})
        self.assertNotEqual(texts[2], texts[7])


class TessellatorTest(unittest.TestCase):
    def test_reuse(self):
        options = {"precision": "double", "grid_resolution": 9, "k_init": 30, "chunk_size": 100, "instructions": ""}
        with vt.Tessellator(device="cpu", threads=2, **options) as tessellator:
            results = []
            for count in (1000, 10, 0, 3000, 1, 1000):
                t = tessellator.tessellate(uniform(count), box=UNIT_BOX, want=EVERYTHING, walls=True)
                alone = vt.tessellate(uniform(count), box=UNIT_BOX, want=EVERYTHING, walls=True)
                np.testing.assert_array_equal(t.neighbors.indices, alone.neighbors.indices)
                np.testing.assert_allclose(t.volumes, alone.volumes, rtol=1e-12)  # another order of seeds
                results.append((t, np.array(t.volumes)))
        for t, volumes in results:  # later calls and the end of the tessellator leave results alone
            np.testing.assert_array_equal(t.volumes, volumes)

    def test_works_on_after_failures(self):
        tessellator = vt.Tessellator()
        with self.assertRaises(ValueError):
            tessellator.tessellate([[np.nan, 0, 0]])
        with self.assertRaises(ValueError):
            tessellator.tessellate(uniform(3), want="edges")
        with self.assertRaises(vt.VotessError):
            tessellator.tessellate(long_run_points(), progress=lambda fraction: False)
        self.assertTrue(tessellator.tessellate(uniform(500)).verify())

    def test_close(self):
        tessellator = vt.Tessellator()
        t = tessellator.tessellate(uniform(5))
        tessellator.close()
        tessellator.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            tessellator.tessellate(uniform(5))
        self.assertTrue(t.verify())

    def test_one_call_at_a_time(self):
        tessellator = vt.Tessellator(threads=1)
        texts = []

        def progress(fraction):
            for function in (tessellator.close, lambda: tessellator.tessellate(uniform(5))):
                with self.assertRaisesRegex(vt.VotessError, "in use") as caught:
                    function()
                self.assertEqual(caught.exception.code, vt.ErrorCode.INVALID_USE)
                texts.append(str(caught.exception))
            return True

        tessellator.tessellate(long_run_points(), progress=progress)
        self.assertGreaterEqual(len(texts), 2)
        for function in (copy.copy, copy.deepcopy, pickle.dumps):
            with self.assertRaisesRegex(TypeError, "pickled"):
                function(tessellator)

    def test_bad_options(self):
        with self.assertRaisesRegex(ValueError, "threads is -2"):
            vt.Tessellator(threads=-2)
        with self.assertRaisesRegex(ValueError, "k_init is -2"):
            vt.Tessellator(k_init=-2)
        with self.assertRaisesRegex(ValueError, "chunk_size is -2"):
            vt.Tessellator(chunk_size=-2)
        with self.assertRaisesRegex(ValueError, "'half'"):
            vt.Tessellator(precision="half")
        with self.assertRaises(TypeError):
            vt.Tessellator(device=None)


class Forks(unittest.TestCase):
    """What a child made by fork() does with the Tessellator of its parent."""

    def test_fork(self):
        points = uniform(3000)
        tessellator = vt.Tessellator(device="cpu", threads=3)
        expected = tessellator.tessellate(points, box=UNIT_BOX)
        for use in (False, True):
            child = os.fork()
            if child == 0:
                signal.alarm(60)  # ends one that hangs
                code = 1
                try:
                    if use:
                        t = tessellator.tessellate(points, box=UNIT_BOX)
                        np.testing.assert_array_equal(t.neighbors.indices, expected.neighbors.indices)
                    tessellator.close()
                    code = 0
                finally:
                    os._exit(code)
            self.assertEqual(os.waitpid(child, 0)[1], 0)
        np.testing.assert_array_equal(tessellator.tessellate(points, box=UNIT_BOX).volumes, expected.volumes)

    def test_fork_at_work(self):
        points = uniform(3000)
        tessellator = vt.Tessellator(device="cpu", threads=2)
        statuses = []

        def progress(fraction):
            child = os.fork()
            if child == 0:
                signal.alarm(60)
                code = 1
                try:
                    tessellator.tessellate(points)
                except vt.VotessError as error:
                    code = 0 if error.code == vt.ErrorCode.INVALID_USE else 2
                finally:
                    os._exit(code)
            statuses.append(os.waitpid(child, 0)[1])

        self.assertTrue(tessellator.tessellate(points, progress=progress).verify())
        self.assertTrue(statuses)
        self.assertEqual(set(statuses), {0})

    def test_multiprocessing(self):
        # In a process of its own: a pool that hangs would hang this one.
        program = (
            "import multiprocessing, signal, numpy as np, pyvotess as vt\n"
            "tessellator = vt.Tessellator(device='cpu', threads=2)\n"
            "points = np.random.default_rng(1).random((2000, 3))\n"
            "expected = tessellator.tessellate(points).neighbors.indices\n"
            "def work(_):\n"
            "    alone = vt.tessellate(points, device='cpu').neighbors.indices\n"
            "    same = tessellator.tessellate(points).neighbors.indices\n"
            "    return np.array_equal(same, expected) and np.array_equal(alone, expected)\n"
            "with multiprocessing.get_context('fork').Pool(3, signal.alarm, (60,)) as pool:\n"
            "    assert pool.map(work, range(6)) == [True] * 6\n"
            "print('done')\n"
        )
        environment = dict(os.environ, PYTHONPATH=PACKAGE_PARENT)
        done = subprocess.run(
            [sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, timeout=120, env=environment
        )
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "done\n", ""))


class Verify(unittest.TestCase):
    def test_fails_on_tampered_points(self):
        points = uniform(500)
        t = vt.tessellate(points, box=UNIT_BOX, want=EVERYTHING)
        self.assertTrue(t.verify(sample=500))
        points[123] = (0.5, 0.5, 0.5)  # t.points is this array
        report = t.verify(sample=500)
        self.assertFalse(report)
        self.assertFalse(report.passed)
        self.assertTrue(report.failure)
        self.assertNotIn("\n", report.failure)

    def test_arguments(self):
        t = vt.tessellate(uniform(20))
        self.assertTrue(t.verify(sample=0))
        self.assertTrue(t.verify(sample=10**9, rng_seed=2**64 - 1))
        self.assertEqual([t.verify(sample=n).sampled for n in (0, 7, 10**9)], [0, 7, 20])
        self.assertEqual(t.verify().sampled, 20)
        with self.assertRaisesRegex(ValueError, "sample is -1"):
            t.verify(sample=-1)
        with self.assertRaisesRegex(ValueError, "rng_seed"):
            t.verify(rng_seed=2**64)
        self.assertTrue(vt.tessellate(np.empty((0, 3))).verify())


class Facts(unittest.TestCase):
    def test_stats(self):
        t = vt.tessellate(uniform(1000), box=(0, 0, 0, 1, 1, 2), want=EVERYTHING, threads=2)
        stats = t.stats
        self.assertEqual(stats.points, 1000)
        self.assertEqual(stats.faces, t.face_counts.sum())
        self.assertAlmostEqual(stats.mean_faces, t.face_counts.mean())
        self.assertAlmostEqual(stats.volume_sum, 2.0, places=9)
        self.assertAlmostEqual(stats.box_volume, 2.0, places=12)
        self.assertEqual(stats.duplicates, 0)
        self.assertEqual(stats.empty_cells, 0)
        self.assertEqual(stats.fallback_cells, 0)
        self.assertTrue(stats.device)
        self.assertGreaterEqual(stats.threads, 1)
        self.assertGreater(stats.peak_memory_bytes, 10**6)
        self.assertGreater(stats.seconds.total, 0)
        as_dict = dataclasses.asdict(stats)
        self.assertEqual(
            list(as_dict["seconds"]), ["upload", "sort", "knn", "clip", "fallback", "download", "total"]
        )
        parts = sum(as_dict["seconds"].values()) - stats.seconds.total
        self.assertLessEqual(parts, stats.seconds.total * 1.01 + 1e-3)
        with self.assertRaises(dataclasses.FrozenInstanceError):
            stats.points = 1

    def test_precision(self):
        for precision in ("single", "double"):
            t = vt.tessellate(uniform(100), device="cpu", precision=precision)
            self.assertEqual(t.stats.precision, "double")  # the CPU has no other
        self.assertIn(vt.tessellate(uniform(100)).stats.precision, ("single", "double"))

    def test_devices(self):
        devices = vt.devices()
        self.assertIn("cpu", [device.id for device in devices])
        for device in devices:
            self.assertTrue(device.name)
            self.assertTrue(vt.tessellate(uniform(20), device=device.id).verify())

    def test_cell_status(self):
        self.assertEqual([int(s) for s in vt.CellStatus], list(range(8)))
        self.assertEqual(vt.CellStatus(5).name, "DUPLICATE")

    def test_errors(self):
        self.assertTrue(issubclass(vt.VotessError, RuntimeError))
        error = pickle.loads(pickle.dumps(vt.VotessError("text", vt.ErrorCode.CANCELLED)))
        self.assertEqual((str(error), error.code), ("text", vt.ErrorCode.CANCELLED))
        for code in vt.ErrorCode:
            kind = {"INVALID_ARGUMENT": ValueError, "OUT_OF_MEMORY": MemoryError}.get(code.name, vt.VotessError)
            with self.assertRaises(kind) as caught:
                tessellation._raise_on_failure(code)
            if kind is vt.VotessError:
                self.assertEqual(caught.exception.code, code)
        self.assertEqual(vt.ErrorCode.DEVICE_LOST, 6)
        self.assertEqual(vt.ErrorCode.INVALID_USE, 7)

    def test_names(self):
        for name in vt.__all__:
            self.assertTrue(hasattr(vt, name), name)


class Loading(unittest.TestCase):
    def test_version(self):
        self.assertEqual(vt.__version__, _library.lib.votess_version_string().decode())
        major, minor, patch = (int(part) for part in vt.__version__.split("."))
        self.assertEqual(_library.lib.votess_version(), major * 1000000 + minor * 1000 + patch)

    def test_struct_sizes(self):
        self.assertEqual(ctypes.sizeof(_c_api.Options), _library.lib.votess_sizeof_options())
        self.assertEqual(ctypes.sizeof(_c_api.Stats), _library.lib.votess_sizeof_stats())

    def test_options_lie_where_the_library_looks(self):
        options = _c_api.Options()
        _library.lib.votess_options_init(ctypes.byref(options), ctypes.sizeof(options))
        self.assertEqual((options.precision, options.k_init, options.chunk_size, options.kernel), (0, 0, 0, 0))
        self.assertIsNone(options.instructions)
        points = uniform(4)
        for field, value, text in (
            ("precision", 77, "precision is 77"),
            ("k_init", 5000, "k_init = 5000"),
            ("kernel", 5000, "kernel is 5000"),
            ("instructions", b"mmx", "instructions 'mmx'"),
        ):
            options = tessellation._new_options("cpu", 0, "single", 0, 0, 0)
            setattr(options, field, value)
            result = ctypes.c_void_p()
            arguments = (None, points.ctypes.data, 4, ctypes.byref(options), ctypes.byref(result))
            self.assertEqual(_library.lib.votess_tessellate(*arguments), vt.ErrorCode.INVALID_ARGUMENT)
            self.assertIn(text, _library.lib.votess_last_error().decode())

    def test_table_names_every_function_of_the_header(self):
        header = pathlib.Path(PACKAGE_PARENT).parents[1] / "include" / "votess" / "votess.h"
        if not header.is_file():
            self.skipTest("not in the source tree")
        declared = re.findall(r"^VOTESS_API [^;(]*?(votess_\w+)\(", header.read_text(), re.MULTILINE)
        self.assertEqual(declared, list(_c_api.SIGNATURES))

    @staticmethod
    def pretend(version=_library.VERSION, options_size=None, stats_size=None):
        sizes = ctypes.sizeof(_c_api.Options), ctypes.sizeof(_c_api.Stats)
        return types.SimpleNamespace(
            votess_version_string=lambda: version.encode(),
            votess_sizeof_options=lambda: sizes[0] if options_size is None else options_size,
            votess_sizeof_stats=lambda: sizes[1] if stats_size is None else stats_size,
        )

    def test_check_refuses_another_library(self):
        _library.check(self.pretend(), "libvotess.so")
        _library.check(self.pretend(options_size=4096), "libvotess.so")
        major, minor, _ = _library.VERSION.split(".")
        _library.check(self.pretend(version=f"{major}.{minor}.99"), "libvotess.so")
        for version in ("99.0.0", f"{major}.99.0" if major == "0" else "0.1.0"):
            with self.assertRaisesRegex(ImportError, f"libvotess.so is votess {version}.*{_library.VERSION}"):
                _library.check(self.pretend(version=version), "libvotess.so")
        with self.assertRaisesRegex(ImportError, "votess_options"):
            _library.check(self.pretend(options_size=8), "libvotess.so")
        with self.assertRaisesRegex(ImportError, "votess_stats"):
            _library.check(self.pretend(stats_size=8), "libvotess.so")

    def run_import(self, library):
        environment = dict(os.environ, VOTESS_LIBRARY=library, PYTHONPATH=PACKAGE_PARENT)
        return subprocess.run(
            [sys.executable, "-c", "import pyvotess; print(pyvotess.__version__)"],
            env=environment,
            capture_output=True,
            text=True,
        )

    def test_environment_names_the_library(self):
        done = self.run_import(_library.path)
        self.assertEqual((done.returncode, done.stdout.strip()), (0, vt.__version__), done.stderr)

    def test_missing_library(self):
        done = self.run_import("/nowhere/libvotess.so")
        self.assertNotEqual(done.returncode, 0)
        self.assertRegex(done.stderr, "ImportError.*/nowhere/libvotess.so.*VOTESS_LIBRARY")

    @unittest.skipUnless(sys.platform == "linux", "needs a library that is surely there")
    def test_foreign_library(self):
        done = self.run_import("libc.so.6")
        self.assertNotEqual(done.returncode, 0)
        self.assertRegex(done.stderr, "ImportError: libc.so.6 is not the library of votess")

    def test_interpreter_ends_quietly_with_results_alive(self):
        code = (
            "import numpy as np, pyvotess as vt\n"
            "t = vt.tessellate(np.random.default_rng(1).random((100, 3)))\n"
            "volumes = t.volumes; tessellator = vt.Tessellator()\n"
        )
        environment = dict(os.environ, VOTESS_LIBRARY=_library.path, PYTHONPATH=PACKAGE_PARENT)
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))


if __name__ == "__main__":
    unittest.main()
