"""Queries among seeds: --locate, --probe, --interpolate, --trace and --to-grid."""

import re
import resource
import signal
import subprocess
import time
import unittest

import numpy as np

from cli_test import CUBE, CUBE_BOX, SANITIZED, CliTest, random_points, text_of


class Locate(CliTest):
    """--locate: the cell that contains each point of another file."""

    def expected(self, points, queries):
        return ((queries[:, None, :] - points[None, :, :]) ** 2).sum(axis=2).argmin(axis=1)

    def test_outputs(self):
        points, queries = random_points(300), random_points(500, seed=8)
        self.put("p.npy", points)
        self.put("q.npy", queries)
        expected = self.expected(points, queries)
        done = self.run_cli("p.npy", "--box", "0,0,0,1,1,1", "--locate", "q.npy", "-o", "ids.npy", "-o", "ids.txt")
        self.assertEqual(done.stdout, "located 500 queries among 300 seeds\n")
        found = np.load(self.folder / "ids.npy")
        self.assertEqual((found.dtype, found.shape), (np.int32, (500,)))
        np.testing.assert_array_equal(found, expected)
        np.testing.assert_array_equal(np.loadtxt(self.folder / "ids.txt", dtype=int), expected)
        text = "".join(f"{i}\n" for i in expected)
        self.assertEqual(self.run_cli("p.npy", "--box", "0,0,0,1,1,1", "--locate", "q.npy", "-o", "-").stdout, text)
        rows = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in queries.tolist())
        self.assertEqual(self.rows("p.npy", "--box", "0,0,0,1,1,1", "--locate", "-", stdin=rows), text.splitlines())

    def test_domains(self):
        self.put("cube.txt", CUBE)
        self.put("q.txt", "1.2 0 0\n0.5 0.5 0.5\n9 0 0\n")
        summary = self.json("cube.txt", "--box", CUBE_BOX, "--locate", "q.txt", "-o", "a.npy")
        self.assertEqual({k: summary[k] for k in ("points", "queries", "outside")},
                         {"points": 8, "queries": 3, "outside": 1})
        self.assertEqual(sorted(summary["seconds"]), sorted(["total", "read", "sort", "locate", "write"]))
        self.assertEqual(np.load(self.folder / "a.npy").tolist(), [1, 0, -1])
        self.assertEqual(self.rows("cube.txt", "--box", CUBE_BOX, "--periodic", "--locate", "q.txt"), ["1", "0", "1"])
        self.put("r.txt", "0 0 0 0.1\n1 0 0 1\n")
        self.assertEqual(self.rows("r.txt", "--box", CUBE_BOX, "--radii", "4", "--locate", "q.txt"), ["1", "1", "-1"])
        self.put("none.txt", "")
        self.assertEqual(self.rows("none.txt", "--box", CUBE_BOX, "--locate", "q.txt"), ["-1"] * 3)
        self.assertEqual(self.rows("cube.txt", "--box", CUBE_BOX, "--locate", "none.txt"), [])

    def test_refused(self):
        self.put("cube.txt", CUBE)
        self.put("q.txt", "0 0 0\n")
        self.put("nan.txt", "0 0 0\nnan 0 0\n")
        asked = ["cube.txt", "--locate", "q.txt"]
        for arguments, says in [(asked, "-o FILE.npy"), ([*asked, "-o", "a.npz"], ".npy and .txt, not 'a.npz'"),
                                ([*asked, "-o", "q.txt"], "'q.txt'"), ([*asked, "-o", "a.npy", "-o", "./a.npy"], "twice"),
                                ([*asked, "-o", "a.npy", "--want", "faces"], "--want is for cells"),
                                ([*asked, "-o", "a.npy", "--verify"], "--verify is for cells"),
                                ([*asked, "-o", "a.npy", "--image", "a.png"], "--image is for cells"),
                                ([*asked, "-o", "a.npy", "--slice", "z=0.5"], "--slice is for cells"),
                                ([*asked, "-o", "a.npy", "--seeds"], "--seeds is for cells"),
                                ([*asked, "-o", "a.npy", "-x", "gpu"], "CPU"), ([*asked, "-o", "-", "--json"], "stdout"),
                                (["cube.txt", "--locate", "", "-o", "a.npy"], "--locate is empty"),
                                (["-", "--locate", "-", "-o", "a.npy"], "stdin"),
                                (["cube.txt", "--locate", "gone.txt", "-o", "a.npy"], "gone.txt"),
                                (["cube.txt", "--locate", "nan.txt", "-o", "a.npy"], "nan")]:
            self.refuse(*arguments, says=says)


