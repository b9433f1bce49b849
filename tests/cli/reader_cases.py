"""Files of every kind that clvotess reads, written by NumPy, h5py or by hand, intact and damaged."""

import contextlib
import gzip
import io
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import time
import zipfile

import numpy as np

from cli_test import CLI, ROOT, SANITIZED, CliTest, random_points, text_of

MEMORY_LIMIT = [] if SANITIZED or not shutil.which("prlimit") else ["prlimit", f"--as={2**33}"]
FUZZ = int(os.environ.get("VOTESS_FUZZ_FILES", "1"))  # factor for the number of damaged files


class ReaderTest(CliTest):
    def read(self, name, *arguments):
        """Returns the points and the ids of a file."""
        rows = [row.split() for row in self.rows(name, *arguments, "--format", "%i %q")]
        return np.array([row[1:] for row in rows], float).reshape(-1, 3), [int(row[0]) for row in rows]

    def assert_points(self, name, points, *arguments, ids=None):
        got, got_ids = self.read(name, *arguments)
        np.testing.assert_array_equal(got, points, name)
        self.assertEqual(got_ids, list(range(len(points))) if ids is None else list(ids), name)

    def assert_column(self, name, values, column, *arguments):
        """Asserts the values that --radii reads from a file, as %r prints them."""
        rows = self.rows(name, "--radii", column, *arguments, "--format", "%r")
        np.testing.assert_array_equal(np.array(rows, float), values, name)

    def damage_program(self, name, tries=20 * FUZZ):
        """Asserts that damaged files give exit code 0 or 2, with at most one line. This is for readers that use foreign
        code, which runs in a separate process; tests/fuzz/readers/ tests all readers."""
        content = (self.folder / name).read_bytes()
        cuts = sorted({0, 1, len(content) - 1} | {len(content) * k // tries for k in range(tries)})
        cases = [(f"cut to {cut}", content[:cut]) for cut in cuts]
        generator = random.Random(name)
        for k in range(4 * tries):
            at = generator.randrange(min(len(content), 2000) if k % 4 else len(content))
            damaged = bytearray(content)
            damaged[at] ^= 1 << generator.randrange(8) if k % 2 else 0xFF
            cases.append((f"byte {at}", bytes(damaged)))
        refused = 0
        environment = dict(os.environ, ASAN_OPTIONS="detect_leaks=0:handle_sigill=2")  # in foreign code
        for what, damaged in cases:
            (self.folder / name).write_bytes(damaged)
            done = subprocess.run([*MEMORY_LIMIT, CLI, name, "-q", "-t", "1", "-x", "cpu"], cwd=self.folder,
                                  capture_output=True, timeout=60, check=False, env=environment)
            message = done.stderr.decode(errors="replace")
            self.assertIn(done.returncode, [0, 2], f"{name}, {what}: {message}")
            self.assertRegex(message, r"\A(clvotess: [^\n]+\n)?\Z", what)
            refused += done.returncode == 2
        self.assertGreater(refused, tries // 2)  # a cut may remove only unneeded bytes, such as a line end


class ArrayFiles(ReaderTest):
    def test_npz(self):
        points = random_points(500)
        for save in [np.savez, np.savez_compressed]:
            with self.subTest(save.__name__):
                save(self.folder / "a.npz", points=points, other=points[:5], velocities=points * 2)
                self.assert_points("a.npz", points)
                self.assert_points("a.npz", points * 2, "--dataset", "velocities")
                save(self.folder / "b.npz", anything=points.astype("f4"), mass=points[:, 0])
                self.assert_points("b.npz", points.astype("f4"))
                save(self.folder / "c.npz", x=points[:, 0], y=points[:, 1].astype("f4"), z=points[:, 2],
                     ids=np.arange(500)[::-1])
                expected = np.stack([points[:, 0], points[:, 1].astype("f4"), points[:, 2]], axis=1)
                self.assert_points("c.npz", expected, ids=range(499, -1, -1))
                save(self.folder / "f.npz", points=np.asfortranarray(points), id=np.arange(500, dtype="u4") + 7)
                self.assert_points("f.npz", points, ids=range(7, 507))
                save(self.folder / "none.npz", points=np.zeros((0, 3)))
                self.assert_points("none.npz", np.zeros((0, 3)))
                save(self.folder / "r.npz", points=points, radii=points[:, 0] / 50, k=np.arange(500))
                self.assert_column("r.npz", points[:, 0] / 50, "radii")
                self.assert_column("r.npz", np.arange(500), "k")
        # Large enough for several pieces of zlib and of the conversion.
        many = random_points(50000).astype("f4")
        np.savez_compressed(self.folder / "many.npz", points=np.asfortranarray(many))
        self.assert_points("many.npz", many)
        # clvotess reads its own files, with and without zip64.
        self.run_cli("--random", 300, "-o", "own.npz", "-o", "own.h5", "--want", "centroids,security_radii")
        for name in ("own.npz", "own.h5"):  # the word is not the name of an array
            self.refuse(name, "--weights", "radii", says=["'radii'", "security_radii"])
        with np.load(self.folder / "own.npz") as arrays:
            self.assert_points("own.npz", arrays["centroids"])
        with zipfile.ZipFile(self.folder / "z64.npz", "w") as archive:
            whole = io.BytesIO()
            np.save(whole, points)
            with archive.open("points.npy", "w", force_zip64=True) as member:
                member.write(whole.getvalue())
        self.assert_points("z64.npz", points)

    def test_numbers_of_any_type_and_order(self):
        """Points, ids, columns and domains. Those of NumPy are as astype() makes them."""
        points = np.concatenate([random_points(200), [(2.0**-24, 2.0**-14, 0.25)]])  # the first two: the least of float16
        ids, cell = np.arange(201) % 100, np.diag([3, 2, 5])
        for order in "<>":
            for kind in ("f2", "f4", "f8"):
                with self.subTest(order + kind):
                    some = points.astype(order + kind)
                    np.savez(self.folder / "a.npz", points=some, radii=some[:, 0])
                    self.assert_points("a.npz", some.astype(float))
                    self.assert_column("a.npz", some[:, 0].astype(float), "radii")
                    np.save(self.folder / "a.npy", np.asfortranarray(some))
                    self.assert_points("a.npy", some.astype(float))
            for kind in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f2", "f4", "f8"):
                with self.subTest(order + kind):
                    more = {} if kind[0] == "f" else {"ids": ids.astype(order + kind)}
                    np.savez(self.folder / "a.npz", points=points, k=ids.astype(order + kind), **more,
                             box=np.array([(0, 0, 0), (3, 2, 5)], order + kind), periodic=np.ones(3, bool),
                             cell=cell.astype(order + kind), origin=np.zeros(3, order + kind))
                    self.assert_points("a.npz", points, **({"ids": ids} if more else {}))
                    self.assert_column("a.npz", ids, "k")
                    self.assertEqual(self.json("a.npz")["box_volume"], 30)
        np.savez(self.folder / "a.npz", points=points, ids=np.full(201, 2**63, ">u8"))
        self.refuse("a.npz", says="number 0 = 9223372036854775808 is too large for int64")
        np.save(self.folder / "a.npy", np.array([np.inf, -np.inf, np.nan], ">f2").repeat(3).reshape(3, 3))
        self.refuse("a.npy", says="point 0: x = inf")

    def test_npz_domains(self):
        """`box` states the domain; `periodic`, `cell` with `origin` and `walls` may stand beside it, not alone."""
        points, box = random_points(20), np.array([(0, 0, 0), (2, 3, 4.0)])
        cell = {"cell": np.diag([2, 3, 4.0]), "origin": np.zeros(3)}

        def summary(**arrays):
            np.savez(self.folder / "a.npz", points=points, **arrays)
            return self.run_cli("a.npz").stdout

        for arrays in ({}, cell, {"walls": np.array([(1, 0, 0, 2.0)])}):
            with self.subTest(list(arrays)):
                text = summary(box=box, **arrays)
                self.assertIn("not periodic", text)
                self.assertNotIn("not read", text)
                self.assertEqual(self.json("a.npz")["box_volume"], 24)
        for arrays, unread in [({"periodic": np.ones(3)}, "periodic"), (cell, "cell origin"), ({"walls": np.ones((2, 4))}, "walls"),
                               ({"box": np.ones(3), **cell}, "box cell origin"), ({"origin": np.zeros(3)}, "origin"),
                               ({"cell": np.ones(3), "periodic": np.ones(2), "walls": np.ones((1, 3))}, "periodic cell walls")]:
            with self.subTest(list(arrays)):
                note = f"not read as the domain, which needs a box of shape (2, 3): {unread}"
                self.assertIn(f" {note}\n", summary(**arrays))
                self.assertEqual(self.json("a.npz")["input"], note)
        self.assertNotIn("not read", summary(periodic=np.ones(20), cell=np.ones(20)))  # numbers of the points
        np.savez(self.folder / "a.npz", points=points, box=box, origin=box[0])
        self.assertEqual(self.json("a.npz")["domain"]["from"], "stated")
        for arrays, says in [({"box": box, "periodic": np.array([0, 1, 2])}, "periodic holds 2, and not 0 or 1 alone"),
                             ({"box": box, "periodic": np.array([0, 1, np.nan])}, "periodic holds nan"),
                             ({"box": box[::-1]}, "box goes from 2 to 0 along x"),
                             ({"box": box * [1, 1, np.nan]}, "box goes from nan to nan along z"),
                             ({"box": box * [1, 1, 0]}, "box is flat along z, at 0: leave z out of points and box, and add --2d"),
                             ({"box": box * [1, 0, 1], "periodic": np.zeros(3)}, "box is flat along y, at 0: give it a length"),
                             ({"box": box, "origin": np.ones(3)}, "there is an origin, and no cell: a cell needs both"),
                             ({"box": box, "cell": cell["cell"]}, "there is a cell, and no origin: a cell needs both"),
                             ({"box": box, **cell, "origin": np.ones(3)}, "box goes from 0 to 2 along x, the cell from 1 to 3"),
                             ({"box": box, **cell, "cell": np.diag([2, 3, 5.0])}, "box goes from 0 to 4 along z, the cell from 0 to 5"),
                             ({"box": np.array([(-np.inf,) * 3, (np.inf,) * 3]), **cell}, "box goes from -inf to inf along x, the cell from 0 to 2"),
                             ({"box": np.array([(0, 0, 0), (2, 3, np.inf)]), **cell}, "box goes from 0 to inf along z, the cell from 0 to 4"),
                             ({"box": np.array([(0, -np.inf, -np.inf), (2, np.inf, np.inf)]), **cell, "cell": np.diag([2, 3, 0.0])}, "box goes from -inf to inf along y"),
                             ({"box": np.ones(3), "periodic": np.ones(3)}, "box does not hold numbers with shape (2, 3)")]:
            np.savez(self.folder / "a.npz", points=points, **arrays)
            self.refuse("a.npz", says=["a.npz: " + says])
        skewed = np.array([(2, 0, 0), (-0.5, 3, 0), (0.1, 0.2, 4)])
        for kind in ("f4", "f8"):
            np.savez(self.folder / "a.npz", points=points, periodic=np.ones(3), box=[(-0.5, 0, 0), (2.1, 3.2, 4)], cell=skewed.astype(kind), origin=np.zeros(3))
            self.assertAlmostEqual(self.json("a.npz")["box_volume"], 24, delta=1e-5)
        np.savez(self.folder / "a.npz", places=points)
        self.assertIn("the points are its array places\n", self.run_cli("a.npz").stdout)

    def test_npz_refused(self):
        points = random_points(50)
        for arrays, says in [({"a": points, "b": points}, ["several", "--dataset", "a b"]),
                             ({"a": points[:, :1]}, "(N, 3)"), ({"points": points[:, :1]}, ["(50, 1)", "(N, 3) or (N, 2)"]),
                             ({"points": points.astype(int)}, "'<i8'"), ({}, "(N, 3)"),
                             ({"x": points[:, 0], "y": points[:9, 0], "z": points[:, 0]}, ["y has 9", "50"]),
                             ({"x": points, "y": points[:, 0], "z": points[:, 0]}, "x is not an array"),
                             ({"points": points, "ids": np.arange(49)}, ["ids has 49 numbers, the array of points has 50"]),
                             ({"points": points, "id": np.arange(51)}, "id has 51 numbers"),
                             ({"points": points, "ids": points[:, 0]}, "ids are not whole numbers in a list"),
                             ({"points": points, "ids": np.zeros((50, 1), int)}, "ids are not whole numbers in a list")]:
            np.savez(self.folder / "a.npz", **arrays)
            self.refuse("a.npz", "-o", "out.txt", says=["a.npz"] + ([says] if isinstance(says, str) else says))
        np.savez(self.folder / "a.npz", points=points, r=points[:9, 0], s=points)
        self.refuse("a.npz", "--dataset", "q", says=["'q'", "points r s"])
        self.refuse("a.npz", "--radii", "q", says="'q'")
        self.refuse("a.npz", "--radii", "r", says=["r has 9", "50"])
        self.refuse("a.npz", "--radii", "s", says="3 numbers for each point")
        self.refuse("a.npz", "--frame", "1", says="--frame")
        points[7, 1] = np.nan
        np.savez(self.folder / "a.npz", points=points)
        self.assertRegex(self.refuse("a.npz", says="nan"), r"\b7\b")
        with zipfile.ZipFile(self.folder / "a.npz", "w", zipfile.ZIP_BZIP2) as archive:
            archive.writestr("points.npy", b"anything" * 99)
        self.refuse("a.npz", says="deflate")
        self.refuse(self.put("b.npz", b"PK\x03\x04"), says="damaged")
        self.refuse(self.put("b.npz", b"1 2 3\n"), says="not a zip")

    def test_npz_damaged(self):
        """A checksum protects the numbers."""
        points = random_points(60)
        for save in [np.savez, np.savez_compressed]:
            save(self.folder / "a.npz", points=points, ids=np.arange(60), r=points[:, 0])
            content = (self.folder / "a.npz").read_bytes()
            at = content.index(b"NUMPY") if save is np.savez else 80
            damaged = bytearray(content)
            damaged[at + 500] ^= 4
            self.refuse(self.put("b.npz", bytes(damaged)), says="checksum")


class PlyFiles(ReaderTest):
    def ply(self, kind, properties, rows, before=("", b"")):
        """Writes a file with the element vertex after another element."""
        head = f"ply\nformat {kind} 1.0\ncomment by hand\n{before[0]}element vertex {len(rows)}\n"
        head += "".join(f"property {t} {name}\n" for t, name in properties) + "element face 0\n"
        head += "property list uchar int vertex_indices\nend_header\n"
        if kind == "ascii":
            return head.encode() + before[1] + "".join(" ".join(map(repr, row)) + "\n" for row in rows).encode()
        codes = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f",
                 "double": "d",
                 "int8": "b", "uint16": "H", "float64": "d"}
        layout = (">" if "big" in kind else "<") + "".join(codes[t] for t, _ in properties)
        return head.encode() + before[1] + b"".join(struct.pack(layout, *row) for row in rows)

    def test_ply(self):
        points = random_points(50)
        plain = [("double", "x"), ("double", "y"), ("double", "z")]
        mixed = [("uchar", "red"), ("float64", "z"), ("int", "id"), ("double", "x"), ("short", "s"), ("double", "y"),
                 ("float", "r"), ("uint16", "u")]
        rows = points.tolist()
        mixed_rows = [[7, p[2], 3 * i, p[0], -5, p[1], i / 128, 65535] for i, p in enumerate(rows)]
        for kind in ["ascii", "binary_little_endian", "binary_big_endian"]:
            with self.subTest(kind):
                self.put("a.ply", self.ply(kind, plain, rows))
                self.assert_points("a.ply", points)
                self.put("a.ply", self.ply(kind, mixed, mixed_rows))
                self.assert_points("a.ply", points, ids=range(0, 150, 3))
                self.assert_column("a.ply", np.arange(50) / 128, "r")
                self.put("a.ply", self.ply(kind, [("float", a) for a in "xyz"], points.astype("f4").tolist()))
                self.assert_points("a.ply", points.astype("f4"))
                # Another element with a list before the vertices.
                order = ">" if "big" in kind else "<"
                lists = (b"3 1 2 3 0.5\n0 0.5\n" if kind == "ascii" else
                         b"".join(struct.pack(f"{order}H{n}if", n, *range(n), 0.5) for n in [3, 0]))
                front = "element other 2\nproperty list ushort int l\nproperty float w\n", lists
                self.put("a.ply", self.ply(kind, plain, rows, front))
                self.assert_points("a.ply", points)
        self.put("a.ply", self.ply("ascii", plain, rows).replace(b"\n", b"\r\n"))
        self.assert_points("a.ply", points)

    def test_lists_of_vertices(self):
        """They are skipped in text and binary, as MeshLab and plyfile do, wherever they stand and however long they are."""
        points = random_points(50)
        properties = ["list uchar float w", "double x", "double y", "list int short q", "double z", "float r", "list uchar int e"]
        rows = [(list(range(i % 3)), p[0], p[1], [7] * (i % 4), p[2], i / 128, [1] * (i % 2)) for i, p in enumerate(points.tolist())]
        head = "ply\nformat {} 1.0\nelement vertex 50\n" + "".join(f"property {p}\n" for p in properties) + "end_header\n"
        text = "".join(" ".join(str(x) for v in row for x in ([len(v), *v] if isinstance(v, list) else [v])) + "\n" for row in rows)
        binary = b"".join(struct.pack(f"<B{len(w)}fddi{len(q)}hdfB{len(e)}i", len(w), *w, x, y, len(q), *q, z, r, len(e), *e)
                          for w, x, y, q, z, r, e in rows)
        for content in (head.format("ascii").encode() + text.encode(), head.format("binary_little_endian").encode() + binary):
            self.put("a.ply", content)
            self.assert_points("a.ply", points)
            self.assert_column("a.ply", np.arange(50) / 128, "r")
            self.run_cli("a.ply", "--copy", "all", "-o", "out.npz")
            with np.load(self.folder / "out.npz") as arrays:
                self.assertTrue({"r"} <= set(arrays.files) and not {"w", "q", "e"} & set(arrays.files))
            self.refuse("a.ply", "--radii", "w", says="'w' is a list")
        self.refuse(self.put("a.ply", (head.format("ascii") + text).rsplit(" ", 1)[0]), says="a.ply:61: the row ends within")
        self.refuse(self.put("a.ply", head.format("ascii") + text[:-1] + " 5\n"), says="a.ply:61: the row has more numbers than")

    def test_own_ply(self):
        self.run_cli("--random", 100, "-o", "own.ply", "-o", "own.npz", "--want", "vertices")
        with np.load(self.folder / "own.npz") as arrays:
            self.assert_points("own.ply", arrays["vertices"])

    def test_ply_refused(self):
        plain = [("double", "x"), ("double", "y"), ("double", "z")]
        rows = random_points(9).tolist()
        for kind in ["ascii", "binary_little_endian"]:
            whole = self.ply(kind, plain, rows)
            for content, says in [(whole.replace(b"vertex 9", b"vertex 10"), ["ends after", "of the 10"]),
                                  (whole.replace(b"vertex 9", b"vertex 9999999999999999"), "0 of the 9999999999999999"),
                                  (whole.replace(b"vertex 9", b"vertex x"), "element NAME COUNT"),
                                  (whole.replace(b"double y", b"double q"), "x, y, z"),
                                  (whole.replace(b"double y", b"quad y"), "unknown type"),
                                  (whole.replace(b"element vertex", b"element vertices"), "no element vertex"),
                                  (whole.replace(kind.encode(), b"binary"), "unknown format"),
                                  (whole.replace(b"end_header", b"end_haeder"), "'end_haeder'"),
                                  (whole[:whole.index(b"element")], ["end_header", "ends"]), (b"solid\n", "not a PLY")]:
                self.refuse(self.put("a.ply", content), "-o", "out.npz",
                            says=["a.ply"] + ([says] if isinstance(says, str) else says))
            self.refuse(self.put("a.ply", whole), "--radii", "w", says=["'w'", "x y z"])
        rows[4][2] = float("nan")
        self.assertRegex(self.refuse(self.put("a.ply", self.ply("binary_little_endian", plain, rows)), says="nan"),
                         r"\b4\b")


class HostileFiles(ReaderTest):
    """Files and pipes that could take memory or time without end, and files of other formats."""

    def test_numbers(self):
        """Numbers are rounded correctly, as by Python's float, for texts of any length."""
        generator = random.Random(1)

        def digits(most):
            return "".join(generator.choice("0123456789") for _ in range(generator.randrange(1, most)))

        words = ["0." + "0" * 100000 + "1", "0." + "0" * 100000 + "1e100001", "1" + "0" * 100000 + "e-100000",
                 "-0e99999999999999999999", "1e-99999999999999999999", "-5e-324", "2.47e-324", "2.5e-324"]
        for _ in range(600):
            exponent = generator.choice(["", f"e{generator.randrange(-400, 400)}", f"E-{digits(30)}"])
            words.append(generator.choice(["", "-", "+"]) + "0" * generator.randrange(400) * generator.randrange(2) +
                         digits(40) + generator.choice(["", "." + "0" * generator.randrange(400) + digits(800)]) + exponent)
        finite = [word for word in words if abs(float(word)) < 1e300]
        self.put("a.txt", "".join(f"{i} 0 {i} {word}\n" for i, word in enumerate(finite)))
        self.run_cli("a.txt", "--copy", "4", "-o", "a.npz")
        with np.load(self.folder / "a.npz") as arrays:
            self.assertEqual(arrays["column_4"].tolist(), [float(word) for word in finite])
        for word in words:
            if float(word) in (float("inf"), -float("inf")):
                self.refuse(self.put("b.txt", f"0 0 0\n1 1 {word}\n"), says="inf")
                break

    def test_decimal_commas(self):
        for content in ["0,5 0 1\n", "0,5 0,5 1\n", "0,5;1;2\n", "0,5;1,5;2,5\n", "1 2 3\n0,5\t1\t2\n", "-0,5, 1 2\n", "0,5, 1, 2\n", "0,5, -1,5, 2,5\n"]:
            for name in ["a.txt", "a.csv", "a.xyz"]:
                self.refuse(self.put(name, content), says=[f"{name}:{content.count(chr(10))}:", "decimals need a point"])
        self.refuse(self.put("a.csv", "x;y;z\n0,5;1,5;2\n"), says=["a.csv:2:", "'0,5'", "decimals need a point"])
        self.refuse(self.put("a.xyz", "1\n\nH 0,5 1 2\n"), says=["a.xyz:3:", "decimals need a point"])
        for content, points in [("1,2,3\n", [1, 2, 3]), ("1, 2 ,3\n", [1, 2, 3]), ("7,1,2,3\n", [1, 2, 3]), ("1;2;3\n", [1, 2, 3]),
                                ("1 , 2 3\n", [1, 2, 3]), ("1,2, 3\n", [1, 2, 3]), ("7,1,2, 3\n", [1, 2, 3]), ("1.5,2 3\n", [1.5, 2, 3]),
                                ("1,-2,3\n", [1, -2, 3]), ("1 2 3 # 0,5\n", [1, 2, 3]), ("0.5,1,2.5\n", [0.5, 1, 2.5])]:
            got, _ = self.read(self.put("a.txt", content))
            np.testing.assert_array_equal(got, [points], content)

    def test_lines_without_end(self):
        for options in [[], ["--memory", "500M"]]:
            self.refuse("/dev/zero", *options, says="a line of more than 1048576 bytes")
            self.refuse(self.put("a.csv", "x,y,z\n" + "1" * 1100000 + ",2,3\n"), *options, says="1048576 bytes")
        for name in ["a.xyz", "POSCAR", "a.dump", "a.data", "a.ply"]:
            self.refuse(self.put(name, "ply\n" * (name == "a.ply") + "1" * 1100000 + "\n"), says="1048576 bytes")

    def test_signals(self):
        os.mkfifo(self.folder / "a.txt")
        for arguments in [["a.txt"], ["a.txt", "--memory", "500M"], ["-"], ["-", "--memory", "500M"]]:
            with self.start(*arguments, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
                time.sleep(0.3)
                began = time.monotonic()
                process.terminate()
                process.wait(timeout=20)
                self.assertIn(process.returncode, [-signal.SIGTERM, 128 + signal.SIGTERM], arguments)
                self.assertLess(time.monotonic() - began, 5, arguments)  # 0.2 s on an idle machine
        with self.start("-", "--memory", "500M", stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            try:
                began = None
                asked = False  # a second signal would end it at once
                while process.poll() is None:  # endless rows
                    process.stdin.write(b"\n" * 100000)
                    if began is None:
                        began = time.monotonic()
                    elif not asked and time.monotonic() - began > 0.5:
                        process.terminate()
                        asked = True
            except BrokenPipeError:
                pass
            self.assertEqual(process.wait(timeout=20), 128 + signal.SIGTERM)
            with contextlib.suppress(BrokenPipeError):
                process.stdin.close()
        for name in ["b.npy", "b.h5"]:
            os.mkfifo(self.folder / name)
            self.refuse(name, says="not a regular file")

    def test_file_that_becomes_shorter(self):
        environment = self.preloading("""
            #include <dlfcn.h>
            #include <unistd.h>
            extern "C" ssize_t read(int file, void* to, size_t count) {
                static const auto real = reinterpret_cast<ssize_t (*)(int, void*, size_t)>(dlsym(RTLD_NEXT, "read"));
                const ssize_t got = real(file, to, count);
                if (count >= 1 << 20 && (truncate("a.txt", 10) != 0 || truncate("a.npy", 100) != 0)) return -1;
                return got;
            }""")
        for name, options in [("a.txt", []), ("a.txt", ["--memory", "500M"]), ("a.npy", [])]:
            self.put("a.txt", "0.25 0.5 0.75\n" * 500000)
            self.put("a.npy", np.zeros((1000000, 3)))
            done = self.run_cli(name, *options, code=1, env=environment)
            self.assertRegex(done.stderr, rf"\Aclvotess: {name}: the file was made shorter while it was read\n\Z")

    def test_packed(self):
        lines = gzip.compress(b"\n" * 2**26)
        self.refuse(self.put("a.txt.gz", lines * 12), says=["a.txt.gz: its", "unpack to more than", "unpack the file first"])
        self.assert_points(self.put("b.txt.gz", gzip.compress(b"") * 20000 + gzip.compress(b"1 2 3\n")), [[1, 2, 3]])
        corpus = ROOT / "tests/fuzz/readers/corpus"
        shutil.copy(corpus / "npz/overlapping", self.folder / "a.npz")
        self.refuse("a.npz", says="members overlap")
        with zipfile.ZipFile(self.folder / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
            whole = io.BytesIO()
            np.save(whole, np.zeros((10**6, 3)))
            for name in range(16):
                archive.writestr(f"{name}.npy", whole.getvalue())
        self.refuse("a.npz", says="unpack to more than")

    def test_counts_that_wrap(self):
        self.put("POSCAR", "c\n1\n1 0 0\n0 1 0\n0 0 1\n" + "1099511627776 " * 70000 + "1\nDirect\n0 0 0\n")
        self.refuse("POSCAR", says="add up to more than")
        huge = 2**64 // 3 + 1  # three of them overflow by 2
        for name, content in [("a.xyz", f"{huge}\n\nH 0 0 0\n"), ("a.xyz", f"{2**64}\n\nH 0 0 0\n"),
                              ("a.ply", f"ply\nformat ascii 1.0\nelement vertex {huge}\nproperty float x\nproperty float y\n"
                                        "property float z\nend_header\n0 0 0\n")]:
            self.refuse(self.put(name, content), says=name)
        whole = (self.folder / self.put("a.npy", np.zeros((2, 3)))).read_bytes()
        self.refuse(self.put("a.npy", whole.replace(b"(2, 3)", f"({huge}, 3)".encode())), says="a.npy")
        self.refuse(self.put("a.xyz", "1\nProperties=" + "a:R:1000:" * 5000 + "pos:R:3\nH 0 0 0\n"), says="4096 columns")

    def test_refusals_lead(self):
        cif = "data_quartz\n_cell_length_a 4.9\nloop_\n_atom_site_label\nSi\n"
        xyz = "1\nProperties=species:S:1:pos:R:3\nH 0 0 0\n"
        for name, content, options, says in [
                ("a.txt", "1 2\n3 4\n", ["--list-walls", "--periodic", "z"], ["a.txt:1:", "2 columns, expected 3", "add --2d"]),
                ("a.txt", "0.1 0.2 0.3 1.0\n", [], ["'0.1' is not a whole number", "--radii 4"]),
                ("POSCAR", cif, [], ["CIF", "ase convert"]), ("a.cif", cif, [], ["extended XYZ", "ase convert"]),
                ("a.pdb", "ATOM\n", [], ["'a.pdb'", "extended XYZ", "ASE"]), ("a.xtc", "x", [], ["OVITO", "lammps/dump"]),
                ("a.gsd", "x", [], "OVITO"), ("a.dcd", "x", [], "OVITO"), ("a.nc", "x", [], "OVITO"), ("a.trr", "x", [], "OVITO"),
                ("XDATCAR", "Cu\n1\n4 0 0\n0 4 0\n0 0 4\nCu\n1\nDirect configuration=     1\n0 0 0\n", [], ["'XDATCAR'", "ase convert"]),
                ("a.stl", "solid\n", [], ".ply"), ("a.extxyz", xyz, ["--weights", "species"],
                                                    ["'H'", "'species' has text", "has text where numbers are needed"])]:
            self.refuse(self.put(name, content), *options, "-o", "out.npz", says=says)
        for good, content in [("a.txt", "1 2 0\n3 4 0\n"), ("b.extxyz", xyz)]:
            self.run_cli(self.put(good, content))
        self.run_cli(self.put("a.txt", "0.1 0.2 0.3 1.0\n"), "--radii", "4")


class Columns(ReaderTest):
    """--copy and --density, from every kind of file."""

    OWN = {"box", "periodic", "cell", "origin", "version", "domain_from", "periodic_from", "units", "indptr", "indices", "shifts", "volumes", "status", "ids"}

    def carried(self, *arguments):
        """Returns the columns in an .npz in addition to the result."""
        self.run_cli(*arguments, "-o", "out.npz")
        with np.load(self.folder / "out.npz") as arrays:
            return {name: arrays[name] for name in arrays.files if name not in self.OWN}, arrays["volumes"]

    def assert_carried(self, name, expected, *options):
        """Asserts the columns one by one, in another order, all at once, and as density."""
        for names in [list(expected), list(expected)[::-1], ["all"]]:
            got, _ = self.carried(name, "--copy", ",".join(names), *options)
            self.assertEqual(set(got), set(expected), name)
            for column, values in expected.items():
                np.testing.assert_array_equal(got[column], values, f"{name}: {column}")
        column = next(c for c, values in expected.items() if np.ndim(values) == 1)
        got, volumes = self.carried(name, "--density", column, *options)
        self.assertEqual(set(got), {"density"})
        np.testing.assert_array_equal(got["density"], expected[column] / volumes)

    def test_names_with_numbers_in_them(self):
        """A field of a line of names may have several words, some of them numbers: pandas writes the first one."""
        points = random_points(20)
        for names in ("Unnamed: 0,x,y,z", "T 300 K;x;y;z", "x,y,z,phase 2"):
            mark = ";" if ";" in names else ","
            order = [names.split(mark).index(axis) for axis in "xyz"]
            rows = np.zeros((20, 4))
            rows[:, order] = points
            self.put("a.csv", "\n".join([names, *(mark.join(map(repr, row)) for row in rows.tolist())]) + "\n")
            self.assert_points("a.csv", points)
        self.put("a.csv", "".join(f"{i} {x},{y},{z}\n" for i, (x, y, z) in enumerate(points.tolist())))
        self.assert_points("a.csv", points)  # a row whose first field has two numbers is not one of names

    def test_coordinates_by_name(self):
        """--columns finds x, y and z under the names of ParaView, units and others, or by numbers."""
        points = random_points(20)
        rows = [row.split() for row in text_of(points).splitlines()]
        self.put("a.csv", '"mass","Points:0","Points:1","Points:2","id"\n'
                 + "".join(f"{i / 4},{','.join(row)},{i + 7}\n" for i, row in enumerate(rows)))
        self.assert_points("a.csv", points, "--columns", "Points:0,points:1,2x".replace("2x", "Points:2"), ids=range(7, 27))
        self.assert_points("a.csv", points[:, ::-1], "--columns", "4,Points:1,2", ids=range(7, 27))
        self.assert_column("a.csv", np.arange(20) / 4, "mass", "--columns", "2,3,4")
        self.refuse("a.csv", says=["a.csv:1:", "'x'", "--columns", "'points:0'", "'mass'"])
        self.refuse("a.csv", "--columns", "Points:0,Points:1,Points:3", says=["'points:3'", "'points:2'"])
        self.refuse("a.csv", "--columns", "x,y,z", says="a.csv:1: the line of names lacks 'x' of --columns; there are 'mass'")
        for columns in ["x,y", "x,y,z,w", "x,,z", ""]:
            self.refuse("a.csv", f"--columns={columns}", says="--columns")
        self.put("a.txt", "x [Mpc];y [Mpc];z [Mpc]\n" + "".join(";".join(row) + "\n" for row in rows))
        self.assert_points("a.txt", points, "--columns", "x [Mpc],y [Mpc],z [Mpc]")
        self.put("b.txt", "".join(f"{i} 1.5 {' '.join(row)} 2 3 4\n" for i, row in enumerate(rows)))
        self.assert_points("b.txt", points, "--columns", "3,4,5")
        self.refuse("b.txt", "--columns", "3,4,9", says=["b.txt:1:", "'9'", "8 columns"])
        self.refuse("b.txt", "--columns", "a,b,c", says=["b.txt:1:", "'a'", "no line of names"])
        self.put("a.dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n20\nITEM: BOX BOUNDS pp pp pp\n0 2\n0 1\n0 1\n"
                 "ITEM: ATOMS id x y z xs ys zs f_avg[1] f_avg[2] f_avg[3]\n"
                 + "".join(f"{i} 0.5 0.5 {(i + 1) / 32} {' '.join(row)} {' '.join(row)}\n" for i, row in enumerate(rows)))
        self.assert_points("a.dump", points, "--columns", "f_avg[1],f_avg[2],f_avg[3]")
        self.assert_points("a.dump", points * [2, 1, 1], "--columns", "xs,ys,zs")
        self.refuse("a.dump", "--columns", "xs,ys,q", says="'q'")
        np.savez(self.folder / "a.npz", px=points[:, 0], py=points[:, 1], pz=points[:, 2], other=points * 2)
        self.assert_points("a.npz", points, "--columns", "px,py,pz")
        self.refuse("a.npz", "--columns", "px,py,q", says="'q'")
        self.put("a.npy", points)
        self.refuse("a.npy", "--columns", "1,2,3", says=["--columns", "'a.npy'"])
        self.refuse("--random", "5", "--columns", "1,2,3", says="--columns")

    def test_watershed(self):
        """`zone` is the number of the minimum that steps to the lowest neighbor reach; here one cell at a time."""
        points, rng = random_points(60), np.random.default_rng(4)
        mass, value = rng.random(60) + 0.5, rng.integers(0, 9, 60)
        rows = [f"{row.replace(' ', ',')},{m!r},{v}\n" for row, m, v in zip(text_of(points).splitlines(), mass.tolist(), value)]
        self.put("a.csv", "x,y,z,mass,value\n" + "".join(rows + rows[:1]))

        def zones(values, arrays):
            ends = []
            for i in range(60):
                while True:
                    row = arrays["indices"][arrays["indptr"][i]:arrays["indptr"][i + 1]]
                    lowest = min([i, *row[row >= 0]], key=lambda j: (values[j], j))
                    if lowest == i:
                        break
                    i = lowest
                ends.append(i)
            return [*np.unique(ends, return_inverse=True)[1], -1]

        for more, names in ((("--copy", "value,mass", "--list-walls"), {"value", "mass"}), (("--density", "mass"), {"density"})):
            got, _ = self.carried("a.csv", "--watershed", "value", *more)
            self.assertEqual(set(got), {*names, "zone", "duplicate_of"})
            with np.load(self.folder / "out.npz") as arrays:
                np.testing.assert_array_equal(got["zone"], zones(value, arrays))
        got, _ = self.carried("a.csv", "--density", "mass", "--watershed", "density")
        with np.load(self.folder / "out.npz") as arrays:
            np.testing.assert_array_equal(got["zone"], zones(got["density"], arrays))
        with np.load(self.folder / "out.npz") as arrays:
            near = [set(arrays["indices"][arrays["indptr"][i]:arrays["indptr"][i + 1]]) - {-1} for i in range(60)]

        def lasts(minimum, level):
            """Whether a flood from the minimum up to the level finds no lower cell."""
            wet = {minimum}
            while more := {j for i in wet for j in near[i] if value[j] <= level} - wet:
                wet |= more
            return min(wet, key=lambda i: (value[i], i)) == minimum

        minima = [i for i in range(60) if all((value[i], i) < (value[j], j) for j in near[i])]
        own, (joined, _) = self.carried("a.csv", "--watershed", "value")[0], self.carried("a.csv", "--watershed", "value", "--merge", "4")
        left = [i for i in minima if lasts(i, value[i] + 4)]
        self.assertTrue(1 <= len(left) < len(minima))
        self.assertEqual([joined["zone"][i] for i in left], list(range(len(left))))
        self.assertEqual(joined["zone"].max(), len(left) - 1)
        self.assertEqual(len(set(zip(own["zone"], joined["zone"]))), len(minima) + 1)  # zones stay whole, -1 beside them
        self.refuse("a.csv", "--merge", "1", says="--watershed")
        self.refuse("a.csv", "--watershed", "value", "--merge", "x", "-o", "out.npz", says="--merge")
        self.refuse("a.csv", "--watershed", "density", "-o", "out.npz", says="'density'")
        self.refuse("a.csv", "--watershed", "value", says="-o FILE")
        self.refuse("a.csv", "--watershed", "value", "--only", "3", "-o", "out.npz", says="--only")
        self.refuse("a.csv", "--watershed", "value", "--memory", "1G", "-o", "out.npz", says="--watershed")
        self.put("b.csv", "x,y,z,value\n0.1,0.2,0.3,1\n0.4,0.5,0.6,nan\n")
        self.refuse("b.csv", "--watershed", "value", "-o", "out.npz", says="value of seed 1 is nan")
        frames = ["60\n\n" + "".join(f"A {row} {v}\n" for row, v in zip(text_of(points).splitlines(), values)) for values in (value, mass)]
        self.put("c.xyz", "".join(frames))
        each = [self.rows("c.xyz", "--frame", frame, "--watershed", "5", "--format", "%i") for frame in "01"]
        self.assertNotEqual(each[0], each[1])
        got = self.rows("c.xyz", "--frames", "all", "--watershed", "5", "--format", "%i")
        self.assertEqual([row for row in got if len(row.split()) == 2 and row[0] != "#"], each[0] + each[1])
        self.put("c.xyz", frames[0] + "1\n\nA 0.1 0.2 0.3 nan\n")
        self.refuse("c.xyz", "--frames", "all", "--watershed", "5", "-o", "out.csv", says=["frame 1:", "seed 0 is nan"])

    def test_words(self):
        """Named columns may hold words; `species` has other names in other formats."""
        words = [["Cu", "Zr", "Al13+"][i % 3] for i in range(30)]
        rows = text_of(random_points(30)).splitlines()
        self.put("a.csv", "x,y,z,word,n\n" + "".join(f"{row.replace(' ', ',')},{w},{i}\n" for i, (row, w) in enumerate(zip(rows, words))))
        self.put("a.xyz", "30\n\n" + "".join(f"{w} {row}\n" for row, w in zip(rows, words)))
        self.put("a.dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n30\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\n"
                 "ITEM: ATOMS type element x y z\n" + "".join(f"1 {w} {row}\n" for row, w in zip(rows, words)))
        order = np.argsort(words, kind="stable")
        self.put("POSCAR", "c\n1\n1 0 0\n0 1 0\n0 0 1\nAl13+ Cu Zr\n10 10 10\nDirect\n" + "".join(rows[i] + "\n" for i in order))
        for name, column in [("a.csv", "word"), ("a.xyz", "species"), ("a.dump", "species"), ("a.dump", "element"), ("POSCAR", "species")]:
            expected = sorted(words) if name == "POSCAR" else words
            self.assertEqual([row.split()[-1] for row in self.rows(name, "--copy", column, "--format", "%i %v")], expected)
            got, _ = self.carried(name, "--copy", column)
            self.assertEqual(got[column].tolist(), [word.encode() for word in expected])
        got, _ = self.carried("a.csv", "--copy", "word,n")
        self.assertEqual((got["word"].tolist(), got["n"].tolist()), ([word.encode() for word in words], list(range(30))))
        self.refuse("a.csv", "--copy", "word", "-o", "out.vtu", says=["'word'", "'out.vtu'"])
        self.refuse("a.csv", "--copy", "word", "--color", "word", "--image", "out.png", says=["'word'", "words"])
        self.refuse("a.csv", "--density", "word", "-o", "out.npz", says="'word' has text")
        self.refuse("a.csv", "--copy", "species", "-o", "out.npz", says=["'species'", "word"])
        self.refuse("a.csv", "--copy", "word", "--memory", "1G", "-o", "out.h5", says="'word' has text")
        many = "".join(f"{w} {row}\n" for row, w in zip(rows, words)) * 3000
        self.put("b.xyz", "90000\n\n" + many)  # pieces for threads
        got = self.rows("b.xyz", "--copy", "species", "--format", "%i")
        self.assertEqual([row.split()[1] for row in got], words * 3000)

    def test_integers_beyond_doubles(self):
        """Carried integers that a double would round keep their digits, from every file into every file."""
        n = 90000  # pieces for threads; the first ones are small
        points, integers = random_points(n), np.where(np.arange(n) % 7 == 6, 2**53 + 1, 1) * np.arange(n)
        integers[-2:] = 2**63 - 1, -(2**63)
        few = integers[[5, 6, -2, -1]]
        lines = [f"{row.replace(' ', ',')},{k},{i}\n" for i, (row, k) in enumerate(zip(text_of(points).splitlines(), integers))]
        self.put("a.csv", "x,y,z,k,mass\n" + "".join(lines))
        np.savez(self.folder / "a.npz", points=points, k=integers, both=np.c_[integers, integers], mass=np.arange(n))
        for name in ("a.csv", "a.npz"):
            got, _ = self.carried(name, "--copy", "all", "--density", "mass")
            self.assertEqual((got["k"].dtype, got["mass"].dtype), (np.int64, np.float64))
            for column in {"k", "both"} & set(got):
                self.assertTrue((got[column].T == integers).all(), (name, column))
        np.savez(self.folder / "few.npz", points=points[[5, 6, -2, -1]], k=few)
        for out in ("o.txt", "o.csv", "o.xyz", "o.dump"):
            self.run_cli("few.npz", "--copy", "k", "-o", out)
            text = (self.folder / out).read_text()
            self.assertTrue(all(str(k) in text.replace(",", " ").split() for k in few), out)
        self.refuse("a.csv", "--copy", "k", "--memory", "1G", "-o", "o.h5", says=["'k'", "2^53"])
        head = "x,y,z,k\n.1,.2,.3,9007199254740993\n.4,.5,.6,"
        for number in ("18446744073709551615", "-9223372036854775809"):
            self.put("b.csv", head + number)
            self.refuse("b.csv", "--copy", "k", "-o", "o.csv", says=["'k'", "64 bits"])
        for number in ("0.5", "1e300", "23112854520106532864", "-9223372036854775808000"):  # a column of doubles
            self.put("b.csv", head + number)
            self.assertEqual(self.carried("b.csv", "--copy", "k")[0]["k"].tolist(), [2.0**53, float(number)])
            rows = head.splitlines()
            self.put("c.csv", "\n".join([rows[0], rows[2] + number, rows[1]]))
            self.assertEqual(self.carried("c.csv", "--copy", "k")[0]["k"].tolist(), [float(number), 2.0**53])
        self.put("b.csv", head + "2e3")
        self.assertEqual(self.carried("b.csv", "--copy", "k")[0]["k"].tolist(), [2**53 + 1, 2000])
        self.run_cli("b.csv", "--weights", "k", "-o", "o.csv")  # a weight is a double

    def test_names_that_are_not_utf8(self):
        """Names in Latin-1 are refused before any file, and others of every script pass."""
        rows = b"".join(f"{row},{i}\n".replace(" ", ",").encode() for i, row in enumerate(text_of(random_points(5)).splitlines()))
        for name in ["Gr\xf6\xdfe".encode("latin-1"), b"m\xc3", b"\xed\xa0\x80", b"\xc0\xaf", b"\xf5\x80\x80\x80", b"\xff", b"a\x80b"]:
            self.put("a.csv", b"x,y,z," + name + b"\n" + rows)
            for out in ["out.npz", "out.h5", "out.csv", "out.xyz", "out.dump", "out.vtu"]:
                self.refuse("a.csv", "--copy", "all", "-o", out, says=["\\x", "not UTF-8", "iconv"])
            self.refuse("a.csv", "--frames", "all", "--points", "--copy", "all", says=["not UTF-8", "iconv"])
            self.refuse("a.csv", "--copy", "q", "-o", "out.npz", says="\\x")  # lists the names
            self.run_cli("a.csv", "-o", "out.npz")
        for name in ["größe", "質量", "Ω²", "\U0001d54f"]:
            self.put("a.csv", f"x,y,z,{name}\n".encode() + rows)
            got, _ = self.carried("a.csv", "--copy", name)
            np.testing.assert_array_equal(got[name], np.arange(5))

    def test_covalent_radii(self):
        words = [["C", "h", "FE3+", "O2-"][i % 4] for i in range(40)]
        rows = text_of(random_points(40) * 9).splitlines()
        self.put("a.xyz", "40\n\n" + "".join(f"{w} {row}\n" for row, w in zip(rows, words)))
        self.put("five.xyz", "40\n\n" + "".join(f"{w} {row} 9\n" for row, w in zip(rows, words)))
        radii = [{"C": 0.76, "h": 0.31, "FE3+": 1.32, "O2-": 0.66}[w] for w in words]
        self.put("a.csv", "x,y,z,r\n" + "".join(f"{row.replace(' ', ',')},{r}\n" for row, r in zip(rows, radii)))
        self.assertEqual(self.rows("a.xyz", "--radii", "covalent", "--format", "%r %n %v"), self.rows("a.csv", "--radii", "r", "--format", "%r %n %v"))
        got, _ = self.carried("five.xyz", "--radii", "covalent", "--copy", "5", "--density", "5")
        self.assertEqual(set(got), {"column_5", "density"})
        self.run_cli("a.xyz", "--radii", "covalent", "-o", "r.csv")
        self.assertEqual((self.folder / "r.csv").read_text().splitlines()[1].split(",")[-1], "0.76")
        self.refuse("a.csv", "--radii", "covalent", says=["names none"])
        self.put("b.xyz", "2\n\nC 0 0 0\nQq 1 1 1\n")
        self.refuse("b.xyz", "--radii", "covalent", says=["atom 1", "'Qq'"])
        self.refuse("a.xyz", "--radii", "covalent", "--memory", "1G", "-o", "out.h5", says="covalent")
        # Queries have the elements that their file names, else radii of 0.
        queries = text_of(random_points(20, 3) * 9).splitlines()
        self.put("q.xyz", "20\n\n" + "".join(f"{w} {row}\n" for row, w in zip(queries, words)))
        self.put("q.csv", "x,y,z,r\n" + "".join(f"{row.replace(' ', ',')},{r}\n" for row, r in zip(queries, radii)))
        box = ["--box=-1,-1,-1,10,10,10", "--format", "%r %w"]
        self.run_cli("a.xyz", "--radii", "covalent", "--probe", "q.xyz", "-o", "names.txt", *box)
        self.run_cli("a.csv", "--radii", "r", "--probe", "q.csv", "-o", "numbers.txt", *box)
        self.assertEqual((self.folder / "names.txt").read_text(), (self.folder / "numbers.txt").read_text())

    def test_rows(self):
        points, mass = random_points(40), np.random.default_rng(2).random(40)
        kind = np.arange(40) % 3
        rows = text_of(points).splitlines()
        together = list(zip(range(40), rows, mass.tolist(), kind.tolist()))
        self.put("a.csv", "id,x,y,z,mass,type,word\n"
                 + "".join(f"{i},{row.replace(' ', ',')},{m!r},{k},w{i}\n" for i, row, m, k in together))
        expected = {"mass": mass, "type": kind}
        self.assert_carried("a.csv", expected)
        self.put("a.dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n40\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\n"
                 "ITEM: ATOMS id element x y z mass type\n"
                 + "".join(f"{i} Cu {row} {m!r} {k}\n" for i, row, m, k in together))
        self.assert_carried("a.dump", expected)
        self.put("a.xyz", "40\nProperties=species:S:1:pos:R:3:mass:R:1:type:I:1:forces:R:3\n"
                 + "".join(f"Cu {row} {m!r} {k} 1 {m!r} 3\n" for i, row, m, k in together))
        forces = np.column_stack((np.ones(40), mass, np.full(40, 3)))
        got, _ = self.carried("a.xyz", "--copy", "forces,mass")
        self.assertEqual(set(got), {"forces", "mass"})
        np.testing.assert_array_equal(got["forces"], forces)
        self.assert_carried("a.xyz", {**expected, **{f"forces_{k + 1}": forces[:, k] for k in range(3)}})
        self.put("a.data", "c\n\n40 atoms\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\nAtoms # sphere\n\n"
                 + "".join(f"{i} {k} {m!r} 2.5 {row}\n" for i, row, m, k in together))
        got, _ = self.carried("a.data", "--copy", "all")
        self.assertEqual(set(got), {"type", "diameter", "density"})
        np.testing.assert_array_equal(got["density"], np.full(40, 2.5))
        got, _ = self.carried("a.data", "--radii", "radius", "--copy", "radius,diameter", "--outside", "drop")
        np.testing.assert_array_equal(got["radius"], mass / 2)
        np.testing.assert_array_equal(got["diameter"], mass)
        self.put("a.ply", "ply\nformat ascii 1.0\nelement vertex 40\n"
                 + "".join(f"property double {name}\n" for name in ["x", "y", "z", "mass", "type"]) + "end_header\n"
                 + "".join(f"{row} {m!r} {k}\n" for i, row, m, k in together))
        self.assert_carried("a.ply", expected)
        self.put("a.txt", "".join(f"{i} {row} {m!r} {k}\n" for i, row, m, k in together))
        got, _ = self.carried("a.txt", "--copy", "6,5")
        np.testing.assert_array_equal(got["column_5"], mass)
        np.testing.assert_array_equal(got["column_6"], kind)
        self.refuse("a.txt", "--copy", "all", "-o", "out.npz", says="header line")

    def test_tables_of_no_rows(self):
        """Their columns are there, with no values."""
        for names in ("x,y,z,mass,kind", "id,kind,x,mass,y,z", "x y z mass kind"):
            self.put("a.csv", names + "\n")
            for columns in ("all", "mass,kind", "kind"):
                got, _ = self.carried("a.csv", "--copy", columns)
                self.assertEqual({name: len(values) for name, values in got.items()},
                                 {name: 0 for name in ("mass", "kind") if columns in ("all", "mass,kind", name)})
            self.run_cli("a.csv", "--copy", "all", "-o", "out.csv")
            self.assertEqual(set((self.folder / "out.csv").read_text().strip().split(",")[-2:]), {"mass", "kind"})
            self.refuse("a.csv", "--copy", "q", "-o", "out.csv", says="'q'")
            self.run_cli("a.csv", "-o", "out.csv")
        self.run_cli(self.put("a.csv", ""), "--copy", "all", "-o", "out.csv")  # no names, no columns

    def test_rows_by_threads(self):
        """Threads parse and write rows in the order of the file, and name the line of an error."""
        points, count = random_points(60000), 60000
        rows = [f"{i},{','.join(repr(float(x)) for x in point)},{i / 8}" for i, point in enumerate(points)]
        rows[1000] += "\n\n# between rows\n"
        self.put("a.csv", "id,x,y,z,mass\n" + "\n".join(rows))
        self.assertGreater((self.folder / "a.csv").stat().st_size, 3 << 20)
        for threads in [1, 3]:
            self.run_cli("a.csv", "-t", threads, "--copy", "mass", "--format", "%i %q", "-o", f"{threads}.txt")
            got = np.loadtxt(self.folder / f"{threads}.txt")
            np.testing.assert_array_equal(got[:, 0], np.arange(count))
            np.testing.assert_array_equal(got[:, 1:4], points)
            np.testing.assert_array_equal(got[:, 4], np.arange(count) / 8)
        atoms = [f"Si {' '.join(repr(float(x)) for x in point)} {i}" for i, point in enumerate(points)]
        comment = "Properties=species:S:1:pos:R:3:id:I:1"
        frame = f"{count}\n{comment}\n" + "\n".join(atoms) + "\n"
        self.put("a.xyz", frame + "2\n\nH 1 2 3\nH 3 4 5\n" + frame)
        for number, expected in [(0, points), (1, [[1, 2, 3], [3, 4, 5]]), (2, points)]:
            self.assert_points("a.xyz", expected, "-t", 3, "--frame", number)
        atoms[59990] = "Si 0 0 none 1"
        self.put("b.xyz", f"{count}\n{comment}\n" + "\n".join(atoms) + "\n")
        self.refuse("b.xyz", "-t", 3, says=["b.xyz:59993:", "'none'"])
        self.put("b.xyz", f"{count + 1}\n{comment}\n" + "\n".join(atoms[:59990] + atoms[59991:]) + "\n")
        self.refuse("b.xyz", "-t", 3, says="the file ends after 59999 of the 60001 rows")
        dump = (f"ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS ff ff ff\n" + "0 1\n" * 3 +
                "ITEM: ATOMS id x y z mass\n" + "".join(f"{i} {' '.join(repr(float(x)) for x in point)} {i / 8}\n"
                                                        for i, point in enumerate(points)))
        self.put("a.dump", dump + dump.replace("\n5\n", "\n6\n"))
        for number in [0, 1]:
            self.run_cli("a.dump", "-t", 3, "--frame", number, "--copy", "all", "--format", "%i %q", "-o", "d.txt")
            got = np.loadtxt(self.folder / "d.txt")
            np.testing.assert_array_equal(got, np.column_stack([np.arange(count), points, np.arange(count) / 8]))
        for row, line in [(10, 12), (59990, 59995)]:
            self.put("b.csv", "id,x,y,z,mass\n" + "\n".join([*rows[:row], "7,0,0,none,1", *rows[row:]]))
            for options in [["-t", 3], ["-t", 1], ["-t", 3, "--memory", "500M"]]:
                self.refuse("b.csv", *options, *["-o", "b.h5"] * (len(options) > 2), says=[f"b.csv:{line}:", "'none'"])

    def test_arrays(self):
        points, mass, flow = random_points(30), np.arange(30) * 0.5, random_points(30, 9)[:, :2]
        expected = {"mass": mass, "flow": flow, "type": np.arange(30)}
        np.savez(self.folder / "a.npz", points=points, ids=np.arange(30) + 7, other=np.zeros(3), deep=np.zeros((30, 2, 2)),
                 **expected)
        self.assert_carried("a.npz", expected)

    def test_outputs(self):
        points, mass = random_points(25), np.random.default_rng(4).random(25)
        np.savez(self.folder / "a.npz", points=points, mass=mass, flow=points[:, :2] * 3)
        options = ["--copy", "mass,flow", "--density", "mass"]
        self.run_cli("a.npz", *options, "-o", "out.txt", "-o", "out.vtu", "-o", "out.npz", "--format", "%i %v")
        rows = np.array([row.split() for row in (self.folder / "out.txt").read_text().splitlines()], float)
        np.testing.assert_array_equal(rows[:, 2:5], np.column_stack((mass, points[:, :2] * 3)))
        np.testing.assert_array_equal(rows[:, 5], mass / rows[:, 1])
        head, body = (self.folder / "out.vtu").read_bytes().split(b'<AppendedData encoding="raw">\n_', 1)

        def array(name, dtype):
            tag = re.search(rf'<DataArray [^>]*Name="{name}"[^>]*>', head.decode())[0]
            at = int(re.search('offset="([0-9]+)"', tag)[1])
            values = np.frombuffer(body, dtype, int(np.frombuffer(body, "<u8", 1, at)[0]) // 8, at + 8)
            return values.reshape(25, -1).squeeze()

        ids = array("id", "<i8")
        self.assertEqual(sorted(ids), list(range(25)))
        for name, values in [("mass", mass), ("flow", points[:, :2] * 3), ("density", rows[:, 5])]:
            np.testing.assert_array_equal(array(name, "<f8"), values[ids])
        # A cell without a volume has no density. A file without points has empty columns.
        self.put("two.csv", "x,y,z,m\n0,0,0,2\n0,0,0,3\n1,1,1,4\n")
        rows = self.rows("two.csv", "--density", "m", "--format", "%i")
        self.assertEqual([row.split()[1] == "nan" for row in rows], [False, True, False])
        self.assertEqual(float(rows[0].split()[1]), 5 / float(self.rows("two.csv", "--format", "%v")[0]))
        self.put("none.csv", "x,y,z,m\n")
        self.assertEqual(self.rows("none.csv", "--density", "m", "--copy", "m", "--radii", "m"), [])

    def test_density_of_duplicates(self):
        """The seed that keeps the cell gets the mass of all equal seeds, also of those a period away."""
        rng = np.random.default_rng(5)
        places = np.round(random_points(40) * 1024) / 1024
        which = np.concatenate((np.arange(40), rng.integers(0, 40, 60)))[rng.permutation(100)]
        points = places[which] + rng.integers(-1, 2, (100, 3))
        mass = rng.random(100)
        keeper = np.array([np.flatnonzero(which == k)[0] for k in which])
        np.savez(self.folder / "a.npz", points=points, mass=mass)
        options = ["a.npz", "--box", "0,0,0,1,1,1", "--periodic", "--density", "mass", "--copy", "mass"]
        got, volumes = self.carried(*options)
        expected = np.full(100, np.nan)
        for i in np.unique(keeper):
            expected[i] = sum(mass[keeper == i]) / volumes[i]
        np.testing.assert_allclose(got["density"], expected, rtol=1e-15)
        np.testing.assert_array_equal(got["mass"], mass)
        self.assertAlmostEqual(np.nansum(got["density"] * volumes), mass.sum(), places=12)
        rows = np.array([row.split() for row in self.rows(*options, "--format", "%i")], float)
        np.testing.assert_array_equal(rows[:, 2], got["density"])

    def test_refused(self):
        np.savez(self.folder / "a.npz", points=random_points(25), mass=np.zeros(25), volumes=np.zeros(25), flow=np.zeros((25, 2)))
        for options, says in [(["--copy", "mass"], "-o FILE"), (["--copy", "mass", "-o", "out.ply"], "--copy"),
                              (["--copy", "q", "-o", "out.npz"], "'q'"),
                              (["--copy", "mass,mass", "-o", "out.npz"], "twice"),
                              (["--copy", "volumes", "-o", "out.npz"], ["'volumes'", "rename"]),
                              (["--copy", ",", "-o", "out.npz"], "--copy is empty"),
                              (["--copy", '"a, b",', "-o", "out.npz"], ["'\"a, b\",'", "an empty name", "leave out a comma"]),
                              (["--density", "flow", "-o", "out.npz"], "2 numbers for each point"),
                              (["--radii", "flow", "-o", "out.npz"], "2 numbers for each point")]:
            self.refuse("a.npz", *options, says=says)
        self.run_cli("a.npz", "--copy", "volumes", "-o", "out.vtu")
        self.refuse("--random", "5", "--copy", "mass", "-o", "out.npz", says="--copy goes with INPUT")
        self.refuse("--random", "5", "--copy", "all", "-o", "out.npz", says="--copy goes with INPUT")
