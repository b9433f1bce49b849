"""t.pieces(): closed meshes, sources, gaps, and files read by other means."""

import json
import pickle
import re
import struct
import unittest
import xml.etree.ElementTree as ElementTree
import zipfile

import numpy as np
from helpers import CUBE, Folder, enclosed, is_closed, uniform

import pyvotess as vt

CORNERS, TRIANGLES = CUBE
# A cube above another, so that a cell around both has two pieces.
TWO_CUBES = (np.concatenate([CORNERS, CORNERS + (0, 0, 2)]), np.concatenate([TRIANGLES, TRIANGLES + 8]))


def read_glb(path):
    """Returns the vertices, triangles and materials of each object by name, z up again."""
    data = path.read_bytes()
    assert data[:4] == b"glTF" and struct.unpack_from("<II", data, 4) == (2, len(data))
    length = struct.unpack_from("<I", data, 12)[0]
    head = json.loads(data[20 : 20 + length])
    binary = data[28 + length :]

    def array(number):
        accessor = head["accessors"][number]
        view = head["bufferViews"][accessor["bufferView"]]
        kind = {5126: "<f4", 5123: "<u2", 5125: "<u4"}[accessor["componentType"]]
        values = np.frombuffer(binary, kind, accessor["count"] * {"VEC3": 3, "SCALAR": 1}[accessor["type"]], view["byteOffset"])
        return values.reshape(-1, 3) if accessor["type"] == "VEC3" else values

    objects = {}
    for node in (head["nodes"][k] for k in head["scenes"][0]["nodes"]):
        parts = head["meshes"][node["mesh"]]["primitives"]
        places = {part["attributes"]["POSITION"] for part in parts}
        assert len(places) == 1
        x, y, z = (array(places.pop()) + np.array(node["translation"])).T
        indices = [array(part["indices"]).reshape(-1, 3).astype(int) for part in parts]
        names = [head["materials"][part["material"]]["name"] for part in parts]
        objects[node["name"]] = np.stack([x, -z, y], 1), np.concatenate(indices), names, node["translation"]
    return objects


