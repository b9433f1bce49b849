"""Frames: read_frames(), and the files of clvotess --frames in other programs, where these are installed."""

import gc
import itertools
import os
import pathlib
import re
import subprocess
import types
import unittest

import numpy as np
from helpers import Folder, uniform, vt
from pyvotess import frames as module

EDGES = np.array([(9.0, 0, 0), (2.0, 8.0, 0), (-1.5, 1.0, 7.0)])
CORNER = np.array((-31.0, 17.5, 4.25))
PBC = (True, True, False)


def program():
    try:
        return module._program()
    except ImportError:
        return None


def positions(frame, count=120):
    return np.random.default_rng(frame).random((count, 3)) @ EDGES + CORNER


def xyz_of(frame, count=120):
    lattice, origin = " ".join(map(repr, EDGES.ravel().tolist())), " ".join(map(repr, CORNER.tolist()))
    return (
        f'{count}\nLattice="{lattice}" Origin="{origin}" pbc="T T F" Timestep={frame * 5} '
        "Properties=species:S:1:pos:R:3:force:R:3:q:R:1\n"
        + "".join(f"{'Cu' if i % 2 else 'Zr'} {x!r} {y!r} {z!r} 1 2 {i} {i / 4}\n"
                  for i, (x, y, z) in enumerate(positions(frame, count).tolist()))
    )


def atoms_like_ase(frame):
    return types.SimpleNamespace(get_positions=lambda: positions(frame), cell=EDGES, pbc=np.array(PBC), get_celldisp=lambda: CORNER)


def expected(frame, **options):
    return vt.tessellate(positions(frame), cell=EDGES, origin=CORNER, periodic=PBC, **options)


class Lists(unittest.TestCase):
    def test_list_and_iterator(self):
        atoms = [atoms_like_ase(k) for k in range(4)]
        for results in (vt.from_ase(atoms, threads=1, want="volumes"), vt.from_ase(tuple(atoms)), vt.from_ase(iter(atoms))):
            results = list(results)
            self.assertEqual(len(results), 4)
            for k, t in enumerate(results):
                np.testing.assert_array_equal(t.volumes, expected(k).volumes)
        self.assertEqual(vt.from_ase([]), [])
        seen = []

        def endless():
            for k in range(10**9):
                seen.append(k)
                yield atoms[k % 4]
        results = vt.from_ase(endless(), want="volumes")
        self.assertEqual([len(next(results)) for _ in range(3)], [120] * 3)
        self.assertEqual(seen, [0, 1, 2])  # an iterator is read as it is used
        with self.assertRaisesRegex(TypeError, "frame 1: atoms are a int"):
            vt.from_ase([atoms[0], 2])


@unittest.skipUnless(program(), "clvotess was not built")
class Text(unittest.TestCase):
    def test_periodic_only_if_it_is(self):
        cell = [(2, 0, 0), (0.5, 2, 0), (0, 0, 2)]
        for repeats, ends in ((False, "(0, 0, 0)>"), (True, "periodic abc>"), ((True, False, False), "periodic a>")):
            frame = vt.Frame(0, uniform(3), vt.Domain.cell(cell, periodic=repeats))
            self.assertTrue(repr(frame).endswith(ends), repr(frame))
        self.assertEqual(repr(vt.Frame(1, uniform(3))), "<pyvotess.Frame 1: 3 points, no domain>")


