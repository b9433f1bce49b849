"""Files of save(): arrays, colors, and that a file is written whole or not at all."""

import contextlib
import errno
import importlib.util
import os
import shutil
import signal
import stat
import subprocess
import sys
import unittest
from unittest import mock

import numpy as np
from helpers import CELL, Folder, cells, have, uniform

import pyvotess as vt
from pyvotess.export import colors, geometry


class Geometry(unittest.TestCase):
    def test_ranges(self):
        numbers = geometry.ranges(np.array([5, 9, 2, 7]), np.array([2, 0, 3, 1]))
        np.testing.assert_array_equal(numbers, [5, 6, 2, 3, 4, 7])
        self.assertEqual(len(geometry.ranges(np.array([], int), np.array([], int))), 0)

    def test_polyhedra_and_triangles(self):
        t = cells()
        mesh = geometry.mesh_of(t, "this")
        some = np.array([7, 3, 30])
        words, begin = geometry.polyhedra(mesh, some)
        expected, ends = [], [0]
        for i in some:
            faces = t.faces[t.neighbors.indptr[i] : t.neighbors.indptr[i + 1]]
            expected.append(len(faces))
            for face in faces:
                expected += [len(face), *face.tolist()]
            ends.append(len(expected))
        self.assertEqual((words.tolist(), begin.tolist()), (expected, ends))
        corners, face = geometry.triangles(mesh, np.arange(len(t.faces)))
        a, b, c = (mesh.vertices[corners[:, k]] for k in range(3))
        areas = np.bincount(face, np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)
        np.testing.assert_allclose(areas, t.face_areas, rtol=1e-9)
        volumes = np.bincount(mesh.cell_of_face[face], np.einsum("ij,ij->i", a, np.cross(b, c)) / 6, len(t))
        np.testing.assert_allclose(volumes, t.volumes, atol=1e-14)


class Arrays(Folder):
    def check(self, t, arrays):
        for name, expected in {
            "indptr": t.neighbors.indptr, "indices": t.neighbors.indices, "volumes": t.volumes, "status": t.status,
            "centroids": t.centroids, "face_areas": t.face_areas, "vertices": t.vertices, "box": t.box,
            "cell_vertex_indptr": t.cell_vertices.indptr, "cell_vertex_indices": t.cell_vertices.indices,
            "face_offsets": t.faces.indptr, "face_vertices": t.faces.indices, "duplicate_of": t.duplicate_of,
            "periodic": np.array(t.periodic, np.uint8), "shifts": t.shifts, "cell": t.cell, "origin": t.origin,
            "walls": t.walls if len(t.walls) else None,
            "ids": None if t.ids is None else t.ids.astype(np.int64),
        }.items():
            if expected is None:
                self.assertNotIn(name, arrays)
                continue
            np.testing.assert_array_equal(arrays[name], expected, name)
            self.assertEqual(np.asarray(arrays[name]).dtype, expected.dtype, name)
        self.assertEqual(np.asarray(arrays["version"]).astype(str), vt.__version__)

    def results(self):
        yield cells(), "option"
        yield cells(periodic=True), "option"
        yield cells(box=None), "default"
        yield cells(box=None, cell=CELL, outside="drop"), "option"
        yield cells(walls=[(1, 1, 1, 2.5)], outside="drop"), "option"
        yield cells(periodic=True, only=[61, 3, 7], weights=np.linspace(0, 0.01, 62)), "option"

    def test_npz(self):
        for t, domain_from in self.results():
            t.save(self.path("a.npz"))
            with np.load(self.path("a.npz"), allow_pickle=False) as arrays:
                self.check(t, dict(arrays))
                self.assertEqual(str(arrays["domain_from"]), domain_from)
        vt.tessellate(uniform(5), want=()).save(self.path("b.npz"))
        with np.load(self.path("b.npz")) as arrays:
            self.assertEqual(sorted(arrays), ["box", "domain_from", "periodic", "periodic_from", "status", "version"])
        first = (self.folder / "b.npz").read_bytes()
        vt.tessellate(uniform(5), want=()).save(self.path("b.npz"))
        self.assertEqual((self.folder / "b.npz").read_bytes(), first, "equal results give equal files")

    @have("h5py")
    def test_h5(self):
        import h5py

        for t, domain_from in self.results():
            t.save(self.path("a.h5"), columns={"mass": np.arange(len(t))})
            with h5py.File(self.path("a.h5")) as file:
                self.check(t, {**{name: values[()] for name, values in file.items()}, **file.attrs})
                self.assertEqual(file.attrs["domain_from"].decode(), domain_from)
                np.testing.assert_array_equal(file["mass"], np.arange(len(t)))
                self.assertIn("box", file.attrs)

    def test_formats_that_need_all_cells(self):
        t = cells(only=[4, 2])
        for extension in ("vtu", "ply", "obj", "glb", "stl", "foam", "tess", "msh", "cgns", "html"):
            with self.assertRaisesRegex(ValueError, f"{extension} .*leave out only=, or write .npz or .h5"):
                t.save(self.path(f"a.{extension}"))

    def test_columns(self):
        t = cells()
        given = {
            "mass": np.arange(62.0), "velocity": np.ones((62, 3), np.float32), "file": list(range(62)),
            "kept": np.arange(62) % 2 == 0, "big": np.arange(62, dtype=">i2"), "half": np.ones(62, np.float16),
        }
        t.save(self.path("a.npz"), columns=given)
        with np.load(self.path("a.npz")) as arrays:
            for name, values in given.items():
                np.testing.assert_array_equal(arrays[name], values)
            types = [arrays[name].dtype.str for name in given]
        self.assertEqual(types, ["<f8", "<f4", "<i8", "|u1", "<i2", "<f4"])
        for name, values, says in [
            ("volumes", np.ones(62), "'volumes'"), ("m", np.ones(3), r"\(3,\).*62"), ("m", ["a"] * 62, "<U1"),
            ("a/b", np.ones(62), "'a/b'"), ("", np.ones(62), "''"), ("m", np.ones((62, 2, 2)), r"\(62, 2, 2\)"),
        ]:
            with self.assertRaisesRegex(ValueError, says):
                t.save(self.path("b.npz"), columns={name: values})
        with self.assertRaisesRegex(ValueError, "'volume'"):
            t.save(self.path("b.vtu"), columns={"volume": t.volumes})
        self.assertEqual(os.listdir(self.folder), ["a.npz"])


