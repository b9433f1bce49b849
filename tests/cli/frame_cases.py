"""Frames of .xyz, extended XYZ, POSCAR, text packed by gzip, and domains that files state."""

import gzip
import json
import re
from pathlib import Path

import numpy as np

from cli_test import CUBE, ROOT, CliTest, random_points, text_of
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
        self.assertRegex(self.run_cli("a.xyz").stdout, r"(?m)^input +frame 1 of 3 \(--frame 0\)$")
        self.refuse("a.xyz", "--frame", "3", says=["frame 3 is missing", "has 3"])
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
            self.assertEqual(self.json(name)["domain"]["from"], "stated")
        # Arrays as the package extxyz 0.2.2 writes them, and 0.4.6 reads them. The columns of a matrix are edges.
        matrix = json.dumps([cell[k::3] for k in range(3)])
        for text in (f"Lattice={matrix}", f"Lattice={matrix.replace(' ', '')}", f"Lattice={json.dumps(cell)}", f"Lattice=[ {matrix[1:-1]} ]"):
            for comment in (f"{text} pbc=[T, T, F] Origin=[-1.0, -2, 0]", f"Origin=[-1,-2,0] note=[[1, 2], [3, 4]] pbc=[T,T,F] {text} a=1"):
                state = self.json(file(comment))["domain"]
                self.assertEqual([state[name] for name in ("periodic", "origin", "a", "b", "c")],
                                 [[True, True, False], [-1, -2, 0], cell[:3], cell[3:6], cell[6:]])
        for rows in ("[[4, 0, 0, 0], [4, 0], [0, 0, 4]]", "[[4, 0, 0], [0, 4, 0]]", "[[4, 0], [0, 4]]",
                     "[[4, 0, 0], [0, 4, 0], [0, 0, 4], [1, 1, 1]]"):
            self.refuse(file(f"Lattice={rows}"), says=["a.xyz:2:", "Lattice must hold three rows of three numbers"])
        # The species of .xyz are `species` before others.
        name = file(f"Properties=species:S:1:pos:R:3:element:S:1:typelabel:I:1 {lattice}", "H {} {} {} O 7")
        self.assertEqual({row.split()[-1] for row in self.rows(name, "--copy", "species", "--format", "%i")}, {"H"})
        # ASE writes texts with quotes so. They hold no keys.
        name = file(f"""note="5\\" film, old pbc='F F F' " {lattice} pbc="T T F" run='no \\'pbc=F' """)
        self.assertEqual(self.json(name)["domain"]["periodic"], [True, True, False])
        name = file(f'{lattice} Origin="1 2 3" pbc="T T T"')
        self.assertEqual(self.json(name)["domain"]["origin"], [1, 2, 3])
        name = file(f"{lattice} properties=id:I:1:species:S:1:radius:R:1:forces:R:3:pos:R:3",
                    "{0:.0f}5 H 0.25 1 2 3 {0} {1} {2}")
        rows = self.rows(name, "--radii", "radius", "--format", "%i %q %r")
        self.assertEqual(rows[0].split(), [f"{places[0][0]:.0f}5", *map(str, places[0].tolist()), "0.25"])
        self.run_cli(name, "--weights", "forces_2")
        self.refuse(name, "--weights", "species", says="'H'")
        self.refuse(name, "--weights", "q", says=["'q'", "forces_3"])
        # Periodic axes without lengths.
        name = file('pbc="T F T"')
        self.refuse(name, says=["periodic", "--periodic none"])
        self.assertEqual(self.json(name, "--periodic", "none")["domain"]["from"], "default")
        box = ["--box=-1,-1,-1,3,3,3"]
        self.assertEqual(self.json(name, *box)["domain"]["periodic"], [True, False, True])
        for comment, says in [('Lattice="1 2 3 4"', "9 numbers"), ('Lattice="1 0 0 0 1 0 0 0 a"', "'a'"),
                              ('pbc="T T"', "three"), ('pbc="T T x"', "'T T x'"), ("Properties=pos:R:2", "pos:R:3"),
                              ("Properties=species:S:1:pos:R", "pos:R:3"), ("Properties=pos:R:3", "4 columns")]:
            self.refuse(file(comment), says=["a.xyz:", says])

    def test_pairs_of_comments(self):
        """Every key that is read is read, or its comment is refused: blanks around =, quotes and brackets without end."""
        lattice, rows = 'Lattice="5 0 0 0 6 0 0 0 7"', "Cu 1 1 1\nCu 2 3 4\n"

        def file(comment):
            return self.put("a.xyz", f"2\n{comment}\n{rows}")

        for comment in ("Lattice=[5,6,7]", "Lattice=[5 6 7]", 'Lattice="5 6 7"', "Lattice = [5, 6, 7]", lattice.replace("=", "= "), lattice.replace("=", " ="),
                        f"a= {lattice}", f"a=b = {lattice}", f"title='don't' {lattice}", f'a=b"c d" {lattice}', f"{lattice} {lattice}", lattice[:-1],
                        f'a="pbc=x" {lattice}', f"{lattice} pbc=T", f'{lattice} note="5 inch', f"= {lattice}", f"a = = {lattice}"):
            with self.subTest(comment):
                domain = self.json(file(comment))["domain"]
                self.assertEqual((domain["from"], domain["upper"], domain["periodic"]), ("stated", [5, 6, 7], [True] * 3))
        self.assertEqual(self.json(file(f'pbc = "T F T" {lattice} a'))["domain"]["periodic"], [True, False, True])
        for comment, says in ((f'{lattice} a=[1 2 pbc="F F F"', "the [ before '1 2 pbc="), (f'a="x {lattice}', """the " before 'x Lattice='"""),
                              (f"a=[[1, 2], [3, 4] {lattice}", "the [ before"), (f"a={{1 2 {lattice}", "the { before"), (f"a='1 2 {lattice}", "the ' before"),
                              (f'{lattice[:-1]} pbc="F F F"', """the " before '5 0"""), (f'{lattice[:-1]} pbc = "F F F"', """the " before '5 0"""),
                              (f'{lattice} Lattice="8 0 0 0 8 0 0 0 8"', "lattice has two values"), (f"{lattice} pbc=T pbc=F", "pbc has two values"),
                              (f"E=-1.2,{lattice}", "holds another key"), (f"E=1 info={lattice}", "holds another key"),
                              (f"x= {lattice.replace('=', ' = ')}", "has no key"), (f"title = {lattice.replace('=', ' = ')}", "has no key")):
            self.refuse(file(comment), says=["a.xyz:2: ", says])

    def test_cells_that_lack_edges(self):
        """A slab without vacuum, as ASE 3.29 and ZnH5MD write it, has no end there; a cell of zeros is none."""
        rows = "".join(f"Cu {row}\n" for row in text_of(random_points(6)).splitlines())
        for lattice, pbc, edge in [("4 0 0 0 4 0 0 0 0", "T T F", "c"), ("0 0 0 0 4 0 0 0 4", "F T T", "a"), ("4 0 0 0 0 0 0 0 4", "F F F", "b")]:
            self.put("a.xyz", f'6\nLattice="{lattice}" pbc="{pbc}" Properties=species:S:1:pos:R:3\n{rows}')
            report = self.json("a.xyz", "--verify")
            self.assertIsNone(report["box_volume"])
            self.assertEqual(report["domain"]["periodic"], [flag == "T" for flag in pbc.split()])
            self.refuse("a.xyz", "--periodic", says=f"a.xyz: edge {edge} of its domain is 0, but the domain repeats along it")
            self.assertEqual(self.json("a.xyz", "--box", "0,0,0,1,1,1")["box_volume"], 1)
        self.put("a.xyz", f'6\nLattice="0 0 0 0 0 0 0 0 0" pbc="F F F"\n{rows}')
        self.assertEqual(self.json("a.xyz")["domain"]["from"], "default")
        self.put("a.xyz", f'6\nLattice="0 0 0 0 0 0 0 0 0" pbc="T F F"\n{rows}')
        self.refuse("a.xyz", says="periodic axes without their lengths")
        self.put("a.xyz", f'6\nLattice="4 0 1 0 4 0 0 0 0" pbc="T T F" Properties=species:S:1:pos:R:3\n{rows}')
        self.put("q.txt", "1 2 3\n0.5 0.5 900\n")
        seeds = [int(row) for row in self.rows("a.xyz", "--locate", "q.txt")]
        shifts = np.stack(np.meshgrid(*2 * [np.arange(-3, 4)]), -1).reshape(-1, 2) @ [(4, 0, 1), (0, 4, 0)]
        away = np.array([[(1, 2, 3)], [(0.5, 0.5, 900)]])[:, :, None] - (random_points(6)[:, None] + shifts)
        self.assertEqual(seeds, (away**2).sum(3).min(2).argmin(1).tolist())
        self.run_cli("a.xyz", "--to-grid", "dtfe", "--shape", "4", "-o", "g.npy", "-o", "g.h5")
        self.assertEqual(np.load(self.folder / "g.npy").shape, (4, 4, 4))

    def test_no_origin(self):
        """dump extxyz of LAMMPS states no Origin: a box that begins elsewhere is named where that matters."""
        points = random_points(50) * [4, 4, 8] - [2, 2, 3]
        atoms = "".join(f"Cu {row}\n" for row in text_of(points).splitlines())
        comment = '50\nTimestep=0 {}pbc="{}" Lattice="4 0 0 0 4 0 0 0 8" Properties=species:S:1:pos:R:3\n' + atoms
        self.put("a.xyz", comment.format("", "T T F"))
        self.put("q.xyz", "1\n\nH 0 0 0\n")
        for options in ([], ["--frames", "all"], ["--locate", "q.xyz", "-o", "out.npy"]):
            self.refuse("a.xyz", *options, says=["of edge c", "no Origin", "dump extxyz", "Origin="])
        self.put("b.xyz", comment.format('Origin="-2 -2 -3" ', "T T F"))
        self.assertAlmostEqual(self.json("b.xyz")["volume_sum"], 128, 9)
        self.put("c.xyz", comment.format("", "T T T"))  # periodic along all edges: the corner does not matter
        self.put("d.xyz", comment.format('Origin="-2 -2 -3" ', "T T T"))
        one, other = ([float(v) for v in self.rows(name, "--format", "%v")] for name in ("c.xyz", "d.xyz"))
        np.testing.assert_allclose(one, other, rtol=1e-12)

    def test_ipi(self):
        """The cell in the comment of i-PI, by lengths and angles or as a matrix whose columns are the edges."""
        edges = np.array([(4.0, 0, 0), (0.5, 3.0, 0), (-0.25, 0.125, 5.0)])
        points = random_points(30) @ edges
        atoms = "".join(f"H {row}\n" for row in text_of(points).splitlines())
        lengths = np.linalg.norm(edges, axis=1)
        angles = [np.degrees(np.arccos(edges[i] @ edges[j] / lengths[i] / lengths[j])) for i, j in ((1, 2), (0, 2), (0, 1))]
        cells = {"abcABC": [*lengths, *angles], "H": edges.T.ravel(), "GENH": edges.ravel()}
        self.put("a.xyz", f'30\nLattice="{" ".join(map(repr, edges.ravel().tolist()))}"\n{atoms}')
        expected = np.array([row.split() for row in self.rows("a.xyz", "--format", "%q %v")], float)
        for kind, numbers in cells.items():
            for mark in ("()", "{}", "[]"):
                units = {"()": "positions{angstrom}  cell{angstrom}", "{}": "", "[]": "cell{atomic_unit}"}[mark]
                cell = "  ".join(repr(float(x)) for x in numbers)
                self.put("i.xyz", f"30\n# CELL{mark[0]}{kind}{mark[1]}:  {cell}  Step:  5  Bead:  0 {units}\n{atoms}")
                got = np.array([row.split() for row in self.rows("i.xyz", "--format", "%q %v")], float)
                np.testing.assert_allclose(got, expected, rtol=1e-12)
        self.assertEqual(self.json("i.xyz")["domain"]["periodic_from"], "assumed")
        for units in ("positions{angstrom} cell{atomic_unit}", "positions{angstrom}", "cell{angstrom}"):
            self.refuse(self.put("i.xyz", f"30\n# CELL(abcABC): 4 3 5 90 90 90 {units}\n{atoms}"), says=["i.xyz:2:", "i-PI", "angstrom"])
        self.refuse(self.put("i.xyz", f"30\n# CELL(H): 4 3 5 90 90 90\n{atoms}"), says=["CELL(H)", "9 numbers"])

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
            self.assertEqual((domain["from"], domain["periodic_from"], domain["periodic"]),
                             ("stated", "option", [True, True, False]))
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


