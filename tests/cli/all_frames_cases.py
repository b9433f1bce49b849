"""--frames: several frames of a file, in one pass."""

import gzip
import os
import subprocess
import threading

import numpy as np

from cli_test import CliTest, random_points, text_of

try:
    import h5py
except ImportError:
    h5py = None

EDGES = np.array([(2.0, 0, 0), (0.5, 1.5, 0), (-0.25, 0.125, 1.0)])


class AllFrames(CliTest):
    def frames(self, count=5, points=30):
        """Returns the points of frames whose number of points and cell change."""
        return [random_points(points + k, k) @ (EDGES * (1 + 0.1 * k)) + [1, -2, 3] for k in range(count)]

    def xyz(self, frames, name="a.xyz"):
        text = ""
        for k, points in enumerate(frames):
            lattice = " ".join(map(repr, (EDGES * (1 + 0.1 * k)).ravel().tolist()))
            text += f'{len(points)}\nLattice="{lattice}" Origin="1 -2 3" Timestep={10 * k} Properties=species:S:1:pos:R:3:m:R:1\n'
            text += "".join(f"{'Cu' if i % 2 else 'Zr'} {row} {i + k / 8}\n" for i, row in enumerate(text_of(points).splitlines()))
        return self.put(name, text)

    def dump(self, frames, name="a.dump"):
        text = ""
        for k, points in enumerate(frames):
            text += "ITEM: UNITS\nmetal\n" if k == 0 else ""  # LAMMPS writes them once
            text += f"ITEM: TIMESTEP\n{10 * k}\nITEM: NUMBER OF ATOMS\n{len(points)}\nITEM: BOX BOUNDS pp pp ff\n"
            text += "-9 9\n-9 9\n-9 9\nITEM: ATOMS id type x y z m\n"
            text += "".join(f"{i + 5} {i % 2 + 1} {row} {i}\n" for i, row in enumerate(text_of(points).splitlines()))
        return self.put(name, text)

    def test_text_equals_single_frames(self):
        frames = self.frames()
        for name in [self.xyz(frames), self.dump(frames), self.put("a.xyz.gz", gzip.compress((self.folder / "a.xyz").read_bytes()))]:
            single = [self.rows(name, "--frame", k, "--copy", "m", "--format", "%i %q %n %v") for k in range(5)]
            for chosen, numbers in [("all", range(5)), ("last", [4]), ("1:4", [1, 2, 3]), ("::2", [0, 2, 4]), ("3:", [3, 4]),
                                    ("1::3", [1, 4]), (":2", [0, 1]), ("4:99", [4])]:
                for threads in ["1", "0"]:
                    rows = self.rows(name, "--frames", chosen, "-t", threads, "--copy", "m", "--format", "%i %q %n %v")
                    expected = []
                    for k in numbers:
                        expected += [f"# frame {k}, timestep {10 * k}, {len(frames[k])} points", *single[k]]
                    self.assertEqual(rows, expected, (name, chosen))
            done = self.json(name, "--frames", "1:3", "--verify")
            self.assertEqual((done["frames"], done["points"], done["verified"]), (2, 63, True))
            self.assertRegex(self.run_cli(name, "--frames", "all").stdout, "(?m)^frames +5, from number 0 to 4, of 30 to 34 points$")
        self.assertRegex(self.run_cli("a.xyz", "--frames", "all").stdout, "(?m)^domain .*; moves from frame to frame$")
        self.assertRegex(self.run_cli("a.dump").stdout, r"(?m)^input +frame 1 of 5 \(--frame 0\), timestep 0$")

    def test_follow(self):
        points = random_points(300, 1)
        frames = [points + k * 1e-4 * random_points(300, 2) for k in range(4)]
        text = "".join("300\n\n" + "".join(f"X {row}\n" for row in text_of(p).splitlines()) for p in frames)
        self.put("moving.xyz", text)
        options = ["moving.xyz", "--frames", "all", "--box", "-1,-1,-1,2,2,2", "-x", "cpu"]
        rows = [self.rows(*options, *more, "--format", "%i %n %v %f") for more in ([], ["--follow"])]
        self.assertEqual(*rows)
        kept = [self.json(*options, *more)["kept_cells"] for more in ([], ["--follow"])]
        self.assertEqual(kept[0], 0)
        self.assertTrue(300 < kept[1] <= 900, kept)

    def test_files_of_one_frame(self):
        """Pictures, fits, subsets and queries of frames, and formats that hold one: each file is that of a run of its frame."""
        self.xyz(self.frames(4))
        inside = random_points(20, 9) @ EDGES + [1, -2, 3]
        self.put("q.npy", inside)
        self.put("q.txt", text_of(inside))
        self.put("rays.npy", np.column_stack([inside, np.tile([1.0, 2, -1, 3], (20, 1))]))
        covalent = ["--radii", "covalent"]
        for names, *options in [
            ("c.vtu",), ("c.npz", "--alpha", 3, *covalent), ("c.glb", "--color", "m", "--copy", "m"), ("c.npz", "--volumes", "m", "--normalize"),
            ("c.csv c.txt", "--only", "3:20", *covalent, "--format", "%i %r %n"), ("p.png", "--image-size", "64x64"),
            ("q.npy", "--locate", "q.npy", *covalent), ("q.npz q.vtu", "--probe", "q.npy", *covalent), ("t.npz", "--trace", "rays.npy"),
            ("q.npy", "--interpolate", "q.npy", "--values", "m"), ("g.npy g.png", "--to-grid", "dtfe", "--shape", 4, "--project", "z", *covalent),
        ]:
            def files(mark):
                named = [name.replace(".", mark + ".") for name in names.split()]
                return [word for name in named for word in ("--image" if name.endswith("png") else "-o", name)]

            with self.subTest(names=names, options=options):
                self.run_cli("a.xyz", "--frames", "1:4", *options, *files("-{frame}"))
                for k in range(1, 4):
                    self.run_cli("a.xyz", "--frame", k, *options, *files("-one"))
                    for name in names.split():
                        made, one = (self.folder / name.replace(".", f"-{mark}.") for mark in (k, "one"))
                        self.assertEqual(made.read_bytes(), one.read_bytes())
                        made.unlink()
        for query in (["--locate", "q.txt"], ["--interpolate", "q.txt", "--values", "m"], ["--trace", "rays.npy"]):
            lines = []
            for k in range(4):
                rows = self.rows("a.xyz", "--frame", k, *query)
                lines += [f"# frame {k}, timestep {10 * k}, {len(rows)} queries", *rows]
            self.assertEqual(self.rows("a.xyz", "--frames", "all", *query), lines)
        done = self.json("a.xyz", "--frames", "1:", "--locate", "q.txt", "-o", "all.txt")
        self.assertEqual((done["frames"], done["points"], done["queries"]), (3, 31 + 32 + 33, 60))
        done = self.json("a.xyz", "--frames", "1:", "--volumes", "m", "--normalize", "--verify")
        self.assertEqual((done["frames"], done["verified"]), (3, True))
        self.assertLess(done["fit"]["residual"], 1e-9)

    def test_tables(self):
        frames = self.frames()
        self.xyz(frames)
        self.run_cli("a.xyz", "--frames", "all", "-o", "t.csv", "-o", "t.xyz", "-o", "t.dump", "-o", "t.txt", "--format", "%i %v %s",
                     "--copy", "m,species")
        table = np.genfromtxt(self.folder / "t.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
        self.assertEqual(table.dtype.names, ("frame", "id", "x", "y", "z", "volume", "neighbors", "n3", "n4", "n5", "n6", "n7",
                                             "face_count", "edge_count", "vertex_count", "m", "species"))
        text = [row.split() for row in (self.folder / "t.txt").read_text().splitlines() if row[0] != "#"]
        np.testing.assert_array_equal(table["volume"], np.array([row[1] for row in text], float))
        np.testing.assert_array_equal(table["neighbors"], np.array([row[2] for row in text], int))
        np.testing.assert_array_equal(sum(table[f"n{k}"] for k in range(3, 8)), table["neighbors"])
        np.testing.assert_array_equal(np.column_stack([table[c] for c in "xyz"]), np.concatenate(frames))
        self.assertEqual(table["species"][:3].tolist(), ["Zr", "Cu", "Zr"])
        for name, volume in [("t.xyz", "volume"), ("t.dump", "c_volume")]:
            for k in range(5):
                chosen = table[table["frame"] == k]
                rows = [row.split() for row in self.rows(name, "--frame", k, "--copy", f"{volume},m,species", "--format", "%q %v")]
                np.testing.assert_array_equal(np.array([row[:3] for row in rows], float), frames[k])
                np.testing.assert_array_equal(np.array([row[4] for row in rows], float), chosen["volume"])
                # A dump states the bounds of a tilted box, which rounds them.
                np.testing.assert_allclose(np.array([row[3] for row in rows], float), chosen["volume"], rtol=1e-12)
                self.assertEqual([row[5] for row in rows], [repr(float(m)).removesuffix(".0") for m in chosen["m"]])
                self.assertEqual([row[6] for row in rows], chosen["species"].tolist())
            self.assertIn(f"timestep {20}", self.run_cli(name, "--frame", 2).stdout if name == "t.dump" else "timestep 20")
        for out in ["out.csv", "out.xyz", "out.dump"]:
            self.refuse("t.dump", "--copy", "c_volume", "-o", out, says=["'c_volume'", f"'{out}'", "rename"])
        self.run_cli("t.dump", "--copy", "element,m", "-o", "again.csv")
        self.assertIn(",m\n", (self.folder / "again.csv").read_text().replace("element,", ""))
        self.run_cli("a.xyz", "-o", "w.csv", "--want", "centroids,surfaces")
        head = (self.folder / "w.csv").read_text().splitlines()[0]
        self.assertEqual(head, "id,x,y,z,centroid_x,centroid_y,centroid_z,surface_area")

    def test_domain_of_tables(self):
        """Boxes, tilted cells and cells of any orientation come back from .xyz and .dump."""
        turned = EDGES @ np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        for name, domain, tolerance in [("box", ["--box=-1,0,0.5,3,2,2.25"], 0), ("cell", ["--cell", EDGES], 1e-15),
                                        ("turned", ["--cell", turned], 0)]:
            inside = random_points(40)
            if len(domain) == 2:
                points = inside @ domain[1] + [7, 0, -1]
                domain = ["--cell", ",".join(map(repr, domain[1].ravel().tolist())), "--origin", "7,0,-1"]
            else:
                points = inside * [4, 2, 1.75] + [-1, 0, 0.5]
            self.put("p.npy", points)
            for axes in ["none", "xy", "xyz"]:
                options = [*domain, "--periodic", axes, "--outside", "drop"]
                expected = self.json("p.npy", *options, "-o", "d.xyz", "-o", "d.dump")["domain"]
                for file in ["d.xyz", "d.dump"]:
                    found = self.json(file, "--outside", "drop")["domain"]
                    self.assertEqual((found["periodic"], found["from"]), (expected["periodic"], "stated"), (name, file))
                    np.testing.assert_allclose(found["lower"] + found["upper"], expected["lower"] + expected["upper"],
                                               rtol=tolerance, atol=tolerance)
                    self.assertAlmostEqual(self.json(file)["volume_sum"], self.json("p.npy", *options)["volume_sum"], 11)

    def test_hull(self):
        self.xyz(self.frames(3))
        self.run_cli("a.xyz", "--frames", "all", "--periodic", "none", "--box", "hull", "-o", "all.csv", "-o", "all.xyz")
        table = np.genfromtxt(self.folder / "all.csv", delimiter=",", names=True)
        for k in range(3):
            hull = ["--frame", k, "--box", "hull", "--periodic", "none"]
            self.run_cli("a.xyz", *hull, "-o", "one.csv")
            one = np.genfromtxt(self.folder / "one.csv", delimiter=",", names=True)
            chosen = table[table["frame"] == k]
            for name in one.dtype.names:
                np.testing.assert_array_equal(chosen[name], one[name])
            # A seed is its own nearest, and the middle of the seeds is inside their hull.
            self.put("q.npy", np.column_stack([one[c] for c in "xyz"]))
            self.put("middle.npy", np.load(self.folder / "q.npy").mean(axis=0)[None] + [[0], [99]])
            self.assertEqual(self.rows("a.xyz", *hull, "--locate", "q.npy"), [str(i) for i in range(len(one))])
            self.assertEqual([int(i) >= 0 for i in self.rows("a.xyz", *hull, "--locate", "middle.npy")], [True, False])
            volumes = [float(v) for v in self.rows("a.xyz", *hull, "--probe", "middle.npy", "--format", "%v")]
            self.assertGreater(volumes[0], 0)
            self.assertEqual(volumes[1], 0)

    def test_ids_in_any_order(self):
        """Lists of neighbors have walls first, then ids that ascend."""
        points = random_points(50)
        ids = np.random.default_rng(4).permutation(50) + 1
        text = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n50\nITEM: BOX BOUNDS pp ff pp\n0 1\n0 1\n0 1\nITEM: ATOMS id x y z\n"
        self.put("any.dump", text + "".join(f"{i} {row}\n" for i, row in zip(ids, text_of(points).splitlines())))
        self.run_cli("any.dump", "-o", "any.npz", "--list-walls")
        with np.load(self.folder / "any.npz") as cells:
            named = [ids[j] if j >= 0 else j for j in cells["indices"]]
            lists = [sorted(named[a:b], key=lambda j: (j >= 0, j)) for a, b in zip(cells["indptr"], cells["indptr"][1:])]
        rows = [[int(j) for j in row.split()] for row in self.rows("any.dump", "--list-walls", "--format", "%n")]
        self.assertEqual(rows, lists)
        self.assertLess(min(map(min, rows)), 0)

    def test_numbers_as_species(self):
        self.dump(self.frames(2))
        self.run_cli("a.dump", "-o", "t.xyz", "-o", "t.dump", "--want", "volumes")
        self.assertIn(" Properties=type:I:1:pos:R:3:id:I:1:volume:R:1\n", (self.folder / "t.xyz").read_text())
        self.assertIn("\nITEM: ATOMS id type x y z c_volume\n5 1 ", (self.folder / "t.dump").read_text())
        self.put("p.npy", random_points(5))
        self.run_cli("p.npy", "-o", "t.xyz", "-o", "t.dump", "--want", "volumes")
        self.assertIn("\nX ", (self.folder / "t.xyz").read_text())
        self.assertIn("\nITEM: ATOMS id type x y z c_volume\n1 1 ", (self.folder / "t.dump").read_text())

    def test_refusals(self):
        frames = self.frames()
        whole = (self.folder / self.xyz(frames)).read_text()
        for value in ["1", "a", "1:2:3:4", "3:1", "::0", "-2:", "1.5:2", "all:"]:
            self.refuse("a.xyz", f"--frames={value}", says=["--frames must be all, last or a:b:c", f"'{value}'"])
        self.refuse("a.xyz", "--frames", "7:9", "-o", "out.txt", says=["frame 7:9 is missing", "has 5"])
        self.refuse("a.xyz", "--frames", "all", "--frame", 1, says="--frame or --frames")
        for name in ["out.npz", "out.vtu", "out.ply", "out.glb"]:
            self.refuse("a.xyz", "--frames", "all", "-o", name, says=[f"'{name}'", "out-{frame}" + name[3:]])
        self.refuse("a.xyz", "--frames", "all", "--image", "out.png", says=["'out.png'", "{frame}"])
        self.refuse("a.xyz", "--frames", "all", "--locate", "a.xyz", "-o", "out.npy", says=["'out.npy'", "{frame}"])
        self.refuse("a.xyz", "-o", "out-{frame}.vtu", says=["'out-{frame}.vtu'", "--frames all"])
        self.refuse("a.xyz", "--frames", "all", "--only", "-", says="--only -")
        self.refuse("a.xyz", "--frames", "all", "--memory", "1G", "-o", "out.h5", says="{frame}")
        self.refuse("--random", 5, "--frames", "all", says="--frames")
        self.refuse("a.xyz", "--points", says="--frames")
        # A failure in a later frame leaves no file. Frames before it can be read.
        line = whole.count("\n", 0, whole.rindex("Zr")) + 1
        for last, says in [("Zr 1 2\n", f"a.xyz:{line}: this row has 3 columns"), ("", "the file ends after"),
                           ("Zr 1 2 3 4\nCu 99 99 99 4\nmore\n", f"a.xyz:{line + 2}: more rows")]:
            self.put("a.xyz", whole[:whole.rindex("Zr")] + last)
            for threads in ["0", "1"]:
                self.refuse("a.xyz", "--frames", "all", "-o", "out.txt", "-t", threads, says=says)
            self.run_cli("a.xyz", "--frames", "0:4", "-q", "-o", "four.txt")
            (self.folder / "four.txt").unlink()
        self.assertRegex(self.run_cli("a.xyz", "--frame", 1).stdout, r"(?m)^input +frame 2 of several \(--frame 1\), timestep 10$")
        self.xyz(frames)
        self.refuse("a.xyz", "--frames", "all", "--box=0,-9,-9,9,9,2.9", "-o", "out.txt", says=["frame 0: ", "outside"])

    def test_frames_of_different_kinds(self):
        """Frames without atoms, and with other columns."""
        first = 'Lattice="1 0 0 0 1 0 0 0 1" Properties=species:S:1:pos:R:3:m:R:1\n'
        second = "2\n" + first.replace(":m:R:1", ":q:R:1:m:R:1") + "C .1 .1 .1 8 4\nH .6 .6 .6 9 5\n\n\n"
        self.put("a.xyz", f"0\n{first}{second}")
        rows = self.rows("a.xyz", "--frames", "all", "-o", "t.csv", "-o", "t.dump", "-o", "t.h5", "--copy", "m,species", "--radii", "covalent",
                         "--format", "%i %r")
        self.assertEqual(rows, ["# frame 0, 0 points", "# frame 1, 2 points", "0 0.76 4 C", "1 0.31 5 H"])
        table = [row.split(",") for row in (self.folder / "t.csv").read_text().splitlines()]
        self.assertEqual([len(row) for row in table], [15] * 3)
        self.assertEqual(self.rows("t.dump", "--frames", "all", "--format", "%i"), ["# frame 0, timestep 0, 0 points",
                                                                                    "# frame 1, timestep 1, 2 points", "1", "2"])
        self.put("b.xyz", f"1\n{first}C 0 0 0 1\n{second}")
        self.refuse("b.xyz", "--frames", "all", "--copy", "all", "-o", "out.csv", says=["frame 1: other columns", "--copy"])
        self.run_cli("b.xyz", "--frames", "all", "--copy", "all", "-o", "t.xyz")
        self.run_cli("b.xyz", "--frames", "all", "--copy", "m", "-o", "t.csv")

    def test_pipe_and_memory(self):
        frames = self.frames(400, 100)
        self.xyz(frames)
        os.mkfifo(self.folder / "pipe.xyz")
        expected = self.rows("a.xyz", "--frames", "all")

        def feed():
            (self.folder / "pipe.xyz").write_bytes((self.folder / "a.xyz").read_bytes())
        thread = threading.Thread(target=feed)
        thread.start()
        self.assertEqual(self.rows("pipe.xyz", "--frames", "all"), expected)
        thread.join()
        few, all_of_them = (self.json("a.xyz", "--frames", chosen, "-x", "cpu")["peak_memory_bytes"] for chosen in [":20", "all"])
        self.assertLess(all_of_them, few + 3e6)  # the file has 7.9 MB
        self.assertGreater((self.folder / "a.xyz").stat().st_size, 7e6)

    def test_stopped(self):
        self.xyz(self.frames(200, 500))
        with self.start("a.xyz", "--frames", "all", "-o", "out.txt", "--verify", stderr=subprocess.PIPE) as process:
            threading.Timer(0.3, process.terminate).start()
            self.assertEqual(process.wait(30), 143)
        self.assertNotIn("out.txt", self.files())


class FramesOfHdf5(CliTest):
    def setUp(self):
        super().setUp()
        if h5py is None:
            self.skipTest("h5py is not installed")

    def test_groups(self):
        points = [random_points(20 + k, k) for k in range(3)]
        self.put("a.xyz", "".join(f'{len(p)}\nLattice="1 0 0 0 1 0 0 0 1"\n' + "".join(f"H {row}\n" for row in text_of(p).splitlines())
                                  for p in points))
        self.run_cli("a.xyz", "--frames", "1:", "-o", "all.h5", "--want", "volumes,neighbors,centroids", "--copy", "species")
        with h5py.File(self.folder / "all.h5") as file:
            self.assertEqual(list(file), ["frame_000001", "frame_000002"])
            for k in [1, 2]:
                self.run_cli("a.xyz", "--frame", k, "-o", "one.h5", "--want", "volumes,neighbors,centroids", "--copy", "species")
                with h5py.File(self.folder / "one.h5") as one:
                    group = file[f"frame_{k:06d}"]
                    self.assertEqual(sorted(group), sorted(one))
                    for name in one:
                        np.testing.assert_array_equal(group[name][()], one[name][()])
                    self.assertEqual(one["species"][0], b"H")
                    self.assertEqual(set(group.attrs) - set(one.attrs), {"frame"})
                    np.testing.assert_array_equal(group.attrs["cell"], one.attrs["cell"])
            group = file["frame_000002"]
        got = np.array([row.split() for row in self.rows("all.h5", "--dataset", "frame_000001/centroids", "--format", "%q")], float)
        self.assertEqual(got.shape, (21, 3))

    def test_h5md(self):
        """As MDAnalysis, pyh5md and others write it."""
        frames = np.stack([random_points(25, k) @ EDGES for k in range(4)])
        cells = np.stack([EDGES * (1 + 0.1 * k) for k in range(4)])
        with h5py.File(self.folder / "a.h5", "w") as file:
            file.create_group("h5md").attrs["version"] = [1, 1]
            atoms = file.create_group("particles/all")
            atoms["position/value"] = frames
            atoms["position/step"] = [0, 5, 10, 20]
            atoms["velocity/value"] = frames
            atoms["force/value"] = frames
            atoms["id/value"] = np.tile(np.arange(25) + 3, (4, 1))
            atoms["mass"] = np.arange(25.0)
            atoms["charge/value"] = np.arange(100.0).reshape(4, 25)
            box = atoms.create_group("box")
            box["edges/value"] = cells
            box.attrs["boundary"] = ["periodic", "none", "periodic"]
        for k in range(4):
            self.put("p.npy", frames[k])
            options = ["--cell", ",".join(map(repr, cells[k].ravel().tolist())), "--periodic", "xz", "--outside", "drop"]
            expected = self.rows("p.npy", *options, "--format", "%v %s")
            rows = [row.split() for row in self.rows("a.h5", "--frame", k, "--outside", "drop", "--copy", "mass,charge", "--format",
                                                     "%i %v %s")]
            self.assertEqual([" ".join(row[1:3]) for row in rows], expected)
            np.testing.assert_array_equal(np.array([[row[0], *row[3:]] for row in rows], float),
                                          np.column_stack((np.arange(25) + 3, np.arange(25), np.arange(25) + 25 * k)))
        self.assertRegex(self.run_cli("a.h5", "--frame", 3, "--outside", "drop").stdout,
                         r"(?m)^input +frame 4 of 4 \(--frame 3\), timestep 20$")
        domain = self.json("a.h5", "--frames", "all", "--outside", "drop")["domain"]
        self.assertEqual((domain["from"], domain["periodic_from"], domain["periodic"]), ("stated", "stated", [True, False, True]))
        self.refuse("a.h5", "--frame", 4, says=["frame 4 is missing", "has 4"])
        for name, memory in [("whole.h5", []), ("pieces.h5", ["--memory", "1G"])]:
            self.run_cli("a.h5", "--frame", 2, "--outside", "drop", "--copy", "charge", "-o", name, *memory)
        with h5py.File(self.folder / "whole.h5") as whole, h5py.File(self.folder / "pieces.h5") as pieces:
            for array in ["charge", "ids", "volumes", "indices"]:
                np.testing.assert_array_equal(whole[array], pieces[array])
        more = ["--outside", "drop", "--copy", "charge", "--memory", "1G"]
        done = self.json("a.h5", "--frames", "::2", *more, "-o", "frame-{frame}.h5")
        self.assertEqual((done["frames"], done["points"]), (2, 50))
        with h5py.File(self.folder / "whole.h5") as whole, h5py.File(self.folder / "frame-2.h5") as pieces:
            for array in ["charge", "ids", "volumes", "indices"]:
                np.testing.assert_array_equal(whole[array], pieces[array])
        self.refuse("a.h5", "--frames", "7:", *more, "-o", "frame-{frame}.h5", says=["frame 7: is missing", "has 4"])
        self.refuse("a.h5", "--frames", "all", *more, "-o", "all.h5", says=["--memory", "{frame}"])
        self.refuse("a.h5", "--dataset", "particles/all/nothing", says=["particles/all/position/value"])
        with h5py.File(self.folder / "a.h5", "a") as file:
            del file["particles/all/box/edges"]
            file["particles/all/box/edges"] = [8.0, 9.0, 10.0]
        self.assertEqual(self.json("a.h5", "--frame", 2)["box_volume"], 720)
        with h5py.File(self.folder / "a.h5", "a") as file:  # no end along y, which does not repeat
            del file["particles/all/box/edges"]
            file["particles/all/box/edges"] = [8.0, 0.0, 10.0]
        domain = self.json("a.h5", "--frame", 2)["domain"]
        self.assertEqual((domain["a"], domain["b"], domain["c"]), ([8, 0, 0], [0, 0, 0], [0, 0, 10]))
        with h5py.File(self.folder / "a.h5", "a") as file:
            del file["particles/all/box/edges"]
            file["particles/all/box/edges/value"] = np.ones((3, 3))
        self.refuse("a.h5", says=["box/edges/value", "each of the 4 frames"])

    def test_h5md_of_several_programs(self):
        """Boxes, flags, steps and absent particles as ZnH5MD 0.4.8, NOMAD and others store them. Each frame equals its text."""
        rng, count, frames = np.random.default_rng(3), 20, 6
        places = rng.random((frames, count, 3)) * 4
        edges = np.array([np.diag(row) for row in rng.uniform(4, 5, (frames, 3))])
        flags = rng.random((frames, 3)) < 0.5
        flags[0] = True, True, True
        flags[1] = True, False, True
        mass = rng.random((frames, count))
        absent = rng.random((frames, count)) < 0.3
        absent[2] = True
        padding = np.arange(count) >= np.array([20, 13, 1, 20, 19, 7])[:, None]
        fixed = np.array(["periodic", "none", "periodic"], "S8")

        def element(group, name, value, step=None, **attributes):
            own = group.create_group(name)
            own["value"] = value
            if step is not None:
                own["step"] = step
                own["step"].attrs.update(attributes)
            return own

        def write(name, boundary=fixed, pbc=None, box_step=None, step=range(0, 60, 10), rows=slice(None), ids=None, gone=None, **attributes):
            with h5py.File(self.folder / name, "w") as file:
                atoms = file.create_group("particles/atoms")
                own = places.copy()
                if gone is not None:
                    own[gone] = np.nan if ids is None else 0
                element(atoms, "position", own, list(step) if isinstance(step, range) else step, **attributes)
                element(atoms, "mass", np.where(gone, np.nan, mass) if gone is not None else mass)
                if ids is not None:
                    atoms.create_group("id").create_dataset("value", data=np.where(gone, ids, np.arange(count)), fillvalue=ids)
                box = atoms.create_group("box")
                if boundary is not None:
                    box.attrs["boundary"] = boundary
                element(box, "edges", edges[rows], box_step)
                if pbc is not None:
                    element(box, "pbc", pbc)

        def check(name, axes, row_of=range(frames), gone=None, steps=range(0, 60, 10), ids=False):
            kept = [np.flatnonzero(~gone[k]) if gone is not None else np.arange(count) for k in range(frames)]
            self.put("t.xyz", "".join(
                f'{len(kept[k])}\nLattice="{" ".join(map(repr, edges[row_of[k]].ravel().tolist()))}" '
                f'pbc="{" ".join("T" if axis else "F" for axis in axes[k])}" step={steps[k]} '
                f"Properties={'id:I:1' if ids else 'n:I:1'}:pos:R:3:mass:R:1\n"
                + "".join(f"{i} {' '.join(map(repr, places[k][i].tolist()))} {float(mass[k][i])!r}\n" for i in kept[k]) for k in range(frames)))
            options = ["--frames", "all", "--copy", "mass", "--list-walls", "--format", "%i %q %v %n"]
            self.assertEqual(self.rows(name, *options), self.rows("t.xyz", *options))

        both = np.tile([True, False, True], (frames, 1))
        for kind in (float, "i1", bool):
            write("a.h5md", pbc=flags.astype(kind))
            check("a.h5md", flags)
        write("a.h5", pbc=np.full((frames, 3), np.nan))  # ZnH5MD, for frames without
        check("a.h5", both)
        for boundary in ([True, False, True], np.array([1, 0, 1]), ["periodic", "none", "periodic"]):
            write("a.h5", boundary=boundary)
            check("a.h5", both)
        write("a.h5", gone=padding)
        check("a.h5", both, gone=padding)
        for ids in (-1, 99):
            write("a.h5", gone=absent, ids=ids)
            check("a.h5", both, gone=absent, ids=True)
        write("a.h5", step=4, offset=7)
        check("a.h5", both, steps=range(7, 31, 4))
        write("a.h5", step=1)
        check("a.h5", both, steps=range(frames))
        for rows, step, used in [([0], [0], [0] * 6), ([0, 3, 5], [0, 15, 40], [0, 0, 3, 3, 5, 5]), ([0, 2, 4], 20, [0, 0, 2, 2, 4, 4]),
                                 ([0, 1, 2, 3, 4, 5, 5, 5], [0, 1, 10, 30, 40, 45, 50, 60], [0, 2, 2, 3, 4, 5])]:
            write("a.h5", rows=rows, box_step=step)
            check("a.h5", both, row_of=used)
        write("a.h5", rows=[0, 1], box_step=[5, 10])
        self.refuse("a.h5", says=["box/edges/value", "each of the 6 frames", "not later than frame 0"])
        places[1, 4] = np.nan  # within a frame: a fault of the run
        write("a.h5")
        self.refuse("a.h5", "--frame", 1, says="point 4: x = nan")
        places[1] = np.nan
        write("a.h5")
        self.refuse("a.h5", "--frame", 1, says="point 0: x = nan")
        edges[:, 2] = 0
        write("a.h5")
        self.refuse("a.h5", "--frame", 0, says=["a.h5: edge c of its domain is 0", "--periodic"])

    def test_one_line_of_a_damaged_frame(self):
        """HDF5's messages are turned off on all threads."""
        with h5py.File(self.folder / "a.h5", "w") as file:
            file.create_dataset("particles/all/position/value", data=np.stack([random_points(50, k) for k in range(3)]),
                                chunks=(1, 50, 3), fletcher32=True)
            at = file["particles/all/position/value"].id.get_chunk_info(2).byte_offset
        damaged = bytearray((self.folder / "a.h5").read_bytes())
        damaged[at + 100] ^= 1
        self.put("a.h5", bytes(damaged))
        for threads in (1, 2):
            self.refuse("a.h5", "--frames", "all", "-t", threads, "-o", "out.csv", says="cannot be read")

    def test_mdtraj(self):
        frames = np.stack([random_points(25, k) * [2, 3, 4] for k in range(3)]).astype(np.float32)
        with h5py.File(self.folder / "a.h5", "w") as file:
            file["coordinates"], file["time"] = frames, np.arange(3.0)
            file["cell_lengths"] = np.tile(np.float32([2, 3, 4]), (3, 1))
            file["cell_angles"] = np.array([[90, 90, 90], [90, 90, 60], [90, 90, 90]], np.float32)
        for k, cell in enumerate(["2,0,0,0,3,0,0,0,4", f"2,0,0,1.5,{float(3 * np.sqrt(0.75))!r},0,0,0,4"]):
            self.put("p.npy", frames[k].astype(float))
            rows = self.rows("a.h5", "--frame", k, "--format", "%q %n %v")
            expected = self.rows("p.npy", "--cell", cell, "--format", "%q %n %v")
            self.assertEqual([row.split()[:-1] for row in rows], [row.split()[:-1] for row in expected])
            np.testing.assert_allclose([float(row.split()[-1]) for row in rows], [float(row.split()[-1]) for row in expected],
                                       rtol=1e-12)
        self.assertEqual(self.json("a.h5", "--frames", "all")["frames"], 3)
        self.assertEqual(self.json("a.h5", "--frames", "all")["domain"]["periodic_from"], "assumed")
        # A cell with missing rows or without angles is not taken for none.
        for name, values in (("cell_lengths", np.ones((2, 3))), ("cell_lengths", np.ones((3, 2))), ("cell_angles", None)):
            with h5py.File(self.folder / "a.h5", "r+") as file:
                kept = file[name][()]
                del file[name]
                if values is not None:
                    file[name] = values
            self.refuse("a.h5", "--frame", 0, says=name)
            with h5py.File(self.folder / "a.h5", "r+") as file:
                file.pop(name, None)
                file[name] = kept
