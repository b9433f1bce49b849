"""Runs: progress, interrupts, threads, Tessellator, forks."""

import _thread
import contextlib
import copy
import io
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import traceback
import unittest
from unittest import mock

import numpy as np
from helpers import EVERYTHING, PACKAGE_PARENT, UNIT_BOX, long_run_points, uniform

import pyvotess as vt  # noqa: E402


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
        # With the GIL held, there would be only a tick or two for each progress call.
        self.assertGreater(during, 60 * seconds, f"{during} ticks in {seconds:.2f} s")

    def test_progress(self):
        fractions = []
        vt.tessellate(long_run_points(), threads=1, progress=fractions.append)
        self.assertTrue(fractions)
        self.assertTrue(all(0 <= f <= 1 for f in fractions), fractions)
        self.assertEqual(fractions, sorted(fractions))

    def test_progress_shown(self):
        points = long_run_points()
        for hidden in ({}, {"tqdm": None, "tqdm.auto": None}):
            shown = io.StringIO()
            with mock.patch.dict(sys.modules, hidden), contextlib.redirect_stderr(shown):
                t = vt.tessellate(points, threads=1, progress=True)
                vt.Tessellator().tessellate(points[:5], progress=True)
            self.assertEqual(len(t), len(points))
            *lines, end = shown.getvalue().split("\n")
            self.assertEqual((len(lines), end), (2, ""))
            for line in lines:
                self.assertIn("100 %", line.split("\r")[-1])
        shown = io.StringIO()
        with contextlib.redirect_stderr(shown):
            vt.tessellate(points[:5], progress=False)
            with self.assertRaisesRegex(ValueError, "nan"), mock.patch.dict(sys.modules, {"tqdm.auto": None}):
                vt.tessellate([[np.nan, 0, 0]], progress=True)
        self.assertEqual(shown.getvalue(), "")
        with self.assertRaisesRegex(TypeError, "progress must be callable, True or False, not int"):
            vt.tessellate(points[:5], progress=1)

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

    def test_what_other_signal_handlers_raise_arrives(self):
        class Alarm(Exception):
            pass

        def handler(number, frame):
            raise Alarm("time is over")

        points = long_run_points()
        tessellator = vt.Tessellator(threads=1)
        calls = {
            "tessellate": lambda: vt.tessellate(points, threads=1),
            "faces": lambda: vt.tessellate(points, threads=1, want="faces", progress=lambda fraction: None),
            "Tessellator": lambda: tessellator.tessellate(points),
            "stream": lambda: vt.tessellate_stream([points], lambda rows: None, memory=10_000_000, threads=1),
            "lloyd": lambda: vt.lloyd(points, threads=1),
        }
        errors = io.StringIO()
        before = signal.signal(signal.SIGALRM, handler)
        try:
            for name, call in calls.items():
                start = time.perf_counter()
                frames = []
                with contextlib.redirect_stderr(errors):
                    try:
                        signal.setitimer(signal.ITIMER_REAL, 0.1)
                        call()
                    except Alarm as error:
                        frames = [frame.name for frame in traceback.extract_tb(error.__traceback__)]
                    finally:
                        signal.setitimer(signal.ITIMER_REAL, 0)
                self.assertLess(time.perf_counter() - start, 5)
                self.assertEqual(frames[-1:], ["handler"], name)
        finally:
            signal.signal(signal.SIGALRM, before)
        self.assertEqual(errors.getvalue(), "")
        self.assertEqual(len(tessellator.tessellate(points[:50])), 50)

    def test_methods_of_a_result_can_be_stopped(self):
        from pyvotess import _c_api, _call

        class Alarm(Exception):
            pass

        def work(fraction):  # as when a signal handler raises
            raise Alarm

        def progress(callbacks, given):
            return callbacks.guarded(_c_api.ProgressCallback, work, 0)

        t = vt.tessellate(uniform(500), box=UNIT_BOX, periodic=True, want="neighbors,volumes,areas,faces,counts", device="cpu")
        network = t.network()
        calls = {
            "delaunay": t.delaunay, "network": t.network, "largest_free": network.largest_free,
            "alpha_complex": t.alpha_complex, "verify": t.verify, "watershed": lambda: t.watershed(t.volumes),
            "pairs": vt.tessellate(uniform(500), box=UNIT_BOX, periodic=True, device="cpu").pairs,
        }  # fmt: skip
        for name, call in calls.items():
            with self.subTest(name):
                with mock.patch.object(_call.Callbacks, "progress", progress), self.assertRaises(Alarm):
                    call()
                self.assertIsNotNone(call())

    def test_callbacks_of_a_run_stop_at_the_first_error(self):
        from pyvotess import _c_api, _call

        def fail(fraction):
            raise ZeroDivisionError(str(fraction))

        with self.assertRaisesRegex(ZeroDivisionError, "0.25"), _call.Callbacks() as callbacks:
            first, second = callbacks.progress(fail), callbacks.progress(lambda fraction: True)
            self.assertEqual((second(0.1), first(0.25), first(0.5), second(0.5)), (1, 0, 0, 0))
        # An error of the block itself has priority, and nothing remains for the garbage collector.
        with self.assertRaises(KeyError), _call.Callbacks() as callbacks:
            callbacks.guarded(_c_api.ProgressCallback, fail, 0)(0.0)
            raise KeyError

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
    def test_repr(self):
        tessellator = vt.Tessellator(device="cpu", follow=True)
        self.assertEqual(repr(tessellator), "<pyvotess.Tessellator: device 'cpu', precision 'single', follow True>")
        tessellator.close()
        self.assertTrue(repr(tessellator).startswith("<pyvotess.Tessellator, closed: device 'cpu'"))

    def test_reuse(self):
        options = {"precision": "double", "grid_resolution": 9, "k_init": 30, "chunk_size": 100, "instructions": ""}
        with vt.Tessellator(device="cpu", threads=2, **options) as tessellator:
            results = []
            for count in (1000, 10, 0, 3000, 1, 1000):
                t = tessellator.tessellate(uniform(count), box=UNIT_BOX, want=EVERYTHING, list_walls=True)
                alone = vt.tessellate(uniform(count), box=UNIT_BOX, want=EVERYTHING, list_walls=True)
                np.testing.assert_array_equal(t.neighbors.indices, alone.neighbors.indices)
                np.testing.assert_allclose(t.volumes, alone.volumes, rtol=1e-12)  # the seeds have another order
                results.append((t, np.array(t.volumes)))
        for t, volumes in results:  # later calls and the end of the tessellator do not change results
            np.testing.assert_array_equal(t.volumes, volumes)

    def test_follow(self):
        """Cells that hold at the new places are kept, and each result is that of a call by itself."""
        points, random = uniform(1000), np.random.default_rng(3)
        with vt.Tessellator(device="cpu", threads=1, follow=True) as tessellator:
            for by, least, most in ((0, 0, 0), (0, 900, 1000), (1e-5, 900, 1000), (1e-4, 500, 1000), (1, 0, 0)):
                points = np.clip(points + by * random.uniform(-1, 1, points.shape), 0, 1)
                t = tessellator.tessellate(points, box=UNIT_BOX, want="volumes,areas,neighbors")
                alone = vt.tessellate(points, box=UNIT_BOX, want="volumes,areas,neighbors", device="cpu")
                np.testing.assert_array_equal(t.neighbors.indices, alone.neighbors.indices)
                np.testing.assert_array_equal(t.volumes, alone.volumes)
                np.testing.assert_array_equal(t.face_areas, alone.face_areas)
                self.assertTrue(least <= t.stats.kept_cells <= most, (by, t.stats.kept_cells))
        with self.assertRaisesRegex(TypeError, "follow"):
            vt.Tessellator(follow="yes")

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


