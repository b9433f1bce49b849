"""Input: text, .npy, stdin, --random, and refused files."""

import csv
import io
import os

import numpy as np

from cli_test import CUBE, CliTest, random_points, text_of


class Source(CliTest):
    def assert_reads(self, name, content, expected, ids=None):
        """Asserts that a file gives exactly these points, in this order."""
        self.put(name, content)
        rows = [row.split() for row in self.rows(name, "--format", "%i %q")]
        self.assertEqual([[float(x) for x in row[1:]] for row in rows], [list(map(float, p)) for p in expected])
        self.assertEqual([int(row[0]) for row in rows], list(range(len(expected))) if ids is None else ids)

    def test_only(self):
        points = random_points(60)
        self.put("a.npy", points)
        self.put("ids.txt", "7 3\n59\n")
        every = self.rows("a.npy", "--format", "%i %v %n")
        self.assertEqual(self.rows("a.npy", "--format", "%i %v %n", "--only", "ids.txt"), [every[k] for k in (7, 3, 59)])
        self.assertEqual(self.rows("a.npy", "--format", "%i %v %n", "--only", "10:20:3"), every[10:20:3])
        self.assertEqual(self.rows("a.npy", "--format", "%i %v %n", "--only", "5"), every[5:6])
        self.run_cli("a.npy", "--only", "ids.txt", "-o", "some.npz", "-q")
        with np.load(self.folder / "some.npz") as file:
            self.assertEqual(file["ids"].tolist(), [7, 3, 59])
        indices = np.array([7, 3, 59])
        flags = np.zeros(60, bool)
        flags[[3, 7, 59]] = True
        for k, some in enumerate([indices, indices.astype("u1"), indices.astype("i4"), flags, indices[:0], flags & False]):
            self.put("some.npy", some)
            self.assertEqual(self.rows("a.npy", "--format", "%i %v %n", "--only", "some.npy"), [every[i] for i in np.arange(60)[some]], k)
        self.put("empty.txt", "\n")
        self.assertEqual(self.rows("a.npy", "--only", "empty.txt"), [])
        (self.folder / "folder.npy").mkdir()
        self.put("bad.txt", "3\n4 x\n")
        self.put("short.npy", flags[:-1])
        self.put("two.npy", np.array([[1, 2]]))
        self.put("float.npy", np.array([1.5]))
        for name, says in ((".", "'.': Is a directory"), ("", "--only is empty"), ("bad.txt", "bad.txt:2: 'x'"), ("folder.npy", "folder.npy"),
                           ("short.npy", ["(59,)", "60 points"]), ("two.npy", "(1, 2)"), ("float.npy", "(1,)"), ("/dev/zero", "1048576 bytes"),
                           ("absent.npy", "No such file")):
            self.refuse("a.npy", "--only", name, "-o", "out.csv", says=says)
        for arguments, says in ((["--only", "60"], "seed 60"), (["--only", "1:2:0"], "step"), (["--only", "no.txt"], "no.txt"),
                                (["--only", "1", "--watershed", "volumes"], "--watershed"), (["--only", "1", "-o", "a.ply"], "a.ply")):
            self.refuse("a.npy", *arguments, says=says)
        self.assertIn("yes, without volumes", self.run_cli("a.npy", "--only", "1:9", "--verify", "-o", "some.npz").stdout)

    def test_only_keeps_words_and_species(self):
        atoms = "".join(f"{name} {k} {k % 2} 0.5\n" for k, name in enumerate(("Cu", "Zr", "Al", "Ni")))
        self.put("a.xyz", '4\nLattice="4 0 0 0 2 0 0 0 1" Properties=species:S:1:pos:R:3\n' + atoms)
        every = self.rows("a.xyz", "--format", "%i %v %n", "--copy", "species")
        self.assertEqual(self.rows("a.xyz", "--format", "%i %v %n", "--copy", "species", "--only", "1:4:2"), every[1:4:2])
        self.run_cli("a.xyz", "--only", "1:4:2", "-o", "some.xyz", "-q")
        names = [line.split()[0] for line in (self.folder / "some.xyz").read_text().splitlines()[2:]]
        self.assertEqual(names, ["Zr", "Ni"])

    def test_outside_keep(self):
        points = random_points(200)
        self.put("a.npy", points)
        summary = self.json("a.npy", "--box", "0.2,0.2,0.2,0.7,0.7,0.7", "--outside", "keep", "--verify")
        self.assertAlmostEqual(summary["volume_sum"], 0.125, places=12)
        self.assertGreater(summary["empty_cells"], 0)

    def test_text_separators_comments_and_line_ends(self):
        expected = [[1, 2, 3], [-4, 5.5, 6e-3], [0.1, 7, 8]]
        for content in ["1 2 3\n-4 5.5 6e-3\n.1 7 8\n",
                        "1,2,3\n-4,5.5,6e-3\n.1,7,8\n",
                        "1;2;3\n-4;5.5;6e-3\n.1;7;8",
                        "\t1\t2\t3\n-4\t5.5\t6e-3\n  .1  7  8  \n",
                        "# x y z\n\n1 , 2 ; 3 # first\n   \n#\n-4, 5.5, +6E-03\n0.1 7. 8\n\n",
                        "1 2 3\r\n-4 5.5 6e-3\r\n\r\n.1 7 8\r\n",
                        "\ufeff1 2 3\n-4 5.5 6e-3\n.1 7 8"]:
            for name in ["a.txt", "a.dat", "a.xyz", "a.csv", "A.TXT"]:
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
        self.assert_reads("a.csv", "x,y,z\n", [])
        # Names locate the columns. Others are skipped, or read as values.
        self.assert_reads("a.csv", "x,y,z,id\n1,2,3,4\n", [[1, 2, 3]], [4])
        many = self.put("a.csv", 'mass,"Z",name_is_1,y,ID,x\n0.5,3,7,2,9,1\n0.25,6,7,5,8,4\n')
        self.assert_reads("a.csv", (self.folder / many).read_text(), [[1, 2, 3], [4, 5, 6]], [9, 8])
        for column in ["mass", "Mass", "1"]:
            self.assertEqual(self.rows(many, "--radii", column, "--format", "%r"), ["0.5", "0.25"])
        self.refuse(many, "--radii", "r", says=["a.csv:2:", "'r'", "mass z name_is_1 y id x"])
        self.refuse(self.put("a.csv", "x,y,w\n1,2,3\n"), says=["a.csv:1:", "lacks 'z'"])
        self.refuse(self.put("a.csv", "1,2,3\nx,y,z\n"), says=["a.csv:2:", "'x'"])
        self.refuse(self.put("a.csv", "id,x,y,z\n5.0,1,2,3\n"), says=["a.csv:2:", "'5.0'", "rename the column id"])
        self.refuse(self.put("a.csv", "1,2,oops\n1,2,3\n"), says=["a.csv:1:", "'oops'"])
        self.refuse(self.put("a.txt", "x y z\n1 2 3\n"), says=["a.txt:1:", "'x'", "put # before a line of names"])

    def test_csv_by_rfc_4180(self):
        """Random tables written by Python's csv come back, with quotes, marks, blanks and line ends in fields, and empty cells."""
        rng = np.random.default_rng(2)
        texts = ["plain", "two words", "a,b", 'say "hi"', "#5", "C#1", "", " padded ", "x;y", '"', "1,5", "1,2,3\n4,5,6", "\n", '"\r\n\n"', "#\n#"]
        for mark, quoting in [(",", csv.QUOTE_MINIMAL), (";", csv.QUOTE_MINIMAL), (",", csv.QUOTE_ALL), (",", csv.QUOTE_NONNUMERIC)]:
            points, mass = rng.random((30, 3)), rng.random(30)
            words = [texts[i] for i in rng.integers(0, len(texts), 30)]
            words[0] = "two words"
            sparse = [None if rng.random() < 0.5 else i / 4 for i in range(30)]
            sparse[0] = 0.0
            names = ["first\n(no name)", "note, long", "y", "mass [10^10 Msun]", "x", "sparse", "z", "Id"]
            rows = [[i, w, p[1], m, p[0], s, p[2], i + 5] for i, (w, p, m, s) in enumerate(zip(words, points.tolist(), mass.tolist(), sparse))]
            text = io.StringIO()
            writer = csv.writer(text, delimiter=mark, quoting=quoting, lineterminator="\r\n")
            last_lines = []
            for row in [names, *rows]:
                writer.writerow(row)
                last_lines.append(text.getvalue().count("\n"))
            self.assert_reads("a.csv", text.getvalue().encode(), points, list(range(5, 35)))
            for arguments in (["--copy", "mass [10^10 Msun]"], ["--copy", "all"]):
                self.run_cli("a.csv", *arguments, "-o", "b.csv", "-o", "b.npz")
                with np.load(self.folder / "b.npz") as arrays:
                    np.testing.assert_array_equal(arrays["mass [10^10 msun]"], mass)
                    if "all" in arguments:  # an empty cell of a column that nobody named
                        np.testing.assert_array_equal(arrays["sparse"], [np.nan if s is None else s for s in sparse])
                with open(self.folder / "b.csv", newline="") as file:
                    table = list(csv.DictReader(file))
                self.assertEqual([float(row["mass [10^10 msun]"]) for row in table], mass.tolist())
            self.run_cli("a.csv", "--copy", '"note, long"', "-o", "b.csv")
            with open(self.folder / "b.csv", newline="") as file:
                self.assertEqual([row["note, long"].strip() for row in csv.DictReader(file)], [w.strip() for w in words])
            for out in ("b.xyz", "b.dump", "b.txt"):
                self.refuse("a.csv", "--copy", "2", "-o", out, says=["'note, long'", f"'{out}'", "one word"])
            self.refuse("a.csv", "--copy", '"note, long', "-o", "b.csv", says=["--copy", "a quote does not end"])
            self.refuse("a.csv", "--radii", "sparse", "-o", "out.npz", says=[f"a.csv:{last_lines[sparse.index(None) + 1]}: column 6 is empty"])
        for content, says in [('x,y,z\n1,"2,3\n', "a.csv:2: the quote in column 2 does not end"), ('x,y,z\n1,"2"3,4\n', "goes on behind its quotes"),
                              ("x,y,z\n1,,3\n", "a.csv:2: column 2 is empty"), ("x,y,z\n1,2\n", "2 columns, the line of names 3"),
                              ('"x,y",z,q\n1,2,3\n', ["lacks 'x'", "'x,y'"]), ('x,y,z\n1,"0,5",3\n', "decimals need a point")]:
            self.refuse(self.put("a.csv", content), "-o", "out.npz", says=says)
        self.assert_reads("a.csv", ",x,y,z\n0,1,2,3\n1,4,5,6\n", [[1, 2, 3], [4, 5, 6]])  # pandas' to_csv()
        self.assert_reads("a.csv", '"1 2",x,y,z\n7,1,2,3 # more\n# none, at all\n1 2 3 4\n', [[1, 2, 3], [2, 3, 4]])

    def test_names_in_a_comment(self):
        """`# x y z mass`, as numpy.savetxt(header=...) writes it, names the columns if it fits the rows."""
        points, mass = random_points(9), np.arange(9) / 8
        for names, columns, values in [("x y z mass", "mass", mass), ("mass x y z", "mass", mass), ("X, Y, Z, Mass", "Mass", mass), ("z mass y x", "2", mass),
                                       ("id x y z mass", "mass", mass)]:
            order = {"x": points[:, 0], "y": points[:, 1], "z": points[:, 2], "mass": mass, "id": np.arange(9) + 4}
            table = np.column_stack([order[name.strip().lower()] for name in names.replace(",", " ").split()])
            rows = "".join(" ".join(f"{x:.17g}" for x in row) + "\n" for row in table)
            for name in ("a.txt", "a.csv", "a.xyz"):
                self.put(name, f"# made in 2026\n# {names}\n{rows}")
                got = [row.split() for row in self.rows(name, "--radii", columns, "--format", "%i %q %r")]
                np.testing.assert_array_equal(np.array(got, float)[:, 1:], np.column_stack((points, mass)), names)
                self.assertEqual([int(row[0]) for row in got], list(range(4, 13) if "id" in names else range(9)))
                self.run_cli(name, "--copy", "all", "-o", "b.npz")
                with np.load(self.folder / "b.npz") as arrays:
                    np.testing.assert_array_equal(arrays["mass"], mass)
        # Comments that do not fit, and ids whatever their name is, mean what they meant before.
        for comment, content, expected, ids in [("x y z", "7 1 2 3\n", [[1, 2, 3]], [7]), ("x y", "1 2 3\n", [[1, 2, 3]], None),
                                                ("number x y z", "7 1 2 3\n", [[1, 2, 3]], [7]), ("x 2 y", "1 2 3\n", [[1, 2, 3]], None),
                                                ('"x" y z', "1 2 3\n", [[1, 2, 3]], None), ("a b c", "1 2 3\n", [[1, 2, 3]], None)]:
            self.assert_reads("a.txt", f"# {comment}\n{content}", expected, ids)
        self.refuse(self.put("a.txt", "# x y mass\n1 2 3\n"), says=["a.txt:2:", "lacks 'z'", "--2d"])
        self.assertEqual(self.rows("a.txt", "--2d", "--format", "%q"), ["1 2"])
        self.refuse(self.put("a.txt", "# x y z r\n1 2 3 4\n"), "--radii", "mass", says=["'mass'", "x y z r"])

    def test_csv_names_are_all_or_none(self):
        """A line of names must name x, y and z once each, and every column of the rows."""
        for names, says in [("a,b,c", "lacks 'x'"), ("pos x,pos y,pos z", "lacks 'x'"), ("x,b,c", "lacks 'y'"),
                            ("id,a,b,c", "lacks 'x'"), ("a b c", "lacks 'x'"), ("x,x,y,z", "'x' more than once"),
                            ("x,y,z,Z", "'z' more than once"), ("id,x,y,z,ID", "'id' more than once")]:
            for rows in ["", "\n" + ",".join("1234567"[:1 + max(names.count(","), names.count(" "))]) + "\n"]:
                with self.subTest(names=names, rows=rows):
                    self.refuse(self.put("a.csv", names + rows), says=["a.csv:1:", says])
        self.refuse(self.put("a.csv", "m,x,y,z,m\n1,2,3,4,5\n"), "--radii", "m", says=["a.csv:1:", "'m' more than once"])
        self.assert_reads("a.csv", "m,x,y,z,m\n1,2,3,4,5\n", [[2, 3, 4]])
        self.refuse(self.put("a.csv", "x,y,z\n1,2,3,4\n"), says=["a.csv:2:", "4 columns, the line of names 3"])
        self.refuse(self.put("a.csv", "x,y,z,m\n1,2,3\n"), says=["a.csv:2:", "3 columns, the line of names 4"])
        # Commas separate names, which may contain blanks.
        self.assert_reads("a.csv", '"my mass" , X; y ,z # units\n7,1,2,3\n', [[1, 2, 3]])
        self.assertEqual(self.rows("a.csv", "--radii", "my mass", "--format", "%r"), ["7"])
        self.assert_reads("a.csv", "x y  z\n1 2 3\n", [[1, 2, 3]])

    def test_columns(self):
        for content, column, ids in [("1 2 3 0.1\n4 5 6 0.2\n", "4", None), ("7 1 2 3 0.1\n8 4 5 6 0.2\n", "5", [7, 8]),
                                     ("0.1 1 2 3\n0.2 4 5 6\n", "1", None),
                                     ("7 0.1 1 2 3\n8 0.2 4 5 6\n", "2", [7, 8])]:
            for option in ["--radii", "--weights"]:
                rows = [row.split() for row in self.rows(self.put("a.txt", content), option, column, "--format",
                                                         "%i %q %r")]
                self.assertEqual([row[1:4] for row in rows], [["1", "2", "3"], ["4", "5", "6"]])
                self.assertEqual([int(row[0]) for row in rows], ids or [0, 1])
                self.assertEqual([row[4] for row in rows], ["0.1", "0.2"] if option == "--radii" else ["0.5", "0.5"])
        self.refuse("a.txt", "--radii", "6", says=["'6'", "1 2 3 4 5"])
        self.refuse("a.txt", "--radii", "0", says="'0'")
        self.refuse(self.put("a.txt", "1 2 3 a\n"), "--radii", "4", says=["a.txt:1:", "'a'"])
        self.refuse(self.put("a.txt", "1 2 3\n"), "--radii", "3", says="in addition to the named ones")
        self.assertEqual(self.rows(self.put("a.xyz", "2\n\nH 1 2 3 9 0.1\nH 4 5 6 9 0.2\n"), "--radii", "6",
                                   "--format", "%q %r"),
                         ["1 2 3 0.1", "4 5 6 0.2"])
        self.refuse(self.put("a.xyz", "2\n\nH 1 2 3 0.1\nH 4 5 6\n"), "--radii", "5", says=["a.xyz:4:", "4 columns"])

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
        for content, says in [(points.astype("i8"), "'<i8'"), (points.astype(">c16"), "'>c16'"), (record, "records"),
                              (points[:, :1], "(10, 1)"), (points.ravel(), "(30,)"), (np.float64(3), "()"),
                              (points.reshape(1, 10, 3), "(1, 10, 3)"), (points.reshape(5, 6), "(5, 6)"),
                              (whole[:-1], "239 bytes"), (whole + b"x", "241 bytes"), (whole[:50], "too early"),
                              (whole[:5], "not a .npy"), (b"", "not a .npy"), (b"1 2 3\n" * 9, "not a .npy"),
                              (b"\x93NUMPY\x09" + whole[7:], "version 9"),
                              (whole.replace(b"(10, 3)", b"(9999999999999999999, 3)")
                               .replace(b" " * 19 + b"\n", b" \n"),
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
        long_text = text_of(random_points(40000))  # larger than the first buffer
        self.assertEqual(len(self.rows("-", stdin=long_text)), 40000)

    def test_bad_rows_name_file_and_line(self):
        for content, line, says in [("1 2 3\n4 5 6\n7 8\n", 3, "2 columns"),
                                    ("1 2 3\n\n# c\n1 2 3 4\n", 4, "4 columns"),
                                    ("1 2 3\n1\n", 2, "1 column,"), ("1\n", 1, "1 column,"),
                                    ("1 2 3 4 5\n", 1, "radii"), ("1 2 3 4 5 6\n", 1, "6 columns"),
                                    ("1 2 3 4\n1 2 3 4 5\n", 2, "5 columns"),
                                    ("1 2 3\n4 five 6\n", 2, "'five'"), ("1 2 3x\n", 1, "'3x'"),
                                    ("1 2 0x3\n", 1, "'0x3'"),
                                    ("1 2 1e\n", 1, "'1e'"), ("1 2 --3\n", 1, "'--3'"), ("1 2 +-3\n", 1, "'+-3'"),
                                    ("1 2 3\n1,,2,3\n", 2, "column 2 is empty"), ("1,2,\n", 1, "column 3 is empty"),
                                    (",1,2,3\n", 1, "column 1 is empty"), ("1,2,;3\n", 1, "column 3 is empty"),
                                    ("1.5 1 2 3\n", 1, "'1.5'"), ("9223372036854775808 1 2 3\n", 1, "too large for an id"),
                                    ("a 1 2 3\n", 1, "'a'"), ("1 2 3\n1 2 \x00\x01\n", 2, "\\x00\\x01"),
                                    ("1 2 " + "y" * 5000 + "\n", 1, "yyy...'")]:
            for name in ["a.txt", "a.xyz"]:
                if name == "a.xyz" and content == "1\n":
                    continue  # the plain format
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
        self.put("a.log", CUBE)
        self.refuse("a.log", says=["a.log", ".npy"])
        for name in ["a.vtu", "a.vtp"]:
            self.refuse(self.put(name, "<VTKFile/>"), says=[name, "this format is not read", "meshio", "numpy.savez"])
        for name in ["folder.txt", "folder.npy", "folder.npz", "folder.ply", "folder.dump"]:
            (self.folder / name).mkdir()
            self.refuse(name, says=name)
        self.refuse("", says="INPUT")
        if os.geteuid() != 0:
            self.put("closed.txt", CUBE)
            (self.folder / "closed.txt").chmod(0)
            self.refuse("closed.txt", says=["closed.txt", "Permission"])

    def test_text_without_an_extension(self):
        self.assert_reads("points", "1 2 3\n4 5 6\n", [[1, 2, 3], [4, 5, 6]])

    def test_empty_input_everywhere(self):
        self.put("a.txt", "# nothing\n")
        self.put("a.npy", np.zeros((0, 3), "f4"))
        for source in [["a.txt"], ["a.npy"], ["--random", "0"], ["-"]]:
            with self.subTest(source):
                summary = self.json(*source, "-o", "out.txt", "-o", "out.npz", "--verify", "--format",
                                    "%i %q %w %s %v %c %n",
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
        # SplitMix64 from state 1, by its reference code: equal on every machine.
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
