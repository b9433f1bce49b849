"""What clvotess promises on its command line, line by line.

VOTESS_CLI names the program. Most tests run it in an empty folder of their own and look at exit code, stdout, stderr
and the files that are left. Answers are compared with plain arithmetic here, and with Voro++ where it is installed.
"""

import io
import json
import os
import pty
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import zipfile
from pathlib import Path

import numpy as np

CLI = os.environ.get("VOTESS_CLI", "clvotess")
ROOT = Path(__file__).resolve().parents[2]
SANITIZED = bool(os.environ.get("VOTESS_TEST_REDUCED"))  # slow build, no foreign code in the process

JSON_KEYS = ["version", "device", "points", "faces", "mean_faces", "volume_sum", "box_volume", "duplicates",
             "empty_cells", "fallback_cells", "exact_cells", "threads", "seconds", "peak_memory_bytes", "verified"]
SECONDS_KEYS = ["total", "read", "upload", "sort", "knn", "clip", "fallback", "download", "write"]
OPTIONS = ["--random", "--rng-seed", "--output", "--format", "--want", "--walls", "--box", "--device", "--threads",
           "--grid-resolution", "--duplicates", "--verify", "--json", "--list-devices", "--version", "--quiet",
           "--help"]
SHORT_OPTIONS = ["-o", "-x", "-t", "-g", "-q", "-h"]

CUBE = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n"
CUBE_BOX = "-0.5,-0.5,-0.5,1.5,1.5,1.5"
CUBE_NEIGHBORS = [[1, 2, 4], [0, 3, 5], [0, 3, 6], [1, 2, 7], [0, 5, 6], [1, 4, 7], [2, 4, 7], [3, 5, 6]]


def random_points(count, seed=7):
    return np.random.default_rng(seed).random((count, 3))


def text_of(points, separator=" "):
    return "".join(separator.join(repr(float(x)) for x in row) + "\n" for row in points)


class CliTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

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

    def refuse(self, *arguments, says=(), stdin="", code=2):
        """Runs a bad call: the exit code, one line on stderr that names the place, nothing on stdout, no new file."""
        before = self.files()
        done = self.run_cli(*arguments, stdin=stdin, code=code)
        self.assertRegex(done.stderr, r"\Aclvotess: [^\n]+\n\Z", arguments)
        self.assertEqual(done.stdout, "", arguments)
        self.assertEqual(self.files(), before, arguments)
        for text in [says] if isinstance(says, str) else says:
            self.assertIn(text, done.stderr, arguments)
        return done.stderr

    def rows(self, *arguments, **options):
        """Runs with text on stdout; the rows."""
        done = self.run_cli(*arguments, "-q", "-o", "-", **options)
        self.assertEqual(done.stderr, "")
        return done.stdout.splitlines()

    def json(self, *arguments, **options):
        return json.loads(self.run_cli(*arguments, "--json", **options).stdout)


