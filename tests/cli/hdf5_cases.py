"""HDF5 input and output, written and read back by h5py."""

import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
import unittest

import numpy as np

from cli_test import CLI, JSON_KEYS, CliTest, random_points
from reader_cases import ReaderTest

try:
    import h5py
except ImportError:
    h5py = None


class Hdf5Test(ReaderTest):
    def save(self, name, attributes=(), **arrays):
        """Writes a file of these datasets; `a__b` is b in the group a. Attributes go to the group Header."""
        with h5py.File(self.folder / name, "w") as file:
            for path, array in arrays.items():
                file[path.replace("__", "/")] = array
            for key, value in dict(attributes).items():
                file.require_group("Header").attrs[key] = value
        return name


class Hdf5Module(CliTest):
    """The HDF5 module is loaded on demand, and a missing module gives a clear message."""

    def test_other_runs_do_without_it(self):
        traced = subprocess.run([shutil.which(CLI)], env={**os.environ, "LD_TRACE_LOADED_OBJECTS": "1"}, text=True,
                                capture_output=True, check=True)
        self.assertIn("libc.so", traced.stdout)
        self.assertNotIn("hdf5", traced.stdout)

    def test_missing(self):
        program = self.folder / "bin" / "clvotess"
        module = self.folder / "lib" / "votess" / "clvotess_hdf5.so"
        for folder in [program.parent, module.parent]:
            folder.mkdir(parents=True)
        shutil.copy(shutil.which(CLI), program)

        def refuse(*arguments, says):
            done = subprocess.run([program, *arguments], cwd=self.folder, text=True, capture_output=True, check=False)
            self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
            for text in ["lib/votess/clvotess_hdf5.so: ", "(build clvotess where libhdf5-dev is installed", *says]:
                self.assertIn(text, done.stderr)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertFalse((self.folder / "out.h5").exists())
        refuse("a.h5", says=["cannot read 'a.h5': ", "No such file"])
        refuse("--random", "50", "-o", "out.h5", says=["cannot write 'out.h5': ", "No such file"])
        module.write_bytes(b"no module")
        refuse("a.h5", says=["file too short"])
        own = pathlib.Path(shutil.which(CLI)).resolve().parents[1] / "lib" / "votess" / module.name
        if sys.platform == "linux" and own.exists():  # a module of another build: its symbol has another name
            names = set(re.findall(rb"clvotess_hdf5_[0-9a-f]{16}", own.read_bytes()))
            self.assertEqual(len(names), 1)
            module.write_bytes(own.read_bytes().replace(names.pop(), b"clvotess_hdf5_" + b"x" * 16))
            refuse("a.h5", says=["another build"])
        done = subprocess.run([program, "--random", "50", "-o", "out.npz"], cwd=self.folder, check=False,
                              capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)