class Regressions(CliTest):
    """Files of data/ that once gave asymmetric lists; their digits matter."""

    def test_verify(self):
        for name, options in [("spacing_1e-8_periodic.xyz.gz", ["--box", "0,0,0,1,1,1", "--periodic"]),
                              ("weights_above_spacing.csv.gz", ["--box=-2,-2,-2,2,2,2", "--weights", "w"])]:
            done = self.run_cli(str(Path(__file__).parent / "data" / name), *options, "--verify")
            self.assertRegex(done.stdout, "(?m)^verified +yes")


class FileDomains(CliTest):
    def dump(self, name, points, bounds, flags="pp pp pp"):
        return self.put(name, f"ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n{len(points)}\nITEM: BOX BOUNDS {flags}\n"
                              + "".join(" ".join(map(repr, row)) + "\n" for row in bounds) + "ITEM: ATOMS x y z\n"
                              + text_of(points))

    def test_periodic_box(self):
        points = random_points(200) * [2, 1, 1.5]
        self.put("a.npy", points)
        box = ["--box", "0,0,0,2,1,1.5"]
        for flags, axes in [("pp pp pp", "xyz"), ("pp ff pp", "xz"), ("ss mm pp", "z")]:
            name = self.dump("a.dump", points, [[0.0, 2.0], [0.0, 1.0], [0.0, 1.5]], flags)
            expected = self.rows("a.npy", *box, "--periodic", axes, "--format", "%n %v")
            self.assertEqual(self.rows(name, "--format", "%n %v"), expected)
            self.assertRegex(self.run_cli(name).stdout,
                             f"(?m)^domain +box 0,0,0 to 2,1,1.5, periodic {axes}; stated$")
        # Options override the file.
        self.assertEqual(self.rows(name, *box), self.rows("a.npy", *box))
        self.assertEqual(self.rows(name, "--periodic", "x"), self.rows("a.npy", *box, "--periodic", "x"))
        self.assertEqual(self.rows(name, "--periodic", "none"), self.rows("a.npy", *box))
        domain = self.json(name, "--periodic", "none")["domain"]
        self.assertEqual((domain["from"], domain["periodic_from"], domain["periodic"]), ("stated", "option", [False] * 3))

    def test_data_file_is_periodic(self):
        points = random_points(60)
        rows = "".join(f"{i} 1 {row}\n" for i, row in enumerate(text_of(points).splitlines()))
        self.put("a.data", f"comment\n\n60 atoms\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\nAtoms\n\n{rows}")
        self.put("a.npy", points)
        self.assertEqual(self.rows("a.data"), self.rows("a.npy", "--box", "0,0,0,1,1,1", "--periodic"))

    def test_sources(self):
        """A property that a rule of the format supplies is assumed."""
        corpus = ROOT / "tests/fuzz/readers/corpus"
        for kind, name, sources, axes in [
                ("lammps_dump/flags", "a.dump", "stated stated", "xy"), ("lammps_dump/no_flags", "a.dump", "stated assumed", "xyz"),
                ("lammps_data/full", "a.data", "stated assumed", "xyz"), ("xyz/extended", "a.xyz", "stated stated", "xz"),
                ("xyz/classic", "a.xyz", "default default", ""), ("poscar/direct", "POSCAR", "stated assumed", "xyz"),
                ("hdf5/own", "a.h5", "stated stated", "xz"), ("hdf5/snapshot", "a.h5", "stated default", ""),
                ("npz/savez", "a.npz", "stated stated", "xz"), ("text/rows", "a.txt", "default default", "")]:
            self.put(name, (corpus / kind).read_bytes())
            domain = self.json(name)["domain"]
            self.assertEqual((f"{domain['from']} {domain['periodic_from']}", domain["periodic"]),
                             (sources, [axis in axes for axis in "xyz"]), kind)
            domain = self.json(name, "--box=-9,-9,-9,9,9,9")["domain"]
            self.assertEqual((domain["from"], domain["periodic_from"]), ("option", "default"), kind)
            box, periodic = sources.split()
            text = self.run_cli(name).stdout
            self.assertRegex(text, f"(?m)^domain .*; {box if box == periodic else f'box {box}, periodicity {periodic}'}$")
        self.put("a.xyz", '1\nLattice="1 0 0 0 1 0 0 0 1"\nH 0 0 0\n')
        self.assertEqual(self.json("a.xyz")["domain"]["periodic_from"], "assumed")

    def test_tilted_box(self):
        a, b, c = np.array([2.0, 0, 0]), np.array([0.5, 1.0, 0]), np.array([-0.25, 0.125, 1.5])
        origin = np.array([1.0, -2.0, 0.5])
        points = origin + random_points(150) @ np.array([a, b, c])
        self.put("a.npy", points)
        cell = ["--cell", "2,0,0,0.5,1,0,-0.25,0.125,1.5", "--origin", "1,-2,0.5"]
        expected = self.rows("a.npy", *cell, "--format", "%n")
        lower, upper = origin, origin + [2, 1, 1.5]
        bounds = [[lower[0] - 0.25, upper[0] + 0.5, 0.5], [lower[1], upper[1] + 0.125, -0.25],
                  [lower[2], upper[2], 0.125]]
        name = self.dump("a.dump", points, [[float(x) for x in row] for row in bounds], "xy xz yz pp pp pp")
        self.assertEqual(self.rows(name, "--format", "%n"), expected)
        self.assertRegex(self.run_cli(name).stdout, "(?m)^domain +cell 2,0,0 .*, periodic abc; stated$")
        self.assertEqual(self.rows(name, "--periodic", "--format", "%n"), expected)
        # A slab: by the boundaries of the file, or by an option, which a data file needs.
        slab = self.rows("a.npy", *cell, "--periodic", "xy", "--list-walls", "--format", "%n %v")
        self.assertNotEqual(slab, self.rows("a.npy", *cell, "--list-walls", "--format", "%n %v"))
        self.assertEqual(self.rows(name, "--periodic", "xy", "--list-walls", "--format", "%n %v"), slab)
        flags = self.dump("f.dump", points, [[float(x) for x in row] for row in bounds], "xy xz yz pp pp ff")
        self.assertEqual(self.rows(flags, "--list-walls", "--format", "%n %v"), slab)
        self.run_cli(flags, "--verify", "-o", "slab.vtu")
        rows = "".join(f"{i} 1 {row}\n" for i, row in enumerate(text_of(points).splitlines()))
        self.put("a.data",
                 "comment\n\n150 atoms\n1 3 xlo xhi\n-2 -1 ylo yhi\n0.5 2 zlo zhi\n0.5 -0.25 0.125 xy xz yz\n\n"
                           f"Atoms # atomic\n\n{rows}")
        self.assertEqual(self.rows("a.data", "--format", "%n"), expected)
        self.assertEqual(self.rows("a.data", "--periodic", "xy", "--list-walls", "--format", "%n %v"), slab)
        self.put("u.data", (self.folder / "a.data").read_text().replace("comment\n", "LAMMPS, timestep = 0, units = metal\n", 1))
        self.put("u.dump", "ITEM: UNITS\nreal\n" + (self.folder / "a.dump").read_text())
        for name, units in [("u.data", "metal"), ("u.dump", "real")]:
            self.run_cli(name, "-o", "out.npz")
            with np.load(self.folder / "out.npz") as arrays:
                self.assertEqual(arrays["units"], units)
        # Scaled coordinates are fractions of the three edges.
        whole = (self.folder / "a.dump").read_text()
        head = whole[:whole.index("ITEM: ATOMS")]
        self.put("s.dump", head + "ITEM: ATOMS xs ys zs\n" + text_of(random_points(150)))
        got = np.array([row.split() for row in self.rows("s.dump", "--format", "%q")], float)
        np.testing.assert_allclose(got, points, rtol=0, atol=1e-14)

    def tables(self, *arguments):
        """Returns places and centroids in the tables of .csv, .xyz and .dump."""
        self.run_cli(*arguments, "--want", "centroids", "-o", "t.csv", "-o", "t.xyz", "-o", "t.dump")
        rows = {".csv": (1, ",", 1), ".xyz": (2, None, 1), ".dump": (9, None, 2)}
        return {kind: np.array([row.split(mark)[first:first + 6] for row in (self.folder / f"t{kind}").read_text().splitlines()[head:]], float)
                for kind, (head, mark, first) in rows.items()}

    def test_relative_codes_of_points_beyond_the_box(self):
        """%c and %p are relative to the point wrapped into the box, as in Voro++."""
        edges = np.array([[2.0, 0, 0], [0.5, 1.0, 0], [-0.9, 0.4, 1.5]])
        for domain, lattice in [(["--box", "0,0,0,2,1,1.5", "--periodic"], np.diag([2, 1, 1.5])),
                                (["--box=-5,0,0,5,1,1.5", "--periodic", "yz"], np.diag([0, 1, 1.5])),
                                (["--cell", ",".join(map(str, edges.ravel()))], edges),
                                (["--cell", ",".join(map(str, edges.ravel())), "--periodic", "xz"],
                                 edges * [[1], [0], [1]])]:
            inside = random_points(80) @ (edges if "--cell" in domain else np.diag([2, 1, 1.5]))
            moved = inside + np.random.default_rng(3).integers(-3, 4, (80, 3)) @ lattice
            self.put("a.npy", inside)
            self.put("b.npy", moved)
            for code in ["%c", "%p"]:
                near, far = ([np.array(re.findall(r"[-+.e0-9]+", row), float).reshape(-1, 3) for row in
                              self.rows(name, *domain, "--format", code)] for name in ["a.npy", "b.npy"])
                for one, other in zip(near, far, strict=True):
                    self.assertEqual(one.shape, other.shape)
                    apart = np.abs(one[:, None] - other[None]).max(axis=2)  # vertices in any order
                    self.assertLess(apart.min(axis=1).max(), 1e-12)
            # Tables have the centroid of the cell around the listed point, also of some cells alone.
            near, far = (self.tables(name, *domain) for name in ["a.npy", "b.npy"])
            for kind in near:
                np.testing.assert_array_equal(far[kind][:, :3], moved)
                np.testing.assert_allclose(near[kind][:, 3:] - near[kind][:, :3], far[kind][:, 3:] - far[kind][:, :3], rtol=0, atol=1e-12)
            np.testing.assert_array_equal(self.tables("b.npy", *domain, "--only", "5:60:7")[".csv"], far[".csv"][5:60:7])
            rows = [row.split() for row in self.rows("a.npy", *domain, "--format", "%q %c %C")]
            values = np.array(rows, float)
            np.testing.assert_allclose(values[:, :3] + values[:, 3:6], values[:, 6:], rtol=0, atol=1e-14)
