"""Meshes of save(), read back by NumPy, and by other packages if they are installed."""

import json
import os
import struct
import subprocess
import sys
import types
import unittest
import xml.etree.ElementTree
from unittest import mock

import numpy as np
from helpers import CELL, PACKAGE_PARENT, UNIT_BOX, Folder, cells, have, lattice, once, uniform

import pyvotess as vt
from pyvotess.export import colors
from pyvotess.export.mesh_file import write_mesh


class FullDisk(Folder):
    @unittest.skipUnless(hasattr(os, "fork"), "a limit of sizes is a limit of a process")
    def test_the_error_of_the_file_is_raised(self):
        """A limit of sizes stands for a full disk. What was there before stays."""
        with open(self.path("kept.obj"), "w") as file:
            file.write("before")
        code = """if True:
            import resource, signal
            import numpy as np
            import pyvotess as vt
            t = vt.tessellate(np.random.default_rng(1).random((300, 3)), box=[(0, 0, 0), (1, 1, 1)], want="faces,volumes")
            p = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.0)]), [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
            pieces = vt.tessellate(t.points, mesh=p).pieces()
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
            for save, names in (t.save, "vtu ply obj glb foam tess msh cgns npz"), (pieces.save, "obj stl glb 3mf"):
                for name in names.split():
                    try:
                        save("kept." + name)
                    except OSError as error:
                        assert error.errno == 27, error
                    else:
                        raise AssertionError(name)
        """
        environment = {**os.environ, "PYTHONPATH": PACKAGE_PARENT}
        subprocess.run([sys.executable, "-c", code], cwd=self.folder, env=environment, check=True)
        self.assertEqual([path.name for path in self.folder.rglob("*")], ["kept.obj"])
        self.assertEqual((self.folder / "kept.obj").read_text(), "before")


