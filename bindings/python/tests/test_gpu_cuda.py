"""vt.gpu.Frames on a device of CUDA: with a driver of which only the functions are there, over the memory of lavapipe.

Memory is exported and mapped for real. Semaphores, which lavapipe cannot export, and the GPU are simulated (tests/support/fake_cuda.c).
"""

import ctypes
import gc
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np
from helpers import UNIT_BOX, uniform
from test_gpu import vectors_for, vjp_on_cpu

import pyvotess as vt
from pyvotess import _cuda
from pyvotess._library import lib

ALL = "neighbors,volumes,centroids,areas"
DEVICE = os.environ.get("VOTESS_TEST_DEVICE")


class OnGpu:
    """A tensor of the fake GPU, whose memory is the host's."""

    def __init__(self, array, strides=None, stream=None):
        self.array = np.ascontiguousarray(array)
        self.__cuda_array_interface__ = {
            "version": 3, "shape": self.array.shape, "typestr": self.array.dtype.str, "data": (self.array.ctypes.data, False),
            "strides": strides, "stream": stream,
        }  # fmt: skip


def read(array):
    """Returns the contents of a CudaArray, by its DLPack capsule."""
    capsule = array.__dlpack__()
    tensor = ctypes.cast(_cuda._capsule_get(id(capsule), b"dltensor"), ctypes.POINTER(_cuda._Managed)).contents.tensor
    assert (tensor.device_type, tensor.device_id) == array.__dlpack_device__() == (2, 0)
    shape, strides = tensor.shape[: tensor.ndim], tensor.strides[: tensor.ndim]
    dtype = np.dtype(f"{'iuf'[tensor.code]}{tensor.bits // 8}")
    interface = array.__cuda_array_interface__
    assert (tuple(shape), tensor.data, np.dtype(interface["typestr"])) == (interface["shape"], interface["data"][0], dtype)
    assert tuple(n * dtype.itemsize for n in strides) == interface["strides"]
    size = sum((n - 1) * s for n, s in zip(shape, strides)) + 1 if all(shape) else 0
    flat = np.ctypeslib.as_array((ctypes.c_uint8 * (size * dtype.itemsize)).from_address(tensor.data)).view(dtype)
    return np.lib.stride_tricks.as_strided(flat, shape, interface["strides"]).copy() if size else np.empty(shape, dtype)


class NoDriver(unittest.TestCase):
    def test_no_library(self):
        with mock.patch.object(_cuda, "LIBRARY", "libcuda-none.so.1"), self.assertRaises(vt.VotessError) as raised:
            vt.gpu.Frames(10, box=UNIT_BOX, device="cuda")
        self.assertRegex(str(raised.exception), "libcuda-none.so.1 cannot be loaded.*device='auto'")
        self.assertEqual(raised.exception.code, vt.ErrorCode.UNSUPPORTED)

    def test_words(self):
        for given, words in (({"device": "cuda:x"}, "device is 'cuda:x'"), ({"dtype": "int32", "device": "cuda"}, "dtype is 'int32'")):
            with self.assertRaisesRegex((ValueError, vt.VotessError), words), mock.patch.object(_cuda, "Driver", mock.MagicMock):
                vt.gpu.Frames(10, box=UNIT_BOX, **given)