class Colors(unittest.TestCase):
    def test_maps(self):
        for name in ("tide", "ember", "gray"):
            table = colors.map_values(np.linspace(1, 2, 256), name)
            self.assertEqual((table.shape, table.dtype), ((256, 3), np.uint8))
            light = (table / 255) ** 2.2 @ [0.2126, 0.7152, 0.0722]
            self.assertTrue((light[16:] > light[:-16]).all(), name)
            self.assertGreater(light[-1] - light[0], 0.6)
        with self.assertRaisesRegex(ValueError, "'rainbows'.*tide"):
            colors.map_values(np.ones(2), "rainbows")

    def test_values(self):
        gray = [c[0] for c in colors.map_values(np.linspace(1, 2, 257), "gray").tolist()]
        np.testing.assert_array_equal(colors.map_values(np.array([0, np.nan, 1]), "gray")[1], [150, 150, 150])
        self.assertEqual(colors.map_values(np.ones(3), "gray")[:, 0].tolist(), [gray[128]] * 3)
        wide = colors.map_values(np.array([0.0, 1.0, 10.0, 100.0, np.inf] + [1.0, 100.0] * 400), "gray")
        self.assertEqual(wide[:5, 0].tolist(), [gray[0], gray[0], gray[128], gray[256], gray[256]])
        self.assertEqual(len(colors.map_values(np.empty(0), "gray")), 0)

    def test_refused(self):
        t = cells()
        for color, says in [
            ("mass", "'mass'.*columns are .*volume"), (np.ones(3), r"\(3,\).*62"), (np.ones((62, 4)), r"\(62, 4\)"),
            (2.0 * np.ones((62, 3)), "0 to 1"), (np.full((62, 3), 7), "0 to 1"),
        ]:
            with self.assertRaisesRegex(ValueError, says):
                colors.cell_colors(t, color, "tide")
        np.testing.assert_array_equal(colors.cell_colors(t, np.ones((62, 3)), "tide"), np.full((62, 3), 255))
        with self.assertRaisesRegex(AttributeError, "surface_areas"):
            colors.cell_colors(t, "area", "tide")