class Source(CliTest):
    def assert_reads(self, name, content, expected, ids=None):
        """A file gives these points, read back bit by bit, in this order."""
        self.put(name, content)
        rows = [row.split() for row in self.rows(name, "--format", "%i %q")]
        self.assertEqual([[float(x) for x in row[1:]] for row in rows], [list(map(float, p)) for p in expected])
        self.assertEqual([int(row[0]) for row in rows], list(range(len(expected))) if ids is None else ids)

    def test_text_separators_comments_and_line_ends(self):
        expected = [[1, 2, 3], [-4, 5.5, 6e-3], [0.1, 7, 8]]
        for content in ["1 2 3\n-4 5.5 6e-3\n.1 7 8\n",
                        "1,2,3\n-4,5.5,6e-3\n.1,7,8\n",
                        "1;2;3\n-4;5.5;6e-3\n.1;7;8",
                        "\t1\t2\t3\n-4\t5.5\t6e-3\n  .1  7  8  \n",
                        "# x y z\n\n1 , 2 ; 3 # first\n   \n#\n-4, 5.5, +6E-03\n0.1 7. 8\n\n",
                        "1 2 3\r\n-4 5.5 6e-3\r\n\r\n.1 7 8\r\n",
                        "\ufeff1 2 3\n-4 5.5 6e-3\n.1 7 8"]:
            for name in ["a.txt", "a.xyz", "a.csv", "A.TXT"]:
                with self.subTest(content=content, name=name):
                    self.assert_reads(name, content.encode(), expected)

    def test_text_keeps_every_bit(self):
        points = random_points(500) * [1e-300, 1, 1e15] + [0, 0, 1e15]
        points[:, 0] *= 1e300
        self.assert_reads("a.txt", text_of(points), points)

    def test_ids(self):
        big = 2**63 - 1
        self.assert_reads("a.txt", f"7 1 2 3\n{big} 4 5 6\n-{big} 7 8 9\n", [[1, 2, 3], [4, 5, 6], [7, 8, 9]],
                          [7, big, -big])

    def test_csv_line_of_names(self):
        self.assert_reads("a.csv", "x,y,z\n1,2,3\n4,5,6\n", [[1, 2, 3], [4, 5, 6]])
        self.assert_reads("a.csv", '# made by hand\n\n"ID";"X";"Y";"Z"\n9;1;2;3\n8;4;5;6\n', [[1, 2, 3], [4, 5, 6]],
                          [9, 8])
        self.assert_reads("a.csv", "pos x,pos y,pos z\n1,2,3\n", [[1, 2, 3]])
        self.assert_reads("a.csv", "x,y,z\n", [])
        self.refuse(self.put("a.csv", "x,y,z,id\n1,2,3,4\n"), says=["a.csv:2:", "'x' in column 1"])
        self.refuse(self.put("a.csv", "1,2,3\nx,y,z\n"), says=["a.csv:2:", "'x'"])
        self.refuse(self.put("a.csv", "1,2,oops\n1,2,3\n"), says=["a.csv:1:", "'oops'"])
        self.refuse(self.put("a.txt", "x y z\n1 2 3\n"), says=["a.txt:1:", "'x'"])

    def test_classic_xyz(self):
        classic = "2\n# anything, 1 2 3\nH 1 2 3\nHe 4 5 6\n"
        self.assert_reads("a.xyz", classic, [[1, 2, 3], [4, 5, 6]])
        self.assert_reads("a.xyz", "0\nempty\n", [])
        self.refuse(self.put("a.xyz", "3\n\nH 1 2 3\n"), says=["a.xyz:3:", "1 of the 3"])
        self.refuse(self.put("a.xyz", "1\n\nH 1 2 3\nH 1 2 4\n"), says=["a.xyz:4:", "more rows than the 1"])
        self.refuse(self.put("a.xyz", "1\n\nH 1 2\n"), says=["a.xyz:3:", "3 columns"])
        self.refuse(self.put("a.xyz", "1\n\nH 1 2 c\n"), says=["a.xyz:3:", "'c'"])
        self.refuse(self.put("a.txt", classic), says=["a.txt:1:", "1 column"])

    def test_npy(self):
        points = random_points(1000)
        for name, array in [("c.npy", points), ("f.npy", np.asfortranarray(points)),
                            ("c4.npy", points.astype("f4")), ("f4.npy", np.asfortranarray(points.astype("f4"))),
                            ("none.npy", np.zeros((0, 3))), ("one.npy", points[:1])]:
            with self.subTest(name):
                self.assert_reads(name, array, array.astype(float))
        for version in [(1, 0), (2, 0), (3, 0)]:
            with open(self.folder / "v.npy", "wb") as file:
                np.lib.format.write_array(file, points, version=version)
            self.assertEqual(len(self.rows("v.npy")), 1000)
        many = np.asfortranarray(random_points(70000))
        self.put("many.npy", many)
        self.put("many_c.npy", np.ascontiguousarray(many))
        self.assertEqual(self.rows("many.npy", "--format", "%q"), self.rows("many_c.npy", "--format", "%q"))

    def test_npy_refused(self):
        points = random_points(10)
        whole = io.BytesIO()
        np.save(whole, points)
        whole = whole.getvalue()
        record = np.zeros(3, dtype=[("x", "f8"), ("y", "f8"), ("z", "f8")])
        for content, says in [(points.astype(">f8"), ["big-endian", "'>f8'"]), (points.astype(">f4"), "big-endian"),
                              (points.astype("i8"), "'<i8'"), (points.astype("f2"), "'<f2'"), (record, "records"),
                              (points[:, :2], "(10, 2)"), (points.ravel(), "(30,)"), (np.float64(3), "()"),
                              (points.reshape(1, 10, 3), "(1, 10, 3)"), (points.reshape(5, 6), "(5, 6)"),
                              (whole[:-1], "239 bytes"), (whole + b"x", "241 bytes"), (whole[:50], "too early"),
                              (whole[:5], "not a .npy"), (b"", "not a .npy"), (b"1 2 3\n" * 9, "not a .npy"),
                              (b"\x93NUMPY\x09" + whole[7:], "version 9"),
                              (whole.replace(b"(10, 3)", b"(9999999999999999999, 3)").replace(b" " * 19 + b"\n", b" \n"),
                               "a.npy"),
                              (whole.replace(b"'shape'", b"'spahe'"), "'shape'"),
                              (whole.replace(b"'<f8'", b"x<f8x"), "type")]:
            with self.subTest(says=says):
                path = self.folder / "a.npy"
                path.unlink(missing_ok=True)
                self.put("a.npy", content if isinstance(content, bytes) else np.asarray(content))
                self.refuse("a.npy", "-o", "out.npz", says=["a.npy"] + ([says] if isinstance(says, str) else says))

    def test_stdin(self):
        self.put("a.txt", CUBE)
        self.assertEqual(self.rows("-", stdin=CUBE), self.rows("a.txt"))
        self.assertEqual(self.rows("-", stdin=""), [])
        self.refuse("-", "-o", "out.txt", stdin="1 2 3\n1 2\n", says=["stdin:2:", "2 columns"])
        long_text = text_of(random_points(40000))  # several times the first buffer
        self.assertEqual(len(self.rows("-", stdin=long_text)), 40000)

    def test_bad_rows_name_file_and_line(self):
        for content, line, says in [("1 2 3\n4 5 6\n7 8\n", 3, "2 columns"), ("1 2 3\n\n# c\n1 2 3 4\n", 4, "4 columns"),
                                    ("1 2 3\n1\n", 2, "1 column,"), ("1 2\n", 1, "2 columns"), ("1\n", 1, "1 column,"),
                                    ("1 2 3 4 5\n", 1, "radii"), ("1 2 3 4 5 6\n", 1, "6 columns"),
                                    ("1 2 3 4\n1 2 3 4 5\n", 2, "5 columns"),
                                    ("1 2 3\n4 five 6\n", 2, "'five'"), ("1 2 3x\n", 1, "'3x'"), ("1 2 0x3\n", 1, "'0x3'"),
                                    ("1 2 1e\n", 1, "'1e'"), ("1 2 --3\n", 1, "'--3'"), ("1 2 +-3\n", 1, "'+-3'"),
                                    ("1 2 3\n1,,2,3\n", 2, "column 2 is empty"), ("1,2,\n", 1, "column 3 is empty"),
                                    (",1,2,3\n", 1, "column 1 is empty"), ("1,2,;3\n", 1, "column 3 is empty"),
                                    ("1.5 1 2 3\n", 1, "'1.5'"), ("9223372036854775808 1 2 3\n", 1, "whole number"),
                                    ("a 1 2 3\n", 1, "'a'"), ("1 2 3\n1 2 \x00\x01\n", 2, "\\x00\\x01"),
                                    ("1 2 " + "y" * 5000 + "\n", 1, "yyy...'")]:
            for name in ["a.txt", "a.xyz"]:
                if name == "a.xyz" and content == "1\n":
                    continue  # the classic layout
                with self.subTest(content=content, name=name):
                    self.put(name, content)
                    self.refuse(name, "-o", "out.txt", says=[f"{name}:{line}: ", says])

    def test_nonfinite_is_refused_by_index_and_value(self):
        for word, shown in [("nan", "nan"), ("-inf", "inf"), ("inf", "inf"), ("1e999", "inf"), ("-1e999", "inf")]:
            with self.subTest(word):
                self.put("a.txt", f"1 2 3\n4 5 6\n7 {word} 9\n")
                message = self.refuse("a.txt", "-o", "out.npz", says=shown)
                self.assertRegex(message, r"\b2\b")
        array = random_points(9)
        array[4, 1] = np.nan
        self.put("a.npy", array)
        self.assertRegex(self.refuse("a.npy", "-o", "out.npz", says="nan"), r"\b4\b")

    def test_tiny_numbers_are_zero(self):
        self.assert_reads("a.txt", "1e-999 0 0\n1 1 1\n", [[0, 0, 0], [1, 1, 1]])

    def test_unreadable(self):
        self.refuse("absent.txt", says=["absent.txt", "No such file"])
        self.refuse("absent.npy", says=["absent.npy", "No such file"])
        for name in ["a.h5", "a.hdf5", "a", "a.dat"]:
            self.put(name, CUBE)
            self.refuse(name, says=[name, ".npy"])
        for name in ["folder.txt", "folder.npy"]:
            (self.folder / name).mkdir()
            self.refuse(name, says=name)
        self.refuse("", says="INPUT")
        if os.geteuid() != 0:
            self.put("closed.txt", CUBE)
            (self.folder / "closed.txt").chmod(0)
            self.refuse("closed.txt", says=["closed.txt", "Permission"])

    def test_empty_input_everywhere(self):
        self.put("a.txt", "# nothing\n")
        self.put("a.npy", np.zeros((0, 3), "f4"))
        for source in [["a.txt"], ["a.npy"], ["--random", "0"], ["-"]]:
            with self.subTest(source):
                summary = self.json(*source, "-o", "out.txt", "-o", "out.npz", "--verify", "--format", "%i %q %w %s %v %c %n",
                                    "--want", "neighbors,volumes,centroids")
                self.assertEqual((summary["points"], summary["mean_faces"], summary["verified"]), (0, 0, True))
                self.assertEqual((self.folder / "out.txt").read_text(), "")
                with np.load(self.folder / "out.npz") as arrays:
                    self.assertEqual(arrays["indptr"].tolist(), [0])
                    self.assertEqual(arrays["indices"].shape, (0,))
                    self.assertEqual(arrays["centroids"].shape, (0, 3))
                    self.assertEqual(arrays["volumes"].shape, (0,))
        self.assertIn("points", self.run_cli("a.txt").stdout)

    def test_random(self):
        rows = self.rows("--random", "2000", "--format", "%q %v")
        values = np.array([row.split() for row in rows], float)
        self.assertEqual(values.shape, (2000, 4))
        self.assertTrue(np.all((values[:, :3] >= 0) & (values[:, :3] < 1)))
        self.assertLess(np.max(np.abs(values[:, :3].mean(axis=0) - 0.5)), 0.03)
        self.assertAlmostEqual(values[:, 3].sum(), 1, places=12)
        # SplitMix64 from state 1, known from its reference code: the same on every machine.
        self.assertEqual(self.splitmix(1, 3), [float(x) for x in rows[0].split()[:3]])
        self.assertEqual(rows, self.rows("--random", "2000", "--rng-seed", "1", "--format", "%q %v"))
        self.assertEqual(self.rows("--random", "1", "--rng-seed", 2**64 - 1, "--format", "%q")[0].split(),
                         [repr(x) for x in self.splitmix(2**64 - 1, 3)])
        self.assertEqual(self.json("--random", "10")["box_volume"], 1)
        self.assertEqual(self.json("--random", "10", "--box", "-1,-1,-1,1,1,3")["box_volume"], 16)

    @staticmethod
    def splitmix(state, count):
        numbers = []
        for _ in range(count):
            state = (state + 0x9E3779B97F4A7C15) % 2**64
            z = state
            z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 % 2**64
            z = (z ^ z >> 27) * 0x94D049BB133111EB % 2**64
            numbers.append(((z ^ z >> 31) >> 11) / 2**53)
        return numbers


