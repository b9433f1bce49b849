"""Base of the tests of clvotess: runs the program in an empty folder."""

import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

CLI = os.environ.get("VOTESS_CLI", "clvotess")
ROOT = Path(__file__).resolve().parents[2]
HIDDEN = {"VK_DRIVER_FILES": "/nonexistent", "VK_ICD_FILENAMES": "/nonexistent"}  # the loader finds no driver
SANITIZED = bool(os.environ.get("VOTESS_TEST_REDUCED"))  # slow build, no foreign code in the process

JSON_KEYS = ["version", "device", "points", "domain", "faces", "mean_faces", "volume_sum", "box_volume", "duplicates",
             "empty_cells", "fallback_cells", "fallback_reasons", "exact_cells", "kept_cells", "tiny_faces", "threads", "seconds",
             "peak_memory_bytes", "verified", "proven", "unproven", "verified_cells"]
SECONDS_KEYS = ["total", "open", "read", "upload", "sort", "knn", "clip", "fallback", "download", "write"]
OPTIONS = re.findall(r'^ *\{"(?:-\w, )?(--[a-z0-9+-]+)', (ROOT / "cli/options.cpp").read_text(), re.M)
SHORT_OPTIONS = ["-o", "-x", "-t", "-g", "-k", "-q", "-h"]

CUBE = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n"
CUBE_BOX = "-0.5,-0.5,-0.5,1.5,1.5,1.5"
CUBE_NEIGHBORS = [[1, 2, 4], [0, 3, 5], [0, 3, 6], [1, 2, 7], [0, 5, 6], [1, 4, 7], [2, 4, 7], [3, 5, 6]]


def random_points(count, seed=7):
    return np.random.default_rng(seed).random((count, 3))


def text_of(points, separator=" "):
    return "".join(separator.join(repr(float(x)) for x in row) + "\n" for row in points)

# A shell makes background processes ignore Ctrl-C, which programs started here would inherit.
signal.signal(signal.SIGINT, signal.default_int_handler)


class CliTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def assertListEqual(self, list1, list2, msg=None):
        """Compares lists up to the first difference. unittest's own comparison of long lists takes hours."""
        for i, (one, two) in enumerate(zip(list1, list2)):
            self.assertFalse(one != two, f"element {i}: {one!r} != {two!r} {msg or ''}")
        self.assertEqual(len(list1), len(list2), msg)

    def put(self, name, content):
        path = self.folder / name
        if isinstance(content, bytes):
            path.write_bytes(content)
        elif isinstance(content, np.ndarray):
            np.save(path, content)
        else:
            path.write_text(content)
        return name

    def files(self):
        return sorted(path.name for path in self.folder.iterdir())

    def start(self, *arguments, **options):
        return subprocess.Popen([CLI, *map(str, arguments)], cwd=self.folder, **options)

    def run_cli(self, *arguments, stdin="", code=0, **options):
        done = subprocess.run([CLI, *map(str, arguments)], cwd=self.folder, input=stdin, text=True,
                              capture_output=True, timeout=300, check=False, **options)
        self.assertEqual(done.returncode, code, f"{arguments}\nstdout: {done.stdout}\nstderr: {done.stderr}")
        return done

    def preloading(self, function):
        """Returns an environment in which this C++ function replaces that of the library."""
        compiler = shutil.which(os.environ.get("CXX", "c++"))
        if SANITIZED or not compiler or b"libvotess.so" not in Path(shutil.which(CLI)).read_bytes():
            self.skipTest("needs a compiler and a shared libvotess without sanitizer")
        build = tempfile.TemporaryDirectory()
        self.addCleanup(build.cleanup)
        (Path(build.name) / "votess").mkdir()
        (Path(build.name) / "votess/version.hpp").write_text("")
        source, library = Path(build.name) / "false.cpp", Path(build.name) / "false.so"
        source.write_text("#include <votess/votess.hpp>\n" + function)
        subprocess.run([compiler, "-std=c++20", "-shared", "-fPIC", f"-I{ROOT / 'include'}", f"-I{build.name}",
                        str(source), "-o", str(library)], check=True)
        return dict(os.environ, LD_PRELOAD=str(library))

    def refuse(self, *arguments, says=(), stdin="", code=2):
        """Runs a bad call. Asserts exit code, one line on stderr with these texts, empty stdout, no new file."""
        before = self.files()
        done = self.run_cli(*arguments, stdin=stdin, code=code)
        self.assertRegex(done.stderr, r"\Aclvotess: [^\n]+\n\Z", arguments)
        self.assertEqual(done.stdout, "", arguments)
        self.assertEqual(self.files(), before, arguments)
        for text in [says] if isinstance(says, str) else says:
            self.assertIn(text, done.stderr, arguments)
        return done.stderr

    def rows(self, *arguments, **options):
        """Runs with text on stdout and returns the rows."""
        done = self.run_cli(*arguments, "-q", "-o", "-", **options)
        self.assertEqual(done.stderr, "")
        return done.stdout.splitlines()

    def json(self, *arguments, **options):
        return json.loads(self.run_cli(*arguments, "--json", **options).stdout)