class TestPieces(Folder):
    def test_arrays(self):
        points = uniform(60, 5)
        t = vt.tessellate(points, mesh=CUBE, want="areas,volumes", device="cpu")
        pieces = t.pieces()
        self.assertEqual(len(pieces), 60)
        np.testing.assert_array_equal(pieces.counts, 1)
        np.testing.assert_array_equal(pieces.cells, np.arange(60))
        np.testing.assert_allclose(pieces.volumes, t.volumes, rtol=1e-12)
        for k, piece in enumerate(pieces):
            self.assertTrue(is_closed(piece.triangles))
            self.assertAlmostEqual(enclosed(piece.vertices[piece.triangles]), t.volumes[k], places=14)
            beyond = np.unique(piece.sources[~piece.on_surface])
            np.testing.assert_array_equal(beyond, t.neighbors[k])
            self.assertTrue((piece.sources[piece.on_surface] < 12).all())
        self.assertEqual(repr(pieces), f"<pyvotess.Pieces: 60 pieces of 60 cells, {len(pieces.triangles)} triangles>")
        np.testing.assert_array_equal(pieces[-1].vertices, pieces[59].vertices)
        with self.assertRaisesRegex(IndexError, "piece 60 of 60"):
            pieces[60]
        self.assertFalse(pieces.vertices.flags.writeable)
        copy = pickle.loads(pickle.dumps(pieces))
        np.testing.assert_array_equal(copy.triangles, pieces.triangles)
        self.assertLess(t.pieces(gap=0.05, threads=1).volumes.sum(), 0.9)
        fractions = []
        t.pieces(progress=fractions.append)
        self.assertGreater(len(fractions), 0)

    def test_refusals(self):
        t = vt.tessellate(uniform(5), mesh=CUBE, device="cpu")
        with self.assertRaisesRegex(ValueError, "gap is -1"):
            t.pieces(gap=-1)
        with self.assertRaisesRegex(ValueError, "tessellate with mesh="):
            vt.tessellate(uniform(5), device="cpu").pieces()
        with self.assertRaisesRegex(ValueError, "save t.pieces"):
            t.save(self.folder / "a.glb")
        pieces = t.pieces()
        with self.assertRaisesRegex(ValueError, "known are .glb .obj .stl .3mf"):
            pieces.save(self.folder / "a.vtu")
        with self.assertRaisesRegex(ValueError, "for each of the 5 cells"):
            pieces.save(self.folder / "a.glb", ids=[1, 2])
        with self.assertRaisesRegex(vt.VotessError, "cancelled by the progress"):
            t.pieces(progress=lambda fraction: False)

    def test_files(self):
        """Files have the objects, names, materials and volumes of the pieces."""
        points = np.array([(0.1, 0.4, 1.6), (0.9, 0.5, 0.4), (0.9, 0.6, 2.6)])
        t = vt.tessellate(points, mesh=TWO_CUBES, device="cpu")
        pieces = t.pieces()
        names = ["0.0", "0.1", "1", "2"]
        np.testing.assert_array_equal(pieces.counts, [2, 1, 1])

        pieces.save(self.folder / "a.glb")
        objects = read_glb(self.folder / "a.glb")
        self.assertEqual(list(objects), names)
        for k, (vertices, triangles, materials, origin) in enumerate(objects.values()):
            self.assertTrue(is_closed(triangles))
            self.assertAlmostEqual(enclosed(vertices[triangles]), pieces.volumes[k], places=6)
            self.assertEqual(materials, ["inside", "surface"])
            x, y, z = pieces.centroids[k]
            np.testing.assert_allclose(origin, (x, z, -y), rtol=0, atol=1e-15)

        copy = pickle.loads(pickle.dumps(pieces))
        copy.save(self.folder / "a.obj", ids=[7, 8, -9])
        found, vertices = {}, []
        for word, *rest in (line.split() for line in (self.folder / "a.obj").read_text().splitlines()):
            if word == "o":
                found[rest[0]] = []
            elif word == "v":
                vertices.append([float(x) for x in rest])
            elif word == "f":
                found[[*found][-1]].append([int(v) - 1 for v in rest])
        self.assertEqual(list(found), ["7.0", "7.1", "8", "-9"])
        for k, triangles in enumerate(np.array(triangles) for triangles in found.values()):
            self.assertTrue(is_closed(triangles))
            self.assertAlmostEqual(enclosed(np.array(vertices)[triangles]), pieces.volumes[k], places=14)

        pieces.save(self.folder / "a.3mf")
        with zipfile.ZipFile(self.folder / "a.3mf") as archive:
            self.assertIsNone(archive.testzip())
            model = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
        space = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
        objects = model.findall(f"{space}resources/{space}object")
        self.assertEqual([one.get("name") for one in objects], names)
        self.assertEqual(len(model.findall(f"{space}build/{space}item")), 4)
        for k, one in enumerate(objects):
            places = np.array([[float(v.get(a)) for a in "xyz"] for v in one.iter(f"{space}vertex")])
            triangles = np.array([[int(t.get(a)) for a in ("v1", "v2", "v3")] for t in one.iter(f"{space}triangle")])
            self.assertTrue(is_closed(triangles))
            self.assertAlmostEqual(enclosed(places[triangles]), pieces.volumes[k], places=14)
            materials = [int(t.get("p1")) for t in one.iter(f"{space}triangle")]
            np.testing.assert_array_equal(materials, pieces[k].on_surface)

        pieces.save(self.folder / "a.stl")
        data = (self.folder / "a.stl").read_bytes()
        self.assertEqual(len(data), 84 + 50 * len(pieces.triangles))
        kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("zero", "<u2")])
        triangles = np.frombuffer(data, kind, offset=84)
        corners = triangles["corners"].astype(float)
        self.assertAlmostEqual(enclosed(corners), 2, places=6)
        np.testing.assert_allclose(np.linalg.norm(triangles["normal"], axis=1), 1, atol=1e-6)

    def test_vtu(self):
        """Each piece is a polyhedron with the numbers of its cell."""
        t = vt.tessellate(np.array([[0.5, 0.5, 0.5], [0.5, 0.5, 9.0]]), mesh=TWO_CUBES, device="cpu", want="neighbors,volumes")
        t.save(self.folder / "a.vtu", columns={"mass": [3.0, 4.0]})
        data = (self.folder / "a.vtu").read_bytes()
        self.assertIn(b'NumberOfPoints="16" NumberOfCells="2"', data)
        body = data[data.index(b"_", data.index(b"<AppendedData")) + 1 :]
        offsets = dict(re.findall(rb'Name="(\w+)".*? offset="(\d+)"', data))
        for name, kind, expected in (
            (b"id", "<i8", [0, 0]), (b"volume", "<f8", [1, 1]), (b"mass", "<f8", [3, 3]), (b"neighbors", "<i4", [0, 0])
        ):  # fmt: skip
            at = int(offsets[name])
            size = struct.unpack_from("<Q", body, at)[0]
            np.testing.assert_allclose(np.frombuffer(body[at + 8 : at + 8 + size], kind), expected, rtol=1e-14)
        with self.assertRaisesRegex(ValueError, "'neighbors' into want"):
            vt.tessellate(uniform(5), mesh=CUBE, device="cpu", want="volumes").save(self.folder / "a.vtu")

    def test_none(self):
        """Files without pieces are valid."""
        pieces = vt.tessellate(np.empty((0, 3)), mesh=CUBE, device="cpu").pieces()
        self.assertEqual(len(pieces), 0)
        for extension in (".glb", ".obj", ".3mf", ".stl"):
            pieces.save(self.folder / ("none" + extension))
        data = (self.folder / "none.glb").read_bytes()
        self.assertEqual(json.loads(data[20:])["asset"]["version"], "2.0")
        shrunk = vt.tessellate(uniform(9), mesh=CUBE).pieces(gap=9)
        self.assertEqual(len(shrunk), 0)
        for none in (pieces, shrunk):
            none.save(self.folder / "none.html")
            with self.assertRaisesRegex(ValueError, "there are no pieces to draw"):
                none.image()


if __name__ == "__main__":
    unittest.main()