@unittest.skipUnless(DEVICE and sys.platform.startswith("linux"), "VOTESS_TEST_DEVICE names no device")
class FakeDriver(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        library = os.path.join(cls.folder.name, "libfake.so")
        source = pathlib.Path(__file__).resolve().parents[3] / "tests/support/fake_cuda.c"
        subprocess.run([os.environ.get("CC", "cc"), "-shared", "-fPIC", "-O1", "-o", library, str(source)], check=True)
        cls.fake = ctypes.CDLL(library)
        cls.fake.fake_option.argtypes = (ctypes.c_char_p, ctypes.c_int)
        for patch in (mock.patch.object(_cuda, "LIBRARY", library), mock.patch.object(_cuda, "semaphore_of", lambda export, device: 99)):
            patch.start()
            cls.addClassCleanup(patch.stop)
        cls.set_device(bytes(16))
        try:
            vt.gpu.Frames(1, box=UNIT_BOX, device="cuda")
        except vt.VotessError as error:  # it lists the devices
            cls.message = str(error)
        cls.uuid = bytes.fromhex(re.search(r"there is.* ([0-9a-f-]{36})", cls.message)[1].replace("-", ""))
        cls.set_device(cls.uuid)

    @classmethod
    def set_device(cls, uuid, frames=None):
        kind = ctypes.CFUNCTYPE(None, ctypes.c_uint64)

        def signal(value):
            cls.order.append(("signal", value))
            assert lib.votess_frames_signal(frames._handle.pointer, value) == 0

        def wait(value):
            cls.order.append(("wait", value))
            assert lib.votess_frames_wait(frames._handle.pointer, value) == 0

        cls.order = []
        cls.calls = kind(signal), kind(wait)
        cls.fake.fake_set(uuid, *cls.calls)

    def option(self, name, value, usual):
        self.fake.fake_option(name, value)
        self.addCleanup(self.fake.fake_option, name, usual)

    def frames(self, max_points, **options):
        """Returns frames, and closes those of the last call: the fake driver has one memory."""
        self.doCleanups()
        frames = vt.gpu.Frames(max_points, device="cuda", **{"box": UNIT_BOX, "want": ALL, **options})
        self.set_device(self.uuid, frames)
        self.addCleanup(frames.close)
        return frames

    def compare(self, cells, points, **domain):
        t = vt.tessellate(points, want=ALL, device="cpu", **domain)
        end = t.indptr[-1]
        np.testing.assert_array_equal(read(cells.status), t.status)
        np.testing.assert_array_equal(read(cells.indptr), t.indptr)
        np.testing.assert_array_equal(read(cells.indices)[:end], t.indices)
        if any(t.periodic):
            np.testing.assert_array_equal(read(cells.shifts)[:end], t.shifts)
        np.testing.assert_allclose(read(cells.volumes), t.volumes, rtol=1e-5)
        np.testing.assert_allclose(read(cells.centroids), t.centroids, atol=1e-5)
        np.testing.assert_allclose(read(cells.face_areas)[:end], t.face_areas, atol=1e-4 * t.volumes.max() ** (2 / 3))
        self.assertEqual(read(cells.centroids).dtype, points.dtype)

    def test_calls_wait_for_nothing_and_run_in_order(self):
        frames = self.frames(150)
        self.assertIn("150 points", repr(frames))
        first, second = uniform(100, 1).astype(np.float32), uniform(150, 2).astype(np.float32)
        tensor = OnGpu(first)
        cells = frames(tensor)
        self.assertEqual((self.fake.fake_queued(), self.order), (3, []))  # copy, signal, wait
        self.fake.cuStreamSynchronize(None)
        self.assertEqual(self.order, [("signal", 1), ("wait", 2)])
        self.compare(cells, first, box=UNIT_BOX)
        frames(tensor)
        cells = frames(OnGpu(second, stream=7))  # two calls in flight
        self.assertEqual(cells.volumes.__cuda_array_interface__["stream"], 7)
        self.fake.cuStreamSynchronize(None)
        self.assertEqual(self.order[2:], [("signal", 3), ("wait", 4), ("signal", 5), ("wait", 6)])
        self.compare(cells, second, box=UNIT_BOX)
        # Another stream waits for the cells too.
        cells.volumes.__dlpack__(stream=9)
        self.assertEqual(self.fake.fake_queued(), 1)
        self.fake.cuStreamSynchronize(None)
        self.assertEqual(self.order[-1], ("wait", 6))
        none = frames(OnGpu(first[:0]))
        self.fake.cuStreamSynchronize(None)
        self.assertEqual((len(none), read(none.indptr).tolist()), (0, [0]))

    def test_kept_cells(self):
        """Two calls in flight: the second one keeps the cells of the first one."""
        points = uniform(150, 2).astype(np.float32)
        frames = self.frames(150, follow=True)
        for step in range(3):
            moved = points + np.float32(1e-5 * step)
            frames(OnGpu(points))
            cells = frames(OnGpu(moved))
            self.fake.cuStreamSynchronize(None)
            self.compare(cells, moved, box=UNIT_BOX)

    def test_float64_periodic_weights_and_resolve(self):
        points = uniform(120, 5)
        points[4] = points[2]
        weights = np.random.default_rng(1).uniform(-0.002, 0.002, 120)
        weights[4] = weights[2]
        frames = self.frames(120, periodic=True, dtype=np.float64, weights=(-0.002, 0.002), max_images=1)
        cells = frames(OnGpu(points), OnGpu(weights))
        self.fake.cuStreamSynchronize(None)
        self.assertGreater((read(cells.status) == vt.CellStatus.CANDIDATES_EXHAUSTED).sum(), 50)
        self.assertIs(cells.resolve(), cells)
        self.compare(cells, points, box=UNIT_BOX, periodic=True, weights=weights)
        frames(OnGpu(points), OnGpu(weights))
        with self.assertRaisesRegex(ValueError, "the last call"):
            cells.resolve()
        with self.assertRaisesRegex(ValueError, "weights are missing"):
            frames(OnGpu(points))
        self.fake.cuStreamSynchronize(None)

    def test_gradients(self):
        points = uniform(120, 5)
        weights = np.random.default_rng(1).uniform(-0.002, 0.002, 120)
        for dtype in (np.float32, np.float64):
            given, masses = points.astype(dtype), weights.astype(dtype)
            frames = self.frames(150, periodic=True, dtype=dtype, weights=(-0.002, 0.002), gradients=True)
            cells = frames(OnGpu(given), OnGpu(masses))
            self.fake.cuStreamSynchronize(None)
            cells.resolve()
            t = vt.tessellate(given, weights=masses, want=ALL, device="cpu", box=UNIT_BOX, periodic=True)
            vectors = vectors_for(t)
            for names in (["volumes"], ["face_areas"], list(vectors)):
                some = {name: vectors[name] for name in names}
                on_gpu = {name: OnGpu(a.astype(dtype) if name == "centroids" else a) for name, a in some.items()}
                queued = self.fake.fake_queued()
                found = cells.vjp(**on_gpu)
                self.assertEqual(self.fake.fake_queued() - queued, len(names) + 2)  # copies, signal, wait
                self.fake.cuStreamSynchronize(None)
                for array, expected in zip(map(read, found), vjp_on_cpu(given, masses, some, box=UNIT_BOX, periodic=True)):
                    self.assertEqual(array.dtype, dtype)
                    np.testing.assert_allclose(array, expected, atol=1e-5 * np.abs(expected).max())
            self.assertEqual(self.order[-2:], [("signal", 7), ("wait", 8)])
        with self.assertRaisesRegex(ValueError, r"volumes has shape \(119,\): it must be \(120"):
            cells.vjp(volumes=OnGpu(vectors["volumes"][1:]))
        with self.assertRaisesRegex(ValueError, "centroids has dtype float32: these Frames take float64"):
            cells.vjp(centroids=OnGpu(vectors["centroids"]))
        frames(OnGpu(given), OnGpu(masses))
        with self.assertRaisesRegex(ValueError, "vjp.. is of the last call"):
            cells.vjp(volumes=OnGpu(vectors["volumes"]))
        self.fake.cuStreamSynchronize(None)

    def test_gradients_of_unresolved_cells(self):
        points = np.float32(uniform(100))
        frames = self.frames(100, max_entries=500, gradients=True)
        cells = frames(OnGpu(points))
        self.fake.cuStreamSynchronize(None)
        pending = read(cells.status) != vt.CellStatus.CERTIFIED
        self.assertTrue(30 < pending.sum() < 90)
        t = vt.tessellate(points, want=ALL, device="cpu", box=UNIT_BOX)
        vectors = vectors_for(t)
        centroids = vectors["centroids"]
        for given in (centroids, np.where(pending[:, None], np.float32(0), centroids)):
            found = cells.vjp(volumes=OnGpu(vectors["volumes"]), centroids=OnGpu(given))
            self.fake.cuStreamSynchronize(None)
            expected = vjp_on_cpu(points, None, {"volumes": vectors["volumes"], "centroids": given}, box=UNIT_BOX)
            near = np.array([pending[row].any() for row in t.neighbors]) & given[pending].any()
            for array, right in zip(map(read, found), expected):
                missing = np.isnan(array).reshape(100, -1).all(axis=1)
                np.testing.assert_array_equal(missing, pending | near)
                np.testing.assert_allclose(array[~missing], right[~missing], atol=1e-5 * np.abs(right).max())

    def test_lifetimes(self):
        self.assertEqual(self.fake.fake_live(), 0)
        frames = vt.gpu.Frames(10, box=UNIT_BOX, want="neighbors", device="cuda")
        self.set_device(self.uuid, frames)
        offsets = frames(OnGpu(np.float32(uniform(10)))).indptr
        self.fake.cuStreamSynchronize(None)
        known = len(_cuda._exported)
        capsule = offsets.__dlpack__()
        self.assertEqual(len(_cuda._exported), known + 1)
        del capsule
        self.assertEqual(len(_cuda._exported), known)
        self.set_device(self.uuid)
        del frames
        gc.collect()
        self.assertGreater(read(offsets)[10], 30)  # it keeps the memory
        self.assertEqual(self.fake.fake_live(), 3)
        del offsets
        gc.collect()
        self.assertEqual(self.fake.fake_live(), 0)

    def test_refusals(self):
        self.assertRegex(self.message, "no Vulkan device has the UUID 00000000-0000-0000-0000-000000000000: there is ")
        for option, value, usual, error, words in (
            (b"version", 11010, 12040, vt.VotessError, "11.2 or newer, this one has 11.1"),
            (b"devices", 0, 1, vt.VotessError, "CUDA has 0 devices"),
            (b"fail_import", 1, 0, MemoryError, "cuImportExternalMemory of CUDA: CUDA_ERROR_OUT_OF_MEMORY.*lower max_points"),
        ):
            self.fake.fake_option(option, value)
            with self.assertRaisesRegex(error, words):
                vt.gpu.Frames(10, box=UNIT_BOX, want="neighbors", device="cuda")
            self.fake.fake_option(option, usual)
            gc.collect()
            self.assertEqual(self.fake.fake_live(), 0)
        points = np.float32(uniform(10))
        frames = self.frames(10, want="neighbors")
        for call, words in (
            (lambda: frames(points), "points is of type ndarray: give an array with __cuda_array_interface__"),
            (lambda: frames(OnGpu(uniform(10))), "points has dtype float64: these Frames take float32"),
            (lambda: frames(OnGpu(points[:, :2])), r"points has shape \(10, 2\): it must be \(N, 3\)"),
            (lambda: frames(OnGpu(points, strides=(4, 40))), "points is not contiguous"),
            (lambda: frames(OnGpu(np.float32(uniform(11)))), "11 points are more than max_points = 10"),
            (lambda: frames(OnGpu(points), OnGpu(points[:, 0])), "weights are given"),
        ):
            with self.assertRaisesRegex(ValueError, words):
                call()
        self.option(b"ordinal", 1, 0)
        with self.assertRaisesRegex(ValueError, "points is on device cuda:1, but these Frames are of cuda:0"):
            frames(OnGpu(points))
        self.fake.fake_option(b"ordinal", 0)
        self.option(b"capturing", 1, 0)
        with self.assertRaisesRegex(ValueError, "stream is capturing a graph"):
            frames(OnGpu(points))
        self.fake.fake_option(b"capturing", 0)
        self.assertEqual((self.fake.fake_queued(), self.order), (0, []))
        frames.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            frames(OnGpu(points))


if __name__ == "__main__":
    unittest.main()