class Probe(CliTest):
    """--probe: the cell of each point of another file, compared with a run with that point added."""

    BOX = ["--box", "0,0,0,1,1,1"]

    def check(self, points, queries, *options, columns=()):
        """columns: radii of the points and of the queries, written as last columns."""
        rows = [np.hstack(row) for row in zip((points, queries), columns)] if columns else (points, queries)
        self.put("p.txt", text_of(rows[0]))
        self.put("q.txt", text_of(rows[1]))
        options = [*options, "--want", "neighbors,volumes,counts,centroids", "--list-walls", "--outside", "drop"]
        self.run_cli("p.txt", "--probe", "q.txt", "-o", "a.npz", "-q", *options)
        with np.load(self.folder / "a.npz") as file:
            probes = dict(file)
        for q, row in enumerate(rows[1]):
            self.put("one.txt", text_of([*rows[0], row]))
            self.run_cli("one.txt", "-x", "cpu", "-o", "one.npz", "-q", *options)
            with np.load(self.folder / "one.npz") as t:
                self.assertEqual(probes["status"][q], t["status"][-1])
                i = len(t["status"]) - 1
                if t["status"][-1] == 5:  # the cell of the seed there is the answer
                    i = t["duplicate_of"][-1]
                for name in ("face_counts", "edge_counts", "vertex_counts"):
                    self.assertEqual(probes[name][q], t[name][i], name)
                for name in ("indices", "shifts") if "shifts" in t else ("indices",):
                    np.testing.assert_array_equal(probes[name][slice(*probes["indptr"][q:q + 2])],
                                                  t[name][slice(*t["indptr"][i:i + 2])], name)
                for name in ("volumes", "centroids"):
                    np.testing.assert_allclose(probes[name][q], t[name][i], rtol=1e-9, atol=1e-12)
        return probes

    def test_domains(self):
        points, queries = random_points(40), random_points(4, seed=8)
        queries[1] = points[5]
        probes = self.check(points, np.vstack((queries, (2, 0, 0))), *self.BOX)
        self.assertEqual(probes["status"].tolist(), [0, 5, 0, 0, 7])
        self.assertEqual(probes["duplicate_of"].tolist(), [-1, 5, -1, -1, -1])
        self.check(points, queries, "--cell", "2,0,0,0.5,1,0,-0.2,0.1,1")

    def test_weights(self):
        points, queries = random_points(40), random_points(4, seed=8)
        radii = [0.2 * random_points(n, seed)[:, :1] for n, seed in ((40, 3), (4, 4))]
        for option in ("--radii", "--weights"):
            probes = self.check(points, queries, *self.BOX, option, "4", columns=radii)
        # Queries without that column, in every kind of file, have weight 0.
        self.put("r.txt", text_of(np.hstack((points, radii[0]))))
        self.put("0.txt", text_of(np.hstack((queries, 0 * radii[1]))))
        asked = ["r.txt", *self.BOX, "--weights", "4", "--format", "%i %n"]
        expected = self.rows(*asked, "--probe", "0.txt")
        self.put("1.txt", text_of(np.hstack((queries, 1 + 0 * radii[1]))))
        self.assertNotEqual(expected, self.rows(*asked, "--probe", "1.txt"))
        self.put("q.npy", queries)
        np.savez(self.folder / "q.npz", points=queries)
        self.put("q.csv", "x,y,z\n" + text_of(queries, ","))
        header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
        self.put("q.ply", header + "end_header\n" + text_of(queries))
        for name in ("q.npy", "q.npz", "q.csv", "q.ply"):
            self.assertListEqual(self.rows(*asked, "--probe", name), expected, name)
        self.assertListEqual(self.rows(*asked, "--probe", "-", stdin=text_of(queries)), expected)

    def test_outputs(self):
        points, queries = random_points(40), random_points(4, seed=8)
        queries[2] = points[7]
        self.put("p.txt", "".join(f"{100 + i} {row}\n" for i, row in enumerate(text_of(points).splitlines())))
        self.put("q.txt", "".join(f"{-i} {row}\n" for i, row in enumerate(text_of(queries).splitlines())))
        asked = ["p.txt", *self.BOX, "--probe", "q.txt"]
        # Rows have the ids of the queries. Neighbors are indices of points.
        done = self.run_cli(*asked, "-o", "a.npz", "-o", "a.txt", "-o", "a.vtu", "--format", "%i %q %s %n", "--want", "neighbors")
        self.assertEqual(done.stdout, "probed 4 queries among 40 seeds, 1 at the place of a seed\n")
        with np.load(self.folder / "a.npz") as file:
            self.assertEqual(file["ids"].tolist(), [0, -1, -2, -3])
            rows = np.split(file["indices"], file["indptr"][1:-1])
        text = [line.split() for line in (self.folder / "a.txt").read_text().splitlines()]
        self.assertEqual([int(words[0]) for words in text], [0, -1, -2, -3])
        np.testing.assert_array_equal(np.array([words[1:4] for words in text], float), queries)
        self.assertEqual([[int(j) for j in words[5:] if int(j) >= 0] for words in text], [row[row >= 0].tolist() for row in rows])
        self.assertIn(b'NumberOfCells="4"', (self.folder / "a.vtu").read_bytes())
        summary = self.json(*asked, "-o", "b.txt")
        self.assertEqual(list(summary), ["version", "points", "queries", "outside", "duplicates", "empty", "seconds"])
        self.assertEqual([summary[k] for k in list(summary)[1:6]], [40, 4, 0, 1, 0])
        self.assertEqual(list(summary["seconds"]), ["total", "read", "sort", "probe", "write"])
        self.assertEqual(self.rows("p.txt", "--probe", self.put("none.txt", "")), [])

    def test_without_a_box(self):
        """Cells of queries that reach infinity, in each output."""
        self.put("p.txt", text_of(random_points(20)))
        self.put("q.txt", "0.5 0.5 0.5\n3 3 3\n")
        asked = ["p.txt", "--probe", "q.txt"]
        codes = "%n;%v;%w;%g;%s;%t;%o;%a;%e;%E"
        inner, outer = (dict(zip(codes[1::3], row.split(";"))) for row in self.rows(*asked, "--format", codes))
        self.assertNotIn("inf", "".join(inner.values()))
        self.assertNotIn("-1", inner["t"])
        self.put("all.txt", text_of([*random_points(20), (3, 3, 3)]))
        again = self.rows("all.txt", "--box", "none", "--list-walls", "--format", codes)[20]
        for code, other in zip(codes[1::3], again.split(";"), strict=True):
            if code in "nvwgsaE":  # vertices have other numbers
                self.assertEqual(outer[code], other, code)
        for name in ("a.vtu", "a.xyz", "a.dump"):
            self.refuse(*asked, "-o", name, says="needs a box with ends, and without a box")
        self.run_cli(*asked, "-q", "-o", "a.csv", "-o", "a.npz")
        self.run_cli(*asked, "-q", "--box", "0,0,0,4,4,4", "-o", "b.csv", "-o", "a.vtu", "-o", "a.xyz", "-o", "a.dump")
        first = [(self.folder / name).read_text().split("\n")[0] for name in ("a.csv", "b.csv")]
        self.assertEqual(first[0], "id,x,y,z,volume,neighbors")
        self.assertEqual(first[1], first[0] + ",n3,n4,n5,n6,n7,centroid_x,centroid_y,centroid_z")

    def test_refused(self):
        self.put("cube.txt", CUBE)
        self.put("q.txt", "0 0 0\n")
        asked = ["cube.txt", "--probe", "q.txt"]
        for arguments, says in [(asked, "-o FILE"), ([*asked, "-o", "a.ply"], "not 'a.ply'"), ([*asked, "-o", "q.txt"], "'q.txt'"),
                                ([*asked, "-o", "a.npz", "--verify"], "--verify is for cells of the points"),
                                ([*asked, "-o", "a.npz", "--copy", "4"], "--copy is for cells"), ([*asked, "-o", "-", "--json"], "stdout"),
                                ([*asked, "-o", "a.npz", "--image", "a.png"], "--image is for cells"),
                                ([*asked, "-o", "a.npz", "--locate", "q.txt"], "not several"),
                                ([*asked, "-o", "a.npz", "--want", "cells"], "'cells'"), ([*asked, "-o", "a.npz", "-x", "gpu"], "CPU"),
                                (["cube.txt", "--probe", "", "-o", "a.npz"], "--probe is empty"),
                                (["-", "--probe", "-", "-o", "a.npz"], "stdin")]:
            self.refuse(*arguments, says=says)


