"""Meshes as .vtu, .ply and .obj, read back by VTK, .glb, and those for solvers; .tess is read."""

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

    def check_grid(self, name, volumes, box_volume, first_id=0, every=1):
        """Asserts watertight, oriented cells of these volumes, by `id`, which fill the box. every: looks at some cells."""
        grid = self.grid(name)
        volumes = np.asarray(volumes)
        self.assertEqual(grid.GetNumberOfCells(), np.count_nonzero(volumes))
        ids = vtk_to_numpy(grid.GetCellData().GetArray("id")) - first_id
        self.assertEqual(sorted(ids), np.flatnonzero(volumes).tolist())
        volumes = volumes[ids]
        sizes = [grid.GetCell(cell).GetNumberOfPoints() for cell in range(grid.GetNumberOfCells())]
        self.assertEqual(sizes, sorted(sizes))
        vertices = vtk_to_numpy(grid.GetPoints().GetData())
        for cell in range(0, grid.GetNumberOfCells(), every):
            self.assertEqual(grid.GetCellType(cell), 42)
            faces = self.polygons(grid, cell)
            edges = [edge for face in faces for edge in zip(face, face[1:] + face[:1])]
            self.assertEqual(len(set(edges)), len(edges))
            self.assertEqual({(b, a) for a, b in edges}, set(edges))  # each edge once in each direction
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
        self.assertAlmostEqual(volumes.sum(), box_volume, delta=1e-11 * box_volume)
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
        # A file of several pieces of 1 MiB. Cells lie in the order of their size, so every eighth has all sizes.
        self.run_cli("--random", 2000 if SANITIZED else 10000, "-o", "a.vtu", "-o", "a.npz", "--want", "vertices,volumes")
        with np.load(self.folder / "a.npz") as arrays:
            grid = self.check_grid("a.vtu", arrays["volumes"], 1, every=8)
            np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), arrays["vertices"])

    def test_faces(self):
        self.run_cli("--random", 500, "-o", "a.ply", "-o", "a.obj", "-o", "a.npz", "--want", "faces,neighbors")
        with np.load(self.folder / "a.npz") as arrays:
            arrays = dict(arrays)
        rows = np.repeat(np.arange(500), np.diff(arrays["indptr"]))
        once = np.flatnonzero((arrays["indices"] < 0) | (rows < arrays["indices"]))
        offsets = arrays["face_offsets"]
        all_polygons = [arrays["face_vertices"][offsets[k]:offsets[k + 1]].tolist() for k in range(len(rows))]
        polygons = [all_polygons[k] for k in once]
        for name, reader in [("a.ply", vtkPLYReader()), ("a.obj", vtkOBJReader())]:
            reader.SetFileName(str(self.folder / name))
            reader.Update()
            mesh = reader.GetOutput()
            # VTK stores float32 here.
            np.testing.assert_allclose(vtk_to_numpy(mesh.GetPoints().GetData()), arrays["vertices"], rtol=0, atol=1e-6)
            expected = sorted(polygons, key=len) if name == "a.ply" else all_polygons
            self.assertEqual(mesh.GetNumberOfPolys(), len(expected))
            ids = vtkIdList()
            for k, polygon in enumerate(expected):
                mesh.GetCellPoints(k, ids)
                self.assertEqual([ids.GetId(j) for j in range(ids.GetNumberOfIds())], polygon)


