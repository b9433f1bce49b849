"""--mesh: a closed triangle mesh as the domain, from each format."""

import json
import re
import struct
import zipfile

import numpy as np

from cli_test import CliTest

CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
TRIANGLES = [(f[0], f[k], f[k + 1]) for f in FACES for k in (1, 2)]


def lines(form, rows):
    return "".join(form.format(*row) + "\n" for row in rows)


def ply(kind, faces_first=False):
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[kind]
    vertex = "element vertex 8\nproperty float x\nproperty uchar red\nproperty double y\nproperty double z\n"
    face = "element face 6\nproperty list uchar float uv\nproperty list uint8 int32 vertex_indices\nproperty short flag\n"
    head = f"ply\nformat {kind} 1.0\n{face + vertex if faces_first else vertex + face}end_header\n".encode()
    if order:
        vertices = b"".join(struct.pack(order + "fBdd", x, 7, y, z) for x, y, z in CORNERS)
        faces = b"".join(struct.pack(order + "BffB4ih", 2, 0.5, 0.5, 4, *f, -1) for f in FACES)
    else:
        vertices = lines("{} 7 {} {}", CORNERS).encode()
        faces = lines("2 0.5 0.5 4 {} {} {} {} -1", FACES).encode()
    return head + (faces + vertices if faces_first else vertices + faces)


def stl_text(triangles=TRIANGLES):
    loop = "outer loop\n{}endloop\n"
    return "solid a cube\n" + "".join("  FACET normal 0 0 0\n" + loop.format(lines("  vertex {} {} {}e0", (CORNERS[v] for v in t)))
                                      + "endfacet\n" for t in triangles) + "endsolid a cube\n"


def stl_binary():
    return b"solid, but binary".ljust(80, b"\0") + struct.pack("<I", 12) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for v in t for x in CORNERS[v]), 0) for t in TRIANGLES)


def glb(nodes, primitives, arrays, **more):
    """Binary glTF. arrays: of the accessors; float32 of three columns, or indices."""
    document, data = {"asset": {"version": "2.0"}, "nodes": nodes, "accessors": [], "bufferViews": [],
                      "meshes": [{"primitives": primitives}], **more}, b""
    for array in arrays:
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "count": len(array),
                                      "componentType": {"f": 5126, "B": 5121, "H": 5123, "I": 5125}[array.dtype.char],
                                      "type": "VEC3" if array.ndim == 2 else "SCALAR"})
        data += array.tobytes().ljust(-(-array.nbytes // 4) * 4, b"\0")
    document["buffers"] = [{"byteLength": len(data)}]
    text = json.dumps(document).encode()
    text = text.ljust(-(-len(text) // 4) * 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def glb_cube():
    """A cube of 2 faces in one node, and 4 in a child that is moved, turned, scaled and mirrored. y is up."""
    up = np.array([(x, z, -y) for x, y, z in CORNERS], "f4")
    first, rest = np.array(TRIANGLES[:4]), np.array(TRIANGLES[4:])
    # The child's corners c give up = turn (scale * c) + move, with a half turn around y.
    scale, move = np.array([2.0, -4.0, 0.5]), np.array([0.5, 3.0, -1.0])
    inner = (up - (0.25, 0, 0) - move) * (-1, 1, -1) / scale
    arrays = [(up - np.float32([0.25, 0, 0])).astype("f4"), first.ravel().astype("B"), inner.astype("f4")[rest[:, ::-1].ravel()]]
    nodes = [{"translation": [0.25, 0, 0], "mesh": 0, "children": [1], "name": "a\"b"},
             {"mesh": 1, "translation": move.tolist(), "scale": scale.tolist(), "rotation": [0, 1, 0, 0]}]
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}, {"attributes": {}, "mode": 1}]},
              {"primitives": [{"attributes": {"POSITION": 2}}]}]
    return glb(nodes, [], arrays, meshes=meshes, scene=0, scenes=[{"nodes": [0]}])


MOVES = {"a skin": {"skin": 0}, "weights": {"weights": [0, 0.5]}, "EXT_mesh": {"extensions": {"EXT_mesh_gpu_instancing": {}}}}
OFF = "OFF # a cube\n\n8 6 12\n" + lines("{} {} {}", CORNERS) + lines("4 {} {} {} {}  255 0 0", FACES)
OBJ = "mtllib a.mtl\no cube\n" + lines("v {} {} {} 1", CORNERS) + "vt 0 0\n" + "usemtl b\n" + \
    lines("f {}/1 {}/1/2 {}//3 {}", [[v + 1 if v < 4 else v - 8 for v in f] for f in FACES])