class Interpolate(CliTest):
    """--interpolate: a field at the points of another file."""

    BOX = ["--box", "0,0,0,1,1,1"]

    def setUp(self):
        super().setUp()
        self.points, self.queries = random_points(400), 0.3 + 0.4 * random_points(60, seed=8)
        self.fields = np.column_stack((self.points @ (1, -2, 0.5), random_points(400, seed=9)[:, 0]))
        self.put("p.csv", "x,y,z,a,b\n" + text_of(np.hstack((self.points, self.fields)), ","))
        self.put("q.txt", text_of(self.queries))

    def test_outputs(self):
        asked = ["p.csv", *self.BOX, "--interpolate", "q.txt"]
        done = self.run_cli(*asked, "--values", "a,b", "-o", "a.npy", "-o", "a.txt")
        self.assertEqual(done.stdout, "interpolated 60 queries among 400 seeds\n")
        field = np.load(self.folder / "a.npy")
        self.assertEqual((field.dtype, field.shape), (np.float64, (60, 2)))
        np.testing.assert_array_equal(np.loadtxt(self.folder / "a.txt"), field)
        np.testing.assert_allclose(field[:, 0], self.queries @ (1, -2, 0.5), rtol=1e-11, atol=1e-11)
        self.assertTrue(np.all((field[:, 1] > self.fields[:, 1].min()) & (field[:, 1] < self.fields[:, 1].max())))
        one = self.rows(*asked, "--values", "b")
        np.testing.assert_array_equal(np.array(one, float), field[:, 1])
        laplace = np.array(self.rows(*asked, "--values", "a", "--natural", "laplace"), float)
        np.testing.assert_allclose(laplace, field[:, 0], rtol=1e-11, atol=1e-11)
        other = np.array(self.rows(*asked, "--values", "b", "--natural", "laplace"), float)
        self.assertGreater(np.abs(other - field[:, 1]).max(), 1e-3)

    def test_domains(self):
        self.put("far.txt", text_of(np.vstack((self.points[3], (5, 0, 0)))))
        asked = ["p.csv", *self.BOX, "--values", "b", "--interpolate"]
        summary = self.json(*asked, "far.txt", "-o", "a.npy")
        self.assertEqual(list(summary), ["version", "points", "queries", "without", "seconds"])
        self.assertEqual((summary["queries"], summary["without"]), (2, 1))
        self.assertEqual(list(summary["seconds"]), ["total", "read", "sort", "interpolate", "write"])
        found = np.load(self.folder / "a.npy")
        self.assertEqual(found[0], self.fields[3, 1])
        self.assertTrue(np.isnan(found[1]))
        inner = self.rows(*asked, "q.txt")
        self.put("moved.txt", text_of(self.queries + (1, 0, -2)))
        np.testing.assert_allclose(np.array(self.rows(*asked, "moved.txt", "--periodic"), float),
                                   np.array(self.rows(*asked, "q.txt", "--periodic"), float), rtol=1e-9)
        # Queries without the column have radius 0.
        radii = np.full((400, 1), 0.01)
        self.put("r.csv", "x,y,z,a,b,r\n" + text_of(np.hstack((self.points, self.fields, radii)), ","))
        self.put("qr.csv", "x,y,z,r\n" + text_of(np.hstack((self.queries, np.full((60, 1), 0.01))), ","))
        power = ["r.csv", *self.BOX, "--values", "b", "--radii", "r", "--interpolate"]
        np.testing.assert_allclose(np.array(self.rows(*power, "qr.csv"), float), np.array(inner, float), rtol=1e-9)
        self.assertNotEqual(self.rows(*power, "q.txt"), self.rows(*power, "qr.csv"))
        self.put("none.txt", "")
        self.assertEqual(self.rows(*asked, "none.txt"), [])
        self.assertEqual(self.rows("none.txt", *self.BOX, "--values", "4", "--interpolate", "q.txt"), ["nan"] * 60)

    def test_refused(self):
        asked = ["p.csv", "--interpolate", "q.txt"]
        for arguments, says in [([*asked, "-o", "a.npy"], "--values COLUMN"),
                                ([*asked, "--values", "a"], "-o FILE.npy"),
                                ([*asked, "--values", "a", "-o", "a.npz"], "not 'a.npz'"),
                                ([*asked, "--values", "c", "-o", "a.npy"], "c"),
                                ([*asked, "--values", "a,", "-o", "a.npy"], "--values 'a,' holds an empty name"),
                                ([*asked, "--values", "a", "--natural", "linear", "-o", "a.npy"], "sibson or laplace"),
                                ([*asked, "--values", "a", "--want", "faces", "-o", "a.npy"], "--want is for cells"),
                                ([*asked, "--values", "a", "--locate", "q.txt", "-o", "a.npy"], "not several"),
                                ([*asked, "--values", "a", "-o", "q.txt"], "'q.txt'"),
                                (["p.csv", "--values", "a", "-o", "a.npz"], "--values goes with --interpolate QUERIES or --to-grid"),
                                (["p.csv", "--natural", "laplace", "-o", "a.npz"], "--natural goes with"),
                                (["--random", "9", "--values", "a", "--interpolate", "q.txt", "-o", "a.npy"], "not with --random")]:
            self.refuse(*arguments, says=says)