class GltfFiles(ReaderTest):
    """Size and colors of .glb. The Python tests cover the writer of the library."""

    def vertices(self, name):
        """Returns color and cell of each vertex of a .glb file, (V, 4) uint8 and (V,) int."""
        content = (self.folder / name).read_bytes()
        size = struct.unpack_from("<I", content, 12)[0]
        head = json.loads(content[20:20 + size])

        def array(kind, number):
            view = head["bufferViews"][head["accessors"][number]["bufferView"]]
            return np.frombuffer(content, kind, view["byteLength"] // np.dtype(kind).itemsize, 28 + size + view["byteOffset"])

        parts = [primitive["attributes"] for primitive in head["meshes"][0]["primitives"]]
        colors = np.concatenate([array("u1", part["COLOR_0"]) for part in parts])
        return colors.reshape(-1, 4), np.concatenate([array("<f4", part["_CELL"]) for part in parts]).astype(int)

    def test_size_is_reported(self):
        done = self.run_cli("--random", 3000, "-o", "a.glb")
        size = (self.folder / "a.glb").stat().st_size
        self.assertEqual(done.stderr, f"'a.glb' takes {-(-size // 10**6)} MB\n")
        self.assertLess(size, 900 * 3000 + 2000)

    def test_colors(self):
        points = random_points(50)
        mass = np.arange(50.0)
        np.savez(self.folder / "p.npz", points=points, mass=mass)
        self.run_cli("p.npz", "--copy", "mass", "--color", "mass", "--colormap", "gray", "-o", "a.glb")
        colors, cells = self.vertices("a.glb")
        self.assertTrue((colors[:, :3] == colors[:, :1]).all() and (colors[:, 3] == 255).all())
        of_cell = np.empty(50)
        of_cell[cells] = colors[:, 0]
        np.testing.assert_array_equal(of_cell[cells], colors[:, 0])
        self.assertTrue((np.diff(of_cell) >= 0).all())  # like the mass; a byte has few dark colors
        self.assertGreater(len(np.unique(of_cell)), 35)
        for column in ["volume", "neighbors", "area", "x", "index"]:
            self.run_cli("p.npz", "--color", column, "-o", "a.glb")
            self.assertGreater(len(np.unique(self.vertices("a.glb")[0], axis=0)), 5)
        self.refuse("p.npz", "--color", "mass", "-o", "b.glb", says=["'mass'", "--copy"])
        self.refuse("p.npz", "--copy", "mass", "-o", "b.obj", says=["--copy", ".glb"])

    def test_no_points(self):
        self.put("none.txt", "")
        self.run_cli("none.txt", "-o", "a.glb")


# The form of Neper, by hand: two grains in a box, with sections that hold nothing for us.
TESS = """***tess
 **format
   3.4
 **general
   3 standard
 **cell
  2
  *id
   7 3
  *crysym
   triclinic
  *seed
   1 0.250000000000 0.500000000000 0.500000000000 {}
   2 0.750000000000 0.500000000000 0.500000000000 {}
  *ori
   rodrigues:active
  -3.297869980066    0.247604034009    0.291831395332
  -1.245462346374   -0.011088000049    0.876068657775
 **vertex
 1
   1  1.000000000000 1.000000000000 0.000000000000     0
 **domain
  *general
   {}
  *vertex
   4
   1  0.000000000000 0.000000000000 0.000000000000 x0y0z0
      1 21
   2  1.000000000000 0.000000000000 0.000000000000 x1y0z0
      1 13
   3  0.000000000000 2.000000000000 0.000000000000 x0y1z0
      1 1
   4  0.000000000000 0.000000000000 1.000000000000 x0y0z1
      1 17
  *edge
   1
   1 2 4 6
     x0y1
     2 27 42
  *face
   {}
***end
"""
CUBE_FACES = """1
   1 4 4 6 5 1
     4 1 2 3 4
     plane
     4 0.000000000000 1.000000000000 0.000000000000 0.000000000000
     x0
     3 14 19 24"""
# The tetrahedron of these corners; normals lead inward, of length 1.
TETRAHEDRON_FACES = "4\n" + "".join(
    f"   {k + 1} 3 1 2 3\n     3 1 2 3\n     plane\n     4 {plane}\n     f{k + 1}\n     0\n"
    for k, plane in enumerate(["0 1 0 0", "0 0 1 0", "0 0 0 1", "-0.666666666667 -0.666666666667 -0.333333333333 -0.666666666667"]))


class GeojsonFiles(ReaderTest):
    """The Python tests cover the rings of pieces."""

    CITY = {"type": "Polygon", "coordinates": [[[0, 0], [0, 3], [2, 1], [4, 3], [4, 0], [0, 0]],  # clockwise
                                               [[1, 0.5], [2, 0.5], [1.5, 1], [1, 0.5]]]}

    def volumes(self, geometry, *options):
        self.put("city.geojson", json.dumps(geometry))
        self.run_cli("--random", "100", "--mesh", "city.geojson", "-q", *options, "-o", "a.npz")
        with np.load(self.folder / "a.npz") as arrays:
            return arrays["volumes"]

    def test_polygons(self):
        volumes = self.volumes(self.CITY, "-o", "cells.geojson")
        self.assertAlmostEqual(volumes.sum(), 7.75, delta=1e-12)
        self.assertTrue((volumes > 0).all())  # points lie inside
        cells = json.loads((self.folder / "cells.geojson").read_text())
        self.assertEqual([feature["id"] for feature in cells["features"]], list(range(100)))
        # The pieces tile the polygon: they are a domain again.
        self.assertAlmostEqual(self.volumes(cells).sum(), 7.75, delta=1e-11)
        other = {"type": "FeatureCollection", "features": [
            {"type": "Feature", "geometry": None, "properties": {}},
            {"type": "Feature", "properties": None, "geometry": {"type": "GeometryCollection", "geometries": [self.CITY]}},
            {"type": "Feature", "geometry": {"type": "MultiPolygon", "coordinates": [[[[5, 0, 9], [6, 0, 9], [6, 1, 9]]]]}}]}
        self.assertAlmostEqual(self.volumes(other).sum(), 8.25, delta=1e-12)
        self.put("marked.json", "\ufeff" + json.dumps(self.CITY))
        self.assertEqual(self.json("--random", 9, "--mesh", "marked.json")["box_volume"], 7.75)

    def test_sequences(self):  # of features, as GDAL writes them: a line each, or after a record separator
        whole = self.volumes(self.CITY)
        cells = [{"type": "Feature", "properties": {"a": 1}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
                 for ring in ([[0, 0], [4, 0], [4, 1], [0, 1]], [[0, 1], [4, 1], [4, 2], [0, 2]], [[5, 5], [6, 5], [6, 6]])]
        lines = [json.dumps(cell) for cell in cells]
        spread = [json.dumps(cell, indent=1) for cell in cells]
        for name, text in (("a.geojsonl", "\n".join(lines)), ("b.geojsonl", "\ufeff" + "\r\n\r\n".join(lines) + "\r\n"),
                           ("a.geojsons", "".join(f"\x1e{line}\n" for line in lines)),
                           ("a.geojsonseq", "".join(f"\x1e{text}\n" for text in spread)), ("c.geojsonl", lines[0] + "\n" + spread[1])):
            self.put(name, text)
            if name == "c.geojsonl":
                self.refuse("--random", 9, "--mesh", name, says="c.geojsonl:2: ")
            else:
                self.assertEqual(self.json("--random", 9, "--mesh", name)["box_volume"], 8.5)
        self.put("city.geojsonl", json.dumps(self.CITY))
        self.run_cli("--random", "100", "--mesh", "city.geojsonl", "-q", "-o", "b.npz")
        with np.load(self.folder / "b.npz") as arrays:
            np.testing.assert_array_equal(arrays["volumes"], whole)
        self.put("a.geojsons", f"\x1e{spread[0]}\n\x1e" + '{"type": "Point", "coordinates": [0, 0]}')
        self.refuse("--random", 9, "--mesh", "a.geojsons", says=f"a.geojsons:{spread[0].count(chr(10)) + 2}: a geometry has the type")
        short = json.dumps({"type": "Polygon", "coordinates": [[[0, 0], [1, 1]]]})
        self.put("a.geojsonl", "\n".join([lines[0], lines[1], short]))
        self.refuse("--random", 9, "--mesh", "a.geojsonl", says="a.geojsonl:3: ring 0 has 2 places")
        self.put("a.geojsonl", "\n\n")
        self.refuse("--random", 9, "--mesh", "a.geojsonl", says="a.geojsonl: no polygon found")

    def test_refusals(self):
        self.put("a.geojson", json.dumps(self.CITY))
        random = ["--random", "50", "--mesh", "a.geojson"]
        self.refuse(*random, "-o", "a.obj", says="needs three dimensions, but --mesh a.geojson means two")
        self.refuse(*random, "-o", "a.vtu", says="holds no polygons with holes: write pieces as .geojson")
        self.run_cli(*random, "--image", "a.png", "--image-size", "200x150", "--seeds", "-q")
        self.assertTrue((self.folder / "a.png").read_bytes().startswith(b"\x89PNG"))
        self.refuse("--random", "50", "--2d", "-o", "b.geojson", says="add --mesh FILE")
        self.put("cube.off", "OFF\n0 0 0\n")
        self.refuse("--random", "50", "--mesh", "cube.off", "-o", "b.geojson", says="holds polygons: add --mesh FILE.geojson")
        self.refuse("--random", "50", "--2d", "--mesh", "cube.off", says="--mesh cube.off needs three dimensions")
        for options in ([], ["--2d"]):
            self.refuse("--random", "50", "--mesh", "a.vtu", *options, says=": known are .off .obj .stl .ply .glb, and "
                                                                           "for --2d .geojson .json .geojsonl .geojsons .geojsonseq: convert")
        for text, message in (("[1", "a.geojson"), ("{}", "the type none"),
                              ('{"type": "Point", "coordinates": [0, 0]}', 'the type "Point": give polygons'),
                              ('{"type": "Polygon"}', 'no "coordinates"'), ('{"type": "FeatureCollection"}', 'no "features"'),
                              ('{"type": "Polygon", "coordinates": [[[0, 0], [1, 1]]]}', "a.geojson: ring 0 has 2 places"),
                              # The place of a ring counts inside of its polygon, feature and text.
                              (json.dumps({"type": "FeatureCollection", "features": [
                                  {"type": "Feature", "geometry": self.CITY}, {"type": "Feature", "geometry": {
                                      "type": "MultiPolygon", "coordinates": [self.CITY["coordinates"], [[[0, 0]]]]}}]}),
                               "a.geojson: feature 1, polygon 1, ring 0 has 1 place: give"),
                              (json.dumps({"type": "GeometryCollection", "geometries": [self.CITY, {
                                  "type": "Polygon", "coordinates": [self.CITY["coordinates"][0], [[0, 0], ["x", 1]]]}]}),
                               'geometry 1, ring 1: place 1 is ["x", 1], not two numbers'),
                              ('{"type": "Polygon", "coordinates": [[[0, 0], [1, "x"], [1, 1]]]}', "place 1 is"),
                              ('{"type": "GeometryCollection", "geometries": []}', "no polygon found")):
            self.put("a.geojson", text)
            self.refuse(*random, says=message)


class SolverFiles(ReaderTest):
    def test_tess_of_neper(self):
        self.put("a.tess", TESS.format("0.300000000000", "0.100000000000", "cube", CUBE_FACES))
        rows = self.rows("a.tess", "--radii", "radius", "--format", "%i %q %v %r")
        values = [[float(x) for x in row.split()] for row in rows]
        at = 0.5 + (0.3**2 - 0.1**2) / 2 / 0.5
        np.testing.assert_allclose(values, [[7, 0.25, 0.5, 0.5, 2 * at, 0.3], [3, 0.75, 0.5, 0.5, 2 - 2 * at, 0.1]], rtol=1e-12)
        done = self.run_cli("a.tess", "--json")
        self.assertEqual(json.loads(done.stdout)["domain"]["from"], "stated")
        self.put("b.tess", TESS.format(0, 0, "poly", TETRAHEDRON_FACES))
        volumes = [float(row) for row in self.rows("b.tess", "--outside", "keep", "--format", "%v")]
        self.assertAlmostEqual(sum(volumes), 2 / 6, places=9)
        self.assertAlmostEqual(volumes[1], 2 * 0.5**3 / 6, places=9)
        self.assertNotIn("regularized", self.run_cli("a.tess").stdout)
        self.put("r.tess", TESS.format(0, 0, "cube", CUBE_FACES).replace("0.000000000000     0\n", "0.000000000000     2\n"))
        self.assertIn("regularized polyhedra, made again without", self.run_cli("r.tess").stdout)
        per = " **periodicity\n  *general\n   1 1 0\n   1.0 2.0 1.0\n***end"
        self.put("c.tess", TESS.format(0, 0, "cube", CUBE_FACES).replace("***end", per))
        self.assertEqual(json.loads(self.run_cli("c.tess", "--json").stdout)["domain"]["periodic"], [True, True, False])
        # The messages name options that were given, or those to give.
        self.put("d.tess", TESS.format(0, 0, "poly", TETRAHEDRON_FACES).replace("***end", per))
        self.refuse("d.tess", says="the file states a domain that repeats and is not a box: add --periodic none, or give --box")
        self.refuse("d.tess", "--periodic", "x", says="--periodic needs a box, and the file's domain is a polyhedron: give --box")
        self.assertEqual(len(self.rows("d.tess", "--periodic", "none", "--outside", "keep")), 2)
        self.run_cli("d.tess", "--box", "0,0,0,1,2,1", "--periodic", "xy", "-q")
        wall = ["--wall", "1,0,0,0.6", "--outside", "keep"]
        self.refuse("c.tess", *wall, says="the file states periodic axes, which walls exclude: add --periodic none")
        self.refuse("c.tess", *wall, "--periodic", "x", says="--wall and --periodic are both given")
        self.assertEqual(len(self.rows("c.tess", *wall, "--periodic", "none")), 2)
        self.put("e.xyz", '1\nLattice="2 0 0 1 2 0 0 0 2"\nX 1 1 1\n')
        self.refuse("e.xyz", *wall, says="the file states a cell, and walls need a box: give --box")

    def test_tess_of_other_polyhedra(self):
        self.run_cli("--random", "20", "-q", "-o", "a.tess")
        self.assertEqual(len(self.rows("a.tess")), 20)
        lines = (self.folder / "a.tess").read_text().splitlines()
        at = next(i for i, line in enumerate(lines) if line.split() == ["*seed"]) + 1
        seeds = [line.split(maxsplit=1) for line in lines[at : at + 20]]
        for k in range(20):  # each cell gets the seed of the next one
            lines[at + k] = f"{seeds[k][0]} {seeds[(k + 1) % 20][1]}"
        self.put("b.tess", "\n".join(lines) + "\n")
        self.refuse("b.tess", says="its polyhedra are not the power cells of its seeds")
        self.put("far.csv", "x,y,z\n" + "".join(f"{5e6 + x},{5e6 + y},{5e6 + z}\n" for x, y, z in random_points(60).tolist()))
        self.run_cli("far.csv", "--box", "5e6,5e6,5e6,5000001,5000001,5000001", "-q", "-o", "far.tess")
        self.assertEqual(len(self.rows("far.tess", "--outside", "keep")), 60)

    def test_tess_in_and_out(self):
        self.put("a.csv", "x,y,z,r\n" + "".join(f"{x},{y},{z},{0.3 * x}\n" for x, y, z in random_points(60).tolist()))
        for box in [["--box", "0,0,0,1,1,1"], ["--cell", "1,0,0,0.2,1,0,0.3,0.1,1", "--periodic", "none", "--outside", "drop"],
                    ["--box", "0,0,0,1,1,1", "--wall-sphere", "0.5,0.5,0.5,0.55,12", "--outside", "drop"]]:
            self.run_cli("a.csv", *box, "--radii", "r", "-q", "-o", "b.tess", "-o", "a.npz", "--want", "volumes,neighbors")
            self.run_cli("b.tess", "--radii", "radius", "--outside", "keep", "-q", "-o", "c.tess", "-o", "b.npz", "--want", "volumes,neighbors,faces")
            a, b = np.load(self.folder / "a.npz"), np.load(self.folder / "b.npz")
            held = np.flatnonzero(a["volumes"])
            np.testing.assert_allclose(b["volumes"], a["volumes"][held], rtol=1e-9)
            counts = [[(row >= 0).sum() for row in np.split(m["indices"], m["indptr"][1:-1])] for m in (a, b)]
            np.testing.assert_array_equal(counts[1], np.array(counts[0])[held])
            polyhedra = [(self.folder / name).read_text().split("**polyhedron")[1].split("**domain")[0].split()[0] for name in ("b.tess", "c.tess")]
            self.assertEqual(polyhedra, [str(len(held))] * 2)

    def test_bad_tess(self):
        whole = TESS.format(0, 0, "cube", CUBE_FACES)
        for content, says in [
                ("x", "begins with ***tess"),
                (whole.replace("***end", " **scale\n  *general\n   2\n***end"), "grains are cut into others"),
                (whole.replace("3 standard", "2 standard"), "a tessellation in 2 dimensions"),
                (whole.replace("*seed", "*group"), "without seeds (*seed)"),
                (whole.replace("**cell\n  2", "**cell\n  99999999999"), "99999999999 is not a number of cells"),
                (whole.replace("     plane", "     cylinder"), "a face that is a cylinder"),
                (whole.replace("0.250000000000", "nan"), "is not finite"),
                (whole[:whole.index("0.75")], "ends where a coordinate is expected"),
                (whole.replace("1.000000000000 0.000000000000 0.000000000000 x1", "0 0 0 x1"), "the domain has no volume")]:
            self.refuse(self.put("bad.tess", content), says=says)
        self.put("a.tess", whole)
        self.refuse("a.tess", "--radii", "r", says="a .tess file has the column 'radius', not 'r'")
        self.refuse("a.tess", "--columns", "x,y,z", says="--columns goes with")

    def test_files_for_solvers(self):
        (self.folder / "run").mkdir()
        done = self.run_cli("--random", "200", "--box", "0,0,0,1,1,1", "-o", "run/case.foam", "-o", "a.msh", "-o", "a.tess", "-o", "a.cgns")
        self.assertTrue((self.folder / "a.cgns").read_bytes().startswith(b"\x89HDF\r\n\x1a\n"))
        self.assertIn("has non-orthogonality up to", done.stderr)
        mesh = self.folder / "run/constant/polyMesh"
        self.assertEqual(sorted(path.name for path in mesh.iterdir()), ["boundary", "faces", "neighbour", "owner", "points"])
        self.assertEqual((self.folder / "run/case.foam").read_bytes(), b"")
        self.assertIn("nCells:200 ", (mesh / "owner").read_text())
        self.assertEqual((self.folder / "a.msh").read_text().count('"cell '), 200)
        self.run_cli("--random", "200", "--box", "0,0,0,1,1,1", "-q", "-o", "a.stl")
        self.assertEqual((self.folder / "a.stl").read_text().count("endsolid"), 200)
        before = (mesh / "points").read_bytes()
        lines = [(mesh / "points").read_text().count("\n")]
        self.run_cli("--random", "200", "--box", "0,0,0,1,1,1", "-q", "-o", "run/case.foam", "--min-edge", "0.03")
        self.assertLess((mesh / "points").read_text().count("\n"), 0.9 * lines[0])
        self.run_cli("--random", "200", "--rng-seed", "2", "--box", "0,0,0,1,1,1", "-q", "-o", "run/case.foam")
        self.assertNotEqual((mesh / "points").read_bytes(), before)

    def test_pieces_for_solvers(self):
        self.put("tetra.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
        done = self.run_cli("--random", "30", "--mesh", "tetra.off", "-o", "case.foam", "-o", "a.msh")
        self.assertIn("has non-orthogonality up to", done.stderr)
        mesh = self.folder / "constant/polyMesh"
        self.assertIn("nCells:30 ", (mesh / "owner").read_text())
        self.assertIn("    surface\n    {\n        type patch;", (mesh / "boundary").read_text())
        before = (mesh / "points").read_text().count("\n")
        self.run_cli("--random", "30", "--mesh", "tetra.off", "-q", "-o", "case.foam", "--min-edge", "0.05")
        self.assertLess((mesh / "points").read_text().count("\n"), 0.95 * before)
        self.assertEqual((self.folder / "a.msh").read_text().count('"cell '), 30)
        self.refuse("--random", "30", "--mesh", "tetra.off", "--gap", "0.1", "-o", "b.foam", says="--gap parts the pieces")
        self.refuse("--random", "30", "--mesh", "tetra.off", "--min-edge", "0.1", "-o", "b.stl", says="add -o FILE in .foam, .msh or .cgns")
        self.refuse("--random", "30", "--mesh", "tetra.off", "-o", "b.tess", says="polygons of whole cells")

    def test_refusals(self):
        box = ["--random", "50", "--box", "0,0,0,1,1,1"]
        self.refuse(*box, "--min-face", "0.1", "-o", "a.foam", says=["is not closed", "leave out --min-face and --min-area"])
        self.refuse(*box, "--periodic", "-o", "a.tess", says="no periodic boundary")
        self.refuse(*box, "--min-edge", "0.1", "-o", "a.vtu", says="--min-edge is for meshes of solvers")
        self.refuse(*box, "--min-edge", "-1", "-o", "a.msh", says="--min-edge is negative")
        self.refuse(*box, "-o", "a.foam", "-o", "b.foam", says="is named twice")
        self.refuse("--random", "50", "--2d", "-o", "a.msh", says="dimensions")
        self.refuse("--random", "50", "--box", "none", "-o", "a.tess", says="in a domain without end")
        self.put("a.xyz", "2\n\nH 0 0 0\nH 1 1 1\n" * 2)
        self.refuse("a.xyz", "--frames", "all", "-o", "a-{frame}.foam", says="whose folder holds one mesh")