class Vtu(Folder):
    def read(self, name):
        """Returns the arrays of a .vtu file, by the offsets in its XML."""
        content = (self.folder / name).read_bytes()
        head, body = content.split(b'<AppendedData encoding="raw">\n_', 1)
        piece = xml.etree.ElementTree.fromstring(head + b"</VTKFile>").find("UnstructuredGrid/Piece")
        arrays, end = {}, 0
        for array in piece.iter("DataArray"):
            at = int(array.get("offset"))
            self.assertEqual(at, end)
            size = int(np.frombuffer(body, "<u8", 1, at)[0])
            kind = array.get("type")
            dtype = np.dtype(kind.lower()).newbyteorder("<")
            values = np.frombuffer(body, dtype, size // dtype.itemsize, at + 8)
            arrays[array.get("Name")] = values.reshape(-1, int(array.get("NumberOfComponents", 1))).squeeze()
            end = at + 8 + size
        self.assertEqual(body[end:], b"\n</AppendedData>\n</VTKFile>\n")
        self.assertEqual(int(piece.get("NumberOfCells")), len(arrays["types"]))
        self.assertEqual(int(piece.get("NumberOfPoints")), len(arrays["Points"]))
        return arrays

    def test_polygons_of_the_plane(self):
        points = np.random.default_rng(2).random((40, 2))
        points[7] = points[3]
        t = vt.tessellate(points, box=(0, 0, 1, 1), periodic="x", want="faces,volumes,centroids")
        t.save(self.path("a.vtu"), columns={"double": 2 * t.volumes})
        arrays = self.read("a.vtu")
        self.assertEqual(set(arrays), {"Points", "connectivity", "offsets", "types", "id", "volume", "neighbors", "centroid",
                                       "status", "double"})  # fmt: skip
        np.testing.assert_array_equal(arrays["Points"], np.insert(t.vertices, 2, 0.0, axis=1))
        np.testing.assert_array_equal(arrays["types"], np.full(39, 7))  # VTK_POLYGON
        np.testing.assert_array_equal(np.sort(arrays["id"]), np.delete(np.arange(40), 7))
        self.assertTrue((np.diff(np.diff(arrays["offsets"], prepend=0)) >= 0).all())
        for corners, seed in zip(np.split(arrays["connectivity"], arrays["offsets"][:-1]), arrays["id"]):
            np.testing.assert_array_equal(corners, t.cell_vertices[seed])
        np.testing.assert_array_equal(arrays["centroid"], np.insert(t.centroids, 2, 0.0, axis=1)[arrays["id"]])
        np.testing.assert_array_equal(arrays["double"], 2 * t.volumes[arrays["id"]])
        with self.assertRaisesRegex(ValueError, "reach infinity"):
            vt.tessellate(points, box="none", want="faces").save(self.path("b.vtu"))

    @have("vtk")
    def test_vtk_reads_polygons_of_the_plane(self):
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

        t = vt.tessellate(np.random.default_rng(2).random((40, 2)), box=(0, 0, 1, 1), periodic=True, want="faces,volumes")
        t.save(self.path("a.vtu"))
        reader, sizes = vtkXMLUnstructuredGridReader(), vtkCellSizeFilter()
        reader.SetFileName(self.path("a.vtu"))
        sizes.SetInputConnection(reader.GetOutputPort())
        sizes.Update()
        data = sizes.GetOutput().GetCellData()
        np.testing.assert_allclose(vtk_to_numpy(data.GetArray("Area")), vtk_to_numpy(data.GetArray("volume")), rtol=1e-9)

    def test_arrays(self):
        t = cells()
        mass = np.arange(62.0)
        t.save(self.path("a.vtu"), columns={'m "1" <&>': mass})
        arrays = self.read("a.vtu")
        ids = arrays["id"]
        np.testing.assert_array_equal(arrays["centroid"], t.centroids[ids])
        np.testing.assert_array_equal(arrays["status"], t.status[ids])
        np.testing.assert_array_equal(arrays["neighbors"], [(t.neighbors[i] >= 0).sum() for i in ids])
        self.assertEqual(arrays["types"].tolist(), [42] * 60)
        self.assertEqual(sorted(ids.tolist()), list(range(60)))
        counts = np.diff(t.cell_vertices.indptr)[ids]
        self.assertTrue((np.diff(counts) >= 0).all())
        np.testing.assert_array_equal(np.diff(arrays["offsets"], prepend=0), counts)
        np.testing.assert_array_equal(arrays["volume"], t.volumes[ids])
        np.testing.assert_array_equal(arrays['m "1" <&>'], mass[ids])
        ends = np.concatenate(([0], arrays["faceoffsets"]))
        for k, i in enumerate(ids):
            faces = [[len(face), *face.tolist()] for face in t.faces[t.neighbors.indptr[i] : t.neighbors.indptr[i + 1]]]
            expected = [len(faces), *(number for face in faces for number in face)]
            self.assertEqual(arrays["faces"][ends[k] : ends[k + 1]].tolist(), expected)
            own = arrays["connectivity"][arrays["offsets"][k] - counts[k] : arrays["offsets"][k]]
            np.testing.assert_array_equal(own, t.cell_vertices[i])

    def test_what_was_not_wanted_is_left_out(self):
        cells(want="faces").save(self.path("a.vtu"))
        self.assertEqual(set(self.read("a.vtu")), {"Points", "connectivity", "offsets", "types", "faces", "faceoffsets",
                                                   "id", "neighbors", "status"})
        vt.tessellate(np.empty((0, 3)), want="faces,volumes").save(self.path("none.vtu"))
        self.assertEqual(len(self.read("none.vtu")["id"]), 0)

    @have("meshio")
    def test_meshio(self):
        import meshio

        tetrahedron = meshio.Mesh(np.vstack((np.zeros(3), np.eye(3))), [("tetra", [[0, 1, 2, 3]])])
        tetrahedron.write(self.path("own.vtu"))
        try:
            meshio.read(self.path("own.vtu"))
        except Exception as error:
            self.skipTest(f"meshio {meshio.__version__} does not read its own .vtu: {error}")
        for t in (cells(200), vt.tessellate(lattice(3), want="faces,volumes")):
            t.save(self.path("a.vtu"), columns={"double": 2 * t.volumes})
            mesh = meshio.read(self.path("a.vtu"))
            np.testing.assert_array_equal(mesh.points, t.vertices)
            ids = np.concatenate(mesh.cell_data["id"])
            self.assertEqual(sorted(ids.tolist()), np.flatnonzero(t.volumes > 0).tolist())
            np.testing.assert_array_equal(np.concatenate(mesh.cell_data["double"]), 2 * t.volumes[ids])
            for block, ids in zip(mesh.cells, mesh.cell_data["id"]):
                for faces, i in zip(block.data, ids):
                    expected = t.faces[t.neighbors.indptr[i] : t.neighbors.indptr[i + 1]]
                    self.assertEqual([f.tolist() for f in faces], [f.tolist() for f in expected])


class AsClvotess(Folder):
    def test_equal_bytes(self):
        program = os.environ.get("VOTESS_CLI")
        if not program:
            self.skipTest("VOTESS_CLI names no clvotess")
        np.save(self.path("p.npy"), uniform(200))
        names = [self.path("a" + extension) for extension in (".vtu", ".ply", ".obj", ".glb", ".msh")]
        for options, periodic in (([], False), (["--periodic"], True)):
            command = [program, self.path("p.npy"), "--box", "0,0,0,1,1,1", "--colormap", "ember", "-q", *options]
            subprocess.run(command + [word for name in names for word in ("-o", name)], check=True)
            t = vt.tessellate(uniform(200), box=UNIT_BOX, periodic=periodic, want="faces,volumes,centroids")
            for name in names:
                t.save(self.path("b" + name[-4:]), colormap="ember")
                with open(name, "rb") as theirs, open(self.path("b" + name[-4:]), "rb") as ours:
                    self.assertEqual(theirs.read(), ours.read(), name)


class FacesTest(Folder):
    def read_ply(self, name):
        """Returns names of the properties, vertices, and rows of the faces."""
        lines = (self.folder / name).read_text().splitlines()
        head = lines[: lines.index("end_header")]
        counts = [int(line.split()[2]) for line in head if line.startswith("element")]
        rows = lines[len(head) + 1 :]
        self.assertEqual(len(rows), sum(counts))
        names = [line.split()[-1] for line in head if line.startswith("property")]
        vertices = np.array([row.split() for row in rows[: counts[0]]], float).reshape(-1, 3)
        return names, vertices, [[int(x) for x in row.split()] for row in rows[counts[0] :]]

    def test_ply(self):
        for t in (cells(), cells(periodic=True), cells(2, periodic=True)):
            t.save(self.path("a.ply"))
            names, vertices, rows = self.read_ply("a.ply")
            self.assertEqual(names, ["x", "y", "z", "vertex_indices", "cell", "neighbor"])
            np.testing.assert_array_equal(vertices, t.vertices)
            expected = sorted(once(t), key=lambda face: len(face[0]))
            self.assertEqual(rows, [[len(face), *face, i, j] for face, i, j in expected])
        vt.tessellate(np.empty((0, 3)), want="faces").save(self.path("a.ply"))
        self.assertEqual(self.read_ply("a.ply")[2], [])

    def test_ply_in_colors(self):
        t = cells()
        rgb = np.arange(3 * 62).reshape(62, 3).astype(np.uint8)
        t.save(self.path("a.ply"), color=rgb)
        names, _, rows = self.read_ply("a.ply")
        self.assertEqual(names[-3:], ["red", "green", "blue"])
        expected = [
            [3, face[0], face[k], face[k + 1], i, j, *rgb[i].tolist()]
            for face, i, j in once(t) for k in range(1, len(face) - 1)
        ]
        self.assertEqual(rows, expected)

    def test_obj(self):
        t = cells()
        t.save(self.path("a.obj"))
        lines = [line.split() for line in (self.folder / "a.obj").read_text().splitlines()]
        np.testing.assert_array_equal(np.array([x[1:] for x in lines if x[0] == "v"], float), t.vertices)
        groups = {}
        for line in lines:
            if line[0] == "g":
                groups[int(line[1])] = group = []
            elif line[0] == "f":
                group.append([int(x) - 1 for x in line[1:]])
        expected = {i: [t.faces[k].tolist() for k in range(*t.neighbors.indptr[i : i + 2])] for i in range(len(t))}
        self.assertEqual(groups, {i: faces for i, faces in expected.items() if faces})

    @have("meshio")
    def test_meshio(self):
        import meshio

        t = cells(200)
        expected = once(t)
        t.save(self.path("a.ply"))
        mesh = meshio.read(self.path("a.ply"))
        self.assertEqual(sum(len(block.data) for block in mesh.cells), len(expected))
        found = [
            (face.tolist(), i, j)
            for block, first, second in zip(mesh.cells, mesh.cell_data["cell"], mesh.cell_data["neighbor"])
            for face, i, j in zip(block.data, first.tolist(), second.tolist())
        ]
        self.assertEqual(sorted(found), sorted(expected))
        np.testing.assert_array_equal(mesh.points, t.vertices)
        t.save(self.path("b.ply"), color="volumes")
        mesh = meshio.read(self.path("b.ply"))
        self.assertEqual([block.type for block in mesh.cells], ["triangle"])
        self.assertIn("red", mesh.cell_data)
        t.save(self.path("a.obj"))
        self.assertEqual(sum(len(block.data) for block in meshio.read(self.path("a.obj")).cells), len(t.faces))

    @have("trimesh")
    def test_trimesh(self):
        import trimesh

        t = cells(200)
        expected = once(t)
        triangles = sum(len(face) - 2 for face, _, _ in expected)
        area = sum(t.face_areas[k] for i, row in enumerate(t.neighbors) for k, j in
                   zip(range(t.neighbors.indptr[i], t.neighbors.indptr[i + 1]), row) if j < 0 or i < j)
        for name, color in (("a.ply", None), ("b.ply", "volumes"), ("a.obj", None)):
            t.save(self.path(name), color=color)
            mesh = trimesh.load(self.path(name), process=False)
            self.assertEqual(len(mesh.faces), triangles)
            self.assertAlmostEqual(mesh.area, area, places=9)
        mesh = trimesh.load(self.path("b.ply"), process=False)
        rgb = colors.cell_colors(t, "volumes", "tide")
        first = [i for face, i, _ in expected for _ in face[2:]]
        np.testing.assert_array_equal(mesh.visual.face_colors[:, :3], rgb[first])


class Glb(Folder):
    def read(self):
        """Returns the JSON of a.glb, and the arrays of all primitives: positions, colors, rows, triangles."""
        content = (self.folder / "a.glb").read_bytes()
        magic, version, length, size, kind = struct.unpack_from("<4sIII4s", content)
        self.assertEqual((magic, version, length, kind), (b"glTF", 2, len(content), b"JSON"))
        head = json.loads(content[20 : 20 + size])
        parts, before, end = [[], [], [], []], 0, 0
        for primitive in head["meshes"][0]["primitives"]:
            arrays = []
            for name in ("POSITION", "COLOR_0", "_CELL", "indices"):
                number = primitive["indices"] if name == "indices" else primitive["attributes"][name]
                accessor = head["accessors"][number]
                view = head["bufferViews"][accessor["bufferView"]]
                width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
                kind = {5126: "<f4", 5125: "<u4", 5123: "<u2", 5121: "<u1"}[accessor["componentType"]]
                self.assertEqual(view["byteLength"], np.dtype(kind).itemsize * width * accessor["count"])
                self.assertEqual(view["byteOffset"], (end + 3) // 4 * 4)
                self.assertEqual(view["target"], 34963 if name == "indices" else 34962)
                end = view["byteOffset"] + view["byteLength"]
                array = np.frombuffer(content, kind, width * accessor["count"], 28 + size + view["byteOffset"])
                arrays.append(array.reshape(-1, 3 if name == "indices" else width).squeeze())
                self.assertEqual("min" in accessor, name == "POSITION")
            position = head["accessors"][primitive["attributes"]["POSITION"]]
            np.testing.assert_array_equal(arrays[0].min(axis=0), np.array(position["min"], "f4"))
            np.testing.assert_array_equal(arrays[0].max(axis=0), np.array(position["max"], "f4"))
            self.assertLessEqual(len(arrays[0]), 65535)
            self.assertEqual(np.unique(arrays[3]).tolist(), list(range(len(arrays[0]))))
            arrays[3], before = arrays[3].astype(int) + before, before + len(arrays[0])
            for part, array in zip(parts, arrays):
                part.append(array)
        self.assertLessEqual(len(content) - 28 - size - head["buffers"][0]["byteLength"], 0)
        return (head, *map(np.concatenate, parts))

    def test_solids(self):
        # The last needs two primitives.
        for options in ({}, {"periodic": True}, {"box": None, "cell": CELL, "outside": "drop"}, {"count": 3000}):
            t = cells(**options)
            rgb = np.random.default_rng(4).integers(0, 256, (len(t), 3)).astype(np.uint8)
            t.save(self.path("a.glb"), color=rgb)
            head, positions, colors, rows, corners = self.read()
            self.assertEqual(len(head["meshes"][0]["primitives"]), 2 if len(t) > 3000 else 1)
            counts = np.diff(t.cell_vertices.indptr)
            cell = np.repeat(np.arange(len(t)), counts)
            np.testing.assert_array_equal(rows, cell)
            # y is up: z becomes y, and y becomes -z.
            turned = positions + np.array(head["nodes"][0]["translation"])
            places = np.column_stack((turned[:, 0], -turned[:, 2], turned[:, 1]))
            np.testing.assert_allclose(places, t.vertices[t.cell_vertices.indices], atol=1e-6)
            x = rgb / 255
            linear = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
            np.testing.assert_allclose(colors[:, :3], 255 * linear[cell], atol=0.51)
            self.assertTrue((colors[:, 3] == 255).all())
            owner = cell[corners]
            self.assertTrue((owner == owner[:, :1]).all(), "a triangle has the vertices of one cell")
            a, b, c = (places[corners[:, k]] for k in range(3))
            volumes = np.bincount(owner[:, 0], np.einsum("ij,ij->i", a, np.cross(b, c)) / 6, len(t))
            np.testing.assert_allclose(volumes, t.volumes, atol=1e-6)

    def test_too_large(self):
        """214,748,400 vertices of 20 bytes; the arrays of zeros take no memory."""
        count = 214_748_400
        huge = types.SimpleNamespace(
            indptr=np.array([0, 0]), indices=np.empty(0, np.int32), shifts=None, face_offsets=np.array([0]),
            face_vertices=np.empty(0, np.int32), vertices=np.zeros((1, 3)), cell_vertex_indptr=np.array([0, count]),
            cell_vertex_indices=np.zeros(count, np.int32), box=np.zeros((2, 3)), planar=False,
            points=np.zeros((1, 3)), weights=None, cell=None,
        )  # fmt: skip
        with self.assertRaisesRegex(ValueError, "would take 4295 MB, but .glb ends at 4 GiB: write .vtu"):
            write_mesh(self.path("a.glb"), ".glb", huge, {}, np.zeros((1, 3), np.uint8), False)

    def test_no_cells(self):
        vt.tessellate(np.empty((0, 3)), box=UNIT_BOX, want="faces,volumes").save(self.path("a.glb"))
        content = (self.folder / "a.glb").read_bytes()
        self.assertEqual(struct.unpack_from("<4sIII4s", content)[2:4], (len(content), len(content) - 20))
        self.assertEqual(list(json.loads(content[20:])), ["asset"])

    @have("trimesh")
    def test_far_from_zero(self):
        import trimesh

        t = vt.tessellate(uniform(50) + 1e6, want="faces,volumes")
        t.save(self.path("a.glb"))
        (mesh,) = trimesh.load(self.path("a.glb"), process=False).dump()
        x, y, z = t.vertices[t.cell_vertices.indices].T
        np.testing.assert_allclose(mesh.vertices, np.column_stack((x, z, -y)), rtol=0, atol=1e-6)

    def test_without_its_package(self):
        t = cells()
        with mock.patch.dict(sys.modules, {"h5py": None}):
            with self.assertRaisesRegex(ImportError, ".h5.*pip install h5py"):
                t.save(self.path("a.h5"))
        self.assertEqual(os.listdir(self.folder), [])


if __name__ == "__main__":
    unittest.main()