class Whole(Folder):
    def test_cells_that_reach_infinity(self):
        slab = ((0, 1), (0, 1), (-np.inf, np.inf))
        for domain in ({"box": "none"}, {"box": slab, "periodic": "xy"}):
            t = vt.tessellate(uniform(62), want="faces,volumes,centroids", **domain)
            closed = np.flatnonzero(~t.open_cells)
            self.assertTrue(0 < len(closed) < 62)
            for name in ("a.vtu", "a.ply", "a.obj", "a.glb"):
                with self.assertRaisesRegex(ValueError, f"{62 - len(closed)} cells reach infinity.*open='skip'"):
                    t.save(self.path(name))
                t.save(self.path(name), open="skip")
            data = (self.folder / "a.vtu").read_bytes()
            self.assertIn(f'NumberOfCells="{len(closed)}"'.encode(), data)
            sides = np.diff(t.faces.indptr)[np.isin(np.repeat(np.arange(62), np.diff(t.neighbors.indptr)), closed)]
            lines = (self.folder / "a.obj").read_text().splitlines()
            self.assertEqual(sum(line.startswith("f ") for line in lines), len(sides))
            self.assertEqual(sum("nan" in line or "inf" in line for line in lines), 0)
        with self.assertRaisesRegex(ValueError, "open"):
            t.save(self.path("a.npz"), open="yes")
        with self.assertRaisesRegex(ValueError, ": 1 cell reaches infinity: "):
            vt.tessellate([(0, 0, 0)], box="none", want="faces,volumes,centroids").save(self.path("a.vtu"))

    @have("h5py")
    def test_full_disk_for_h5(self):
        """HDF5 reports a full disk late or by a crash, so it is found before, and else its error becomes an OSError."""
        import h5py

        t = vt.tessellate(uniform(9))
        full = mock.Mock(return_value=mock.Mock(free=100))
        failing = mock.Mock(side_effect=RuntimeError("fwrite failed"))
        for target, name, double, says in ((shutil, "disk_usage", full, "the file takes"), (h5py.Group, "create_dataset", failing, "fwrite")):
            with self.subTest(name), mock.patch.object(target, name, double), self.assertRaisesRegex(OSError, says) as caught:
                t.save(self.path("a.h5"))
            self.assertEqual(caught.exception.filename, self.path("a.h5"))
            self.assertEqual(list(self.folder.iterdir()), [])

    def test_refused(self):
        t = vt.tessellate(uniform(9))
        for name in ("a.txt", "a", "a.VTK"):
            with self.assertRaisesRegex(ValueError, "known are .npz"):
                t.save(self.path(name))
        for name in ("a.vtu", "a.ply", "a.obj", "a.glb"):
            with self.assertRaisesRegex(ValueError, "'faces' into want"):
                t.save(self.path(name))
        with self.assertRaisesRegex(ValueError, ".npz holds no colors: .ply .glb .html do"):
            t.save(self.path("a.npz"), color="x")
        with self.assertRaisesRegex(ValueError, ".obj holds no columns"):
            t.save(self.path("a.obj"), columns={"m": np.ones(9)})
        with self.assertRaisesRegex(FileNotFoundError, "nowhere"):
            t.save(self.path("nowhere/a.npz"))
        (self.folder / "folder.npz").mkdir()
        with self.assertRaisesRegex(ValueError, "not a regular file"):
            t.save(self.path("folder.npz"))
        self.assertEqual(os.listdir(self.folder), ["folder.npz"])

    def test_a_failure_leaves_the_old_file(self):
        t = vt.tessellate(uniform(9))
        (self.folder / "a.npz").write_text("old")
        with mock.patch("numpy.lib.format.write_array", side_effect=OSError("disk full")):
            with self.assertRaisesRegex(OSError, "disk full"):
                t.save(self.path("a.npz"))
        self.assertEqual((self.folder / "a.npz").read_text(), "old")
        self.assertEqual(os.listdir(self.folder), ["a.npz"])

    def test_a_killed_process_leaves_nothing(self):
        if not hasattr(os, "O_TMPFILE"):
            self.skipTest("the system has no unnamed files")
        code = (
            "import os, signal, sys, pyvotess as vt, numpy as np\n"
            "t = vt.tessellate(np.random.default_rng(1).random((50, 3)), want='faces,volumes')\n"
            "at, name = sys.argv[1:]\n"
            "kill = lambda *_, **__: os.kill(os.getpid(), signal.SIGKILL)\n"
            "if at == 'sync': os.fsync = kill\n"
            "if at == 'link': os.link = kill\n"
            "if at == 'open': import builtins; builtins.open = kill\n"
            "t.save(name)\n"
        )
        (self.folder / "b.glb").write_text("old")
        for at, name in (("open", "a.glb"), ("sync", "a.npz"), ("link", "b.glb"), ("sync", "a.h5")):
            if name == "a.h5" and importlib.util.find_spec("h5py") is None:
                continue
            done = subprocess.run([sys.executable, "-c", code, at, self.path(name)], capture_output=True)
            self.assertEqual((done.returncode, done.stderr), (-signal.SIGKILL, b""), name)
            self.assertEqual(os.listdir(self.folder), ["b.glb"], name)
        self.assertEqual((self.folder / "b.glb").read_text(), "old")

    def test_power_loss(self):
        """The bytes are synced before the file gets its name, the name before save() returns."""
        t = vt.tessellate(uniform(9))
        calls = []

        def noting(name, call, fail=None):
            def noted(*args, **options):
                what = "folder" if name == "fsync" and stat.S_ISDIR(os.fstat(args[0]).st_mode) else name
                calls.append(what)
                if what == fail:
                    raise OSError(number, "no")
                return call(*args, **options)

            return noted

        def save(fail=None):
            calls.clear()
            with contextlib.ExitStack() as stack:
                for name in ("fsync", "link", "replace"):
                    stack.enter_context(mock.patch.object(os, name, noting(name, getattr(os, name), fail)))
                t.save(self.path("a.npz"))
            return [*calls]

        number = errno.EINVAL
        self.assertIn(save(), (["fsync", "link", "folder"], ["fsync", "replace", "folder"]))
        self.assertIn(save(), (["fsync", "link", "link", "replace", "folder"], ["fsync", "replace", "folder"]))
        with mock.patch.object(os, "O_TMPFILE", os.O_RDONLY, create=True):  # a folder opened like this cannot be written
            self.assertEqual(save(), ["fsync", "replace", "folder"])
        self.assertEqual(save("fsync")[-1], "folder")  # a file system without fsync
        self.assertEqual(save("folder")[-1], "folder")
        (self.folder / "a.npz").write_text("old")
        number = errno.EIO
        with self.assertRaisesRegex(OSError, "no"):
            save("fsync")
        self.assertEqual((self.folder / "a.npz").read_text(), "old")
        self.assertEqual(os.listdir(self.folder), ["a.npz"])
        with self.assertRaisesRegex(OSError, "no"):
            save("folder")
        self.assertEqual(os.listdir(self.folder), ["a.npz"])

    @unittest.skipUnless(os.name == "posix", "links and permissions are those of POSIX")
    def test_links_and_permissions(self):
        t = vt.tessellate(uniform(9))
        t.save(self.folder / "new.NPZ")
        mask = os.umask(0)
        os.umask(mask)
        self.assertEqual(stat.S_IMODE(os.stat(self.path("new.NPZ")).st_mode), 0o666 & ~mask)
        real = self.folder / "real.npz"
        real.write_text("old")
        real.chmod(0o640)
        (self.folder / "link.npz").symlink_to("real.npz")
        t.save(self.path("link.npz"))
        self.assertTrue((self.folder / "link.npz").is_symlink())
        self.assertEqual(stat.S_IMODE(real.stat().st_mode), 0o640)
        with np.load(real) as arrays:
            np.testing.assert_array_equal(arrays["volumes"], t.volumes)

    def test_importing_imports_no_other_package(self):
        code = (
            "import sys, pyvotess as vt, numpy as np\n"
            "t = vt.tessellate(np.random.default_rng(1).random((20, 3)), want='faces,volumes')\n"
            "t._repr_html_()\n"
            "names = 'scipy matplotlib pyvista h5py trimesh pandas networkx freud tqdm meshio'.split()\n"
            "print([name for name in names if name in sys.modules])\n"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout, "[]\n")


if __name__ == "__main__":
    unittest.main()
