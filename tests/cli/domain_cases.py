"""Domains that files state: boxes of LAMMPS, periodic and tilted."""

import re
from pathlib import Path

import numpy as np

from cli_test import CliTest, random_points, text_of


class Regressions(CliTest):
    """Files of data/ whose lists were once asymmetric."""

    def test_verify(self):
        for name, options in [("spacing_1e-8_periodic.xyz", ["--box", "0,0,0,1,1,1", "--periodic"]),
                              ("weights_above_spacing.csv", ["--box=-2,-2,-2,2,2,2", "--weights", "w"])]:
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
                             f"(?m)^domain +box 0,0,0 to 2,1,1.5, periodic {axes}, of the file$")
        # What the user says goes before what the file says.
        self.assertEqual(self.rows(name, *box), self.rows("a.npy", *box))
        self.assertEqual(self.rows(name, "--periodic", "x"), self.rows("a.npy", *box, "--periodic", "x"))
        self.assertEqual(self.rows(name, "--periodic", "none"), self.rows("a.npy", *box))
        domain = self.json(name, "--periodic", "none")["domain"]
        self.assertEqual((domain["from"], domain["periodic"]), ("file", [False] * 3))

    def test_data_file_is_periodic(self):
        points = random_points(60)
        rows = "".join(f"{i} 1 {row}\n" for i, row in enumerate(text_of(points).splitlines()))
        self.put("a.data", f"comment\n\n60 atoms\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\nAtoms\n\n{rows}")
        self.put("a.npy", points)
        self.assertEqual(self.rows("a.data"), self.rows("a.npy", "--box", "0,0,0,1,1,1", "--periodic"))

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
        self.assertRegex(self.run_cli(name).stdout, "(?m)^domain +cell 2,0,0 .*, periodic abc, of the file$")
        self.assertEqual(self.rows(name, "--periodic", "--format", "%n"), expected)
        # A slab: by the boundaries of the file, or by the user, whom a data file needs for that.
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

    def test_relative_codes_of_points_beyond_the_box(self):
        """%c and %p are relative to where the point lies inside the box, as in Voro++."""
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
            rows = [row.split() for row in self.rows("a.npy", *domain, "--format", "%q %c %C")]
            values = np.array(rows, float)
            np.testing.assert_allclose(values[:, :3] + values[:, 3:6], values[:, 6:], rtol=0, atol=1e-14)
