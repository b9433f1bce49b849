"""Frames of .xyz, the extended layout, POSCAR, and text packed by gzip."""

import gzip

import numpy as np

from cli_test import CUBE, random_points, text_of
from reader_cases import ReaderTest


class FrameFiles(ReaderTest):
    def test_xyz_frames(self):
        frames = [random_points(n, n) for n in (4, 7, 5)]
        text = "".join(f"{len(p)}\nstep {k}\n" + "".join(f"H {row}\n" for row in text_of(p).splitlines()) + "\n" * (k == 1)
                       for k, p in enumerate(frames))
        self.put("a.xyz", text)
        for options, points in [([], frames[0])] + [(["--frame", str(k)], p) for k, p in enumerate(frames)]:
            got = [row.split() for row in self.rows("a.xyz", *options, "--format", "%q")]
            np.testing.assert_array_equal(np.array(got, float), points)
        self.assertRegex(self.run_cli("a.xyz").stdout, "(?m)^input +frame 0$")
        self.refuse("a.xyz", "--frame", "3", says=["no frame 3", "has 3"])
        self.put("rows.xyz", CUBE)
        self.refuse("rows.xyz", "--frame", "0", says="--frame")
        self.refuse(self.put("b.xyz", text[:text.rindex("H")]), "--frame", "2", says="of the 5 rows")

    def test_extended_xyz(self):
        points, cell = random_points(40), [2.0, 0.0, 0.0, 0.5, 1.5, 0.0, -0.25, 0.125, 1.0]
        places = points @ np.array(cell).reshape(3, 3)
        self.put("a.npy", places)
        lattice = "Lattice=\"" + " ".join(map(str, cell)) + "\""

        def file(comment, row="Cu {} {} {}"):
            return self.put("a.xyz", f"40\n{comment}\n" + "".join(row.format(*p) + "\n" for p in places.tolist()))

        options = ["--cell", ",".join(map(str, cell))]
        for pbc, axes in [("", "xyz"), (' pbc="T T F"', "xy"), (" pbc='1 false T'", "xz"), (" pbc={F F F}", "none")]:
            expected = self.rows("a.npy", *options, "--periodic", axes, "--list-walls")
            name = file(f"energy=-3.5 {lattice}{pbc} note=\"a = b\"")
            self.assertEqual(self.rows(name, "--list-walls"), expected)
            self.assertEqual(self.json(name)["domain"]["from"], "file")
        name = file(f'{lattice} Origin="1 2 3" pbc="T T T"')
        self.assertEqual(self.json(name)["domain"]["origin"], [1, 2, 3])
        name = file(f"{lattice} properties=id:I:1:species:S:1:radius:R:1:forces:R:3:pos:R:3",
                    "{0:.0f}5 H 0.25 1 2 3 {0} {1} {2}")
        rows = self.rows(name, "--radii", "radius", "--format", "%i %q %r")
        self.assertEqual(rows[0].split(), [f"{places[0][0]:.0f}5", *map(str, places[0].tolist()), "0.25"])
        self.run_cli(name, "--weights", "forces_2")
        self.refuse(name, "--weights", "species", says="'H'")
        self.refuse(name, "--weights", "q", says=["'q'", "forces_3"])
        # Axes without lengths.
        name = file('pbc="T F T"')
        self.refuse(name, says=["periodic", "--periodic none"])
        self.assertEqual(self.json(name, "--periodic", "none")["domain"]["from"], "bounds")
        box = ["--box=-1,-1,-1,3,3,3"]
        self.assertEqual(self.json(name, *box)["domain"]["periodic"], [True, False, True])
        for comment, says in [('Lattice="1 2 3"', "9 numbers"), ('Lattice="1 0 0 0 1 0 0 0 a"', "'a'"),
                              ('pbc="T T"', "three"), ('pbc="T T x"', "'T T x'"), ("Properties=pos:R:2", "pos:R:3"),
                              ("Properties=species:S:1:pos:R", "pos:R:3"), ("Properties=pos:R:3", "4 columns")]:
            self.refuse(file(comment), says=["a.xyz:", says])

    def test_poscar(self):
        points = random_points(30)
        edges = np.array([(2.0, 0, 0), (0.5, 1.5, 0), (-0.25, 0.125, 1.0)])
        head = "comment\n{}\n" + "".join(" ".join(map(str, e)) + "\n" for e in edges.tolist())
        self.put("a.npy", points @ edges)
        options = ["--cell", ",".join(map(str, edges.ravel()))]
        for name in ["POSCAR", "CONTCAR.relaxed", "a.vasp"]:
            self.put(name, head.format("1.0") + "Cu Ni\n10 20\nDirect\n" + text_of(points) + "\n\n 0 0 0\n")
            got = np.array([row.split() for row in self.rows(name, "--format", "%q")], float)
            np.testing.assert_allclose(got, points @ edges, rtol=0, atol=1e-15)
            domain = self.json(name, "--periodic", "xy", "--outside", "drop")["domain"]
            self.assertEqual((domain["from"], domain["periodic"]), ("file", [True, True, False]))
        flags = "".join(row + " T T F\n" for row in text_of(points @ edges).splitlines())
        self.put("POSCAR", head.format("1") + "30\nSelective dynamics\nCartesian\n" + flags)
        self.assertEqual(self.rows("POSCAR"), self.rows("a.npy", *options))
        self.put("POSCAR", head.format("2 2 2") + "30\nk\n" + flags)
        self.assertEqual(self.json("POSCAR")["box_volume"], 24)
        self.put("POSCAR", head.format("-24") + "30\nc\n" + flags)
        self.assertAlmostEqual(self.json("POSCAR")["box_volume"], 24, places=10)
        for content, says in [("c\n1\n1 0 0\n0 1 0\n", "edge"), (head.format("0") + "1\nd\n0 0 0\n", "positive"),
                              (head.format("1") + "Cu\nx\nd\n", "'x'"), (head.format("1") + "2\nq\n0 0 0\n0 0 0\n", "'q'"),
                              (head.format("1") + "2\nd\n0 0 0\n", "atom 2 of 2"),
                              (head.format("1") + "99999999\nd\n0 0 0\n", "99999999")]:
            self.refuse(self.put("POSCAR", content), says=["POSCAR", says])
        self.refuse("POSCAR", "--radii", "1", says="no column")

    def test_packed_text(self):
        points = random_points(2000)
        text = text_of(points).encode()
        for name, content in [("a.txt.gz", gzip.compress(text)), ("b.xyz.gz", gzip.compress(text, 1)),
                              ("two.dat.gz", gzip.compress(text[:5000]) + gzip.compress(text[5000:])),
                              ("c.xyz.gz", gzip.compress(b"2000\n\n" + b"".join(b"H " + row + b"\n" for row in
                                                                               text.splitlines())))]:
            self.put(name, content)
            got = np.array([row.split() for row in self.rows(name, "--format", "%q")], float)
            np.testing.assert_array_equal(got, points)
        whole = gzip.compress(text)
        for content in [whole[:-200], whole[:3], b"", text, whole[:-6] + b"xxxxxx", whole + b"more"]:
            self.refuse(self.put("d.txt.gz", content), "-o", "out.npz", says="d.txt.gz: ")
        self.refuse(self.put("a.npy.gz", whole), says=["a.npy.gz", "gunzip"])
        self.refuse(self.put("a.gz", whole[:9]), says="a.gz: ")
        self.put("e.txt.gz", gzip.compress(b"1 2 3\n1 2\n"))
        self.refuse("e.txt.gz", says="e.txt.gz:2: ")

    def test_damaged(self):
        rows = [f"{i} H {row} 0.5\n" for i, row in enumerate(text_of(random_points(20)).splitlines())]
        self.put("a.xyz", "20\nLattice=\"2 0 0 0.5 1 0 0 0 1\" pbc=\"T T F\" "
                          "Properties=id:I:1:species:S:1:pos:R:3:q:R:1\n" + "".join(rows))
        self.damage("a.xyz", "q")
        self.put("a.vasp", "c\n1\n2 0 0\n0.5 1 0\n0 0 1\nCu Ni\n10 10\nDirect\n" + text_of(random_points(20)))
        self.damage("a.vasp")