class Trace(CliTest):
    """--trace: the cells along rays. C++ proves them (tests/cases/query/trace.cpp)."""

    def test_trace(self):
        points, origins = random_points(60), random_points(20, seed=9)
        rng = np.random.default_rng(5)
        directions, lengths = rng.normal(size=(20, 3)), rng.random(20) * 2
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        lengths[3] = 0
        self.put("p.npy", points)
        self.put("rays.txt", "".join(" ".join(map(repr, row)) + "\n" for row in np.column_stack((origins, directions, lengths)).tolist()))
        run = ("p.npy", "--box", "0,0,0,1,1,1", "--periodic", "--trace", "rays.txt")
        done = self.run_cli(*run, "-o", "cells.npz", "-o", "cells.txt")
        self.assertEqual(done.stdout, "traced 20 queries among 60 seeds, 1 without cells\n")
        with np.load(self.folder / "cells.npz") as arrays:
            offsets, seeds, parts = (arrays[name] for name in ("offsets", "seeds", "lengths"))
        self.assertEqual([a.dtype for a in (offsets, seeds, parts)], [np.int64, np.int32, np.float64])
        self.put("rays.npy", np.column_stack((origins, directions, lengths)))
        self.run_cli(*run[:-1], "rays.npy", "-o", "again.txt")
        self.assertEqual((self.folder / "again.txt").read_bytes(), (self.folder / "cells.txt").read_bytes())
        rows = (self.folder / "cells.txt").read_text().splitlines()
        for r in range(20):
            own = slice(offsets[r], offsets[r + 1])
            self.assertEqual(rows[r].split(), [str(x) for pair in zip(seeds[own].tolist(), parts[own].tolist()) for x in pair])
            self.assertAlmostEqual(parts[own].sum(), lengths[r], 12)
            away = points - origins[r]
            self.assertEqual(seeds[own][:1].tolist(), [((away - np.round(away)) ** 2).sum(axis=1).argmin()] * int(lengths[r] > 0))

    def test_refused(self):
        self.put("p.txt", CUBE)
        self.put("rays.txt", "0.5 0.5 0.5 1 0 0 1\n")
        self.refuse("p.txt", "--trace", "rays.txt", says="--trace needs an output")
        self.refuse("p.txt", "--trace", "rays.txt", "-o", "a.csv", says=".npz and .txt")
        self.refuse("p.txt", "--trace", "rays.txt", "--locate", "rays.txt", "-o", "a.txt", says="--trace")
        for count in (3, 6, 8):
            rows = ",".join("xyzabcde"[:count]) + "\n" + ",".join(["0.5"] * count) + "\n"
            self.put("row.csv", rows)
            self.put("row.txt", rows.split("\n")[1].replace(",", " ") + "\n")
            for name in ("row.csv", "row.txt"):
                self.refuse("p.txt", "--trace", name, "-o", "a.txt",
                            says=f"this row has {count} columns, expected the 7 of a ray: origin, direction and length")  # fmt: skip
        for name, says in (("a.npz", "not 'a.npz'"), ("a.dump", "not 'a.dump'"), ("POSCAR", "not 'POSCAR'"), ("a.xyz", "without a count first")):
            self.put(name, "1\n\nH 0 0 0\n")
            self.refuse("p.txt", "--trace", name, "-o", "a.txt", says=("rays are rows of text", says))
        self.put("short.npy", np.ones((2, 6)))
        self.refuse("p.txt", "--trace", "short.npy", "-o", "a.txt", says="expected (N, 7)")
        self.put("still.txt", "0.5 0.5 0.5 0 0 0 1\n")
        self.refuse("p.txt", "--trace", "still.txt", "-o", "a.txt", says="direction is 0")


