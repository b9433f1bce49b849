"""Dumps and data files of LAMMPS."""

import random

import numpy as np

from cli_test import random_points, text_of
from reader_cases import ReaderTest


class LammpsFiles(ReaderTest):
    DUMP = ("ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS ff ff ff\n0 2\n0 1\n-1 1\n"
            "ITEM: ATOMS {names}\n")

    def dump(self, names, rows, step=0, head=DUMP):
        return head.format(step=step, count=len(rows), names=names) + "".join(row + "\n" for row in rows)

    def test_dump(self):
        points = random_points(40) * [2, 1, 2] - [0, 0, 1]
        lines = text_of(points).splitlines()
        ids = list(range(100, 140))
        random.Random(1).shuffle(ids)
        for names, rows in [("id type x y z", [f"{i} 1 {line}" for i, line in zip(ids, lines)]),
                            ("type z y vx x id", [f"1 {p[2]!r} {p[1]!r} 9 {p[0]!r} {i}" for i, p in
                                                  zip(ids, points.tolist())]),
                            ("id element xu yu zu c_1[2]", [f"{i} He {line} 3" for i, line in zip(ids, lines)])]:
            self.put("a.dump", self.dump(names, rows))
            self.assert_points("a.dump", points, ids=ids)
            self.assertEqual(self.json("a.dump")["box_volume"], 4)
            self.assertEqual(self.json("a.dump", "--box=-3,-3,-3,3,3,3")["box_volume"], 216)
        for name in ["dump.melt", "dump.0.lammpstrj", "a.lammpstrj"]:
            self.put(name, self.dump("x y z", lines))
            self.assert_points(name, points)
        self.assertRegex(self.run_cli("a.lammpstrj").stdout,
                         "(?m)^input +timestep 0\ndomain +box 0,0,-1 to 2,1,1, not periodic; stated$")

    def test_type_labels(self):
        """`typelabel` of LAMMPS since 2024 is the species, except beside elements; `type` finds it too."""
        rows = text_of(random_points(6) * [2, 1, 1]).splitlines()
        labels, elements = ["Cu", "c3", "Zr+", "Cu", "o_w", "c3"], ["Cu", "C", "Zr", "Cu", "O", "C"]
        for names, row, species in [("id typelabel x y z", "{i} {label} {row}", labels), ("typelabel id type x y z", "{label} {i} 7 {row}", labels),
                                    ("type x y z typelabel element", "7 {row} {label} {element}", elements), ("type x y z", "7 {row}", ["7"] * 6)]:
            self.put("a.dump", self.dump(names, [row.format(i=i, row=r, label=l, element=e) for i, (r, l, e) in enumerate(zip(rows, labels, elements))]))
            self.run_cli("a.dump", "-o", "b.xyz", "-o", "b.dump")
            for name in ("b.xyz", "b.dump"):
                lines = (self.folder / name).read_text().splitlines()[-6:]
                self.assertEqual([line.split()[0 if name == "b.xyz" else 1] for line in lines], species, names)
            got = self.rows("a.dump", "--copy", "species", "--format", "%i")
            self.assertEqual([line.split()[-1] for line in got], species)
            types = labels if " type " not in f" {names} " else ["7"] * 6
            got = self.rows("a.dump", "--copy", "type", "--format", "%i")
            self.assertEqual([line.split()[-1] for line in got], types)

    def test_species_beside_elements(self):
        """A column of --copy that the output names otherwise, or not at all, is never lost."""
        self.put("a.dump", self.dump("id type species element x y z", ["1 1 aa H 0.1 0.2 0.3", "2 2 bb O 0.4 0.5 0.6"]))
        self.run_cli("a.dump", "--copy", "species,element,type", "-o", "b.dump", "-o", "b.csv")
        for name, mark in (("b.dump", " "), ("b.csv", ",")):
            head, *rows = [line.split(mark) for line in (self.folder / name).read_text().splitlines()[-3:]]
            head = head[2:] if mark == " " else head
            self.assertEqual([[row[head.index(of)] for of in ("species", "element", "type")] for row in rows], [["aa", "H", "1"], ["bb", "O", "2"]])
        self.refuse("a.dump", "--copy", "species", "-o", "b.xyz", says="cannot carry the column 'species', for the file has another one")
        self.run_cli("a.dump", "--copy", "element,type", "-o", "b.xyz")
        self.put("r.csv", "x,y,z,a,radius\n0,0,0,1,2\n1,1,1,1,3\n")
        self.refuse("r.csv", "--radii", "a", "--copy", "radius", "-o", "b.csv", says="cannot carry the column 'radius'")
        self.run_cli("r.csv", "--radii", "radius", "--copy", "radius", "-o", "b.csv")

    def test_dump_scaled(self):
        scaled = random_points(30)
        rows = text_of(scaled).splitlines()
        for names in ["xs ys zs", "xsu ysu zsu"]:
            self.put("a.dump", self.dump(names, rows))
            got, _ = self.read("a.dump")
            np.testing.assert_allclose(got, scaled * [2, 1, 2] - [0, 0, 1], rtol=1e-15, atol=1e-15)

    def test_dump_frames(self):
        frames = [random_points(10 + k, k) * [2, 1, 1] for k in range(3)]
        self.put("a.dump", "".join(self.dump("x y z radius", [f"{row} {0.01 * j}" for j, row in
                                                              enumerate(text_of(frame).splitlines())], 100 * k)
                                   for k, frame in enumerate(frames)))
        self.assert_points("a.dump", frames[0])
        for k in range(3):
            self.assert_points("a.dump", frames[k], "--frame", k)
            self.assertIn(f"frame {k + 1} of 3 (--frame {k}), timestep {100 * k}", self.run_cli("a.dump", "--frame", k).stdout)
        self.refuse("a.dump", "--frame", 3, says=["frame 3 is missing", "has 3"])
        self.refuse("a.dump", "--frame", "-1", says="'-1'")
        self.assert_column("a.dump", [0.01 * j for j in range(12)], "radius", "--frame", 2)
        self.assert_column("a.dump", [0.01 * j for j in range(10)], "4")
        self.refuse("a.dump", "--radii", "r", says=["'r'", "x y z radius"])
        self.refuse("a.dump", "--radii", "5", says="'5'")

    def test_general_triclinic(self):
        """Boxes of any orientation, `abc origin` in dumps and avec, bvec, cvec in data files."""
        turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        edges = np.array([(2.0, 0, 0), (0.5, 1.5, 0), (-0.25, 0.125, 1.0)]) @ turn
        corner = np.array((7.0, -1.0, 0.5))
        scaled = random_points(50)
        points = scaled @ edges + corner
        self.put("a.npy", points)
        cell = ["--cell", ",".join(map(repr, edges.ravel().tolist())), "--origin", "7,-1,0.5", "--format", "%n %v"]
        lines = text_of(points).splitlines()
        for flags, axes in [("pp pp pp", "xyz"), ("pp ff pp", "xz"), ("ff ff ff", "none")]:
            box = f"ITEM: BOX BOUNDS abc origin {flags}\n" + "".join(
                f"{' '.join(map(repr, edge))} {c!r}\n" for edge, c in zip(edges.tolist(), corner.tolist()))
            head = f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n50\n{box}ITEM: ATOMS "
            self.put("a.dump", head + "x y z\n" + text_of(points))
            expected = self.rows("a.npy", *cell, "--periodic", axes)
            self.assertEqual(self.rows("a.dump", "--format", "%n %v"), expected)
            self.put("s.dump", head + "xs ys zs\n" + text_of(scaled))
            got = np.array([row.split() for row in self.rows("s.dump", "--format", "%q")], float)
            np.testing.assert_allclose(got, points, rtol=0, atol=1e-14)
        vectors = [f"{' '.join(map(repr, edge))} {name}\n" for edge, name in zip(edges.tolist(), ["avec", "bvec", "cvec"])]
        data = "c\n\n50 atoms\n{}\nAtoms # atomic\n\n" + "".join(f"{i} 1 {line}\n" for i, line in enumerate(lines))
        self.put("a.data", data.format("".join(vectors) + "7 -1 0.5 abc origin\n"))
        self.assertEqual(self.rows("a.data", "--format", "%n %v"), self.rows("a.npy", *cell, "--periodic"))
        self.assertEqual(self.json("a.data")["domain"]["periodic_from"], "assumed")
        for header, says in [("".join(vectors), "abc origin"), ("".join(vectors[1:]) + "7 -1 0.5 abc origin\n", "avec"),
                             ("0 0 0 avec\n" + "".join(vectors[1:]) + "0 0 0 abc origin\n", "no edge a"),
                             ("1 0 inf avec\n" + "".join(vectors[1:]) + "0 0 0 abc origin\n", "not finite")]:
            self.refuse(self.put("a.data", data.format(header)), says=["a.data:", says])
        whole = (self.folder / "a.dump").read_text()
        self.refuse(self.put("a.dump", whole.replace(" 7.0\n", "\n")), says=["a.dump:6:", "corner"])

    def test_dump_refused(self):
        row = ["0.5 0.5 0.5"]
        whole = self.dump("x y z", row)
        for content, says in [("", "ends"), ("1 2 3\n", [":1:", "ITEM: TIMESTEP"]),
                              (whole[:-13], [":9:", "0 of the 1"]),
                              (whole + "1 2 3\n", [":11:", "more rows"]), (self.dump("x y q", row), [":9:", "x y z"]),
                              (self.dump("x y z id", row), [":10:", "3 columns", "4"]),
                              (self.dump("x y z", ["a 1 2"]), [":10:", "'a'"]),
                              (self.dump("x y z id", ["0 0 0 1.5"]), [":10:", "'1.5'"]),
                              (whole.replace("0 2\n", "2 0\n"), [":8:", "along x"]),
                              (whole.replace("0 2\n", "0 nan\n"), "along x"),
                              (whole.replace("OF ATOMS\n1\n", "OF ATOMS\n99999999999999\n"), [":4:", "99999999999999"]),
                              (whole.replace("OF ATOMS\n1\n", "OF ATOMS\n-1\n"), [":4:", "whole number"]),
                              (whole.replace("ITEM: NUMBER OF ATOMS\n1\n", ""), [":7:", "NUMBER OF ATOMS"])]:
            self.refuse(self.put("a.dump", content), "-o", "out.npz",
                        says=["a.dump"] + ([says] if isinstance(says, str) else says))
        self.put("a.dump", self.dump("x y z", row + ["3 0 0"]))
        self.refuse("a.dump", says=["point 1", "outside"])

    DATA = ("LAMMPS data file\n\n{count} atoms\n2 atom types\n\n0 2 xlo xhi\n0 1 ylo yhi\n-1 1 zlo zhi\n\nMasses\n\n"
            "1 12.0\n2 1.0\n\nAtoms{hint}\n\n{rows}\nVelocities\n\n1 0 0 0\n")

    def data(self, rows, hint="", head=DATA):
        return head.format(count=len(rows), hint=hint, rows="".join(row + "\n" for row in rows))

    def test_data(self):
        points = random_points(25) * [2, 1, 2] - [0, 0, 1]
        lines = text_of(points).splitlines()
        for style, before in [("atomic", "1"), ("charge", "1 -0.5"), ("molecular", "3 1"), ("bond", "3 1"),
                              ("angle", "3 2"), ("full", "3 1 0.25"), ("sphere", "1 0.5 1.0"), ("amoeba", "3 1 0.25"),
                              ("apip", "1"), ("oxdna", "1"), ("rheo", "1 2 1000.0")]:
            for flags in ["", " 0 -1 2"]:
                rows = [f"{i + 1} {before} {line}{flags}" for i, line in enumerate(lines)]
                for hint in ["", f" # {style}"]:
                    with self.subTest(style=style, flags=flags, hint=hint):
                        self.put("a.data", self.data(rows, hint))
                        self.assert_points("a.data", points, "--box=0,0,-1,2,1,1", ids=range(1, 26))
        for style, before, after in [("dipole", "1 0.5", " 0.1 0.2 0.3"), ("electron", "1 3.0 0 0.5", ""),
                                     ("spin", "1", " 0.0 0.5 1.0 2.2"), ("line", "1 1 1 0.5", ""),
                                     ("sph", "1 1.0 0 0.5", ""),
                                     ("ellipsoid", "1 1 2.0", ""), ("hybrid", "1", " 0.5 7 8.0 9"),
                                     ("hybrid", "1", " 3")]:
            self.put("a.data",
                     self.data([f"{i} {before} {line}{after}" for i, line in enumerate(lines, 1)], " # " + style))
            self.assert_points("a.data", points, "--box=0,0,-1,2,1,1", ids=range(1, 26))
            self.put("a.data", self.data([f"{i} {before} {line}{after}" for i, line in enumerate(lines, 1)]))
            if style in ["electron", "spin", "line", "sph"]:
                self.refuse("a.data", says=["a.data:17:", "is not a whole number", "Atoms # sphere"])
        self.put("data.melt", self.data([f"{i} 1 {line}" for i, line in enumerate(lines, 1)]))
        self.assert_points("data.melt", points, ids=range(1, 26))
        self.put("a.lmp", self.data([f"{i} 1 {0.1 * i} 1.0 {line}" for i, line in enumerate(lines, 1)], " # sphere"))
        self.assert_column("a.lmp", [0.1 * i / 2 for i in range(1, 26)], "radius")
        self.assert_column("a.lmp", [0.1 * i for i in range(1, 26)], "diameter")
        self.assert_column("a.lmp", [0.1 * i for i in range(1, 26)], "3")

    # Columns between the id and the coordinates, and after them, by the manual and the sources of LAMMPS.
    STYLES = [("eff", "1 2.0 0 0.5", ""), ("electron", "1 3.0 0 0.5", ""), ("line", "1 1 1 0.5", ""),
              ("tri", "2 1 1 0.5", ""), ("sph", "1 1000.0 0 0.5", ""), ("meso", "1 1000.0 0 0.5", ""),
              ("smd", "1 1 0.5 1.5 0.25 0.125 9 8 7", ""), ("mesont", "1 1 2 1.5 6.785 20.0 0", ""),
              ("mesont", "1 1 -1 2 1.5 6.785 20.0 0", ""), ("dielectric", "1 0.5", " 0 0 1 0.5 10 5.5 1 -2"),
              ("dielectric", "1 2 0.5", " 0 0 1 0.5 10 5.5 1 -2"), ("template", "1 1 0 2", ""),
              ("wavepacket", "1 0.5 1 0.5 7 0.25 0.5", ""), ("bpm/sphere", "1 1 0.5 1.0", ""),
              ("full/kk", "1 1 0.5", ""), ("rheo/thermal", "1 2 1000.0 0.5", ""), ("spin", "1", " 0 0 1 2"), ("dipole", "1 0.5", " 0 1 0")]

    def test_data_styles(self):
        """Coordinates may be whole numbers too, which no check of image flags can tell apart."""
        for points in [random_points(25) * [2, 1, 2] - [0, 0, 1], np.indices((3, 3, 3)).reshape(3, -1).T * 1.0]:
            lines = [" ".join(f"{x:g}" if x == int(x) else repr(x) for x in map(float, row)) for row in points]
            for style, before, after in self.STYLES:
                for flags in ["", " 0 -1 2"]:
                    rows = [f"{i} {before} {line}{after}{flags}" for i, line in enumerate(lines, 1)]
                    with self.subTest(style=style, before=before, flags=flags):
                        self.put("a.data", self.data(rows, f"  # {style}"))
                        self.assert_points("a.data", points, "--box=-9,-9,-9,9,9,9", ids=range(1, len(points) + 1))
                        # Without the style these are refused, except where the coordinates have a common place (whole
                        # numbers of style dipole may be those of style spin).
                        self.put("a.data", self.data(rows))
                        if style == "full/kk" or (style == "dipole" and not flags and "." in lines[0]):
                            self.assert_points("a.data", points, "--box=-9,-9,-9,9,9,9", ids=range(1, len(points) + 1))
                        else:
                            self.refuse("a.data", says=["a.data:", "Atoms # sphere"])
        self.put("a.data", self.data(["1 1 0.5 0.25 0.5 0.5 0.5"], " # smd"))
        self.refuse("a.data", says=["a.data:17:", "7 columns", "style smd have 13, and 3 more"])
        self.put("a.data", self.data(["1 1 0.5 0.25 0.5 0.5 0.5"], " # mesont"))
        self.refuse("a.data", says=["style mesont have 11 or 12, and 3 more"])

    def test_data_hybrid(self):
        points = random_points(25) * [2, 1, 2] - [0, 0, 1]
        radii = [0.1 * i / 2 for i in range(1, 26)]
        for hint, after in [("hybrid sphere bond", "{d} 1.0 3"), ("hybrid charge sphere/kk", "0.5 {d} 1.0"),
                            ("hybrid sphere bond", "{d} 1.0 3 0 0 -1"), ("hybrid dipole sphere", "0.5 1 0 0 {d} 1.0")]:
            self.put("a.data", self.data([f"{i} 1 {line} {after.format(d=0.1 * i)}"
                                          for i, line in enumerate(text_of(points).splitlines(), 1)], " # " + hint))
            self.assert_points("a.data", points, "--box=0,0,-1,2,1,1", ids=range(1, 26))
            self.assert_column("a.data", radii, "radius")
        for hint in ["hybrid", "hybrid body nparticle 2 10", "tdpd"]:
            self.put("a.data", self.data([f"{i} 1 {line} 0.5 0.25 0.125"
                                          for i, line in enumerate(text_of(points).splitlines(), 1)], " # " + hint))
            self.assert_points("a.data", points, "--box=0,0,-1,2,1,1", ids=range(1, 26))
        self.put("a.data", self.data(["1 1 0.5 0.5"], " # tdpd"))
        self.refuse("a.data", says="at least 5 columns")

    def test_data_line_of_names(self):
        points = random_points(25) * [2, 1, 2] - [0, 0, 1]
        lines = text_of(points).splitlines()
        for names, before, after in [("id type x y z", "1", ""), ("atom-ID atom-type rho esph cv x y z", "1 1 0 1", ""),
                                     ("ID mol type lineflag density X Y Z", "1 1 1 0.5", ""),
                                     ("id type x y z ix iy iz", "1", " 0 0 1"), ("id x y z spin", "", " 7"),
                                     ("id type q diameter x y z", "1 0.5 0.25", "")]:
            for flags in ["", " 0 -1 2"]:
                rows = [f"{i} {before} {line}{after}{flags}" for i, line in enumerate(lines, 1)]
                for hint, head in [("", names), ("", "# " + names), ("", "#" + names), (" # " + names, "# by hand"),
                                   (" # " + names, names)]:
                    with self.subTest(names=names, flags=flags, hint=hint, head=head):
                        self.put("a.data", self.data(rows, hint).replace(f"Atoms{hint}\n\n", f"Atoms{hint}\n\n{head}\n"))
                        self.assert_points("a.data", points, "--box=0,0,-1,2,1,1", ids=range(1, 26))
        self.assert_column("a.data", [0.125] * 25, "radius")

        def put(rows, hint, head):
            self.put("a.data", self.data(rows, hint).replace(f"Atoms{hint}\n\n", f"Atoms{hint}\n\n{head}\n"))

        sphere = [f"{i} 1 0.25 1.0 {line}" for i, line in enumerate(lines, 1)]
        # The style agrees with the names, or the comment is unrelated.
        for hint, head in [(" # sphere", "id type diameter density x y z"), (" # sphere", "# id type x y z"),
                           (" # sphere", "# the spheres, x y z last"), ("", "# seven words: where x y z are"),
                           (" # sphere", "# id type d rho x y z"), (" # sphere", "id type d rho x y z")]:
            put(sphere, hint, head)
            self.assert_points("a.data", points, "--box=0,0,-1,2,1,1", ids=range(1, 26))
            if hint:
                self.assert_column("a.data", [0.125] * 25, "radius")
        for hint, head, says in [(" # sphere", "id type x y z a b", [":18:", "column 5", "'sphere'", "column 3"]),
                                 (" # sphere", "# id type x y z a b", [":18:", "column 5", "column 3"]),
                                 ("", "id type x y z", [":18:", "7 columns", "5 are named"]),
                                 ("", "id type d rho x y x", [":17:", "'id' is not a whole number"]),
                                 ("", "id type d rho x z y", [":17:", "'id' is not a whole number"])]:
            put(sphere, hint, head)
            self.refuse("a.data", says=["a.data" + says[0], *says[1:]])

    def test_data_refused(self):
        whole = self.data(["1 1 0.5 0.5 0.5", "2 1 1.5 0.5 0.5"])
        for content, says in [("", "ends before its section Atoms"), (whole.replace("Atoms", "Bonds"), "ends before"),
                              (whole.replace("2 atoms", "3 atoms"), ["1 column,"]),
                              (whole.replace("2 atoms", "9999999999999 atoms"), "0 of the 9999999999999"),
                              (whole.replace("2 atoms", "x atoms"), [":3:", "'x'"]),
                              (whole.replace("2 atoms\n", ""), "N atoms"),
                              (whole.replace("0 1 ylo yhi", ""), "ylo yhi"),
                              (whole.replace("0 1 ylo", "1 1 ylo"), "along y"),
                              (whole.replace("1.5 0.5", "1.5 q"), "'q'"),
                              (whole.replace("Atoms", "Atoms # unheard-of").replace(" 1 0.5", " 1"), ["4 columns", "Atoms # sphere"]),
                              (whole.replace(" 1 0.5", " 1 1 1 1 1 1 1 0.5"), ["11 columns", "Atoms # sphere"]),
                              (whole.replace("Atoms", "Atoms # full"), ["full", "5 columns"]),
                              (whole.replace("2 1 1.5", "2.5 1 1.5"), "'2.5'")]:
            self.refuse(self.put("a.data", content), "-o", "out.npz",
                        says=["a.data"] + ([says] if isinstance(says, str) else says))
