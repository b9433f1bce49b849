"""Arguments, refusals, and ownership of the memory of results."""

import copy
import ctypes
import gc
import importlib.util
import pickle
import unittest
from pathlib import Path
import weakref

import numpy as np
from helpers import CUBE, EVERYTHING, UNIT_BOX, uniform

import pyvotess as vt  # noqa: E402
from pyvotess import _c_api, _input, _library  # noqa: E402


class DLPackOnly:
    """An array that has no other interface."""

    def __init__(self, array, device=(1, 0)):
        self._array, self._device = array, device

    def __dlpack__(self, **options):
        return self._array.__dlpack__(**options)

    def __dlpack_device__(self):
        return self._device


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

    def test_files_and_frames(self):
        """Names of files and frames are no points; the message shows the way."""
        frame = vt.Frame(0, np.zeros((1, 3)))
        for points, message in (("run.xyz", r"points is 'run.xyz': .*read_frames\(\)"), (Path("a.npy"), "read_frames"), (frame, "method tessellate")):
            with self.assertRaisesRegex(TypeError, message):
                vt.tessellate(points)
        with self.assertRaisesRegex(ValueError, r"mesh is 'a.obj': .*trimesh"):
            vt.tessellate(np.zeros((1, 3)), mesh="a.obj")
        with self.assertRaisesRegex(TypeError, r"as in Frame\(0, points\)"):
            vt.Frame(np.zeros((1, 3)), vt.Domain.box(UNIT_BOX))

    def test_dlpack(self):
        t = self.assert_same(DLPackOnly(self.points))
        self.assertTrue(np.shares_memory(t.points, self.points))
        self.assert_same(DLPackOnly(np.asfortranarray(self.points)))
        values, mask = 0.01 * self.points[:, 0], self.points[:, 1] > 0.5
        arrays = {"points": self.points, "weights": values, "box": np.array(UNIT_BOX, float), "only": np.flatnonzero(mask)}
        given = {name: DLPackOnly(array) for name, array in arrays.items()}
        np.testing.assert_array_equal(vt.tessellate(**given).volumes, vt.tessellate(**arrays).volumes)
        for as_given in (values, DLPackOnly(values)):
            self.assertTrue(np.shares_memory(_input.as_one_each(as_given, "weights", 200, "points"), values))
        cube = tuple(DLPackOnly(array) for array in CUBE)
        np.testing.assert_allclose(vt.tessellate(self.points, mesh=cube).volumes.sum(), 1, rtol=1e-12)
        diagram, queries = vt.Diagram(DLPackOnly(self.points), box=UNIT_BOX), 0.4 + 0.2 * self.points[:20]
        found = diagram.interpolate(DLPackOnly(values), DLPackOnly(queries))
        np.testing.assert_array_equal(found, diagram.interpolate(values, queries))
        with self.assertRaisesRegex(ValueError, "points is in memory of a device, type 2 of DLPack: copy it to the CPU"):
            vt.tessellate(DLPackOnly(self.points, device=(2, 0)))

    def test_dlpack_of_results(self):
        volumes = self.expected.volumes
        try:
            exported = np.from_dlpack(volumes)
        except BufferError as error:  # before NumPy 2.1
            self.assertIn("readonly", str(error))
        else:
            self.assertTrue(np.shares_memory(exported, volumes))
            self.assertFalse(exported.flags.writeable)
        np.testing.assert_array_equal(np.from_dlpack(volumes.copy()), volumes)

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

    def test_rounded_coordinates(self):
        """Points that the decimals of a file put beyond a wall are to be kept; farther ones are a fault."""
        inside = np.random.default_rng(4).random((20, 3))
        edges = np.array([(4.1, 0, 0), (0.7, 3.3, 0), (0.2, -0.4, 5.2)])
        for scale in (1e-3, 1, 1e5):
            cell, box = edges * scale, (0, 0, 0, *(np.array((4.1, 3.3, 5.2)) * scale))
            for places, domain in ((inside * box[3:], {"box": box}), (inside @ cell, {"cell": cell, "periodic": "xy"}),
                                   (inside * box[3:], {"box": box, "walls": [(1, 1, 1, 99 * scale), (0, 0.6, 0.8, (0.6 * 3.3 + 0.8 * 5.2) * scale)]})):
                for beyond, rounded in ((5e-9, True), (1e-7, True), (1e-3, False), (0.5, False)):
                    points = places.copy()
                    points[7] = (np.array(box[3:]) / 2 if "cell" not in domain else cell.sum(axis=0) / 2)
                    points[7, 2] = box[5] + beyond * scale
                    with self.assertRaisesRegex(ValueError, r"^points\[7\]") as raised:
                        vt.tessellate(points, **domain)
                    self.assertEqual('may be rounded: keep points outside (outside="keep")' in str(raised.exception), rounded, (domain, beyond))
                    self.assertEqual('outside="drop"' in str(raised.exception), not rounded)
                    t = vt.tessellate(points, outside="keep", **domain)
                    self.assertAlmostEqual(t.volumes.sum() / np.prod(box[3:]), 1, 9)

    def test_pandas(self):
        """Nullable and Arrow columns of pandas 3.1.1, which NumPy takes for objects; imitations, and frames where it is installed."""
        class Kind:
            def __init__(self, kind):
                self.kind = kind

        def column(values, *kinds, missing=False):
            def to_numpy(dtype, **options):
                if missing and "na_value" not in options:
                    raise ValueError("NA")
                return np.array(values, dtype)
            own = type("Frame", (), {"__module__": "pandas.core.frame", "__array__": lambda self, dtype=None, copy=None: np.array(values, object)})()
            own.ndim, own.to_numpy = np.ndim(values), to_numpy
            own.dtypes = [Kind(kind) for kind in kinds]
            own.dtype = own.dtypes[0]
            own.isna = lambda: np.array([missing])
            return own

        points = np.random.default_rng(2).random((9, 3)).tolist()
        expected = vt.tessellate(points).volumes
        np.testing.assert_array_equal(vt.tessellate(column(points, "f", "f", "f")).volumes, expected)
        whole = [[i, i * i, -i] for i in range(9)]
        self.assertEqual(vt.tessellate(column(whole, "i", "f", "u")).points.dtype, np.float64)
        np.testing.assert_array_equal(vt.tessellate(column(whole, "i", "i", "i")).points, whole)
        radii = column([0.1] * 9, "f")
        np.testing.assert_array_equal(vt.tessellate(points, radii=radii).volumes, vt.tessellate(points, radii=[0.1] * 9).volumes)
        np.testing.assert_array_equal(vt.tessellate(points, only=column([True] + [False] * 8, "b")).ids, [0])
        for frame, says in ((column([[2**53 + 1, 0, 0]], "i", "i", "i"), r"points\[0\]\[0\] is 9007199254740993"),
                            (column([[1, np.nan, 2]], "f", "f", "f", missing=True), r"^points\[0\]: y = nan"), (column([["1", "2", "3"]], "O", "O", "O"), "dtype object"),
                            (column(points, "f", "b", "f"), "dtype object")):
            with self.assertRaisesRegex(ValueError, says):
                vt.tessellate(frame)
        try:
            import pandas
        except ImportError:
            return
        frame = pandas.DataFrame(points, columns=list("xyz"))
        backends = [{}] + ([{"dtype_backend": "pyarrow"}] if importlib.util.find_spec("pyarrow") else [])
        for options in backends:
            other = frame.convert_dtypes(**options)
            np.testing.assert_array_equal(vt.tessellate(other).volumes, expected)
            np.testing.assert_array_equal(vt.tessellate(points, weights=other["x"] / 99).volumes, vt.tessellate(points, weights=frame["x"].to_numpy() / 99).volumes)
            other.iloc[3, 1] = None
            with self.assertRaisesRegex(ValueError, r"^points\[3\]: y = nan"):
                vt.tessellate(other)
            with self.assertRaisesRegex(ValueError, "dtype object"):
                vt.tessellate(frame.astype(str).convert_dtypes(**options))

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
            there = _c_api.Array()
            _library.lib.votess_result_array(t._result.pointer, name.encode(), ctypes.byref(there))
            self.assertEqual(array.ctypes.data, there.data, name)
            self.assertEqual(array.size, there.length * there.components, name)
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
                function(t._result)
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(t.volumes)), t.volumes)


if __name__ == "__main__":
    unittest.main()