class ToGrid(CliTest):
    """--to-grid: a field on a regular grid, as files and pictures."""

    BOX = ["--box", "0,0,0,1,2,3"]

    def setUp(self):
        super().setUp()
        self.points = random_points(300) * (1, 2, 3)
        self.put("p.csv", "x,y,z,a,<b>\n" + text_of(np.column_stack((self.points, random_points(300, seed=9)[:, :2])), ","))
        self.asked = ["p.csv", *self.BOX, "--shape", "4,5,6", "--to-grid"]

    def test_files_hold_the_same(self):
        both = [*self.asked, "mean", "--values", "a,<b>"]
        done = self.run_cli(*both, "-o", "g.npy", "-o", "g.h5", "-o", "g.vti")
        self.assertEqual(done.stdout, "a grid of 4, 5, 6 cells by mean from 300 seeds\n")
        grid = np.load(self.folder / "g.npy")
        self.assertEqual((grid.dtype, grid.shape), (np.float64, (4, 5, 6, 2)))
        data = (self.folder / "g.vti").read_bytes()
        for text in (b'WholeExtent="0 4 0 5 0 6" Origin="0 0 0" Spacing="0.25 0.4 0.5"', b'Name="a"', b'Name="&lt;b>"'):
            self.assertIn(text, data)
        raw = data[data.index(b"\n_") + 2:]
        for column in range(2):
            begin = column * (8 + 960)
            self.assertEqual(int.from_bytes(raw[begin:begin + 8], "little"), 960)
            numbers = np.frombuffer(raw[begin + 8:begin + 968]).reshape(6, 5, 4).T
            np.testing.assert_array_equal(numbers, grid[..., column])
        self.check_hdf5(grid)

    def check_hdf5(self, grid):
        try:
            import h5py
        except ImportError:
            return
        with h5py.File(self.folder / "g.h5") as file:
            np.testing.assert_array_equal(file["grid"][()], grid)
            self.assertEqual(file.attrs["columns"].decode(), "a,<b>")
            self.assertEqual(file.attrs["method"].decode(), "mean")
            np.testing.assert_array_equal(file.attrs["box"], ((0, 0, 0), (1, 2, 3)))

    def test_totals(self):
        self.run_cli("p.csv", *self.BOX, "--want", "volumes", "-o", "v.npz")
        volumes, a = np.load(self.folder / "v.npz")["volumes"], random_points(300, seed=9)[:, 0]
        self.run_cli(*self.asked, "mean", "--values", "a", "-o", "m.npy")
        self.assertAlmostEqual(np.load(self.folder / "m.npy").mean() * 6, volumes @ a, places=11)
        summary = self.json(*self.asked, "dtfe", "--periodic", "-o", "d.npy")
        self.assertEqual(list(summary), ["version", "points", "shape", "without", "seconds"])
        self.assertEqual((summary["shape"], summary["without"]), ([4, 5, 6], 0))
        self.assertEqual(list(summary["seconds"]), ["total", "read", "sort", "grid", "write"])
        self.assertAlmostEqual(np.load(self.folder / "d.npy").mean() * 6, 300, places=9)
        self.put("plane.txt", "".join(f"{x} {y} 0.5\n" for x in range(3) for y in range(3)))
        flat = self.run_cli("plane.txt", "--to-grid", "dtfe", "--shape", "2", "--box", "-1,-1,0,3,3,1", "-o", "f.npy")
        self.assertIn("9 in no tetrahedron, whose mass is left out", flat.stdout)

    def test_projections_and_pictures(self):
        for method in ("nearest", "sibson", "dtfe"):
            values = ["--values", "a", "--periodic"]
            self.run_cli(*self.asked, method, *values, "-o", "g.npy")
            self.run_cli(*self.asked, method, *values, "-o", "p.npy", "--project", "y", "-o", "p.vti", "--image", "p.png")
            whole, projected = (np.load(self.folder / name) for name in ("g.npy", "p.npy"))
            np.testing.assert_allclose(projected, whole.sum(1) * 0.4, rtol=1e-11)
            self.assertIn(b'WholeExtent="0 4 0 1 0 6" Origin="0 0 0" Spacing="0.25 2 0.5"',
                          (self.folder / "p.vti").read_bytes())
            png = (self.folder / "p.png").read_bytes()
            self.assertEqual((png[:4], png[16:24]), (b"\x89PNG", (4).to_bytes(4, "big") + (6).to_bytes(4, "big")))

    def test_refused(self):
        out = ["-o", "g.npy"]
        for arguments, says in [([*self.asked, "cic", "--values", "a", *out], "mean, dtfe, nearest or sibson"),
                                ([*self.asked, "mean", *out], "add --values COLUMN"),
                                ([*self.asked, "mean", "--values", "a"], "-o FILE.npy, FILE.h5 or FILE.vti"),
                                ([*self.asked, "mean", "--values", "a", "-o", "g.txt"], "not 'g.txt'"),
                                ([*self.asked, "mean", "--values", "a", "-o", "-"], "not '-'"),
                                ([*self.asked, "mean", "--values", "a", "--project", "w", *out], "must be x, y or z"),
                                ([*self.asked, "mean", "--values", "a", "--image", "g.png"], "add --project"),
                                ([*self.asked, "mean", "--values", "a", "--want", "faces", *out], "--want is for cells"),
                                ([*self.asked, "mean", "--values", "a", "--locate", "p.csv", *out], "not several"),
                                ([*self.asked, "mean", "--values", "a,<b>", "--project", "x", "--image", "g.png"], "one column"),
                                (["p.csv", "--to-grid", "dtfe", *out], "add --shape"),
                                (["p.csv", "--shape", "3", *out], "--shape goes with --to-grid"),
                                (["p.csv", "--project", "x", *out], "--project goes with --to-grid"),
                                (["p.csv", "--cell", "9,0,0,1,9,0,0,0,9", "--to-grid", "dtfe", "--shape", "2", "-o", "g.vti"],
                                 "of a skewed cell")]:
            self.refuse(*arguments, says=says)
        for shape in ("0", "1,2", "1,2,3,4", "2,,2", "x", "", "1,2,", "9999999"):
            self.refuse("p.csv", "--to-grid", "dtfe", "--shape", shape, *out, says="--shape ")