class End(unittest.TestCase):
    def test_modules_that_are_empty_at_exit(self):
        """Objects of the library end without a word after the interpreter has emptied the modules."""
        program = (
            "import ctypes, os, sys, numpy as np, pyvotess as vt\n"
            "points = np.random.default_rng(1).random((20, 3))\n"
            "tessellator, diagram = vt.Tessellator(device='cpu'), vt.Diagram(points)\n"
            "t = tessellator.tessellate(points, want='faces')\n"
            "kept = [tessellator, diagram, t, t.delaunay(), t.network(), t.watershed(np.arange(20.0)), diagram.locate(points),\n"
            "        diagram.natural_neighbors(points), diagram.trace(points, points - 0.5), t.vertices]\n"
            "for module in (ctypes, os, *(m for name, m in sys.modules.items() if name.startswith('pyvotess'))):\n"
            "    vars(module).update(dict.fromkeys(vars(module)))\n"
            "del tessellator, diagram, t, kept\n"
            "print('done')\n"
        )
        environment = dict(os.environ, PYTHONPATH=PACKAGE_PARENT)
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=environment)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "done\n", ""))


class Forks(unittest.TestCase):
    """Uses the Tessellator of the parent in a forked child."""

    def test_multiprocessing(self):
        # In a separate process, because a hanging pool would hang this one.
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
        # Python warns of a fork with threads, which is what this tests.
        warnings = ["-W", "error", "-W", "ignore:This process:DeprecationWarning"]
        command = [sys.executable, *warnings, "-c", program]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "done\n", ""))


if __name__ == "__main__":
    unittest.main()