class Usage(CliTest):
    def test_bad_usage(self):
        self.put("a.txt", CUBE)
        self.put("b.txt", CUBE)
        for arguments, says in [([], "INPUT"), (["a.txt", "b.txt"], "'b.txt'"), (["a.txt", "--random", "5"], "not both"),
                                (["a.txt", "--rng-seed", "5"], "--rng-seed"), (["--rng-seed", "5"], "--random"),
                                (["--random", "-5"], "'-5'"), (["--random", "x"], "'x'"), (["--random", "1.5"], "'1.5'"),
                                (["--random", "2147483648"], "'2147483648'"), (["--random"], "--random"),
                                (["--random", "5", "--rng-seed", "-1"], "'-1'"),
                                (["a.txt", "--box", "0,0,0,1,1"], "--box"), (["a.txt", "--box", "0,0,0,1,1,z"], "'z'"),
                                (["a.txt", "--box", "0,0,0,1,1,1,1"], "--box"), (["a.txt", "--box", ""], "--box"),
                                (["a.txt", "--box"], "--box"), (["a.txt", "--box", "0,0,0,1,,1"], "''"),
                                (["a.txt", "-x", "gpu"], ["'gpu'", "CPU engine only"]),
                                (["a.txt", "--device", "lavapipe"], "CPU engine only"), (["a.txt", "-x", "0"], "'0'"),
                                (["a.txt", "-t", "-1"], "'-1'"), (["a.txt", "-t", "two"], "'two'"),
                                (["a.txt", "-t", "1025"], "1024"), (["a.txt", "-t", "1", "-t", "2"], "threads"),
                                (["a.txt", "-g", "-1"], "--grid-resolution"), (["a.txt", "-g", "1048577"], "1048576"),
                                (["a.txt", "-g", "99999999999999999999"], "--grid-resolution"),
                                (["a.txt", "--duplicates", "maybe"], "'maybe'"),
                                (["a.txt", "--want", "areas"], ["'areas'", "neighbors, volumes and centroids"]),
                                (["a.txt", "--want", "volumes,vertices"], "'vertices'"), (["a.txt", "--want", ""], "''"),
                                (["a.txt", "--format", "%i"], "text output"),
                                (["a.txt", "-o", "c.npz", "--format", "%i"], "text output"),
                                (["a.txt", "-o", "-", "--json"], "stdout"), (["a.txt", "-o", "-", "-o", "-"], "twice"),
                                (["a.txt", "--quiet=maybe"], "quiet"), (["a.txt", "-o"], "output")]:
            with self.subTest(arguments):
                self.refuse(*arguments, says=says)

    def test_options_of_later_versions_do_not_exist(self):
        self.put("a.txt", CUBE)
        for option in ["--periodic", "--cell=1", "--origin=1", "--wall=1,0,0,1", "--min-face=0", "--weights=1",
                       "--radii=1", "-k1", "--k-init=1", "--chunk-size=1", "--precision=single", "--image=a.png",
                       "--dataset=a", "--bogus", "-z"]:
            with self.subTest(option):
                self.refuse("a.txt", option, "-o", "out.txt", says=["unknown option", option.split("=")[0]])
        for name in ["a.h5", "a.vtu", "a.ply", "a.hdf5", "out", "out.csv"]:
            self.refuse("a.txt", "-o", name, says=[f"'{name}'", ".npz"])

    def test_bad_domain(self):
        self.put("a.txt", CUBE)
        message = self.refuse("a.txt", "-o", "out.npz", "--box", "-0.5,-0.5,-0.5,1.5,0.75,1.5", says="1")
        self.assertRegex(message, r"\b2\b")  # the first point outside
        for box in ["0,0,0,0,1,1", "0,0,0,1,-1,1", "0,0,nan,1,1,1", "0,0,0,1,1,inf", "0,0,0,1e999,1,1"]:
            self.refuse("a.txt", "-o", "out.npz", "--box", box, says="box")
            self.refuse("--random", "0", "-o", "out.npz", f"--box={box}", says="box")
        self.assertEqual(self.json("a.txt", f"--box={CUBE_BOX}")["box_volume"], 8)
        self.assertEqual(self.json("a.txt", "--box", CUBE_BOX)["box_volume"], 8)
        self.assertEqual(self.json("a.txt", "--box", "0,0,0,1,1,1")["box_volume"], 1)

    def test_default_box(self):
        points = random_points(64) * [2, 1, 1]
        self.put("a.npy", points)
        sides = np.ptp(points, axis=0) + np.ptp(points, axis=0).max() / 4
        self.assertAlmostEqual(self.json("a.npy")["box_volume"], sides.prod(), places=12)

    def test_duplicates(self):
        self.put("a.txt", CUBE + "0 1 0\n0 0 0\n")
        summary = self.json("a.txt", "-o", "out.npz", "--box", CUBE_BOX)
        self.assertEqual((summary["duplicates"], summary["empty_cells"]), (2, 2))
        with np.load(self.folder / "out.npz") as arrays:
            self.assertEqual(arrays["duplicate_of"].tolist(), [-1] * 8 + [2, 0])
            self.assertEqual(arrays["duplicate_of"].dtype, np.int32)
            self.assertEqual(arrays["status"].tolist(), [0] * 8 + [5, 5])
            self.assertEqual(arrays["volumes"].tolist(), [1] * 8 + [0, 0])
        rows = self.rows("a.txt", "--box", CUBE_BOX, "--format", "%i|%n|%v|%s|%w|%c")
        self.assertEqual(rows[0], "0|1 2 4|1|6|8|0 0 0")
        self.assertEqual(rows[8], "8||0|0|0|nan nan nan")
        (self.folder / "out.npz").unlink()
        message = self.refuse("a.txt", "-o", "out.npz", "--duplicates", "error")
        self.assertRegex(message, r"\b8\b")
        self.assertRegex(message, r"\b2\b")
        self.assertEqual(self.rows("a.txt", "--duplicates", "merge"), self.rows("a.txt"))

    def test_tuning_never_changes_the_answer(self):
        arguments = ["--random", "3000", "--format", "%i %n"]
        expected = self.rows(*arguments)
        for option in [["-t", "1"], ["--threads=3"], ["-t0"], ["-g", "1"], ["--grid-resolution", "40"], ["-g", "0"],
                       ["-x", "cpu"], ["--device", "auto"], ["-xauto"]]:
            self.assertEqual(self.rows(*arguments, *option), expected, option)
        self.assertEqual(self.json("--random", "3000", "-t", "1")["threads"], 1)

    def test_help_is_true_and_complete(self):
        for option in ["-h", "--help"]:
            done = self.run_cli(option)
            self.assertEqual(done.stderr, "")
        text = done.stdout
        self.assertEqual(set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", text)), set(OPTIONS))
        for option in SHORT_OPTIONS:
            self.assertRegex(text, rf"(?m)^  {option}, --")
        for code in "ixyzqwsnvc%":
            self.assertIn("%" + code, text)
        for word in ["units", "exit codes", ".xyz", ".txt", ".csv", ".npy", ".npz", "stdin", "stdout", "default"]:
            self.assertIn(word, text)
        self.assertLessEqual(max(map(len, text.splitlines())), 100)
        # The example runs as it stands, with fewer points.
        example = next(line for line in text.splitlines() if line.startswith("  clvotess --random 1000000"))
        example = example.strip().replace("1000000", "1000").replace("clvotess", f'"{CLI}"', 1)
        subprocess.run(example, shell=True, cwd=self.folder, check=True, capture_output=True)
        self.assertEqual(len((self.folder / "cells.txt").read_text().splitlines()), 1000)

    def test_readme_names_only_options_that_exist(self):
        readme = ROOT / "README.md"
        if not readme.exists():
            self.skipTest("no README.md")
        commands = re.findall(r"clvotess [^\n`]*", readme.read_text())
        self.assertTrue(commands)
        for command in commands:
            for option in re.findall(r"(?<=\s)--[a-z][a-z-]*", command):
                self.assertIn(option, OPTIONS, command)

    def test_version(self):
        done = self.run_cli("--version")
        self.assertRegex(done.stdout, r"\Aclvotess \d+\.\d+\.\d+\n\Z")
        self.assertEqual(done.stdout.split()[1], self.json("--random", "5")["version"])

    def test_list_devices(self):
        lines = self.run_cli("--list-devices").stdout.splitlines()
        self.assertIn("cpu", [line.split()[0] for line in lines])

    def test_summary_on_stdout(self):
        text = self.run_cli("--random", "1000").stdout
        for word in ["points        1000\n", "mean faces", "volume sum", "exact", "thread", "seconds", "peak memory"]:
            self.assertIn(word, text)
        self.assertLess(len(text.splitlines()), 16)
        self.assertNotIn("volume sum", self.run_cli("--random", "9", "--want", "neighbors").stdout)
        quiet = self.run_cli("--random", "1000", "-q")
        self.assertEqual(quiet.stdout + quiet.stderr, "")
        self.assertEqual(self.run_cli("--random", "1000", "--quiet").stdout, "")

    def test_summary_gives_way_to_text_on_stdout(self):
        done = self.run_cli("--random", "10", "-o", "-")
        self.assertEqual(len(done.stdout.splitlines()), 10)
        self.assertIn("mean faces", done.stderr)

    def test_json(self):
        started = time.monotonic()
        done = self.run_cli("--random", "20000", "--json", "-q", "-o", "out.txt")
        elapsed = time.monotonic() - started
        self.assertEqual(done.stdout.count("\n"), 1)
        self.assertEqual(done.stderr, "")
        summary = json.loads(done.stdout)
        self.assertEqual(list(summary), JSON_KEYS)
        self.assertEqual(list(summary["seconds"]), SECONDS_KEYS)
        seconds = summary["seconds"]
        self.assertTrue(all(isinstance(value, (int, float)) and value >= 0 for value in seconds.values()))
        stages = sum(value for key, value in seconds.items() if key != "total")
        self.assertLessEqual(stages, seconds["total"] * 1.001 + 1e-4)
        self.assertLessEqual(seconds["total"], elapsed)
        self.assertGreater(seconds["clip"], 0)
        self.assertGreater(seconds["write"], 0)
        self.assertEqual((summary["points"], summary["duplicates"], summary["empty_cells"], summary["fallback_cells"]),
                         (20000, 0, 0, 0))
        self.assertAlmostEqual(summary["volume_sum"], 1, places=10)
        self.assertAlmostEqual(summary["mean_faces"], summary["faces"] / 20000)
        self.assertTrue(14 < summary["mean_faces"] < 15.6)
        self.assertIsNone(summary["verified"])
        self.assertGreater(summary["peak_memory_bytes"], 1e6)
        self.assertGreaterEqual(summary["threads"], 1)
        self.assertIsInstance(summary["device"], str)
        self.assertIsNone(self.json("--random", "9", "--want", "neighbors")["volume_sum"])
        self.assertIsNone(self.json("--random", "9", "--want", "neighbors", "--verify")["volume_sum"])

    def test_lattice_needs_exact_arithmetic(self):
        self.put("a.txt", CUBE)
        self.assertGreater(self.json("a.txt", "--box", CUBE_BOX)["exact_cells"], 0)

    def test_verify(self):
        for extra in [[], ["--walls"], ["--want", "neighbors"], ["--want", "volumes", "-o", "out.npz"], ["-t", "1"]]:
            self.assertIs(self.json("--random", "5000", "--verify", *extra)["verified"], True)
        self.assertRegex(self.run_cli("--random", "500", "--verify").stdout, r"(?m)^verified +yes$")
        with np.load(self.folder / "out.npz") as arrays:
            self.assertNotIn("indices", arrays.files)  # computed for the check, not asked for

    @unittest.skipIf(SANITIZED, "a preloaded library and a sanitizer exclude each other")
    def test_failed_verification(self):
        compiler = shutil.which(os.environ.get("CXX", "c++"))
        if not compiler or b"libvotess.so" not in Path(shutil.which(CLI)).read_bytes():
            self.skipTest("needs a compiler and a shared libvotess")
        with tempfile.TemporaryDirectory() as build:
            # What the library would say about a wrong result.
            (Path(build) / "votess").mkdir()
            (Path(build) / "votess/version.hpp").write_text("")
            (Path(build) / "false.cpp").write_text(
                "#include <votess/votess.hpp>\n"
                "votess::VerifyReport votess::verify(const Tessellation&, std::span<const double>, const VerifyOptions&)"
                "{ return {false, \"seed 3 lists 5\\nbut not back\", {}}; }\n")
            library = Path(build) / "false.so"
            subprocess.run([compiler, "-std=c++20", "-shared", "-fPIC", f"-I{ROOT / 'include'}", f"-I{build}",
                            str(Path(build) / "false.cpp"), "-o", str(library)], check=True)
            done = self.run_cli("--random", "50", "--verify", "--json", "-o", "out.txt", "-o", "out.npz", code=3,
                                env=dict(os.environ, LD_PRELOAD=str(library)))
        self.assertIs(json.loads(done.stdout)["verified"], False)
        self.assertRegex(done.stderr, r"\Aclvotess: verification failed[^\n]*seed 3 lists 5 but not back\n\Z")
        self.assertEqual(self.files(), [])


class TextOutput(CliTest):
    def test_default_format(self):
        self.put("a.txt", CUBE)
        expected = [f"{i} " + " ".join(map(str, row)) for i, row in enumerate(CUBE_NEIGHBORS)]
        self.run_cli("a.txt", "--box", CUBE_BOX, "-o", "out.txt")
        self.assertEqual((self.folder / "out.txt").read_text(), "\n".join(expected) + "\n")
        self.assertEqual(self.rows("a.txt", "--box", CUBE_BOX), expected)
        self.assertEqual(self.rows("a.txt", "--box", CUBE_BOX, "--format", "%i %n"), expected)

    def test_codes(self):
        self.put("a.txt", CUBE)
        row = self.rows("a.txt", "--box", CUBE_BOX, "--format", "i=%i x=%x y=%y z=%z q=%q w=%w s=%s n=%n v=%v c=%c 5%%n\t.")[5]
        self.assertEqual(row, "i=5 x=1 y=0 z=1 q=1 0 1 w=8 s=6 n=1 4 7 v=1 c=0 0 0 5%n\t.")
        self.assertEqual(self.rows("a.txt", "--format", "%%i"), ["%i"] * 8)
        self.assertEqual(self.rows("a.txt", "--format", "%n%i", "--box", CUBE_BOX)[0], "1 2 40")

    def test_bad_codes(self):
        self.put("a.txt", CUBE)
        for form, says in [("%i %k", "'%k'"), ("%r", "'%r'"), ("%", "%%"), ("%i %", "%%"), ("", "empty"), ("% i", "'% '"),
                           ("%I", "'%I'"), ("%i\n%n", "line end")]:
            self.refuse("a.txt", "-o", "out.txt", "--format", form, says=["--format", says])

    def test_walls(self):
        self.put("a.txt", CUBE)
        rows = self.rows("a.txt", "--box", CUBE_BOX, "--walls", "--format", "%n")
        for i, row in enumerate(rows):
            walls = [-5 - (i >> 2), -3 - (i >> 1 & 1), -1 - (i & 1)]
            self.assertEqual([int(j) for j in row.split()], walls + CUBE_NEIGHBORS[i])
        self.run_cli("a.txt", "--box", CUBE_BOX, "--walls", "-o", "out.npz")
        with np.load(self.folder / "out.npz") as arrays:
            self.assertEqual(arrays["indices"][:6].tolist(), [-5, -3, -1, 1, 2, 4])

    def test_ids_name_rows_and_neighbors(self):
        ids = [50, 2**62, -3, 7, 1000, -1, 8, 9]
        self.put("a.txt", "".join(f"{i} {row}\n" for i, row in zip(ids, CUBE.splitlines())))
        rows = self.rows("a.txt", "--box", CUBE_BOX, "--format", "%i:%n")
        self.assertEqual(rows, [f"{ids[i]}:" + " ".join(map(str, sorted(ids[j] for j in row)))
                                for i, row in enumerate(CUBE_NEIGHBORS)])
        rows = self.rows("a.txt", "--box", CUBE_BOX, "--format", "%n", "--walls")
        self.assertEqual(rows[0], "-5 -3 -1 " + " ".join(map(str, sorted(ids[j] for j in CUBE_NEIGHBORS[0]))))
        # Arrays are about rows: indices, not ids.
        self.run_cli("a.txt", "--box", CUBE_BOX, "-o", "out.npz")
        with np.load(self.folder / "out.npz") as arrays:
            self.assertEqual(arrays["indices"].tolist(), sum(CUBE_NEIGHBORS, []))

    def test_numbers_read_back(self):
        points = random_points(300)
        self.put("a.npy", points)
        rows = [row.split() for row in self.rows("a.npy", "--format", "%q %x %y %z %v %c")]
        self.run_cli("a.npy", "-o", "out.npz", "--want", "volumes,centroids")
        values = np.array(rows, float)
        np.testing.assert_array_equal(values[:, :3], points)
        np.testing.assert_array_equal(values[:, 3:6], points)
        with np.load(self.folder / "out.npz") as arrays:
            np.testing.assert_array_equal(values[:, 6], arrays["volumes"])
            np.testing.assert_array_equal(values[:, 7:], arrays["centroids"] - points)
        for row in rows:  # the fewest digits: as many as Python's repr has
            for text in row:
                self.assertEqual(len(re.findall(r"\d", re.sub(r"e.*", "", text).lstrip("0.").replace("-", ""))) > 17, False)
                self.assertLessEqual(len(text), len(repr(float(text))) + 1)

    def test_against_voropp(self):
        voropp = shutil.which("voro++")
        if not voropp:
            self.skipTest("no voro++")
        self.put("v", "".join(f"{i} {row}" for i, row in enumerate(text_of(random_points(400)).splitlines(True))))
        shutil.copy(self.folder / "v", self.folder / "v.txt")
        subprocess.run([voropp, "-c", "%i|%q|%w|%s|%n|%v|%c", *"0 1 0 1 0 1 v".split()], cwd=self.folder, check=True,
                       capture_output=True)
        rows = self.rows("v.txt", "--walls", "--box", "0,0,0,1,1,1", "--format", "%i|%q|%w|%s|%n|%v|%c")
        theirs = {int(row.split("|")[0]): row.split("|") for row in (self.folder / "v.vol").read_text().splitlines()}
        self.assertEqual(len(theirs), 400)
        for row in rows:
            mine = row.split("|")
            other = theirs[int(mine[0])]
            self.assertEqual(mine[2:4], other[2:4])
            self.assertEqual(sorted(map(int, mine[4].split())), sorted(map(int, other[4].split())))
            for column in [1, 5, 6]:
                np.testing.assert_allclose(np.array(mine[column].split(), float), np.array(other[column].split(), float),
                                           rtol=1e-4, atol=1e-6)

    def test_rows_longer_than_usual(self):
        # One seed inside a sphere of many: a row of thousands of neighbors.
        count = 3000
        i = np.arange(count) + 0.5
        z, angle = 1 - 2 * i / count, np.pi * (1 + 5**0.5) * i
        radius = np.sqrt(1 - z * z)
        sphere = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
        self.put("a.npy", np.vstack([[0, 0, 0], sphere]))
        text = self.rows("a.npy", "--format", "%n " + "x" * 100)
        self.assertGreater(len(text[0].split()), 2000)
        self.assertEqual(len(text), count + 1)


class ArrayOutput(CliTest):
    def load(self, *arguments):
        self.run_cli(*arguments, "-o", "out.npz")
        with np.load(self.folder / "out.npz", allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}

    def test_arrays(self):
        count = 2000
        arrays = self.load("--random", count, "--want", "neighbors,volumes,centroids")
        self.assertEqual({name: (array.dtype.str, array.shape[1:]) for name, array in arrays.items()},
                         {"indptr": ("<i8", ()), "indices": ("<i4", ()), "volumes": ("<f8", ()),
                          "centroids": ("<f8", (3,)), "status": ("|u1", ())})
        indptr, indices = arrays["indptr"], arrays["indices"]
        self.assertEqual((len(indptr), indptr[0], indptr[-1]), (count + 1, 0, len(indices)))
        for name in ["volumes", "centroids", "status"]:
            self.assertEqual(len(arrays[name]), count)
        self.assertAlmostEqual(arrays["volumes"].sum(), 1, places=12)
        np.testing.assert_allclose(arrays["volumes"] @ arrays["centroids"], [0.5] * 3, rtol=1e-12)
        rows = [set(indices[indptr[i]:indptr[i + 1]].tolist()) for i in range(count)]
        self.assertTrue(all(i in rows[j] for i, row in enumerate(rows) for j in row))
        text = [[int(j) for j in row.split()] for row in self.rows("--random", count, "--format", "%n")]
        self.assertEqual(sum(text, []), indices.tolist())

    def test_only_what_is_wanted(self):
        for want, names in [([], ["indptr", "indices", "volumes", "status"]),
                            (["--want", "neighbors"], ["indptr", "indices", "status"]),
                            (["--want", "volumes"], ["volumes", "status"]),
                            (["--want=centroids,volumes"], ["volumes", "centroids", "status"])]:
            self.assertEqual(sorted(self.load("--random", "50", *want)), sorted(names))
        # Text that needs more adds it.
        self.run_cli("--random", "50", "--want", "volumes", "-o", "cells.txt", "--format", "%n %c %w")
        self.assertEqual(len((self.folder / "cells.txt").read_text().splitlines()), 50)

    def test_archive_is_sound_and_repeatable(self):
        self.load("--random", "1000")
        with zipfile.ZipFile(self.folder / "out.npz") as archive:
            self.assertIsNone(archive.testzip())
            self.assertEqual({info.compress_type for info in archive.infolist()}, {zipfile.ZIP_STORED})
        first = (self.folder / "out.npz").read_bytes()
        self.load("--random", "1000", "-t", "1")
        with np.load(io.BytesIO(first)) as old, np.load(self.folder / "out.npz") as new:
            np.testing.assert_array_equal(old["indices"], new["indices"])
        unzip = shutil.which("unzip")
        if unzip:
            subprocess.run([unzip, "-tq", str(self.folder / "out.npz")], check=True, capture_output=True)

    def test_zip64(self):
        """The same code with the limit at 100 bytes instead of 4 GiB, so that every kind of record occurs."""
        compiler = shutil.which(os.environ.get("CXX", "c++"))
        if not compiler:
            self.skipTest("no compiler")
        self.put("driver.cpp", """
            #include <array>
            #include "atomic_file.hpp"
            #include "zip_writer.hpp"
            int main() {
                const std::string small(99, 's'), large(100, 'l');
                clvotess::OutputFile file("out.npz");
                clvotess::ZipWriter zip(file, 100);
                zip.add("small", std::array<std::string_view, 2>{small, ""});
                zip.add("large", std::array<std::string_view, 2>{large, large});
                zip.add("later", std::array<std::string_view, 1>{small});
                zip.finish();
                file.finish();
                file.publish();
            }""")
        sources = [ROOT / "cli" / name for name in ["zip_writer.cpp", "atomic_file.cpp", "interrupt.cpp", "numbers.cpp"]]
        subprocess.run([compiler, "-std=c++20", f"-I{ROOT / 'cli'}", "driver.cpp", *map(str, sources), "-lz", "-o", "driver"],
                       cwd=self.folder, check=True)
        subprocess.run(["./driver"], cwd=self.folder, check=True)
        content = (self.folder / "out.npz").read_bytes()
        self.assertEqual(content.count(b"PK\x06\x06"), 1)
        with zipfile.ZipFile(self.folder / "out.npz") as archive:
            self.assertIsNone(archive.testzip())
            self.assertEqual([archive.read(name) for name in ["small", "large", "later"]], [b"s" * 99, b"l" * 200, b"s" * 99])
        unzip = shutil.which("unzip")
        if unzip:
            subprocess.run([unzip, "-tq", str(self.folder / "out.npz")], check=True, capture_output=True)


class Files(CliTest):
    def test_several_outputs(self):
        self.run_cli("--random", "20", "-o", "a.txt", "--output", "b.npz", "--output=c.TXT", "-od.txt")
        self.assertEqual(self.files(), ["a.txt", "b.npz", "c.TXT", "d.txt"])
        self.assertEqual((self.folder / "a.txt").read_text(), (self.folder / "c.TXT").read_text())
        done = self.run_cli("--random", "20", "-o", "-", "-o", "e.txt", "-q")
        self.assertEqual(done.stdout, (self.folder / "e.txt").read_text())

    def test_replaces_whole_and_keeps_permissions(self):
        self.put("out.txt", "old\n" * 100000)
        (self.folder / "out.txt").chmod(0o640)
        self.run_cli("--random", "5", "-o", "out.txt")
        self.assertEqual(len((self.folder / "out.txt").read_text().splitlines()), 5)
        self.assertEqual((self.folder / "out.txt").stat().st_mode & 0o777, 0o640)
        umask = os.umask(0)
        os.umask(umask)
        self.run_cli("--random", "5", "-o", "new.txt")
        self.assertEqual((self.folder / "new.txt").stat().st_mode & 0o777, 0o666 & ~umask)
        (self.folder / "link.txt").symlink_to("out.txt")
        self.run_cli("--random", "6", "-o", "link.txt")
        self.assertTrue((self.folder / "link.txt").is_symlink())
        self.assertEqual(len((self.folder / "out.txt").read_text().splitlines()), 6)

    def test_bad_input_leaves_old_output_alone(self):
        self.put("out.txt", "old\n")
        self.put("a.txt", "1 2 3\n1 2\n")
        self.refuse("a.txt", "-o", "out.txt")
        self.put("a.txt", "1 2 3\n1 2 nan\n")
        self.refuse("a.txt", "-o", "out.txt")
        self.assertEqual((self.folder / "out.txt").read_text(), "old\n")

    def test_bad_outputs(self):
        self.put("a.txt", CUBE)
        (self.folder / "folder.txt").mkdir()
        self.refuse("a.txt", "-o", "absent/out.txt", says=["absent/out.txt", "no folder"])
        self.refuse("a.txt", "-o", "folder.txt", says=["folder.txt", "folder"])
        self.refuse("a.txt", "-o", "a.txt/out.txt", says="a.txt/out.txt")
        self.refuse("a.txt", "-o", "out.npz", "-o", "./out.npz", says="twice")
        self.refuse("a.txt", "-o", "a.txt", says=["a.txt", "is the input"])
        self.refuse("a.txt", "-o", "folder.txt/../a.txt", says="is the input")
        self.refuse("a.txt", "-o", "", says="''")
        self.assertEqual((self.folder / "a.txt").read_text(), CUBE)
        if os.geteuid() != 0:
            self.put("closed.txt", "old")
            (self.folder / "closed.txt").chmod(0o400)
            self.refuse("a.txt", "-o", "closed.txt", says=["closed.txt", "Permission"])

    def test_special_files(self):
        self.run_cli("--random", "20", "-o", "/dev/null")
        self.assertEqual(self.run_cli("--random", "20", "-q", "-o", "/dev/stdout").stdout.count("\n"), 20)
        self.assertTrue(Path("/dev/null").is_char_device())

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_full_disk(self):
        for extra in [[], ["-o", "out.npz"], ["--format", "%q"]]:
            message = self.refuse("--random", "50", *extra, "-o", "/dev/full", code=1)
            self.assertIn("/dev/full", message)
            self.assertIn("No space", message)
        (self.folder / "full.npz").symlink_to("/dev/full")
        self.refuse("--random", "50", "-o", "full.npz", code=1, says="No space")
        with open("/dev/full", "w") as full:
            for arguments in [["-o", "-"], ["--json"], []]:
                done = subprocess.run([CLI, "--random", "50", *arguments], stdout=full, stderr=subprocess.PIPE, text=True,
                                      check=False)
                self.assertEqual(done.returncode, 1)
                self.assertIn("clvotess: cannot write to stdout: No space", done.stderr.splitlines()[-1])

    def test_disk_that_fills_up(self):
        # A limit on the size of files stands in for a small disk; its signal is ignored, so that write() fails.
        def limit():
            import resource
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        for name in ["out.txt", "out.npz"]:
            done = self.run_cli("--random", "2000", "-o", name, code=1, preexec_fn=limit, restore_signals=False)
            self.assertRegex(done.stderr, rf"\Aclvotess: cannot write '{name}'[^\n]*\n\Z")
            self.assertEqual(self.files(), [])

    def test_reader_that_leaves(self):
        process = self.start("--random", "50000", "-q", "-o", "-", "-o", "out.txt", stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE)
        process.stdout.readline()
        process.stdout.close()
        message = process.stderr.read().decode()
        process.stderr.close()
        self.assertEqual(process.wait(60), 1)
        self.assertIn("clvotess: cannot write to stdout: Broken pipe", message)
        self.assertEqual(self.files(), [])

    def test_closed_stdout_does_not_spoil_files(self):
        command = f'"{CLI}" --random 20 -o out.txt >&-'
        done = subprocess.run(["sh", "-c", command], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("stdout", done.stderr)
        for line in (self.folder / "out.txt").read_text().splitlines():
            self.assertRegex(line, r"\A[0-9 ]+\Z")

    def interrupt(self, process, ready):
        deadline = time.monotonic() + 60
        while not ready() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        error = process.stderr.read().decode()
        process.stderr.close()
        self.assertEqual(process.wait(60), 130, error)
        self.assertRegex(error, r"\Aclvotess: [^\n]*\n\Z")

    def test_interrupt_while_tessellating(self):
        process = self.start("--random", 1000000 if SANITIZED else 300000, "-t", "1", "-q", "-o", "out.npz",
                             stderr=subprocess.PIPE)
        began = time.monotonic()
        self.interrupt(process, lambda: time.monotonic() - began > 1.5)
        self.assertEqual(self.files(), [])

    def test_interrupt_while_writing(self):
        os.mkfifo(self.folder / "pipe")  # without a reader: opening it waits
        process = self.start("--random", "1000", "-q", "-o", "out.txt", "-o", "pipe", stderr=subprocess.PIPE)
        self.interrupt(process, lambda: len(self.files()) > 1 and time.sleep(0.3) is None)
        self.assertEqual(self.files(), ["pipe"])

    def progress_of(self, *arguments):
        """What a terminal on stderr is shown."""
        terminal, stderr = pty.openpty()
        process = self.start(*arguments, stdout=subprocess.DEVNULL, stderr=stderr)
        os.close(stderr)
        shown = b""
        while True:
            try:
                select.select([terminal], [], [], 60)
                piece = os.read(terminal, 65536)
            except OSError:  # the other end is closed
                break
            if not piece:
                break
            shown += piece
        os.close(terminal)
        self.assertEqual(process.wait(60), 0)
        return shown.decode()

    def test_progress(self):
        long = ["--random", 60000 if SANITIZED else 60000, "-t", "1", "--want", "volumes"]
        shown = self.progress_of(*long)
        self.assertRegex(shown, r"\r\[#*\.*\] +\d+ %")
        percents = [int(text) for text in re.findall(r"(\d+) %", shown)]
        self.assertEqual(percents, sorted(percents))
        self.assertTrue(shown.endswith("\r\x1b[K"))
        self.assertEqual(self.progress_of("--random", "1000"), "")
        self.assertEqual(self.progress_of(*long, "-q"), "")
        self.assertEqual(self.run_cli(*long).stderr, "")


if __name__ == "__main__":
    if not shutil.which(CLI):
        sys.exit(f"VOTESS_CLI must name clvotess, but there is no {CLI}")
    unittest.main(verbosity=2)