class Stops(CliTest):
    """Ctrl-C during a query, and threads that the system does not provide."""

    def stop(self, *arguments):
        # A signal before the query catches it ends the program at once, so it is sent later.
        for wait in (0.05, 0.5, 1.5):
            status, error, seconds = self.interrupted(wait, *arguments)
            self.assertLess(seconds, 3)
            if status != -signal.SIGINT:
                break
        self.assertEqual(status, 130, error)
        self.assertEqual(error, "clvotess: stopped, no file was written\n")

    def interrupted(self, wait, *arguments):
        """Returns exit status, stderr and seconds from the signal to the end. The signal is sent when it can be caught."""
        process = self.start("--random", 2000, "-t", 1, "-q", *arguments, stderr=subprocess.PIPE)
        self.addCleanup(process.kill)
        caught = 0
        deadline = time.monotonic() + 60
        while not caught & 1 << (signal.SIGINT - 1) and process.poll() is None and time.monotonic() < deadline:
            with open(f"/proc/{process.pid}/status", encoding="ascii") as status:
                caught = int(re.search(r"^SigCgt:\s*(\w+)", status.read(), re.MULTILINE)[1], 16)
            time.sleep(0.005)
        time.sleep(wait)
        began = time.monotonic()
        process.send_signal(signal.SIGINT)
        error = process.communicate(timeout=60)[1].decode()
        return process.returncode, error, time.monotonic() - began

    def test_interrupt(self):
        self.put("q.npy", random_points(3_000_000, seed=4))
        for query in (["--locate", "q.npy", "-o", "a.npy"], ["--probe", "q.npy", "-o", "a.npz"],
                      ["--to-grid", "dtfe", "--shape", "200", "-o", "a.npy"]):
            with self.subTest(query=query[0]):
                self.stop(*query)
                self.assertEqual(self.files(), ["q.npy"])

    @unittest.skipIf(SANITIZED, "a sanitizer takes all addresses")
    def test_threads(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))  # stacks of 8 MB each

        done = self.run_cli("--random", 100, "-t", 1024, "-x", "cpu", "-o", "a.npz", code=1, preexec_fn=limit)
        self.assertRegex(done.stderr, r"\Aclvotess: --threads 1024, but the system gives only \d+: request fewer[^\n]*\n\Z")
        self.assertEqual(self.files(), [])
