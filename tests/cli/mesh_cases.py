"""Meshes as .vtu, .ply and .obj, read back by VTK, and .glb."""

import json
import struct
import unittest

import numpy as np

from cli_test import CUBE, CUBE_BOX, SANITIZED, random_points
from reader_cases import ReaderTest

try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkIdList
    from vtkmodules.vtkIOPLY import vtkPLYReader
    from vtkmodules.vtkIOGeometry import vtkOBJReader
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    HAS_VTK = True
except ImportError:
    HAS_VTK = False


@unittest.skipUnless(HAS_VTK, "NO VTK: .vtu, .ply AND .obj ARE NOT READ BACK (Debian: python3-vtk9)")
class MeshFiles(ReaderTest):
    def grid(self, name):
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(self.folder / name))
        errors = []
        reader.AddObserver("ErrorEvent", lambda *_: errors.append(1))
        reader.Update()
        self.assertEqual(errors, [])
        return reader.GetOutput()

    @staticmethod
    def polygons(grid, cell):
        stream = vtkIdList()
        grid.GetFaceStream(cell, stream)
        numbers = [stream.GetId(k) for k in range(stream.GetNumberOfIds())]
        faces, at = [], 1
        while at < len(numbers):
            faces.append(numbers[at + 1:at + 1 + numbers[at]])
            at += 1 + numbers[at]
        assert len(faces) == numbers[0]
        return faces

    def check_grid(self, name, volumes, box_volume, first_id=0):
        """Watertight, oriented cells whose volumes are those of the library, by `id`, and fill the box."""
        grid = self.grid(name)
        volumes = np.asarray(volumes)
        self.assertEqual(grid.GetNumberOfCells(), np.count_nonzero(volumes))
        ids = vtk_to_numpy(grid.GetCellData().GetArray("id")) - first_id
        self.assertEqual(sorted(ids), np.flatnonzero(volumes).tolist())
        volumes = volumes[ids]
        sizes = [grid.GetCell(cell).GetNumberOfPoints() for cell in range(grid.GetNumberOfCells())]
        self.assertEqual(sizes, sorted(sizes))
        vertices = vtk_to_numpy(grid.GetPoints().GetData())
        total = 0
        for cell in range(grid.GetNumberOfCells()):
            self.assertEqual(grid.GetCellType(cell), 42)
            faces = self.polygons(grid, cell)
            edges = [edge for face in faces for edge in zip(face, face[1:] + face[:1])]
            self.assertEqual(len(set(edges)), len(edges))
            self.assertEqual({(b, a) for a, b in edges}, set(edges))  # each edge once in either direction
            corners = {v for face in faces for v in face}
            self.assertEqual(len(corners) - len(edges) // 2 + len(faces), 2)
            ids = vtkIdList()
            grid.GetCellPoints(cell, ids)
            self.assertEqual({ids.GetId(k) for k in range(ids.GetNumberOfIds())}, corners)
            origin = vertices[faces[0][0]]
            volume = 0
            for face in faces:
                fan = vertices[face] - origin
                volume += sum(np.dot(fan[0], np.cross(fan[k], fan[k + 1])) for k in range(1, len(fan) - 1)) / 6
            self.assertAlmostEqual(volume, volumes[cell], delta=1e-12 * box_volume)
            total += volume
        self.assertAlmostEqual(total, box_volume, delta=1e-11 * box_volume)
        return grid

    def test_vtu(self):
        self.put("a.txt", "".join(f"{i + 50} {row}\n" for i, row in enumerate(CUBE.splitlines())) + "99 0 0 0\n")
        self.run_cli("a.txt", "--box", CUBE_BOX, "-o", "a.vtu")
        grid = self.check_grid("a.vtu", [1] * 8 + [0], 8, 50)
        self.assertEqual(grid.GetNumberOfPoints(), 27)
        data = {grid.GetCellData().GetArrayName(k): vtk_to_numpy(grid.GetCellData().GetArray(k))
                for k in range(grid.GetCellData().GetNumberOfArrays())}
        self.assertEqual(data["id"].tolist(), list(range(50, 58)))
        self.assertEqual(data["volume"].tolist(), [1] * 8)
        self.assertEqual(data["neighbors"].tolist(), [3] * 8)
        self.assertEqual(data["status"].tolist(), [0] * 8)
        np.testing.assert_allclose(data["centroid"], np.loadtxt(CUBE.splitlines()), atol=1e-15)
        self.run_cli("--random", 0, "-o", "none.vtu")
        self.assertEqual(self.grid("none.vtu").GetNumberOfCells(), 0)

    def test_vtu_of_many(self):
        count = 2000 if SANITIZED else 10000
        self.run_cli("--random", count, "-o", "a.vtu", "-o", "a.npz", "--want", "vertices,volumes")
        with np.load(self.folder / "a.npz") as arrays:
            grid = self.check_grid("a.vtu", arrays["volumes"], 1)
            np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), arrays["vertices"])

    def test_faces(self):
        self.run_cli("--random", 500, "-o", "a.ply", "-o", "a.obj", "-o", "a.npz", "--want", "faces,neighbors")
        with np.load(self.folder / "a.npz") as arrays:
            arrays = dict(arrays)
        rows = np.repeat(np.arange(500), np.diff(arrays["indptr"]))
        once = np.flatnonzero((arrays["indices"] < 0) | (rows < arrays["indices"]))
        offsets = arrays["face_offsets"]
        polygons = [arrays["face_vertices"][offsets[k]:offsets[k + 1]].tolist() for k in once]
        for name, reader in [("a.ply", vtkPLYReader()), ("a.obj", vtkOBJReader())]:
            reader.SetFileName(str(self.folder / name))
            reader.Update()
            mesh = reader.GetOutput()
            # VTK keeps float32 here.
            np.testing.assert_allclose(vtk_to_numpy(mesh.GetPoints().GetData()), arrays["vertices"], rtol=0, atol=1e-6)
            self.assertEqual(mesh.GetNumberOfPolys(), len(once))
            ids = vtkIdList()
            for k, polygon in enumerate(sorted(polygons, key=len) if name == "a.ply" else polygons):
                mesh.GetCellPoints(k, ids)
                self.assertEqual([ids.GetId(j) for j in range(ids.GetNumberOfIds())], polygon)
        obj = (self.folder / "a.obj").read_text().splitlines()
        vertices = np.array([line.split()[1:] for line in obj if line.startswith("v ")], float)
        np.testing.assert_array_equal(vertices, arrays["vertices"])
        # The two cells of each face.
        head, body = (self.folder / "a.ply").read_text().split("end_header\n", 1)
        self.assertIn("property list uchar int vertex_indices\nproperty int cell\nproperty int neighbor", head)
        lines = body.splitlines()
        np.testing.assert_array_equal(np.array([line.split() for line in lines[:len(vertices)]], float), vertices)
        faces = [[int(word) for word in line.split()] for line in lines[len(vertices):]]
        expected = [[len(polygon), *polygon, rows[k], arrays["indices"][k]] for k, polygon in zip(once, polygons)]
        self.assertEqual(faces, sorted(expected, key=lambda face: face[0]))


