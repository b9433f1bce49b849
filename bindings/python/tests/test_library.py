"""verify(), statistics, devices, and loading of the library."""

import ctypes
import dataclasses
import os
import pathlib
import pickle
import pydoc
import re
import subprocess
import sys
import types
import typing
import unittest

import numpy as np
from helpers import EVERYTHING, PACKAGE_PARENT, uniform

import pyvotess as vt  # noqa: E402
from pyvotess import _arrays, _c_api, _call, _library, _run  # noqa: E402


class Verify(unittest.TestCase):
    def test_arguments(self):
        t = vt.tessellate(uniform(20))
        self.assertTrue(t.verify(sample=0))
        self.assertTrue(t.verify(sample=10**9, rng_seed=2**64 - 1))
        self.assertEqual([t.verify(sample=n).sampled for n in (0, 7, 10**9)], [0, 7, 20])
        self.assertEqual([t.verify(sample=n).proven for n in (0, 7, 10**9)], [False] * 3)
        self.assertEqual((t.verify().proven, t.verify().unproven, t.verify().sampled), (True, "", 0))
        self.assertEqual(t.verify(sample=7).unproven, "a number of cells was given, which are sampled")
        self.assertTrue(vt.tessellate(uniform(9), only=[]).verify().passed)
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
        self.assertEqual(set(vars(stats.fallback_reasons).values()), {0})
        self.assertTrue(stats.device)
        self.assertGreaterEqual(stats.threads, 1)
        self.assertGreater(stats.peak_memory_bytes, 10**6)
        self.assertGreater(stats.seconds.total, 0)
        as_dict = dataclasses.asdict(stats)
        self.assertEqual(
            list(as_dict["seconds"]), ["open", "upload", "sort", "knn", "clip", "fallback", "download", "total"]
        )
        parts = sum(as_dict["seconds"].values()) - stats.seconds.total
        self.assertLessEqual(parts, stats.seconds.total * 1.01 + 1e-3)
        with self.assertRaises(dataclasses.FrozenInstanceError):
            stats.points = 1

    def test_precision(self):
        for precision in ("single", "double"):
            t = vt.tessellate(uniform(100), device="cpu", precision=precision)
            self.assertEqual(t.stats.precision, "double")  # always on the CPU
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
                _call.raise_on_failure(code)
            if kind is vt.VotessError:
                self.assertEqual(caught.exception.code, code)
        self.assertEqual(vt.ErrorCode.DEVICE_LOST, 6)
        self.assertEqual(vt.ErrorCode.INVALID_USE, 7)

    def test_names(self):
        for name in dir(vt):
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
        self.assertEqual((options.precision, options.k_init, options.chunk_size, options.wall_count), (0, 0, 0, 0))
        self.assertIsNone(options.instructions)
        points = uniform(4)
        for field, value, text in (
            ("precision", 77, "precision = 77"),
            ("k_init", 5000, "k_init = 5000"),
            ("instructions", b"mmx", "instructions is 'mmx'"),
        ):
            options = _run.new_options(device="cpu")
            setattr(options, field, value)
            result = ctypes.c_void_p()
            arguments = (None, points.ctypes.data, 4, ctypes.byref(options), ctypes.byref(result))
            self.assertEqual(_library.lib.votess_tessellate(*arguments), vt.ErrorCode.INVALID_ARGUMENT)
            self.assertIn(text, _library.lib.votess_last_error().decode())

    def test_literal_types_hold_the_words(self):
        for words, literal in (
            (_arrays.WANT_BITS, _arrays.WantWord),
            (_c_api.DUPLICATES, _c_api.DuplicatesWord),
            (_c_api.OUTSIDE, _c_api.OutsideWord),
            (_c_api.PRECISIONS, _c_api.PrecisionWord),
        ):
            self.assertEqual(set(words), set(typing.get_args(literal)))

    def test_report(self):
        """python -m pyvotess --info names what a report of a fault needs."""
        env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(PACKAGE_PARENT), os.environ.get("PYTHONPATH", "")])}
        done = subprocess.run([sys.executable, "-m", "pyvotess", "--info"], env=env, capture_output=True, text=True, check=True)
        report = dict((line[:12].strip(), line[12:]) for line in done.stdout.splitlines())
        self.assertEqual((report["pyvotess"], report["numpy"]), (vt.__version__, np.__version__))
        self.assertEqual({name[7:] for name in report if name.startswith("device ")}, {device.id for device in vt.devices()})
        self.assertIn(sys.executable, report["python"])

    def test_names_of_the_package(self):
        self.assertLess(set(vt.__all__), set(dir(vt)))
        self.assertEqual([name for name in dir(vt) if not hasattr(vt, name)], [])
        # help() has functions and what users make; inherited members of records and enumerations would triple it.
        # Python 3.14 shows a quarter more lines than 3.11.
        self.assertLess(len(pydoc.plain(pydoc.render_doc(vt)).splitlines()), 4000)
        self.assertEqual(dir(vt.walls), ["cone", "cylinder", "sphere"])

    def test_arrays_by_name(self):
        t = vt.tessellate(uniform(10), want="volumes", device="cpu")
        handle = t._result
        for name, kind, size in (("volumes", "f8", 10), ("status", "u1", 10), ("indptr", "i8", 0), ("face_counts", "u4", 0), ("shifts", "i1", 0)):
            self.assertEqual((handle.array(name).dtype, len(handle.array(name))), (np.dtype(kind), size), name)
        self.assertEqual(handle.array("walls").shape, (0, 4))
        with self.assertRaisesRegex(ValueError, "name is 'volume': the arrays of result are indices, .*, indptr, .*, walls$"):
            handle.array("volume")
        listed = str(self.error_of(lambda: handle.array("x"))).rsplit(" are ", 1)[1].split(", ")
        self.assertEqual(set(listed), {*_arrays.TABLE, "box", "periodic", "cell", "walls"})

    @staticmethod
    def error_of(call):
        try:
            call()
        except ValueError as error:
            return error

    def test_headers_are_read(self):
        """Every function, with its arguments; fields of each form; pointers that take arrays of one type only."""
        folder = pathlib.Path(__file__).resolve().parents[3] / "include" / "votess"
        if not folder.is_dir():
            self.skipTest("not in the source tree")
        text = "".join((folder / f"{name}.h").read_text() for name in ("votess", "surface", "picture", "stream", "frames"))
        self.assertEqual(text.count("\nVOTESS_API "), len(_c_api.SIGNATURES))
        for name, (result, arguments) in _c_api.SIGNATURES.items():
            declared = re.search(rf"^VOTESS_API ([^;(]*?) {name}\(([^)]*)\);", text, re.MULTILINE)
            self.assertEqual(len(arguments), 0 if declared[2] == "void" else declared[2].count(",") + 1, name)
            self.assertEqual(result is None, declared[1] == "void", name)
        self.assertEqual(_c_api.SIGNATURES["votess_last_error"], (ctypes.c_char_p, ()))
        self.assertEqual(_c_api.SIGNATURES["votess_device_info"][1][:3], (ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t))
        fields = dict(_c_api.StreamCounts._fields_)
        self.assertEqual((fields["temporary_bytes"], fields["failure"]), (ctypes.c_uint64, ctypes.c_char * 256))
        self.assertEqual(dict(_c_api.Options._fields_)["cell_c"], ctypes.c_double * 3)
        self.assertEqual(dict(_c_api.Stream._fields_)["next"](lambda seeds: 7)(None), 7)
        numbers = _c_api.SIGNATURES["votess_diagram_locate"][1][1]
        for wrong in (np.zeros(3, np.float32), np.zeros((3, 3)).T):
            with self.assertRaisesRegex(TypeError, "float64 in C order"):
                numbers.from_param(wrong)

    def test_a_struct_keeps_its_arrays(self):
        given = np.arange(3.0)
        options = _c_api.SurfaceOptions(weights=given, threads=2)
        self.assertEqual((options.weights, options.struct_size), (given.ctypes.data, ctypes.sizeof(options)))
        count = sys.getrefcount(given)
        del options
        self.assertEqual(sys.getrefcount(given), count - 1)

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