FILES = {"plain.off": OFF, "glued.off": OFF.replace("OFF # a cube\n\n", "OFF"),
         "colors.off": OFF.replace("OFF", "COFF", 1).replace("\n1 1 1\n", "\n1 1 1 0 255 0 255 # green\n"), "a.obj": OBJ,
         "text.stl": stl_text(), "dos.STL": stl_text().replace("\n", "\r\n"), "binary.stl": stl_binary(),
         "line.stl": stl_text().replace("\n", " ").replace("cube ", "cube\n", 1),
         "facets.stl": stl_text().replace("solid a cube", "solid facet normal test", 1),
         "words.stl": "solid a b\n" + stl_text()[13:-16].replace(" ", "\n") + "endsolid a b\n",
         "mac.stl": stl_text().replace("\n", "\r"), "one.stl": stl_text().replace("\n", " "),
         "both.stl": (stl_text(TRIANGLES[:5]) + stl_text(TRIANGLES[5:])).replace("\n", " ").replace("solid a cube ", "solid a solid facet "),
         "none.stl": (stl_text([]) + stl_text()).replace("\n", " "), "names.stl": stl_text().replace("solid a cube", "solid my solid facet"),
         "upper.stl": stl_text().upper(), "mark.stl": "\ufeff" + stl_text(), "indented.stl": "\n  " + stl_text(),
         "blank.stl": b"solid".ljust(80) + stl_binary()[80:], "lines.obj": OBJ.replace("f 1/1 ", "f 1/1 \\\n").replace("v 1 0 0", "v 1 \\\n0\\\n 0"),
         "ctrl_z.stl": stl_text().replace("\n", "\r\n") + "\x1a\r\n", "ctrl_zz.stl": stl_binary() + b"\x1a\x1a", "mark_in.stl": stl_binary()[:-2] + b"\x1a\x1a",
         "cube.glb": glb_cube(),
         **{f"{kind}.off": OFF.replace("OFF", kind + "OFF", 1) for kind in ["N", "NC", "CN", "STN"]},
         "ascii.ply": ply("ascii"), "little.ply": ply("binary_little_endian"), "big.ply": ply("binary_big_endian"),
         "faces_first.ply": ply("ascii", True), "faces_first_too.ply": ply("binary_big_endian", True)}