class GltfFiles(ReaderTest):
    def read(self, name):
        """The JSON of a .glb file, and the arrays of all its primitives, one behind the other."""
        content = (self.folder / name).read_bytes()
        magic, version, length, size, kind = struct.unpack_from("<4sIII4s", content)
        self.assertEqual((magic, version, length, kind), (b"glTF", 2, len(content), b"JSON"))
        head = json.loads(content[20:20 + size])
        binary, kind = struct.unpack_from("<I4s", content, 20 + size)
        self.assertEqual((binary, kind), (len(content) - 28 - size, b"BIN\0"))
        body = content[28 + size:]
        self.assertLessEqual(head["buffers"][0]["byteLength"], len(body))
        parts = {}
        ends = [0]  # of the bytes of arrays, which lie one behind the other
        before = 0
        for primitive in head["meshes"][0]["primitives"]:
            for name, number in {**primitive["attributes"], "indices": primitive["indices"]}.items():
                accessor = head["accessors"][number]
                view = head["bufferViews"][accessor["bufferView"]]
                width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
                kind = {5126: "<f4", 5125: "<u4", 5123: "<u2", 5121: "<u1"}[accessor["componentType"]]
                self.assertEqual(view["byteLength"], np.dtype(kind).itemsize * width * accessor["count"])
                self.assertEqual(view["byteOffset"], (ends[-1] + 3) // 4 * 4)
                ends.append(view["byteOffset"] + view["byteLength"])
                self.assertEqual(view["target"], 34963 if name == "indices" else 34962)
                array = np.frombuffer(body, kind, width * accessor["count"], view["byteOffset"])
                array = array.reshape(-1, width).squeeze()
                if name == "indices":
                    array = array.astype(int)
                    count = len(parts["POSITION"][-1])
                    self.assertEqual((array.min(), array.max()), (0, count - 1))
                    self.assertLessEqual(count, 65535)
                    array, before = array + before, before + count
                self.assertEqual("min" in accessor, name == "POSITION")
                if "min" in accessor:
                    np.testing.assert_array_equal(array.min(axis=0), np.array(accessor["min"], "f4"))
                    np.testing.assert_array_equal(array.max(axis=0), np.array(accessor["max"], "f4"))
                parts.setdefault(name, []).append(array)
        self.assertEqual((ends[-1] + 3) // 4 * 4, len(body))
        return head, {name: np.concatenate(some) for name, some in parts.items()}

    def test_solids(self):
        for more, count in [([], 3000), (["--box", "1e6,0,0,1000001,1,2", "--outside", "drop"], 1)]:
            if count == 1:
                self.put("a.txt", "1000000.25 0.5 0.5\n1000000.25 0.5 0.5\n")
            done = self.run_cli(*(["--random", count] if count > 1 else ["a.txt", *more]), "-o", "a.glb", "-o", "a.npz")
            size = (self.folder / "a.glb").stat().st_size
            self.assertEqual(done.stderr, f"'a.glb' takes {-(-size // 10**6)} MB\n")
            self.assertLess(size, 900 * count + 2000)
            head, arrays = self.read("a.glb")
            with np.load(self.folder / "a.npz") as file:
                volumes, vertices, own = file["volumes"], file["vertices"], file["cell_vertex_indices"]
                box = file["box"]
            # y is up: z becomes y, and y becomes -z. The node moves the middle of the domain to its place.
            node = head["nodes"][0]
            turned = arrays["POSITION"].astype(float) + node["translation"]
            corners = np.column_stack((turned[:, 0], -turned[:, 2], turned[:, 1]))
            np.testing.assert_allclose(corners, vertices[own], rtol=0, atol=1e-7)
            np.testing.assert_allclose(node["translation"], box.mean(axis=0)[[0, 2, 1]] * (1, 1, -1), rtol=0, atol=1e-9)
            self.assertEqual(set(node), {"mesh", "name", "translation"})
            corners -= box.mean(axis=0)
            triangles = arrays["indices"].reshape(-1, 3)
            a, b, c = (corners[triangles[:, k]] for k in range(3))
            cross = np.cross(b - a, c - a)
            cells = arrays["_CELL"].astype(int)
            measured = np.bincount(cells[triangles[:, 0]], np.einsum("tk,tk->t", a, cross) / 6, len(volumes))
            np.testing.assert_allclose(measured, volumes, atol=1e-6)
            # Each triangle is of one cell, and there are no normals: readers shade flat.
            self.assertTrue((cells[triangles] == cells[triangles[:, :1]]).all())
            self.assertEqual(set(arrays), {"POSITION", "COLOR_0", "_CELL", "indices"})
            self.assertEqual(len(head["meshes"][0]["primitives"]), 2 if count > 1 else 1)

    def test_colors(self):
        points = random_points(50)
        mass = np.arange(50.0)
        np.savez(self.folder / "p.npz", points=points, mass=mass)
        self.run_cli("p.npz", "--copy", "mass", "--color", "mass", "--colormap", "gray", "-o", "a.glb")
        arrays = self.read("a.glb")[1]
        colors, cells = arrays["COLOR_0"], arrays["_CELL"].astype(int)
        self.assertTrue((colors[:, :3] == colors[:, :1]).all() and (colors[:, 3] == 255).all())
        of_cell = np.empty(50)
        of_cell[cells] = colors[:, 0]
        np.testing.assert_array_equal(of_cell[cells], colors[:, 0])
        self.assertTrue((np.diff(of_cell) >= 0).all())  # as the mass; a byte tells few dark colors apart
        self.assertGreater(len(np.unique(of_cell)), 35)
        for column in ["volume", "neighbors", "area", "x", "index"]:
            self.run_cli("p.npz", "--color", column, "-o", "a.glb")
            self.assertGreater(len(np.unique(self.read("a.glb")[1]["COLOR_0"], axis=0)), 5)
        self.refuse("p.npz", "--color", "mass", "-o", "b.glb", says=["'mass'", "--copy"])
        self.refuse("p.npz", "--copy", "mass", "-o", "b.obj", says=["--copy", ".glb"])

    def test_no_points(self):
        self.put("none.txt", "")
        self.run_cli("none.txt", "-o", "a.glb")
