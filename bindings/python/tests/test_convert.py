"""Results as objects of other packages, as DLPack, and as HTML."""

import base64
import importlib
import re
import struct
import sys
import unittest
import xml.etree.ElementTree
import zlib
from unittest import mock

import numpy as np
from helpers import CUBE, UNIT_BOX, cells, have, lattice, uniform

import pyvotess as vt


class Packages(unittest.TestCase):
    @have("pyvista")
    def test_pyvista(self):
        t = cells(100)
        mass = np.arange(102.0)
        grid = t.to_pyvista(columns={"mass": mass})
        self.assertEqual(grid.celltypes.tolist(), [42] * 100 + [0, 0])
        np.testing.assert_array_equal(grid.points, t.vertices)
        for name, values in (("volume", t.volumes), ("centroid", t.centroids), ("mass", mass), ("status", t.status)):
            np.testing.assert_array_equal(grid.cell_data[name], values)
        np.testing.assert_array_equal(grid.cell_data["neighbors"], [(row >= 0).sum() for row in t.neighbors])
        np.testing.assert_allclose(grid.compute_cell_sizes().cell_data["Volume"], t.volumes, atol=1e-4)
        for i in (0, 17):
            faces = [face.point_ids for face in grid.get_cell(i).faces]
            expected = t.faces[t.neighbors.indptr[i] : t.neighbors.indptr[i + 1]]
            self.assertEqual(faces, [face.tolist() for face in expected])
        grid.points[0] = 7  # the grid owns its points
        self.assertEqual(vt.tessellate(np.empty((0, 3)), want="faces,centroids").to_pyvista().n_cells, 0)
        with self.assertRaisesRegex(ValueError, "'faces' into want"):
            vt.tessellate(uniform(5)).to_pyvista()

    @have("pandas")
    def test_dataframe(self):
        t = cells(want="volumes,centroids,counts,surfaces,radii,areas")
        frame = t.to_dataframe()
        self.assertEqual(len(frame), 62)
        self.assertEqual(list(frame.columns), [
            "x", "y", "z", "neighbors", "volume", "centroid_x", "centroid_y", "centroid_z", "surface_area",
            "security_radius", "face_count", "edge_count", "vertex_count", "status", "duplicate_of",
        ])
        self.assertEqual(frame.index.name, "id")
        np.testing.assert_array_equal(frame[["x", "y", "z"]], t.points)
        np.testing.assert_array_equal(frame.volume, t.volumes)
        np.testing.assert_array_equal(frame.neighbors, [len(row) for row in t.neighbors])
        frame.loc[0, "volume"] = 9
        weighted = vt.tessellate(uniform(5), weights=np.full(5, 0.01), want=())
        self.assertEqual(list(weighted.to_dataframe().columns), ["x", "y", "z", "weight", "status"])
        plane = vt.tessellate(uniform(5)[:, :2], want="volumes,surfaces").to_dataframe()
        self.assertEqual(list(plane.columns), ["x", "y", "area", "perimeter", "status"])
        given = dict(want="volumes,centroids", weights=np.linspace(0, 0.01, 62))
        whole = cells(**given).to_dataframe()
        for only in ([61, 3, 7], []):
            self.assertTrue(cells(**given, only=only).to_dataframe().equals(whole.loc[only]), only)

    @have("networkx")
    def test_networkx(self):
        t = cells(list_walls=True)
        graph = t.to_networkx()
        self.assertEqual(list(graph), list(range(62)))
        pairs = t.pairs()
        self.assertEqual(2 * graph.number_of_edges(), len(pairs))
        for k in (0, 20, 100):
            edge = graph[int(pairs.i[k])][int(pairs.j[k])]
            self.assertAlmostEqual(edge["area"], pairs.area[k])
            self.assertAlmostEqual(edge["distance"], pairs.distance[k])
            self.assertEqual(edge["faces"], 1)
        self.assertEqual(graph.nodes[3]["volume"], t.volumes[3])
        self.assertEqual(len(graph[60]), 0)
        self.assertNotIn("area", next(iter(vt.tessellate(uniform(9)).to_networkx().edges(data=True)))[2])
        for apart in (1e-300, 1e-160, 1e-20, 1e200):  # squares of some are no numbers
            two = vt.tessellate([(0, 0, 0), (0.75 * apart, apart, 0)], box=(0, 0, 0) + (max(1, 2 * apart),) * 3).pairs()
            np.testing.assert_allclose(two.distance, 1.25 * apart, rtol=1e-15)
        # Two cells of 1 x 2 x 2 in a periodic cube share two faces, and touch images of themselves in y and z.
        both = vt.tessellate([(0.5, 1, 1), (1.5, 1, 1)], box=(0, 0, 0, 2, 2, 2), periodic=True, want="areas")
        both = both.to_networkx()
        self.assertEqual({(i, j): (e["area"], e["faces"], e["distance"]) for i, j, e in both.edges(data=True)},
                         {(0, 1): (8, 2, 1), (0, 0): (4, 2, 2), (1, 1): (4, 2, 2)})
        self.assertEqual(len(vt.tessellate(np.empty((0, 3))).to_networkx()), 0)

    @have("scipy")
    def test_scipy(self):
        t = cells()
        self.assertEqual((t.to_scipy() != t.neighbors.to_scipy()).nnz, 0)

    @have("freud")
    def test_freud(self):
        import freud

        points = uniform(300) - 0.5
        t = vt.tessellate(points, box=(-0.5,) * 3 + (0.5,) * 3, periodic=True, want="areas,volumes")
        found = t.to_freud()
        pairs = t.pairs()
        np.testing.assert_array_equal(found.query_point_indices, pairs.i)
        np.testing.assert_array_equal(found.point_indices, pairs.j)
        np.testing.assert_allclose(found.weights, pairs.area, rtol=1e-6)
        np.testing.assert_allclose(found.distances, pairs.distance, rtol=1e-6)
        np.testing.assert_allclose(found.vectors, pairs.vector, atol=1e-7)
        # Equal to freud's own, except for faces that its tolerance drops.
        box = freud.box.Box.cube(1)
        theirs = freud.locality.Voronoi().compute((box, points)).nlist
        ours = dict(zip(zip(found.query_point_indices.tolist(), found.point_indices.tolist()), found.weights.tolist()))
        missing = 0
        for i, j, area in zip(theirs.query_point_indices.tolist(), theirs.point_indices.tolist(), theirs.weights):
            self.assertAlmostEqual(ours.get((i, j), 0.0), area, delta=1e-5)
            missing += (i, j) not in ours
        self.assertLess(missing, 5)
        order = freud.order.Steinhardt(6, weighted=True).compute((box, points), neighbors=found)
        self.assertEqual(len(order.particle_order), 300)
        with self.assertRaisesRegex(AttributeError, "'areas' into want"):
            vt.tessellate(points).to_freud()