@unittest.skipUnless(h5py, "NO h5py: HDF5 FILES ARE NOT TESTED (Debian: python3-h5py)")
class Hdf5Files(Hdf5Test):
    def test_datasets(self):
        points = random_points(400)
        for name in ["a.h5", "a.hdf5", "A.HDF5"]:
            self.assert_points(self.save(name, anything=points, mass=points[:, 0]), points)
        self.assert_points(self.save("a.h5", deep__er__points=points.astype("f4")), points.astype("f4"))
        self.assert_points(self.save("a.h5", points=points.astype(">f8")), points)
        self.assert_points(self.save("a.h5", points=points.astype("f2")), points.astype("f2"))
        self.assert_points(self.save("a.h5", points=np.zeros((0, 3))), np.zeros((0, 3)))
        self.save("two.h5", a=points, g__b=2 * points, g__ids=np.arange(400)[::-1], g__r=points[:, 0] / 9,
                  r=points[:, 1])
        self.refuse("two.h5", says=["several", "--dataset", "a g/b"])
        self.assert_points("two.h5", points, "--dataset", "a")
        for name in ["g/b", "/g/b"]:
            self.assert_points("two.h5", 2 * points, "--dataset", name, ids=range(399, -1, -1))
        self.assert_column("two.h5", points[:, 0] / 9, "r", "--dataset", "g/b")  # first in the group of the points
        self.assert_column("two.h5", points[:, 1], "/r", "--dataset", "a")
        with h5py.File(self.folder / "packed.h5", "w") as file:
            file.create_dataset("points", data=np.zeros((20000, 3)) + 0.5, chunks=(512, 3), compression="gzip",
                                shuffle=True)
            file["points"][:100] = points[:100]
            file["points"][100:20000] = random_points(19900)
        self.assert_points("packed.h5", np.concatenate([points[:100], random_points(19900)]))

    def test_refused(self):
        points = random_points(30)
        box = {"BoxSize": 75000.0}
        for name, says in [(self.save("a.h5", a=points[:, :1]), "(N, 3) or (N, 2)"),
                           (self.save("b.h5", a=points.astype(int)), "(N, 3)"),
                           (self.save("x.h5", **dict(zip("xyz", points.T))), "the arrays x, y, z of an .npz"),
                           (self.save("c.h5", a=points, b=points), ["a b", "--dataset"]),
                           (self.save("d.h5", box, PartType0__Coordinates=points, PartType1__Coordinates=points),
                            "PartType0/Coordinates PartType1/Coordinates"),
                           (self.put("e.h5", b"1 2 3\n"), "not an HDF5 file"),
                           (self.put("f.h5", b""), "not an HDF5 file"),
                           ("absent.h5", ["absent.h5", "No such file"])]:
            self.refuse(name, "-o", "out.npz", says=[name] + ([says] if isinstance(says, str) else says))
        with h5py.File(self.folder / "w.h5", "w") as file:  # which HDF5 locks
            file["points"] = points
            file.flush()
            self.refuse("w.h5", says=["w.h5", "another program has it open"])
        self.refuse("c.h5", "--dataset", "q", says=["'q'", "a b"])
        self.refuse("c.h5", "--dataset", "a/b", says="'a/b'")
        self.refuse("a.h5", "--dataset", "a", says="(30, 1)")
        self.refuse("b.h5", "--dataset", "a", says="int64")
        self.refuse("c.h5", "--dataset", "a", "--radii", "b", says="3 numbers for each point")
        self.refuse("c.h5", "--dataset", "a", "--radii", "q", says="'q'")
        self.refuse("c.h5", "--dataset", "a", "--frame", "0", says="--frame")
        (self.folder / "folder.h5").mkdir()
        self.refuse("folder.h5", says="folder.h5")
        points[3, 2] = np.inf
        self.assertRegex(self.refuse(self.save("a.h5", a=points), says="inf"), r"\b3\b")
        with h5py.File(self.folder / "v.h5", "w") as file:
            layout = h5py.VirtualLayout((30, 3), "f8")
            layout[:] = h5py.VirtualSource("c.h5", "a", (30, 3))
            file.create_virtual_dataset("points", layout)
        self.refuse("v.h5", says="virtual")
        with h5py.File(self.folder / "w.h5", "w") as file:
            file.create_dataset("points", (100, 3), "f8", chunks=(10, 3))[:10] = points[:10]
        self.refuse("w.h5", says="more numbers")
        # libver="latest" of HDF5 2.0 (h5py 3.16) writes packed chunks with version 5 of the layout message; here, by
        # hand, a version that no HDF5 knows yet.
        with h5py.File(self.folder / "n.h5", "w") as file:
            file.create_dataset("points", data=random_points(30), chunks=(10, 3), compression="gzip")
        content = (self.folder / "n.h5").read_bytes()
        layout = b"\x03\x02\x03"  # version 3, chunked, of three sides
        self.assertEqual(content.count(layout), 1)
        self.refuse(self.put("n.h5", content.replace(layout, b"\x09\x02\x03")), says=["'points'", "a newer HDF5 than ", 'without libver="latest"'])

    def snapshot(self, base, parts, points, **header):
        """Gadget's layout, with the particles of type 1 in the even files only."""
        pieces = np.array_split(points, (parts + 1) // 2)
        for part in range(parts):
            own = pieces[part // 2] if part % 2 == 0 else points[:0]
            attributes = {"NumFilesPerSnapshot": parts, "NumPart_ThisFile": [9, len(own), 0, 0, 0, 0], "BoxSize": 1.0,
                          "NumPart_Total": np.array([9, len(points), 0, 0, 0, 0], "u4"),
                          "NumPart_Total_HighWord": np.zeros(6, "u4"), **header}
            arrays = {"PartType0__Coordinates": points[:9]}
            if len(own):
                first = sum(map(len, pieces[:part // 2]))
                arrays.update(PartType1__Coordinates=own, PartType1__Velocities=own * 2,
                              PartType1__ParticleIDs=np.arange(first, first + len(own), dtype="u8") + 1000,
                              PartType1__SmoothingLength=own[:, 0])
            self.save(f"{base}.{part}.hdf5" if parts > 1 else f"{base}.hdf5", attributes, **arrays)

    def test_snapshots(self):
        points = random_points(101)
        ids = range(1000, 1101)
        wish = ["--dataset", "PartType1/Coordinates"]
        self.snapshot("one", 1, points)
        self.assert_points("one.hdf5", points, *wish, ids=ids)
        self.snapshot("snap_010", 5, points)
        for name in ["snap_010.0.hdf5", "snap_010.hdf5", "snap_010"]:
            self.assert_points(name, points, *wish, ids=ids)
            self.assert_column(name, points[:, 0], "SmoothingLength", *wish)
        self.assertRegex(self.run_cli("snap_010", *wish).stdout, "(?m)^input +5 files of a snapshot$")
        self.refuse("snap_010.3.hdf5", *wish, says=["first", "'snap_010.0.hdf5'"])
        self.refuse("snap_010", "--dataset", "PartType2/Coordinates", says="PartType2/Coordinates")
        # BoxSize is the box; --periodic makes it periodic.
        for options, axes in [([], "not periodic"), (["--periodic"], "periodic xyz"), (["--periodic", "y"], "periodic y")]:
            source = "box stated, periodicity " + ("option" if options else "default")
            self.assertRegex(self.run_cli("snap_010", *wish, *options).stdout,
                             f"(?m)^domain +box 0,0,0 to 1,1,1, {axes}; {source}$")
            self.assertEqual(self.json("snap_010", *wish, *options)["box_volume"], 1)
        self.snapshot("sides", 1, points, BoxSize=[1.0, 2.0, 3.0])
        self.assertEqual(self.json("sides.hdf5", *wish, "--periodic")["domain"]["upper"], [1, 2, 3])
        self.snapshot("isolated", 1, points, BoxSize=0.0)
        self.assertEqual(self.json("isolated.hdf5", *wish)["domain"]["from"], "default")
        self.refuse("isolated.hdf5", *wish, "--periodic", says="--periodic needs a box")
        self.snapshot("outside", 1, points, BoxSize=0.5)
        self.refuse("outside.hdf5", *wish, says=["point", "outside the box"])
        (self.folder / "snap_010.0.hdf5").rename(self.folder / "renamed.hdf5")
        self.refuse("renamed.hdf5", *wish, says=["5 files", "NAME.0.hdf5"])
        self.snapshot("short", 3, points, NumPart_Total=np.array([9, 102, 0, 0, 0, 0], "u4"))
        self.refuse("short", *wish, says=["101 points", "102"])
        self.snapshot("gone", 3, points)
        (self.folder / "gone.2.hdf5").unlink()
        self.refuse("gone", *wish, says=["gone.2.hdf5", "No such file"])

    def test_groups_masses_and_periodicity(self):
        """Of snapshots: --dataset PartType1, MassTable, SWIFT's flag, and vectors that are no places."""
        points = random_points(300)
        with h5py.File(self.folder / "a.hdf5", "w") as file:
            for kind in [0, 1]:
                group = file.create_group(f"PartType{kind}")
                group["Coordinates"], group["Velocities"] = points + kind * 0.5, points * 9
                group["ParticleIDs"] = np.arange(300) + 5
            file["PartType0/CenterOfMass"] = points
            file["PartType0/Masses"] = np.arange(300.0)
            file.create_group("Header").attrs.update(BoxSize=2.0, MassTable=[0.5, 0.25, 0, 0, 0, 0], NumFilesPerSnapshot=1,
                                                     NumPart_ThisFile=[300, 300, 0, 0, 0, 0])
        for last in (2**63 - 1, 2**63):
            with h5py.File(self.folder / "ids.h5", "w") as file:
                file["points"], file["ids"] = points[:2], np.array([7, last], dtype="u8")
            if last < 2**63:
                self.assert_points("ids.h5", points[:2], ids=[7, last])
            else:  # HDF5 would convert it to 2**63 - 1
                self.refuse("ids.h5", says="row 1 = 9223372036854775808 is too large for int64")
        for name in ("ids", "id"):
            self.refuse(self.save("ids.h5", points=points, **{name: np.arange(2)}), says=[name, "expected a number for each of the 300 points"])
        message = self.refuse("a.hdf5", says=["PartType0/Coordinates", "PartType1/Coordinates"])
        self.assertNotIn("Velocities", message)
        self.assertNotIn("Velocities", self.refuse("a.hdf5", "--dataset", "PartType3", says="PartType1/Coordinates"))
        self.assert_points("a.hdf5", points + 0.5, "--dataset", "PartType1", ids=range(5, 305))
        self.assert_points("a.hdf5", points, "--dataset", "/PartType0/", ids=range(5, 305))
        for kind, masses in [(0, np.arange(300)), (1, np.full(300, 0.25))]:
            for copy in ["Masses", "all"]:
                self.run_cli("a.hdf5", "--dataset", f"PartType{kind}", "--density", "Masses", "--copy", copy, "-o", "out.npz")
                with np.load(self.folder / "out.npz") as arrays:
                    np.testing.assert_array_equal(arrays["Masses"], masses)
                    np.testing.assert_array_equal(arrays["density"], masses / arrays["volumes"])
        self.run_cli("a.hdf5", "--dataset", "PartType1", "--density", "Masses", "-o", "m.h5", "--memory", "1G")
        with h5py.File(self.folder / "m.h5") as file:
            np.testing.assert_array_equal(file["density"], masses / file["volumes"])
        self.refuse("a.hdf5", "--dataset", "PartType1", "--density", "Mass_", "-o", "out.h5", says="'Mass_'")
        self.assertEqual(self.json("a.hdf5", "--dataset", "PartType1")["domain"]["periodic"], [False] * 3)
        for group, name, value, periodic in [("RuntimePars", "PeriodicBoundariesOn", np.int32([1]), True),
                                             ("RuntimePars", "PeriodicBoundariesOn", np.int32([0]), False),
                                             ("Parameters", "InitialConditions:periodic", np.bytes_(b"1"), True),
                                             ("Parameters", "InitialConditions:periodic", "0", False)]:
            with h5py.File(self.folder / "a.hdf5", "a") as file:
                for old in {"RuntimePars", "Parameters"} & set(file):
                    del file[old]
                file.create_group(group).attrs[name] = value
            domain = self.json("a.hdf5", "--dataset", "PartType1")["domain"]
            self.assertEqual((domain["periodic"], domain["from"], domain["periodic_from"]), ([periodic] * 3, "stated", "stated"))
        self.assertEqual(self.json("a.hdf5", "--dataset", "PartType1", "--periodic", "x")["domain"]["periodic"], [True, False, False])

    def test_damaged(self):
        points = random_points(40)
        self.save("a.h5", points=points)
        self.damage_program("a.h5")
        with h5py.File(self.folder / "p.h5", "w", libver="latest") as file:
            file.create_dataset("points", data=points, chunks=(8, 3), compression="gzip", fletcher32=True)
        self.damage_program("p.h5")

    def test_own_domains_that_contradict_themselves(self):
        """The attributes of an own file are refused as arrays of .npz are; as written they give the domain, endless or skewed."""
        self.put("a.npy", random_points(20))
        for cell in ("2,0,0,-0.5,3,0,0.1,0.2,4", "1,0,0,0.5,0.9,0,0,0,0"):
            self.run_cli("a.npy", "--cell", cell, "--periodic", "xy", "--want", "vertices", "-o", "own.h5", "-o", "own.npz")
            for name in ("own.h5", "own.npz"):
                domain = self.json(name, "--dataset", "vertices", "--outside", "drop")["domain"]
                self.assertEqual([*domain["a"], *domain["b"], *domain["c"]], [float(x) for x in cell.split(",")])
        self.run_cli("a.npy", "--cell", "2,0,0,-0.5,3,0,0.1,0.2,4", "--periodic", "--want", "centroids", "-o", "own.h5")
        box, cell = np.array([(-0.5, 0, 0), (2.1, 3.2, 4)]), [(2, 0, 0), (-0.5, 3, 0), (0.1, 0.2, 4)]
        for attributes, says in [({"origin": None}, "there is a cell, and no origin"), ({"cell": None}, "there is an origin, and no cell"),
                                 ({"box": box + [(0, 0, 0), (1, 0, 0)]}, "box goes from -0.5 to 3.1 along x, the cell from -0.5 to 2.1"),
                                 ({"cell": np.multiply(cell, 2)}, "along x, the cell from -1 to 4.2"),
                                 ({"box": box * [1, 1, 0], "cell": None, "origin": None}, "box is flat along z, at 0")]:
            shutil.copy(self.folder / "own.h5", self.folder / "b.h5")
            with h5py.File(self.folder / "b.h5", "a") as file:
                for name, value in attributes.items():
                    del file.attrs[name]
                    if value is not None:
                        file.attrs[name] = value
            self.refuse("b.h5", "--dataset", "centroids", says=["b.h5: ", says])

    def test_attributes_that_are_no_domain(self):
        """Attributes of the root state a domain as arrays of .npz do; none is ignored silently."""
        points, box, flags = random_points(20), np.array([(0, 0, 0), (2, 3, 4.0)]), np.ones(3)

        def put(walls=None, **attributes):
            self.save("a.h5", points=points, **({} if walls is None else {"walls": walls}))
            with h5py.File(self.folder / "a.h5", "a") as file:
                file.attrs.update(attributes)

        put(box=box)
        self.assertEqual(self.json("a.h5")["domain"]["upper"], [2, 3, 4])
        for arrays, unread in [({"periodic": flags}, "periodic"), ({"cell": np.eye(3), "origin": np.zeros(3)}, "cell origin"),
                               ({"box": np.ones(3)}, "box"), ({"box": box.ravel()}, "box"), ({"box": box.T}, "box"), ({"box": "cubic"}, "box"),
                               ({"walls": np.ones((2, 4))}, "walls")]:
            put(**arrays)
            self.assertEqual(self.json("a.h5")["input"], f"not read as the domain, which needs a box of shape (2, 3): {unread}")
        for arrays, says in [({"box": box, "periodic": flags[:2]}, "periodic does not hold 3 numbers"), ({"box": box, "periodic": flags * 2}, "periodic holds 2"),
                             ({"box": box.T, "periodic": flags}, "box does not hold 2 rows of 3 numbers"), ({"box": np.ones(3), "periodic": flags}, "box does not hold 2 rows"),
                             ({"box": box, "cell": np.ones(3), "origin": flags}, "cell does not hold 3 rows of 3"),
                             ({"box": box, "walls": np.ones((2, 3))}, "expected shape (W, 4) of floats"),
                             ({"box": [(-np.inf,) * 3, (np.inf,) * 3], "periodic": flags, "cell": np.eye(3), "origin": np.zeros(3)}, "along x, the cell from 0 to 1")]:
            put(**arrays)
            self.refuse("a.h5", says=["a.h5: ", says])
        self.save("a.h5", {"BoxSize": 0.0}, PartType1__Coordinates=points)
        self.assertIn("no length: BoxSize", self.json("a.h5")["input"])
        for name, value in (("edges", np.ones(5)), ("edges", np.ones(2)), ("boundary", [b"periodic"]), ("boundary", b"none")):
            self.save("a.h5", particles__all__position=points)
            with h5py.File(self.folder / "a.h5", "a") as file:
                own = file.create_group("particles/all/box").attrs
                own.update({"edges": np.ones(3), "boundary": [b"periodic"] * 3, name: value})
            self.refuse("a.h5", says=[f"particles/all/box/{name} does not hold 3 "])

    def test_output_equals_npz(self):
        words = "neighbors,volumes,centroids,areas,normals,surfaces,radii,counts,vertices,faces"
        duplicates = self.put("d.txt", "0 0 0\n1 0 0\n0 0 0\n0 1 0.5\n")
        for source in [["--random", 3000], ["--random", 0], [duplicates], ["--random", 50, "--list-walls"]]:
            for want in [[], ["--want", words], ["--want", "volumes"]]:
                self.run_cli(*source, *want, "-o", "out.npz", "-o", "out.h5", "-o", "out.hdf5")
                with np.load(self.folder / "out.npz") as arrays, h5py.File(self.folder / "out.h5") as file:
                    self.assertEqual(sorted(arrays.files), sorted([*file, *file.attrs]))
                    texts = {"version", "domain_from", "periodic_from"}
                    for name in texts:
                        self.assertEqual(arrays[name], file.attrs[name].decode())
                    for name in set(arrays.files) - texts:
                        other = file[name][()] if name in file else file.attrs[name]
                        self.assertEqual((arrays[name].dtype, arrays[name].shape), (other.dtype, other.shape), name)
                        np.testing.assert_array_equal(arrays[name], other, name)
                self.assertEqual((self.folder / "out.h5").read_bytes(), (self.folder / "out.hdf5").read_bytes())

    def test_nested(self):
        """Groups 3,000 deep, and a circle of links, take neither time nor memory."""
        points = random_points(5)
        with h5py.File(self.folder / "deep.h5", "w", libver="latest") as file:
            group = file
            for _ in range(3000):
                group = group.create_group("g")
            group["points"] = points
        self.refuse("deep.h5", says="groups are nested more than 64 deep")
        with h5py.File(self.folder / "ring.h5", "w") as file:
            file["a/b/points"] = points
            file["a/b/again"] = file["/"]
            file["a/points"] = file["a/b/points"]
        self.assert_points("ring.h5", points)

    def test_probes(self):
        points, queries = random_points(40), random_points(5, seed=8)
        self.save("p.h5", points=points, r=0.2 * points[:, 0])
        self.save("q.h5", points=queries)
        self.save("0.h5", points=queries, r=np.zeros(5))
        asked = ["p.h5", "--box", "0,0,0,1,1,1", "--radii", "r", "-q", "--probe"]
        self.run_cli(*asked, "q.h5", "-o", "a.h5", "-o", "a.npz")
        self.run_cli(*asked, "0.h5", "-o", "b.h5")
        with h5py.File(self.folder / "a.h5") as a, h5py.File(self.folder / "b.h5") as b, np.load(self.folder / "a.npz") as c:
            for name in ("indptr", "indices", "volumes", "status"):
                np.testing.assert_array_equal(a[name], b[name], name)
                np.testing.assert_array_equal(a[name], c[name], name)

    def test_a_snapshot_told_alone(self):
        """The output holds domain, ids and units, and states them when it is read."""
        points = random_points(2000) * 100
        self.snapshot("snap", 2, points, BoxSize=100.0, UnitLength_in_cm=3.085678e21, HubbleParam=0.7)
        self.run_cli("snap", "--dataset", "PartType1/Coordinates", "--periodic", "xz", "-o", "out.h5", "-o", "out.npz",
                     "--want", "volumes,centroids", "--density", "SmoothingLength", "--copy", "Velocities")
        with h5py.File(self.folder / "out.h5") as file, np.load(self.folder / "out.npz") as arrays:
            self.assertAlmostEqual(file["volumes"][()].sum(), 1e6, places=3)
            np.testing.assert_array_equal(file["ids"], np.arange(1000, 3000))
            np.testing.assert_array_equal(file["Velocities"], points * 2)
            np.testing.assert_array_equal(file["density"], points[:, 0] / file["volumes"])
            np.testing.assert_array_equal(file.attrs["box"], [[0, 0, 0], [100, 100, 100]])
            np.testing.assert_array_equal(file.attrs["periodic"], [1, 0, 1])
            self.assertEqual((file.attrs["UnitLength_in_cm"], file.attrs["HubbleParam"]), (3.085678e21, 0.7))
            self.assertEqual((arrays["domain_from"], arrays["periodic_from"]), ("stated", "option"))
            self.assertEqual((arrays["UnitLength_in_cm"], arrays["HubbleParam"]), (3.085678e21, 0.7))
        for name in ["out.h5", "out.npz"]:
            domain = self.json(name, "--dataset", "centroids")["domain"]
            self.assertEqual((domain["from"], domain["upper"], domain["periodic"]),
                             ("stated", [100, 100, 100], [True, False, True]))
        self.put("in.npy", random_points(300) * 0.3 + 0.35)
        cell = ["--cell", "2,0,0,0.5,1.5,0,-0.25,0.125,1", "--origin=-0.1,0,0", "--periodic", "xy"]
        for options in [cell, ["--box", "0,0,0,1,1,1", "--wall-sphere", "0.5,0.5,0.5,0.7,200", "--wall", "1,1,1,2"]]:
            expected = self.json("in.npy", *options, "-o", "out.h5", "-o", "out.npz", "--want", "centroids,volumes")
            for name in ["out.h5", "out.npz"]:
                told = self.json(name)
                source = {"from": "stated", "periodic_from": "stated"}
                self.assertEqual(told["domain"], {**expected["domain"], **source})
                self.assertAlmostEqual(told["box_volume"], expected["box_volume"], places=12)

    def test_output_whole_or_not_at_all(self):
        self.refuse("--random", 50, "-o", "absent/out.h5", says="no folder")
        os.mkfifo(self.folder / "pipe.h5")
        self.refuse("--random", 50, "-o", "pipe.h5", says=["pipe.h5", "regular file"])
        (self.folder / "pipe.h5").unlink()

        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        done = self.run_cli("--random", 2000, "-o", "out.h5", code=1, preexec_fn=limit, restore_signals=False)
        self.assertRegex(done.stderr, r"\Aclvotess: cannot write 'out.h5'[^\n]*\n\Z")
        self.assertEqual(self.files(), [])


@unittest.skipUnless(h5py, "NO h5py: HDF5 FILES ARE NOT TESTED (Debian: python3-h5py)")
class Streamed(Hdf5Test):
    """--memory: the file equals that of a run in memory."""

    def least(self, *arguments, stdin=""):
        """Returns a value of --memory for blocks of some thousand points, in addition to clvotess itself."""
        said = self.run_cli(*arguments, "--memory", "1M", stdin=stdin, code=2).stderr
        return f"{int(re.search('is too little: .* give at least ([0-9]+)M', said)[1]) + 1}M"

    def assertSame(self, *arguments, stdin="", blocks=3, **options):
        """Asserts that whole files are equal."""
        self.run_cli(*arguments, "-x", "cpu", "-o", "whole.h5", stdin=stdin, **options)
        streamed = [*arguments, "-o", "streamed.h5"]
        told = self.json(*streamed, "--memory", self.least(*streamed, stdin=stdin), stdin=stdin, **options)
        self.assertGreaterEqual(told["blocks"], blocks)
        self.assertEqual([name for name in self.files() if name.startswith(".")], [])
        self.assertTrue((self.folder / "whole.h5").read_bytes() == (self.folder / "streamed.h5").read_bytes())
        return told

    def test_same_file(self):
        points = random_points(20000)
        points[5000:5050] = points[:50]  # duplicates
        self.put("a.npy", points)
        told = self.assertSame("a.npy")
        self.assertEqual(sorted(set(told) - set(JSON_KEYS)),
                         ["asked_cells", "blocks", "largest_block", "temporary_bytes"])
        self.assertEqual((told["points"], told["duplicates"], told["domain"]["from"]), (20000, 50, "default"))
        self.put("single.npy", points.astype("f4"))
        self.assertSame("single.npy", "--want", "centroids,counts,areas,normals,surfaces,radii", "--list-walls",
                        "--box", "0,0,0,1,1,1", "--periodic", "xy")
        self.assertSame("a.npy", "--cell", "1,0,0,0.4,1,0,-0.3,0.2,1", "--want", "volumes")
        self.assertSame("a.npy", "--wall", "1,1,1,1.5", "--outside", "drop")
        self.assertSame("--random", 20000, "--want", "counts")
        self.put("none.npy", points[:0])
        self.assertSame("none.npy", blocks=1)
        told = self.assertSame("a.npy", "--verify", "--box", "0,0,0,1,1,1", "--periodic", "--want", "volumes")
        self.assertEqual((told["verified"], told["proven"], told["verified_cells"]), (True, True, 20000))
        self.put("fortran.npy", np.asfortranarray(points))
        self.refuse("fortran.npy", "-o", "out.h5", "--memory", "400M", says="np.ascontiguousarray(points)")

    def test_domains_of_points(self):
        """The plane, the hull, and all of space."""
        points = random_points(15000)
        self.put("a.npy", points)
        self.put("flat.npy", points[:, :2])
        self.put("a.csv", "x,y,m\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points.tolist()))
        everything = "centroids,counts,areas,normals,surfaces,radii"
        told = self.assertSame("flat.npy", "--want", everything, "--box", "0,0,1,1", "--periodic", "--verify")
        self.assertEqual((told["dimensions"], told["verified"]), (2, True))
        self.assertSame("a.csv", "--2d", "--density", "m", "--copy", "m", "--box", "hull")
        self.assertSame("a.npy", "--box", "hull")
        points[:, 2] = 0.5
        self.put("level.npy", points)
        self.assertSame("level.npy", "--2d", "--box", "none", "--want", everything)

    def test_text(self):
        """A catalogue with clusters, ids and carried columns."""
        rng = np.random.default_rng(4)
        directions = rng.normal(size=(15000, 3)) + (0, 0, 2)
        points = directions * (rng.random((15000, 1)) ** 0.3 / np.linalg.norm(directions, axis=1)[:, None])
        points[9000:9100] = points[:100]  # duplicates
        points[9100:9150] = points[:50]
        rows = np.column_stack([rng.permutation(15000) + 7, points, rng.random((15000, 2))])
        lines = [",".join([str(int(row[0])), *map(repr, map(float, row[1:]))]) for row in rows]
        self.put("a.csv", "id,x,y,z,mass,r\n" + "\n".join(lines) + "\n\n")
        self.assertSame("a.csv", "--density", "mass", "--copy", "r")
        with h5py.File(self.folder / "streamed.h5") as file:
            self.assertAlmostEqual(np.nansum(file["density"][()] * file["volumes"][()]), rows[:, 4].sum(), places=8)
        self.assertSame("a.csv", "--radii", "r", "--copy", "mass", "--density", "mass")
        self.assertSame("a.csv", "--weights", "mass", "--copy", "all")
        self.put("long.csv", "id,x,y,z,mass,r\n" + "".join(f"{line}{'0' * 1200}\n" for line in lines))  # parts for threads
        self.assertSame("long.csv", "--weights", "mass", "--copy", "r")
        self.assertSame("-", stdin="# x y z\n" + "\n".join(line.replace(",", " ").rsplit(" ", 2)[0] for line in lines))
        self.put("rows.xyz", "\n".join(line.replace(",", " ").rsplit(" ", 2)[0] for line in lines))
        self.assertSame("rows.xyz")
        self.put("frames.xyz", "1\nframe\nAr 0.5 0.5 0.5\n")
        self.refuse("frames.xyz", "-o", "out.h5", "--memory", "400M", says=".xyz without frames")
        self.put("bad.csv", "id,x,y,z,mass,r\n" + "\n".join(lines) + "\n7,1\n")
        self.refuse("bad.csv", "-o", "out.h5", "--memory", "400M", says="bad.csv:15002: this row has 2 columns")

    def test_snapshot(self):
        points = 75 * random_points(12000)
        header = {"BoxSize": 75.0, "NumFilesPerSnapshot": 3, "UnitLength_in_cm": 3.0857e21}
        for part in range(3):
            own = slice(4000 * part, 4000 * (part + 1))
            self.save(f"snap.{part}.hdf5", header, PartType1__Coordinates=points[own],
                      PartType1__ParticleIDs=np.arange(12000)[::-1][own], PartType1__Masses=points[own, 0],
                      PartType1__Velocities=points[own])
        self.assertSame("snap", "--periodic", "--dataset", "PartType1/Coordinates", "--copy", "all")
        (self.folder / "snap.2.hdf5").unlink()
        self.refuse("snap", "--dataset", "PartType1/Coordinates", "-o", "out.h5", "--memory", "400M",
                    says="snap.2.hdf5")

    def test_failed_verification(self):
        # The library's report for wrong rows.
        environment = self.preloading(
            "#include <votess/stream.hpp>\n"
            "votess::StreamResult votess::tessellate_stream(StreamSource&, StreamSink& sink, const Options&,"
            "                                               const StreamOptions& stream)"
            "{ sink.begin({}); StreamResult result;"
            "  if (stream.verify) result.verified = {false, \"rows differ\", {\"euler\"}, 7}; return result; }\n")
        done = self.run_cli("--random", "50", "--memory", "400M", "--verify", "--json", "-o", "out.h5", code=3,
                            env=environment)
        told = json.loads(done.stdout)
        self.assertEqual((told["verified"], told["verified_cells"]), (False, 7))
        self.assertEqual(done.stderr, "clvotess: verification failed, no file was written: rows differ\n")
        self.assertEqual(self.files(), [])

    def test_refused(self):
        for options, says in [(["-o", "out.npz"], "only be written to .h5"), (["-o", "out.h5", "-o", "-"], "only be written to .h5"),
                              (["--want", "faces"], "share vertices"), (["--min-face", "0.1"], "--memory does not work with --min-face"),
                              (["--duplicates", "error"], "duplicate_of"),
                              (["--image", "a.png"], "--image"), (["-x", "lavapipe"], "on the CPU"),
                              (["--locate", "q.npy"], "--locate"), (["--temporary", ""], "is empty"),
                              (["--temporary", "absent"], "'absent'")]:
            self.refuse("--random", 50, "--memory", "400M", *options, says=says)
        for size in ["x", "G", "4Q", "-1", "nan", "4iG"]:
            self.refuse("--random", 50, f"--memory={size}", says="--memory must be a number of bytes such as")
        self.refuse("--random", 50, "--temporary", ".", says="--temporary goes with --memory SIZE only")
        self.put("a.ply", "ply\n")
        self.refuse("a.ply", "--memory", "400M", says="--memory reads .npy, .h5 and rows of text")
        points = random_points(9000)
        points[8765, 1] = 3
        self.put("a.npy", points)
        self.refuse("a.npy", "--memory", "400M", "-o", "out.h5", "--box", "0,0,0,1,1,1", "-q",
                    says="point 8765: y = 3 is outside the box")

    def test_stopped(self):
        """Ctrl-C and a full disk leave no files."""
        (self.folder / "temporary").mkdir()
        for seconds in [0, 0.6]:
            with self.start("--random", 8000000, "--memory", "400M", "-o", "out.h5", "--temporary", "temporary",
                            stderr=subprocess.PIPE, text=True) as run:
                self.assertIn("of temporary files in temporary", run.stderr.readline())
                time.sleep(seconds)
                run.send_signal(signal.SIGINT)
                self.assertEqual((run.wait(), run.stderr.read()), (130, "clvotess: stopped, no file was written\n"))
            self.assertEqual((self.files(), os.listdir(self.folder / "temporary")), (["temporary"], []))

        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        done = self.run_cli("--random", 9000, "-q", "-o", "out.h5", "--memory", "400M", code=1, preexec_fn=limit,
                            restore_signals=False)
        self.assertRegex(done.stderr, r"\Aclvotess: temporary file: it cannot grow beyond \d+ bytes: [^\n]*\n\Z")
        self.assertEqual(self.files(), ["temporary"])