class Mesh(CliTest):
    def arrays(self, *arguments):
        self.run_cli(*arguments, "-o", "out.npz", "-q")
        with np.load(self.folder / "out.npz") as file:
            return dict(file)

    def test_formats(self):
        """A cube in each format has the cells of the box."""
        want = ["--random", 200, "--want", "neighbors,volumes,areas,surfaces"]
        box = self.arrays(*want, "--box", "0,0,0,1,1,1")
        for name, content in FILES.items():
            with self.subTest(name):
                mesh = self.arrays(*want, "--mesh", self.put(name, content))
                for array in ["indptr", "indices"]:
                    np.testing.assert_array_equal(mesh[array], box[array])
                for array in ["volumes", "face_areas", "surface_areas"]:
                    np.testing.assert_allclose(mesh[array], box[array], rtol=0, atol=1e-14)
                self.assertAlmostEqual(mesh["mesh_areas"].sum(), 6, delta=1e-12)

    def test_polygons(self):
        """Prisms over polygons that are not convex: each corner first once, in each format. Shoelaces give the areas."""
        star = [(round(r * np.cos(a), 3), round(r * np.sin(a), 3)) for r, a in zip([1, 0.3] * 6, np.arange(12) * np.pi / 6)]
        outlines = {"L": [(0, 0), (2, 0), (2, 0.3), (0.3, 0.3), (0.3, 2), (0, 2)], "star": star,
                    "comb": [(0, 0), (7, 0), (7, 2), (6, 2), (6, 1), (5, 1), (5, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]}
        for name, outline in outlines.items():
            n = len(outline)
            places = np.array(outline)
            (x, y), (u, v) = places.T, np.roll(places, -1, 0).T
            area, around = (x * v - y * u).sum() / 2, np.hypot(u - x, v - y).sum()
            for first in range(n):
                turned = [*range(first, n), *range(first)]
                faces = [turned[::-1], [n + k for k in turned], *([k, (k + 1) % n, (k + 1) % n + n, k + n] for k in range(n))]
                corners = [(*p, z) for z in (0, 1) for p in outline]
                listed = "".join(" ".join(map(str, [len(f), *f])) + "\n" for f in faces)
                files = {"a.off": f"OFF {2 * n} {n + 2} 0\n" + lines("{} {} {}", corners) + listed,
                         "a.obj": lines("v {} {} {}", corners) + "".join("f " + " ".join(str(k + 1) for k in f) + "\n" for f in faces),
                         "a.ply": f"ply\nformat ascii 1.0\nelement vertex {2 * n}\nproperty double x\nproperty double y\n"
                                  f"property double z\nelement face {n + 2}\nproperty list uchar int vertex_indices\nend_header\n"
                                  + lines("{} {} {}", corners) + listed}
                kind = list(files)[first % 3]
                with self.subTest(name=name, first=first, kind=kind):
                    found = self.arrays("--random", 20, "--mesh", self.put(kind, files[kind]), "--want", "volumes,surfaces")
                    self.assertAlmostEqual(found["mesh_areas"].sum(), 2 * area + around, delta=1e-10)
                    self.assertAlmostEqual(found["volumes"].sum(), area, delta=1e-10)
        run = ["--random", 9, "--mesh"]
        cube = OBJ.replace("v 1 1 1 1", "v 1 1 1.001 1")
        self.refuse(*run, self.put("b.obj", cube), says=["b.obj: face 2 is not flat: its vertex ", "cut it into triangles"])
        bow = OFF.replace("4 0 4 6 2", "4 0 6 4 2")
        self.refuse(*run, self.put("b.off", bow), says="face 4 is not simple: its sides from vertex ")

    def test_random(self):
        """Random points lie inside the mesh, wherever it is: a prism over an L, with a third of them in each arm and in the corner."""
        outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
        n = len(outline)
        faces = [[*range(n)][::-1], [n + k for k in range(n)], *([k, (k + 1) % n, (k + 1) % n + n, k + n] for k in range(n))]
        corners = [(10 + x, y - 30, z) for z in (5, 5.5) for x, y in outline]
        self.put("l.off", f"OFF {2 * n} {n + 2} 0\n" + lines("{} {} {}", corners) + "".join(" ".join(map(str, [len(f), *f])) + "\n" for f in faces))
        rows = np.array([list(map(float, row.split())) for row in self.rows("--random", 6000, "--mesh", "l.off", "--format", "%q %v")])
        x, y, z = rows[:, :3].T - np.array([[10], [-30], [5]])
        self.assertTrue(((x >= 0) & (y >= 0) & (z >= 0) & (x <= 2) & (y <= 2) & (z <= 0.5) & ((x <= 1) | (y <= 1))).all())
        self.assertEqual(len(rows), 6000)
        for count in [((x < 1) & (y < 1)).sum(), (x > 1).sum(), (y > 1).sum()]:
            self.assertLess(abs(count - 2000), 5 * np.sqrt(6000 * 2 / 9))
        self.assertAlmostEqual(rows[:, 3].sum(), 1.5, delta=1e-10)

    def test_repair(self):
        """Triangles with vertices of their own are a cube once these are merged, as an .stl is."""
        content = f"OFF\n36 12 0\n{lines('{} {} {}', (CORNERS[v] for t in TRIANGLES for v in t))}" + \
            lines("3 {} {} {}", [range(3 * t, 3 * t + 3) for t in range(12)])
        run = ["--random", 50, "--want", "neighbors,volumes", "--mesh"]
        self.refuse(*run, self.put("open.off", content), says="merge vertices at equal places: --mesh-repair")
        whole, merged = self.arrays(*run, self.put("a.stl", stl_text())), self.arrays(*run, "open.off", "--mesh-repair", "merge")
        for array in ["indptr", "indices", "volumes"]:
            np.testing.assert_array_equal(merged[array], whole[array])
        self.refuse("--random", 9, "--mesh-repair", "merge", says="--mesh")

    def test_tolerance(self):
        """Corners that rounding sets apart become one, and the summary says how far they moved."""
        rng = np.random.default_rng(6)
        corners = [tuple(x + 1e-12 * rng.uniform(-1, 1) for x in CORNERS[v]) for t in TRIANGLES for v in t]
        off = f"OFF\n36 12 0\n{lines('{!r} {!r} {!r}', corners)}" + lines("3 {} {} {}", [range(3 * t, 3 * t + 3) for t in range(12)])
        stl = "solid\n" + "".join("facet normal 0 0 0\nouter loop\n" + lines("vertex {!r} {!r} {!r}", corners[3 * t:3 * t + 3]) +
                                  "endloop\nendfacet\n" for t in range(12)) + "endsolid\n"
        run = ["--random", 50, "--mesh"]
        for name, content, repair in [("a.off", off, ["--mesh-repair", "merge"]), ("a.stl", stl, [])]:
            with self.subTest(name):
                self.refuse(*run, self.put(name, content), *repair, says=["36 edges are open", "merge near vertices: --mesh-tolerance ", "vertices 0 (", ") and 1 ("])
                summary = self.run_cli(*run, name, *repair, "--mesh-tolerance", "1e-9").stdout
                self.assertRegex(summary, r"(?m)^mesh          a\....,.* 12 triangles; 28 vertices moved by at most \d\.?\d*e-12$")
                found = self.json(*run, name, *repair, "--mesh-tolerance", "1e-9")
                self.assertEqual(found["moved_vertices"], 28)
                self.assertLess(found["moved_distance"], 4e-12)
                self.assertAlmostEqual(found["box_volume"], 1, delta=1e-11)
        self.refuse(*run, "a.off", "--mesh-tolerance", "1e-9", says="--mesh-tolerance needs --mesh-repair")
        self.refuse(*run, "a.stl", "--mesh-tolerance", "0.5", says="--mesh-tolerance is 0.5: give a share")
        self.refuse(*run, "a.stl", "--mesh-tolerance", "-1", says="-1")
        self.refuse("--random", 9, "--mesh-tolerance", "1e-9", says="--mesh")

    def test_outputs(self):
        self.put("a.off", OFF)
        points = self.put("points.txt", "0.25 0.5 0.5\n0.75 0.5 0.5\n3 0.5 0.5\n")
        mesh = [points, "--mesh", "a.off"]
        self.assertEqual(self.rows(*mesh, "--format", "%i %n"), ["0 1", "1 0", "2 "])
        np.testing.assert_allclose(np.array(self.rows(*mesh, "--format", "%F"), float), [4, 4, 0], rtol=1e-14)
        self.run_cli(*mesh, "-o", "a.csv", "-o", "a.xyz", "-o", "a.dump", "-q")
        head, row = (self.folder / "a.csv").read_text().splitlines()[:2]
        self.assertEqual(head, "id,x,y,z,volume,neighbors")
        np.testing.assert_allclose(np.array(row.split(","), float), [0, 0.25, 0.5, 0.5, 0.5, 1], rtol=1e-14)
        self.run_cli(*mesh, "-o", "a.csv", "--want", "surfaces", "-q")
        head, row = (self.folder / "a.csv").read_text().splitlines()[:2]
        self.assertEqual(head, "id,x,y,z,surface_area,mesh_area")
        np.testing.assert_allclose(np.array(row.split(","), float), [0, 0.25, 0.5, 0.5, 4, 3], rtol=1e-14)
        areas = self.arrays(*mesh, "--only", "1", "--want", "surfaces")["mesh_areas"]
        np.testing.assert_allclose(areas, [3], rtol=1e-14)
        self.assertRegex(self.run_cli(*mesh, "--verify").stdout, r"(?m)^verified ")
        summary = self.run_cli(*mesh).stdout
        self.assertRegex(summary, r"(?m)^mesh          a.off, 12 triangles$")
        self.assertRegex(summary, r"(?m)^volume sum    1 of the mesh's 1, relative")
        self.assertRegex(summary, r"(?m)^domain        box .*, not periodic, around points and mesh; default$")
        found = self.json(*mesh, "--box", "-1,-1,-1,4,2,2")
        self.assertEqual((found["mesh"], found["triangles"], found["empty_cells"], found["box_volume"]), ("a.off", 12, 1, 1))
        self.assertEqual((found["domain"]["kind"], found["domain"]["upper"]), ("mesh", [4, 2, 2]))

    def test_pieces(self):
        """Pieces are objects, apart by the gap. As a mesh they have the volume of all."""
        self.put("a.off", OFF)
        points = self.put("points.txt", "7 0.25 0.5 0.5\n9 0.75 0.5 0.5\n8 3 0.5 0.5\n")
        self.run_cli(points, "--mesh", "a.off", "--gap", "0.25", *(f for e in ["glb", "obj", "stl", "3mf"] for f in ("-o", f"p.{e}")), "-q")
        lines_of_obj = (self.folder / "p.obj").read_text().splitlines()
        self.assertEqual([line for line in lines_of_obj if line[0] == "o"], ["o 7", "o 9"])
        self.assertEqual({line for line in lines_of_obj if line[0] == "u"}, {"usemtl inside", "usemtl surface"})
        for name in ["p.obj", "p.stl", "p.glb"]:
            self.assertEqual(self.json("--random", 9, "--mesh", name)["box_volume"], 0.75)
        with zipfile.ZipFile(self.folder / "p.3mf") as archive:
            self.assertEqual(archive.read("3D/3dmodel.model").count(b"<object "), 2)
        data = (self.folder / "p.glb").read_bytes()
        head = json.loads(data[20:20 + struct.unpack_from("<I", data, 12)[0]])
        self.assertEqual([(node["name"], node["translation"]) for node in head["nodes"]],
                         [("7", [0.1875, 0.5, -0.5]), ("9", [0.8125, 0.5, -0.5])])
        run = [points, "--mesh", "a.off"]
        for more, says in [(["--gap", "1"], "add -o FILE in .glb"), (["--gap", "-1", "-o", "p.stl"], "negative"),
                           (["-o", "p.ply"], "whole cells"), (["-o", "p.glb", "--color", "x"], "materials")]:
            self.refuse(*run, *more, says=says)
        self.refuse(points, "-o", "p.3mf", says="add --mesh FILE")
        self.refuse(points, "--gap", "1", "-o", "p.glb", says="--mesh")

    def test_replaces_the_domain_of_the_file(self):
        self.put("a.off", OFF)
        frame = '2\nLattice="9 0 0 0 9 0 0 0 9" Properties=pos:R:3\n0.25 0.5 0.5\n0.75 0.5 0.5\n'
        points = self.put("a.xyz", frame + frame.replace("0.75", "1.25"))
        run = [points, "--mesh", "a.off", "--format", "%v"]
        np.testing.assert_allclose(np.array(self.rows(*run), float), [0.5, 0.5], rtol=1e-14)
        volumes = [row for row in self.rows(*run, "--frames", "all") if row[0] != "#"]
        np.testing.assert_allclose(np.array(volumes, float), [0.5, 0.5, 0.75, 0.25], rtol=1e-14)
        self.assertIn("a.off, 12 triangles", self.run_cli(points, "--mesh", "a.off", "--frames", "all").stdout)
        self.refuse(points, "--mesh", "a.off", "--periodic", says="--periodic needs a box")

    def test_periodic(self):
        """The second cell has its own part at x = 0.85 to 1, and that of an image at 0 to 0.1."""
        self.put("a.off", OFF)
        points = self.put("a.csv", "0.4,0.5,0.5\n1.3,0.5,0.5\n")
        cells = self.arrays(points, "--mesh", "a.off", "--box=0,-1,-1,1.5,2,2", "--periodic", "x", "--want", "neighbors,volumes,areas")
        np.testing.assert_allclose(cells["volumes"], [0.75, 0.25], rtol=1e-14)
        np.testing.assert_allclose(cells["face_areas"], 1, rtol=1e-14)
        self.assertEqual(cells["shifts"].tolist(), [[-1, 0, 0], [0, 0, 0], [0, 0, 0], [1, 0, 0]])

    def test_min_face(self):
        """Two of three cells share a small face."""
        self.put("a.off", OFF)
        points = self.put("a.csv", "0.25,0.25,0.5\n0.75,0.25,0.5\n0.45,0.9,0.5\n")
        run = [points, "--mesh", "a.off", "--want", "neighbors"]
        areas = self.arrays(points, "--mesh", "a.off", "--want", "areas")["face_areas"]
        self.assertEqual(len(areas), 6)
        self.assertEqual(len(self.arrays(*run, "--min-area", repr(1.001 * float(areas.min())))["indices"]), 4)

    def test_vtu(self):
        """Each piece is a polyhedron with the numbers of its row."""
        self.put("a.off", OFF)
        points = self.put("points.csv", "id,x,y,z,m\n7,0.25,0.5,0.5,2.5\n9,0.75,0.5,0.5,3.5\n8,3,0.5,0.5,4.5\n")
        self.run_cli(points, "--mesh", "a.off", "--gap", "0.25", "--copy", "m", "-o", "p.vtu", "-q")
        data = (self.folder / "p.vtu").read_bytes()
        self.assertIn(b'NumberOfCells="2"', data)
        body = data[data.index(b"_", data.index(b"<AppendedData")) + 1:]
        arrays = dict(re.findall(rb'Name="(\w+)".*? offset="(\d+)"', data))
        for name, kind, expected in [(b"id", "<i8", [7, 9]), (b"volume", "<f8", [0.375, 0.375]), (b"types", "u1", [42, 42]),
                                     (b"neighbors", "<i4", [1, 1]), (b"centroid", "<f8", [0.1875, 0.5, 0.5, 0.8125, 0.5, 0.5]),
                                     (b"m", "<f8", [2.5, 3.5])]:
            at = int(arrays[name])
            size = struct.unpack_from("<Q", body, at)[0]
            np.testing.assert_allclose(np.frombuffer(body[at + 8:at + 8 + size], kind), expected, rtol=1e-14)

    def test_queries(self):
        """Answers inside; none outside. The first seed lies outside of the cube."""
        self.put("a.off", OFF)
        points = self.put("points.csv", "x,y,z,v\n-0.25,0.5,0.5,1\n0.75,0.5,0.5,2\n0.75,0.5,1.5,3\n")
        queries = self.put("queries.csv", "0,0.5,0.5\n-0.25,0.5,0.5\n0.9,0.5,0.25\n0.75,0.5,1\n")
        run = [points, "--mesh", "a.off"]
        self.assertEqual(self.run_cli(*run, "--locate", queries, "-o", "-").stdout.split(), ["0", "-1", "1", "1"])
        self.run_cli(*run, "--probe", queries, "-o", "q.npz", "-o", "q.vtu", "--want", "neighbors,volumes", "-q")
        with np.load(self.folder / "q.npz") as cells:
            self.assertAlmostEqual(cells["volumes"][0], 0.375, places=12)
        rays = self.put("rays.csv", "-1,0.5,0.5,1,0,0,9\n")
        traced = self.run_cli(*run, "--trace", rays, "-o", "-").stdout.split()
        self.assertEqual([traced[0], traced[2]], ["0", "1"])
        np.testing.assert_allclose([float(traced[1]), float(traced[3])], [0.25, 0.75], rtol=1e-14)
        self.run_cli(*run, "--box=-1,-1,-1,2,2,2", "--to-grid", "mean", "--shape", "3", "--values", "v", "-o", "g.npy", "-q")
        grid = np.load(self.folder / "g.npy")
        self.assertAlmostEqual(grid[1, 1, 1], 1.75, places=12)
        self.assertAlmostEqual(grid.sum(), 1.75, places=12)

    def test_what_moves_other_vertices_of_a_glb(self):
        """Nodes outside of the scene, without a mesh, or with a mesh of lines, and weights that a node replaces."""
        up = np.array([(x, z, -y) for x, y, z in CORNERS], "f4")
        cube = {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}
        lines = {"primitives": [{"attributes": {"POSITION": 0}, "mode": 1}], "weights": [1]}
        for more in MOVES.values():
            for nodes, first in (([{"mesh": 0}, {"mesh": 0, **more}], cube), ([{"mesh": 0, "children": [1]}, more], cube),
                                 ([{"mesh": 0, "children": [1]}, {"mesh": 1, **more}], cube),
                                 ([{"mesh": 0, "weights": [0]}], {**cube, "weights": [1]})):
                self.put("b.glb", glb(nodes, [], [up, np.array(TRIANGLES, "B").ravel()], meshes=[first, lines], scene=0, scenes=[{"nodes": [0]}]))
                self.assertAlmostEqual(self.json("--random", 9, "--mesh", "b.glb")["volume_sum"], 1, places=12)
        camera = {"camera": 0, "matrix": [*np.eye(4).ravel()[:-2], -1, 0]}  # places nothing
        self.put("b.glb", glb([{"mesh": 0}, camera], [], [up, np.array(TRIANGLES, "B").ravel()], meshes=[cube], scene=0, scenes=[{"nodes": [0, 1]}]))
        self.assertAlmostEqual(self.json("--random", 9, "--mesh", "b.glb")["volume_sum"], 1, places=12)

    def test_refusals(self):
        self.put("a.off", OFF)
        run = ["--random", 9, "--mesh"]
        for more, says in [(["-o", "a.ply"], "whole cells"), (["--image", "a.png", "--slice", "z=9"], "slice at z = 9 is not inside"),
                           (["-o", "a.csv", "--want", "faces"], "faces"),
                           (["--memory", "1G", "-o", "a.h5"], "--mesh"), (["--2d"], "--mesh"), (["--box", "0,0,0,1,1,1"], "strictly inside"),
                           (["--mesh-repair", "holes"], "'holes': give merge"),
                           (["--wall", "1,0,0,1"], "replaces --wall"), (["--outside", "keep"], "outside")]:
            self.refuse(*run, "a.off", *more, says=says)
        self.refuse(*run, "", says="--mesh is empty")
        self.refuse(*run, "none.off", says="'none.off'")
        (self.folder / "zero.stl").symlink_to("/dev/zero")
        self.refuse(*run, "zero.stl", says="'zero.stl' is a device: give a file")
        for name, content, says in [
                ("a.step", "x", ["'a.step'", ".off .obj .stl .ply .glb"]),
                ("b.glb", b"glTF", "not a binary glTF"), ("b.glb", glb_cube()[:-4], "bytes are announced"),
                ("b.glb", glb_cube().replace(b'"asset"', b'"asset\\'), "JSON is damaged"),
                ("b.glb", glb([{"mesh": 0}], [{"attributes": {"POSITION": 0}}], [np.zeros((0, 3), "f4")]), "no triangles"),
                ("b.glb", glb([{"mesh": 3}], [], []), "mesh 3 is named, but there are 1"),
                ("b.glb", glb([{"children": [1]}, {"children": [1]}], [], []), "node 1 has two parents"),
                ("b.glb", glb([{"mesh": 0}], [{"attributes": {"POSITION": 0}, "indices": 1}],
                              [np.zeros((3, 3), "f4"), np.array([0, 1, 3], "H")]), "names vertex 3, but there are 3"),
                ("b.glb", glb([{"mesh": 0}], [{"attributes": {"POSITION": 0}}], [np.zeros((9, 3), "f4")])
                 .replace(b'"count": 9', b'"count":99'), "accessor 0 reaches beyond its bytes"),
                ("b.glb", glb_cube().replace(b'[{"byteLength"', b'[{"uri":"","b"'), ['"uri"', "write .ply"]),
                *(("b.glb", glb([{"mesh": 0, **more}], [{"attributes": {"POSITION": 0}}], [np.zeros((3, 3), "f4")]), f"placed by {says}")
                  for says, more in MOVES.items()),
                ("b.glb", glb([{"mesh": 0, "rotation": [0, 0, 1, 1]}], [], []), "not of length 1"),
                ("b.glb", glb([{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1]}], [], []), ["node 0", "another last row", "glTF forbids"]),
                ("b.glb", glb([{"matrix": [0] * 16, "children": [1]}, {"mesh": 0}], [], [], scene=0, scenes=[{"nodes": [0]}]), ["node 0", "another last row"]),
                *(("b.glb", glb([{"mesh": 0, "matrix": np.eye(4).ravel().tolist(), **more}], [], []), ["node 0 has both", f"'{next(iter(more))}'", "glTF forbids"])
                  for more in ({"translation": [5, 0, 0]}, {"rotation": [0, 0, 0, 1]}, {"scale": [1, 1, 1]})),
                ("b.glb", glb([], [], [], extensionsRequired=["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression"),
                ("b.off", OFF.replace("4 0 4 6 2  255 0 0\n", "").replace("8 6", "8 5"), ["edge between vertices 0 (0, 0, 0) and 2 (0, 1, 0)", "4 edges", "close the hole"]),
                ("b.off", OFF.replace("4 0 4 6 2", "4 2 6 4 0"), "reverse one of them"),
                ("b.off", OFF.replace("4 0 4 6 2", "4 0 4 6 8"), "face 4 names vertex 8, but there are 8"),
                ("b.off", OFF.replace("4 0 4 6 2", "4 0 4 6 -1"), "face 4 names vertex -1: give numbers from 0 on"),
                ("b.off", OFF.replace("4 0 4 6 2", "2 0 4"), "face 4 has 2 corners"),
                ("b.off", OFF.replace("4 0 4 6 2", "9 0 4 6 2"), "b.off:16: a face of 9 corners, but the line lists 7"),
                ("b.off", OFF.replace("8 6 12", "9 6 12"), "after 5 of the 6 faces"),
                ("b.off", OFF.replace("8 6 12", "8 99999999999999 12"), "after 6 of the 99999999999999 faces"),
                ("b.off", OFF.replace("8 6 12", "-8 6 12"), "'-8' is negative"), ("b.off", "4OFF\n", "three dimensions"),
                ("b.off", "OFF BINARY\n", ".ply"), ("b.off", "", "begin with"), ("b.off", "OFF\n", "after its header"),
                ("b.off", OFF.replace("1 1 1\n", "1 1 nan\n"), "vertex 7: z = nan is not finite"),
                ("b.off", OFF.replace("1 1 1\n", "1 1\n"), "b.off:11: a vertex has 2 numbers"),
                ("b.obj", OBJ.replace("f 1/1", "f 0/1"), "face 1 names vertex 0: give numbers from 1 on"),
                ("b.obj", OBJ.replace("f 1/1", "f -9/1"), "vertex -9 is before the first"),
                ("b.obj", OBJ.replace("f 1/1", "f x/1"), "'x' is not a whole number"), ("b.obj", "g\n", "no triangles"),
                ("b.stl", stl_text(TRIANGLES[1:]), "close the hole"), ("b.stl", stl_text().replace("endsolid", "#"), "unknown"), *(("b.stl", text, "the file ends before \"endsolid\"") for text in ("solid a\n", stl_text().split("endsolid")[0], stl_text() + stl_text().split("endsolid")[0] + "\x1a")),
                *(("b.stl", stl_text().split("endsolid")[0][:-n], "b.stl:") for n in (10, 11, 20, 40, 70)), ("b.stl", stl_text().split("endsolid")[0][:-10], "the file ends inside a facet"),
                ("b.stl", stl_text().split("endsolid")[0][:-2], "not 'endface'"), ("b.stl", stl_text() + "\x1ax", "expected: solid"), ("b.stl", stl_binary()[:-1] + b"\x1a\x1a", "has 683"),
                ("b.stl", stl_text().replace("endloop\n", "vertex 1 2 3\nendloop\n", 1), "a facet of 4 corners"),
                ("b.stl", stl_text().replace("1e0", "inf"), "'inf' is not finite"), ("b.stl", "solid\nloop\n", "'loop' is unknown"),
                ("b.stl", stl_text().replace("outer loop", "outer"), "expected: loop, not 'vertex'"),
                ("b.stl", stl_text().replace("endfacet", "endfacets"), "expected: endfacet, not 'endfacets'"),
                ("b.stl", stl_binary()[:-1], ["12 triangles are announced, which take 684 bytes", "has 683"]),
                ("b.stl", stl_binary()[:80] + b"\xff\xff\xff\xff", "4294967295 triangles"), ("b.stl", b"x", "1 bytes"),
                ("b.ply", ply("ascii").replace(b"element face", b"element fac"), "no element face"),
                ("b.ply", ply("ascii").replace(b"vertex_indices", b"indices"), "no list vertex_indices"),
                ("b.ply", ply("ascii").replace(b"face 6", b"face 6666"), "0 of the 6666 elements face"),
                ("b.ply", ply("ascii").replace(b"0.5 4 0", b"0.5 40 0"), "ends within 'vertex_indices'"),
                ("b.ply", ply("ascii").replace(b"-1\n", b"-1 3\n"), "more numbers"),
                ("b.ply", ply("binary_big_endian").replace(b"face 6", b"face 6666666"), "0 of the 6666666 elements face"),
                ("b.ply", ply("binary_big_endian")[:-1], "5 of the 6 elements face")]:
            with self.subTest(name=name, says=says):
                self.refuse(*run, self.put(name, content), says=says)

    def test_files_that_end_early(self):
        """Each cut file is refused in one line, or is still a mesh."""
        for name in ["plain.off", "a.obj", "text.stl", "binary.stl", "little.ply", "ascii.ply", "cube.glb"]:
            content = FILES[name] if isinstance(FILES[name], bytes) else FILES[name].encode()
            for cut in range(0, len(content) - 20, len(content) // 12):
                with self.subTest(name=name, cut=cut):
                    self.refuse("--random", 9, "--mesh", self.put(name, content[:cut]))