class Missing(unittest.TestCase):
    def test_packages_are_named(self):
        t = cells(20)
        natural = vt.Diagram(uniform(20)).natural_neighbors([(0.5, 0.5, 0.5)])
        for package, call in [
            ("scipy", t.to_scipy), ("scipy", t.neighbors.to_scipy), ("scipy", lambda: natural.to_scipy(20)),
            ("scipy", t.derivatives), ("pandas", t.to_dataframe), ("networkx", t.to_networkx), ("pyvista", t.to_pyvista),
            ("freud-analysis", t.to_freud), ("networkx", t.network().to_networkx), ("openpnm", t.network().to_openpnm),
            ("gudhi", t.alpha_complex().to_gudhi), ("jax", lambda: importlib.import_module("pyvotess.autodiff.jax")),
            ("torch", lambda: importlib.import_module("pyvotess.autodiff.torch")),
        ]:
            name = package.split("-")[0]
            hidden = {name: None, "scipy.sparse": None}
            with mock.patch.dict(sys.modules, hidden):
                sys.modules.pop(f"pyvotess.autodiff.{name}", None)
                with self.assertRaisesRegex(ImportError, f"needs {name}.*: pip install {package}$"):
                    call()


class Html(unittest.TestCase):
    def picture(self, t):
        root = xml.etree.ElementTree.fromstring(t._repr_html_())
        return root.find("{http://www.w3.org/2000/svg}svg")

    def test_picture(self):
        t = vt.tessellate(lattice(3), box=(0, 0, 0, 3, 3, 3), want="faces,volumes")
        svg = self.picture(t)
        shapes = svg.findall("{http://www.w3.org/2000/svg}polygon")
        self.assertEqual(len(shapes), 9)
        places = np.array([[p.split(",") for p in s.get("points").split()] for s in shapes], float)
        self.assertEqual((places.min(), places.max()), (0, 260))
        for box, axis in (((0, 0, 0, 1, 2, 3), "x"), ((0, 0, 0, 3, 1, 2), "y"), ((0, 0, 0, 1, 1, 1), "z")):
            svg = self.picture(vt.tessellate(uniform(50) * np.reshape(box, (2, 3))[1], box=box, want="faces"))
            self.assertIn(f"at {axis} = ", svg.find("{http://www.w3.org/2000/svg}title").text)
        for options in ({"box": UNIT_BOX, "periodic": True}, {"cell": [(1, 0, 0), (0.3, 1, 0), (0, 0, 1)]}):
            t = vt.tessellate(uniform(20), want="faces", outside="drop", **options)
            self.assertGreater(len(self.picture(t)), 5)

    def test_table(self):
        html = cells(want="neighbors,volumes")._repr_html_()
        for text in ("62", "box (0, 0, 0) to (1, 1, 1)", "mean faces", "volume sum", "empty cells"):
            self.assertIn(text, html)
        self.assertNotIn("<svg", html)

    def test_never_raises(self):
        for points in (np.empty((0, 3)), uniform(1), np.zeros((3, 3)) + 0.5):
            for want in ((), "faces", "faces,volumes", "volumes"):
                xml.etree.ElementTree.fromstring(vt.tessellate(points, box=UNIT_BOX, want=want)._repr_html_())
        t = cells()
        with mock.patch("pyvotess.export.html.sections_in_box", side_effect=RuntimeError):
            self.assertIn("62", t._repr_html_())
        with mock.patch("pyvotess.export.html._rows", side_effect=RuntimeError):
            self.assertIn("Tessellation", t._repr_html_())
        with mock.patch("pyvotess.export.html._MAX_POLYGONS", 3):
            self.assertNotIn("<svg", t._repr_html_())

    def test_other_results(self):
        """Each result has a table with its numbers, and a picture with one shape for each thing."""
        points = uniform(60)
        t = vt.tessellate(points, box=UNIT_BOX, periodic=True, want="faces,volumes")
        fit = vt.fit_volumes(points, np.full(60, 1 / 60), box=UNIT_BOX, want="faces,volumes")
        self.assertIn("residual", fit._repr_html_())
        self.assertGreater(len(self.picture(fit)), 5)
        for n in (t.network(), vt.tessellate(points[:, :2], box=(0, 0, 1, 1), want="faces").network()):
            self.assertIn(f"<td style=\"text-align:left\">{len(n.edges)}</td>", n._repr_html_())
            self.assertEqual(len(self.picture(n).findall("{http://www.w3.org/2000/svg}line")), len(n.edges))
        zones = t.watershed(t.volumes)
        self.assertIn(f"{len(zones)}, of minima", zones._repr_html_())
        self.assertIsNotNone(self.picture(zones))
        self.assertIsNone(self.picture(zones.merge(np.inf)))
        pieces = vt.tessellate([(0.2, 0.5, 0.5), (0.8, 0.5, 0.5)], mesh=CUBE, want="volumes").pieces()
        self.assertIn("volume sum", pieces._repr_html_())
        # Three sides are seen, two of them in two pieces. Triangles inside face each other, and one of the two is seen.
        sides = self.picture(pieces).findall("{http://www.w3.org/2000/svg}polygon")
        self.assertTrue(10 <= len(sides) < len(pieces.triangles))

    def test_diagram(self):
        for points, options, where in (
            (uniform(20), {"box": UNIT_BOX}, "box (0, 0, 0) to (1, 1, 1)"), (uniform(20), {}, "domain without end"),
            (uniform(20)[:, :2], {"box": (0, 0, 1, 1)}, "box (0, 0) to (1, 1)"), (np.empty((0, 3)), {}, "domain without end"),
            (uniform(20), {"mesh": CUBE}, "mesh of 12 triangles"), (uniform(1), {}, "domain without end"),
        ):
            d = vt.Diagram(points, **options)
            self.assertIn(where, repr(d))
            html = d._repr_html_()
            self.assertIn(where, html)
            self.assertEqual("<img" in html, len(points) > 1, where)
        # The colors of the cells of two seeds, left and right.
        d = vt.Diagram([(0.25, 0.5), (0.75, 0.5)], box=(0, 0, 1, 1))
        png = base64.b64decode(re.search("base64,([^\"]+)", d._repr_html_())[1])
        size = struct.unpack(">II", png[16:24])
        data = b"".join(png[k + 8 : k + 8 + struct.unpack(">I", png[k : k + 4])[0]] for k in [png.index(b"IDAT") - 4])
        rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(size[1], -1)[:, 1:].reshape(size[1], size[0], 4)
        self.assertEqual(size, (130, 130))
        self.assertTrue((rows[:, :65] == rows[0, 0]).all() and (rows[:, 65:] == rows[0, -1]).all())
        self.assertFalse((rows[0, 0] == rows[0, -1]).all())


if __name__ == "__main__":
    unittest.main()