class Files(Folder):
    def put(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def run_cli(self, *arguments):
        subprocess.run([program(), *map(str, arguments)], cwd=self.folder, check=True, capture_output=True)

    def test_frames_without_points(self):
        """Ids and species are empty, so that those of all frames can be joined."""
        dump = "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS id element x y z m\n{}"
        xyz = '{1}\nLattice="1 0 0 0 1 0 0 0 1" Properties=species:S:1:pos:R:3:id:I:1:m:R:1\n{2}'
        rows = {dump: ("", "5 C .1 .1 .1 7\n", "6 O .2 .2 .2 8\n9 C .5 .5 .5 9\n"), xyz: ("", "C .1 .1 .1 5 7\n", "O .2 .2 .2 6 8\nC .5 .5 .5 9 9\n")}
        for form, name in ((dump, "a.dump"), (xyz, "a.xyz")):
            for order in itertools.permutations(range(3)):
                path = self.put(name, "".join(form.format(step, k, rows[form][k]) for step, k in enumerate(order)))
                frames = list(vt.read_frames(path, columns=["m"]))
                self.assertEqual([len(frame) for frame in frames], list(order))
                ids = np.concatenate([frame.ids for frame in frames])
                self.assertEqual((ids.dtype, sorted(ids.tolist())), (np.int64, [5, 6, 9]))
                self.assertEqual(sorted(sum((frame.species for frame in frames), [])), ["C", "C", "O"])
                self.assertEqual(sorted(np.concatenate([frame.columns["m"] for frame in frames])), [7, 8, 9])
                self.assertTrue(all(frame.tessellate().verify() for frame in frames))

    def test_read_frames(self):
        path = self.put("a.xyz", "".join(xyz_of(k) for k in range(6)))
        with vt.Tessellator(threads=1) as tessellator:
            numbers = []
            for frame in vt.read_frames(path):
                numbers.append(frame.number)
                np.testing.assert_array_equal(frame.points, positions(frame.number))
                self.assertEqual(frame.timestep, 5 * frame.number)
                self.assertEqual(frame.species, ["Zr", "Cu"] * 60)
                self.assertIsNone(frame.ids)
                np.testing.assert_array_equal(frame.columns["q"], np.arange(120) / 4)
                self.assertEqual(frame.domain, vt.Domain.cell(EDGES, origin=CORNER, periodic=PBC))
                for t in (frame.tessellate(tessellator), frame.tessellate(), vt.tessellate(frame.points, frame.domain)):
                    np.testing.assert_array_equal(t.volumes, expected(frame.number).volumes)
                self.assertIsNone(frame.tessellate(box=(-99, -99, -99, 99, 99, 99)).cell)
                frame.points[0] = 0  # belongs to the caller
        self.assertEqual(numbers, list(range(6)))
        self.assertEqual([f.number for f in vt.read_frames(str(path), frames="1::2")], [1, 3, 5])
        last, = vt.read_frames(path, frames="last", columns=["force", "q"])
        self.assertEqual((last.number, list(last.columns)), (5, ["force", "q"]))
        np.testing.assert_array_equal(last.columns["force"], np.column_stack((np.ones(120), np.full(120, 2), np.arange(120))))
        self.assertEqual(next(vt.read_frames(path, columns=())).columns, {})
        self.assertEqual(repr(last), "<pyvotess.Frame 5: 120 points, cell (9, 0, 0), (2, 8, 0), (-1.5, 1, 7) at (-31, 17.5, 4.25), periodic ab>")
        frames = vt.read_frames(path)
        next(frames)
        del frames  # ends the program that reads
        gc.collect()

    def test_write_frames(self):
        """What is written is read again: boxes and cells of any shape, types and elements, ids, columns of each kind, the plane."""
        rng = np.random.default_rng(4)
        turned = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        domains = [vt.Domain.box((-1, 0.1, 2, 3, 4, 5.7), periodic="xz"), vt.Domain.box((0.1, 0.2, 0.3, 1, 2, 3)),
                   vt.Domain.cell(EDGES, origin=CORNER, periodic=PBC), vt.Domain.cell(EDGES @ turned), vt.Domain.box((0, 0, 1, 1), periodic="x"),
                   vt.Domain.cell(((2, 0), (0.5, 1)))]
        for name in ("a.xyz", "a.extxyz", "a.dump", "a.lammpstrj"):
            frames = []
            for number in range(24):
                domain = domains[number % 6]
                count = int(rng.integers(0, 9))
                frames.append(vt.Frame(
                    number, rng.normal(size=(count, domain.dimensions)) * 10.0 ** rng.integers(-9, 9), domain, float(rng.integers(0, 99)),
                    rng.permutation(count) + 5 if number % 4 != 1 else None,
                    [None, ["Cu", "Zr"] * 9, ["1", "2"] * 9][number % 3] and [["Cu", "Zr"] * 9, ["1", "2"] * 9][number % 3 - 1][:count],
                ).with_columns(m=rng.normal(size=count), k=rng.integers(-9, 9, count), v=rng.normal(size=(count, 3)), name=["a", "b"] * 4 if count == 8 else ["c"] * count))
            vt.write_frames(self.folder / name, iter(frames))
            numbers = ["m", "k", *(["v_1", "v_2", "v_3"] if "dump" in name or "lammps" in name else ["v"])]
            read = list(vt.read_frames(self.folder / name, columns=[*numbers, "name"]))
            self.assertEqual(len(read), 24)
            for frame, found in zip(frames, read):
                flat = frame.points.shape[1] == 2
                np.testing.assert_array_equal(found.points[:, :frame.points.shape[1]], frame.points)
                self.assertFalse(flat and found.points[:, 2].any())
                self.assertEqual(found.timestep, frame.timestep)
                np.testing.assert_array_equal(found.domain.periodic[:2], frame.domain.periodic[:2])
                self.assertEqual(found.domain.periodic[2], not flat and frame.domain.periodic[2])
                ends = [d.limits if d.limits is not None else np.concatenate([d.vectors, [np.zeros(d.dimensions) if d.origin is None else d.origin]])
                        for d in (frame.domain, found.domain)]
                size = ends[0].shape[1]
                if len(ends[0]) == len(ends[1]):
                    np.testing.assert_array_equal(ends[1][[0, 1] if size == 2 else slice(None)][:, :size], ends[0][:2 if size == 2 else None])
                if frame.ids is not None:
                    np.testing.assert_array_equal(found.ids, frame.ids)
                if frame.species is not None:
                    self.assertEqual(list(found.species or []), list(frame.species))
                np.testing.assert_array_equal(np.column_stack([found.columns[k] for k in numbers]),
                                              np.column_stack([frame.columns[k] for k in ("m", "k", "v")]))
                self.assertEqual(found.columns["name"].tolist(), list(frame.columns["name"]))
        box = vt.Domain.box((0, 0, 0, 1, 1, 1))
        for frame, says in (
            (vt.Frame(3, np.ones((2, 3))), "frame 3: .* a box or a cell"), (vt.Frame(0, np.ones((2, 3)), vt.Domain.space()), "box or a cell"),
            (vt.Frame(0, np.ones((2, 3)), vt.Domain.box((0, 0, 0, 1, 1, np.inf))), "infinity"),
            (vt.Frame(0, np.ones((2, 3)), vt.Domain(box=(0, 0, 0, 1, 1, 1), walls=[(1, 1, 1, 2)])), "cut by 1 wall"),
            (vt.Frame(0, np.ones((2, 3)), box, columns={"a b": np.ones(2)}), "'a b' is not a name"),
            (vt.Frame(0, np.ones((2, 3)), box, columns={"a": np.ones(3)}), "'a' has shape"),
            (vt.Frame(0, np.ones((2, 3)), box, columns={"a": np.array(["x", "y z"])}), "'a' holds texts"),
            (vt.Frame(0, np.ones((2, 3)), box, columns={"a": np.ones((2, 0))}), "'a' has shape"),
            (vt.Frame(0, np.ones((2, 3)), box, columns={"a": np.full(2, 2**63, np.uint64)}), "9223372036854775808 .* below"),
            (vt.Frame(0, np.ones((2, 3)), box, ids=[1, 2], columns={"id": [3, 4]}), "has a column 'id' of its own"),
            (vt.Frame(0, np.ones((2, 3)), box, ids=[1, 2], columns={"id": [1.0, 2.0], "pos": [3, 4]}), "has a column 'pos' of its own"),
            (vt.Frame(0, np.ones((2, 3)), box, ids=[1]), r"ids have shape \(1,\): give 2"),
            (vt.Frame(0, np.ones((2, 3)), box, ids=[1.5, 2]), "whole numbers"),
            (vt.Frame(0, np.ones((2, 3)), box, species=["H"]), r"species have shape \(1,\): give 2"),
            (vt.Frame(0, np.ones((2, 3)), box, species=["H", "a b"]), "without blanks"),
            (vt.Frame(0, np.ones((2, 3)), box, species=["H", "1"]), "types or elements"),
            (vt.Frame(0, np.ones((2, 2)), box), "points have 2 coordinates, and its domain has 3"),
            (vt.Frame(0, np.ones(3), box), "points of frame 0 has shape"),
        ):
            with self.assertRaisesRegex(ValueError, says):
                vt.write_frames(self.folder / "b.xyz", [vt.Frame(0, np.ones((1, 3)), box), frame])
        for step, says in ((0.5, "whole numbers"), (np.nan, "whole numbers")):
            with self.assertRaisesRegex(ValueError, says):
                vt.write_frames(self.folder / "b.dump", [vt.Frame(0, np.ones((1, 3)), box, step)])
        names, written = ("element", "typelabel", "species", "symbol", "type"), set()
        for extension in (".xyz", ".dump"):
            for species in (None, ["H", "C"], ["1", "2"]):
                for name in (*names, "id", "x", "xu"):
                    given = vt.Frame(0, np.ones((2, 3)), box, species=species, columns={name: np.array([7.5, 8.5])})
                    path = self.folder / ("f" + extension)
                    try:
                        vt.write_frames(path, [given])
                    except ValueError as error:
                        self.assertRegex(str(error), "give (it|this one) another name")
                        continue
                    written.add((extension, species is not None and species[0], name))
                    found = next(vt.read_frames(path))
                    self.assertEqual(found.columns[name].tolist(), [7.5, 8.5])
                    if species is not None:
                        self.assertEqual(list(found.species), species)
        for one in ((".xyz", "H", "element"), (".xyz", False, "x"), (".dump", "H", "species"), (".dump", "1", "xu")):
            self.assertIn(one, written)
        for one in ((".xyz", "H", "species"), (".xyz", "1", "element"), (".dump", "1", "element"), (".xyz", False, "id")):
            self.assertNotIn(one, written)
        edge = vt.Frame(0, [[0.9, 0.3, 0.8], [0.2, 0.1, 0.1]], vt.Domain.box((0.2, 0.1, 0.1, 0.9, 0.3, 0.8)))
        for name in ("d.xyz", "d.dump"):
            vt.write_frames(self.folder / name, [edge])
            found = next(vt.read_frames(self.folder / name))
            self.assertAlmostEqual(found.tessellate(want="volumes").volumes.sum(), 0.7 * 0.2 * 0.7)
        flat = vt.Frame(0, [[0.5, 0.25]], vt.Domain.box((0, 0, 1, 2), periodic="y"))
        for name in ("e.xyz", "e.dump"):
            vt.write_frames(self.folder / name, [flat, flat])
            for found in vt.read_frames(self.folder / name, planar=True):
                np.testing.assert_array_equal(found.points, flat.points)
                self.assertEqual((found.domain.dimensions, found.domain.periodic), (2, (False, True)))
        given = vt.Frame(0, [[0.25, 0.5, 0.75]], box, 0.5, species=["²"])
        vt.write_frames(self.folder / "c.xyz", [given])
        found = next(vt.read_frames(self.folder / "c.xyz"))
        self.assertEqual([found.points.tolist(), found.timestep, list(found.species)], [given.points, 0.5, ["²"]])
        with self.assertRaisesRegex(ValueError, "path is 'b.h5'"):
            vt.write_frames("b.h5", [])
        with self.assertRaisesRegex(TypeError, "frames holds something 1: give Frame"):
            vt.write_frames(self.folder / "b.xyz", [1])
        self.assertFalse((self.folder / "b.xyz").exists())

    def test_files_without_frames(self):
        points = positions(1)
        np.save(self.folder / "a.npy", points)
        self.put("a.txt", "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()))
        self.put("a.csv", "id,x,y,z,m\n" + "".join(f"{i + 3},{x!r},{y!r},{z!r},{i}\n" for i, (x, y, z) in enumerate(points.tolist())))
        for name in ("a.npy", "a.txt", "a.csv"):
            frame, = vt.read_frames(self.folder / name)
            np.testing.assert_array_equal(frame.points, points)
            self.assertEqual((frame.number, frame.domain, frame.species), (0, None, None))
        np.testing.assert_array_equal(frame.ids, np.arange(120) + 3)
        np.testing.assert_array_equal(frame.columns["m"], np.arange(120))

    def test_refusals(self):
        with self.assertRaisesRegex(FileNotFoundError, "No such file.*nothing.xyz'"):
            vt.read_frames(self.folder / "nothing.xyz")
        (self.folder / "a.csv").mkdir()
        with self.assertRaises(IsADirectoryError):
            vt.read_frames(self.folder / "a.csv")
        with self.assertRaises(NotADirectoryError):
            vt.read_frames(self.put("b.txt", "1 2 3\n") / "b.txt")
        path = self.put("a.xyz", xyz_of(0) + xyz_of(1)[:-20])
        with self.assertRaisesRegex(ValueError, "^frames must be"):
            vt.read_frames(path, frames="some")
        with self.assertRaisesRegex(ValueError, "no column 'p'"):
            vt.read_frames(path, columns="p")
        frames = vt.read_frames(path)
        self.assertEqual(next(frames).number, 0)
        with self.assertRaisesRegex(ValueError, "a.xyz:24"):
            next(frames)

    def test_words_of_python(self):
        """Messages name arguments of read_frames(), never options of the command line."""
        for name, text, options, says in (
            ("a.csv", "a,b,c\n1,2,3\n", {}, "lacks 'x': name the columns of the coordinates by coordinates; there are"),
            ("a.csv", "x,y,m\n1,2,3\n", {}, r'or give coordinates=\("x", "y"\) for these alone'),
            ("a.csv", "x,y,m\n1,2,3\n", {"coordinates": ("x", "m", "z")}, "lacks 'z' of coordinates"),
            ("a.txt", "1 2 3 4 5\n", {}, 'name it with columns="5", or remove it'),
            ("a.txt", "0.5 2 3 4\n", {}, 'if the columns are x y z r, give columns="4"'),
            ("a.txt", "1 2 3 4\n1 2 3 q\n", {"columns": "4"}, "the column 'column_4' has text where numbers are needed"),
            ("a.csv", "x,y,z,--q\n1,2,3,4\n", {"columns": "r"}, "there are x y z --q"),
            ("a.npy", "", {"dataset": "q"}, "^dataset goes with"),
            ("a.xyz", xyz_of(0), {"frames": "1:0:"}, "frame"),
            ("--x", "1 2\n1\n", {}, "--x:2: "),
        ):
            path = self.put(name, text)
            with self.assertRaisesRegex(ValueError, says) as raised:
                list(vt.read_frames(path, **options))
            if "--" not in text + name:
                self.assertNotIn("--", str(raised.exception))
        root = pathlib.Path(__file__).resolve().parents[3]
        for source in (root / "cli/read").rglob("*.cpp"):
            if "surface" in source.name or "mesh" in str(source.relative_to(root)):
                continue  # of --mesh
            for text in re.findall(r'"((?:[^"\\\n]|\\.)*--[a-z0-9](?:[^"\\\n]|\\.)*)"', source.read_text()):
                self.assertNotIn("--", module._in_python(text, ""), source)

    def test_paths(self):
        """A path that looks like an option or like stdin is a file; so are paths of bytes."""
        old = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, old)
        for name in ("-x.xyz", "--help", "-", "- .xyz", "--frames=all"):
            self.put(name, xyz_of(3) if name.endswith(".xyz") else "1 2 3\n4 5 6\n")
            for path in (name, os.fsencode(name), pathlib.Path(name), self.folder / name):
                frame, = vt.read_frames(path)
                self.assertEqual(len(frame), 120 if name.endswith(".xyz") else 2)

    def test_columns(self):
        """Columns of words, those of quoted names and cells, and coordinates under other names."""
        points = positions(2)
        rows = [f'{i},"w {i % 3}",{x!r},{y!r},{z!r},{"" if i % 4 == 1 else i / 2}' for i, (x, y, z) in enumerate(points.tolist())]
        path = self.put("a.csv", 'n,"a, note",Points:0,Points:1,Points:2,sparse\n' + "\n".join(rows))
        frame, = vt.read_frames(path, coordinates=("Points:0", "Points:1", "Points:2"), columns=("a, note", "n"))
        np.testing.assert_array_equal(frame.points, points)
        self.assertEqual(frame.columns["a, note"].tolist(), [f"w {i % 3}" for i in range(120)])
        np.testing.assert_array_equal(frame.columns["n"], np.arange(120))
        frame, = vt.read_frames(path, coordinates="345")
        self.assertEqual(list(frame.columns), ["n", "sparse"])
        np.testing.assert_array_equal(np.isnan(frame.columns["sparse"]), np.arange(120) % 4 == 1)
        path = self.put("a.xyz", "3\n\nCu 1 2 3\nZr 4 5 6\nCu 7 8 9\n")
        frame, = vt.read_frames(path, columns="species")
        self.assertEqual((frame.species, frame.columns["species"].tolist()), (["Cu", "Zr", "Cu"],) * 2)

    def test_wrong_arguments_are_named(self):
        path = self.path("a.csv")
        with open(path, "w") as file:
            file.write("1,2,3,4\n")
        frame, = vt.read_frames(path, coordinates=[1, 2, 3], columns=[4])
        self.assertEqual((frame.points.tolist(), list(frame.columns)), ([[1, 2, 3]], ["column_4"]))
        for arguments in (
            dict(frames=0), dict(dataset=0), dict(columns=None), dict(columns=[[]]), dict(coordinates=1 + 2j),
            dict(coordinates=b"x"), dict(coordinates=[True, 2, 3]),
        ):  # fmt: skip
            name, = arguments
            with self.subTest(arguments), self.assertRaisesRegex(TypeError, f"^{name} (is|has) "):
                vt.read_frames(path, **arguments)

    def test_h5py_reads_what_clvotess_reads(self):
        """A clvotess without HDF5, as in a wheel, leaves .h5 to h5py. Both readers give the same frames."""
        try:
            import h5py
        except ImportError:
            self.skipTest("h5py is not installed")
        rng = np.random.default_rng(5)
        places = rng.random((4, 9, 3)) * 3
        padded, absent = places.copy(), np.tile(np.arange(9), (4, 1))
        padded[1, 5:] = np.nan
        absent[2, ::2] = -1

        def h5md(name, value, edges, boundary, step=(0, 10, 20, 30), box_step=None, pbc=None, ids=None, **attributes):
            with h5py.File(self.folder / name, "w") as file:
                group = file.create_group("particles/all")
                group["position/value"], group["position/step"] = value, step
                group["position/step"].attrs.update(attributes)
                group["velocity/value"], group["mass"], group["charge/value"] = value, np.arange(9.0), rng.random((4, 9))
                box = group.create_group("box")
                box.attrs["boundary"] = boundary
                if np.ndim(edges) == 1:
                    box.attrs["edges"] = edges
                else:
                    box["edges/value"] = edges
                if box_step is not None:
                    box["edges/step"] = box_step
                if pbc is not None:
                    box["pbc/value"] = pbc
                if ids is not None:
                    group.create_dataset("id/value", data=ids, fillvalue=-1)
            return name

        words = np.array(["periodic", "none", "periodic"], "S8")
        cells = np.array([EDGES * (1 + k / 10) for k in range(4)])
        names = [h5md("a.h5", places, cells, words), h5md("b.h5md", padded, (4.0, 5.0, 6.0), [True, False, True], pbc=rng.random((4, 3)) < 0.5),
                 h5md("c.h5", places, cells[:2], words, box_step=[0, 15], ids=absent), h5md("d.h5", places, cells[:, :1, 0][:, [0, 0, 0]] * 1.0, words, step=5, offset=3),
                 h5md("e.h5", places[:, :, :2], (4.0, 5.0), words[:2], pbc=np.full((4, 2), np.nan))]
        names.append(h5md("j.h5", places, (4.0, 0.0, 6.0), words))  # no end along y
        with h5py.File(self.folder / "f.h5", "w") as file:
            file["coordinates"], file["cell_lengths"], file["cell_angles"] = places.astype("f4"), np.full((4, 3), 4.0), np.tile((90.0, 80, 60), (4, 1))
        with h5py.File(self.folder / "g.h5", "w") as file:
            file["PartType0/Coordinates"], file["PartType0/Masses"], file["PartType0/ParticleIDs"] = places[0], np.arange(9.0), np.arange(9, dtype="u8") + 7
            file.create_group("Header").attrs.update(BoxSize=4.0, Time=0.5, UnitLength_in_cm=3e21)
            file.create_group("RuntimePars").attrs["PeriodicBoundariesOn"] = 1
        self.run_cli("--random", "50", "-o", "h.h5", "--want", "centroids")
        self.run_cli("h.h5", "--dataset", "centroids", "--cell", "2,0,0,0.5,2,0,0,0.1,2", "--origin=-0.5,-0.5,-0.5", "--want", "centroids", "-o", "i.h5")
        names += ["f.h5", "g.h5", "h.h5", "i.h5"]

        def same(one, other):
            parts = [{} if frame.domain is None else frame.domain._values for frame in (one, other)]
            self.assertEqual((one.number, one.timestep, one.units, sorted(parts[0]), sorted(one.columns)),
                             (other.number, other.timestep, other.units, sorted(parts[1]), sorted(other.columns)))
            np.testing.assert_array_equal(one.points, other.points)
            np.testing.assert_array_equal(one.ids, other.ids)
            for key in parts[0]:
                np.testing.assert_allclose(parts[0][key], parts[1][key], rtol=1e-15, atol=1e-15)
            for key in one.columns:
                np.testing.assert_array_equal(one.columns[key], other.columns[key])

        try:
            next(vt.read_frames(self.folder / "a.h5"))
        except ValueError as error:
            self.skipTest(str(error))
        real = module._frames

        def without_hdf5(command, path):
            raise ValueError("cannot read 'a.h5': the module for HDF5 cannot be loaded: no such file")
            yield

        for name in names:
            for options in ({}, {"frames": "last"}, {"frames": "1:4:2"} if name < "g" else {}, {"columns": "mass"} if name < "f" else {}):
                answers = []
                for frames in (real, without_hdf5):
                    module._frames = frames
                    try:
                        answers.append(list(vt.read_frames(self.folder / name, **options)))
                    finally:
                        module._frames = real
                self.assertEqual(len(answers[0]), len(answers[1]), name)
                for one, other in zip(*answers):
                    with self.subTest(name, frame=one.number):
                        same(one, other)

    def test_cell_that_lacks_an_edge(self):
        path = self.put("a.xyz", '2\nLattice="4 0 0 0 4 0 0 0 0" pbc="T T F"\nCu 1 1 1\nCu 2 2 2\n')
        frame, = vt.read_frames(path)
        slab = frame.tessellate()  # without end
        self.assertEqual(np.isinf(slab.volumes).tolist(), [True, True])
        self.assertEqual(slab.periodic, (True, True, False))
        with self.assertRaisesRegex(ValueError, "cell: c is 0, but the cell repeats along it"):
            frame.tessellate(periodic=True)
        self.assertAlmostEqual(frame.tessellate(box=(0, 0, 0, 4, 4, 4)).volumes.sum(), 64)

    def test_volumes_of_ovito(self):
        try:
            from ovito.io import import_file
            from ovito.modifiers import VoronoiAnalysisModifier
        except ImportError:
            self.skipTest("OVITO is not installed")
        path = self.put("a.xyz", "".join(xyz_of(k).replace('"T T F"', '"T T T"') for k in range(20)))
        self.run_cli(path, "--frames", "all", "-o", "a.dump", "-o", "b.xyz")
        pipeline = import_file(str(path))
        pipeline.modifiers.append(VoronoiAnalysisModifier(compute_indices=True))
        written = [(import_file(str(self.folder / name)), prefix) for name, prefix in (("a.dump", "c_"), ("b.xyz", ""))]
        for k, frame in enumerate(vt.read_frames(path)):
            t = frame.tessellate()
            found = pipeline.compute(k).particles
            np.testing.assert_allclose(t.volumes, found["Atomic Volume"], rtol=1e-6)
            for pipe, prefix in written:
                self.assertEqual(pipe.source.num_frames, 20)
                data = pipe.compute(k)
                np.testing.assert_allclose(data.particles[prefix + "volume"], t.volumes, rtol=1e-15)
                np.testing.assert_array_equal(data.particles[prefix + "neighbors"], np.diff(t.neighbors.indptr))
                np.testing.assert_allclose(np.asarray(data.cell), np.column_stack((EDGES.T, CORNER)), rtol=0, atol=1e-14)
                index = data.particles["voronoi_index"] if not prefix else np.column_stack([data.particles[f"c_n{j}"] for j in range(3, 8)])
                np.testing.assert_array_equal(np.asarray(index)[:, :4], np.asarray(found["Voronoi Index"])[:, 2:6])

    def test_files_in_ase(self):
        try:
            import ase.io
        except ImportError:
            self.skipTest("ASE is not installed")
        path = self.put("a.xyz", "".join(xyz_of(k) for k in range(5)))
        self.run_cli(path, "--frames", "all", "-o", "a.dump", "-o", "b.xyz")
        for name, prefix, kind in (("a.dump", "c_", "lammps-dump-text"), ("b.xyz", "", "extxyz")):
            for k, atoms in enumerate(ase.io.iread(self.folder / name, format=kind)):
                np.testing.assert_allclose(vt.from_ase(atoms).volumes, expected(k).volumes, rtol=1e-12)
            read = ase.io.read(self.folder / name, index=":", format=kind)
            self.assertEqual(len(read), 5)
            for k, atoms in enumerate(read):
                t = expected(k, want="neighbors,volumes")
                np.testing.assert_array_equal(np.ravel(atoms.arrays[prefix + "volume"]), t.volumes)
                np.testing.assert_array_equal(np.ravel(atoms.arrays[prefix + "neighbors"]), np.diff(t.neighbors.indptr))
                np.testing.assert_array_equal(atoms.positions, positions(k))
                self.assertEqual(atoms.get_chemical_symbols(), ["Zr", "Cu"] * 60)
                np.testing.assert_allclose(atoms.cell[:], EDGES, rtol=0, atol=1e-13)
                self.assertEqual(tuple(atoms.pbc), PBC)

    def test_the_same_system_from_everywhere(self):
        """A shifted, tilted slab, written by other packages and read by both."""
        try:
            import ase
            import ase.io
        except ImportError:
            self.skipTest("ASE is not installed")
        t = expected(0)
        folder = self.folder
        atoms = ase.Atoms("Cu120", positions=positions(0) - CORNER, cell=EDGES, pbc=PBC)
        for name, kind, digits in (("a.xyz", {"format": "extxyz"}, 1e-6), ("a.data", {"format": "lammps-data"}, 1e-9),
                                   ("POSCAR", {"format": "vasp", "direct": False}, 1e-9)):
            ase.io.write(folder / name, atoms, **kind)
            frame, = vt.read_frames(folder / name)
            np.testing.assert_allclose(frame.tessellate(periodic="xy").volumes, t.volumes, rtol=digits)
        self.assertEqual(next(vt.read_frames(folder / "POSCAR")).species, ["Cu"] * 120)
        try:
            import ovito.data
            from ovito.io import export_file
            from ovito.pipeline import Pipeline, StaticSource
        except ImportError:
            return
        data = ovito.data.DataCollection()
        data.create_cell(np.column_stack((EDGES.T, CORNER)), pbc=PBC)
        particles = data.create_particles(count=120)
        particles.create_property("Position", data=positions(0))
        particles.create_property("Particle Type", data=np.ones(120, int))
        pipeline = Pipeline(source=StaticSource(data=data))
        columns = ["Particle Type", "Position.X", "Position.Y", "Position.Z"]
        export_file(pipeline, str(folder / "o.xyz"), "xyz", columns=columns, precision=17)
        export_file(pipeline, str(folder / "o.dump"), "lammps/dump", columns=columns, precision=17)
        export_file(pipeline, str(folder / "o.data"), "lammps/data", atom_style="atomic", precision=17)
        for name in ("o.xyz", "o.dump", "o.data"):
            frame, = vt.read_frames(folder / name)
            np.testing.assert_allclose(frame.tessellate(periodic="xy").volumes, t.volumes, rtol=1e-12)


if __name__ == "__main__":
    unittest.main()
