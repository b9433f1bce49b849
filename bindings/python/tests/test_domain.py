"""Domains: periodic and triclinic boxes, walls, weights."""

import copy
import inspect
import pickle
import re
import tempfile
import types
import unittest

import numpy as np
from helpers import CELL, CUBE
from helpers import uniform as points

import pyvotess as vt

UNIT = (0, 0, 0, 1, 1, 1)


class Tensor:
    """An array of Open3D."""

    def __init__(self, array):
        self.numpy = lambda: array

    def cpu(self):
        return self


class MixedFaces:
    """A mesh of PyVista with polygons of several sizes."""

    points, is_all_triangles = np.zeros((4, 3)), False

    @property
    def regular_faces(self):
        raise ValueError("Mesh does not have regular faces")


class Scene:
    """A scene of trimesh."""

    geometry, graph = {}, None

    def __init__(self, vertices, triangles):
        self.to_mesh = lambda: types.SimpleNamespace(vertices=vertices, faces=triangles)


class Domains(unittest.TestCase):
    def test_periodic_axes_by_word_and_by_flags(self):
        a = vt.tessellate(points(200), box=UNIT, periodic="xz", list_walls=True, device="cpu")
        b = vt.tessellate(points(200), box=UNIT, periodic=(True, False, True), list_walls=True, device="cpu")
        np.testing.assert_array_equal(a.neighbors.indices, b.neighbors.indices)
        np.testing.assert_array_equal(a.shifts, b.shifts)
        self.assertEqual(set(a.neighbors.indices[a.neighbors.indices < 0]), {-3, -4})
        self.assertTrue(a.verify())

    def test_the_result_tells_its_domain(self):
        cell = [(1, 0, 0), (0.4, 1, 0), (-0.3, 0.2, 1)]
        t = vt.tessellate(points(10), cell=cell, origin=(1, 2, 3), device="cpu")
        np.testing.assert_array_equal(t.cell, cell)
        np.testing.assert_array_equal(t.origin, (1, 2, 3))
        np.testing.assert_allclose(t.box, [(0.7, 2, 3), (2.4, 3.2, 4)])
        self.assertEqual(t.periodic, (True, True, True))
        self.assertEqual(t.walls.shape, (0, 4))
        self.assertIsNone(t.weights)
        t = vt.tessellate(points(10), box=UNIT, periodic="xz", radii=np.arange(10) / 100, device="cpu")
        self.assertEqual(t.periodic, (True, False, True))
        self.assertIsNone(t.cell)
        self.assertIsNone(t.origin)
        np.testing.assert_array_equal(t.weights, (np.arange(10) / 100) ** 2)
        for array in (t.weights, t.walls, t.box):
            self.assertFalse(array.flags.writeable)

    def test_a_cell_repeats_along_the_edges_that_are_named(self):
        for periodic in (None, True, "xyz", (True, True, True)):
            self.assertEqual(vt.tessellate(points(9), cell=np.eye(3), periodic=periodic).periodic, (True,) * 3)
        for periodic in ("x", "yz", (True, False, False), False, ""):
            t = vt.tessellate(points(9), cell=np.eye(3), periodic=periodic, list_walls=True)
            flags = tuple(axis in periodic for axis in "xyz") if isinstance(periodic, str) else periodic or (False,) * 3
            self.assertEqual(t.periodic, flags)
            walls = {-1 - 2 * k - side for k in range(3) if not flags[k] for side in (0, 1)}
            self.assertEqual(set(t.neighbors.indices[t.neighbors.indices < 0].tolist()), walls)
            self.assertTrue(t.verify())

    def test_repr_tells_the_domain(self):
        p = points(20)
        self.assertIn("in a box (0, 0, 0) to (1, 1, 1), periodic xz:", repr(vt.tessellate(p, box=UNIT, periodic="xz")))
        self.assertRegex(repr(vt.tessellate(p)), r"in a box \(.*\) to \(.*\) around them:")
        self.assertIn("in a cell (1, 0, 0), (0, 1, 0), (0, 0, 1) at (0, 0, 0), periodic ab:",
                      repr(vt.tessellate(p, cell=np.eye(3), periodic="xy")))
        self.assertIn("cut by 1 wall:", repr(vt.tessellate(p, box=UNIT, walls=[(1, 1, 1, 3)])))

    def test_wrapped_points_of_some_cells(self):
        for size in (2, 3):
            p = 3 * points(30)[:, :size] - 1
            box = ((0,) * size, (1,) * size)
            whole = vt.tessellate(p, box=box, periodic=True)
            for only in ([], [3], [7, 2]):
                t = vt.tessellate(p, box=box, periodic=True, only=only)
                np.testing.assert_array_equal(t.wrapped_points, whole.wrapped_points)
                np.testing.assert_array_equal(pickle.loads(pickle.dumps(t)).wrapped_points, whole.wrapped_points)

    def test_shifts_without_entries(self):
        """They are an empty array in a periodic domain, whatever the reason that no cell has a neighbor."""
        for size in (2, 3):
            box, p = ((0,) * size, (1,) * size), points(2)[:, :size]
            hidden = dict(weights=[1, -9], only=[1])
            for q, given in ((p, hidden), (p, dict(only=[])), (np.empty((0, size)), {})):
                t = vt.tessellate(q, box=box, periodic=True, **given)
                self.assertEqual((t.shifts.shape, t.shifts.dtype), ((0, size), np.int8))
                self.assertIsNone(vt.tessellate(q, box=box, **given).shifts)
                self.assertIsNone(vt.tessellate(q, box=box, periodic=True, want="volumes", **given).shifts)

    def test_wrapped_points_and_pairs(self):
        edges = np.array([(2.0, 0, 0), (0.8, 1.5, 0), (-0.5, 0.3, 1)])
        inside = points(60) @ edges + (1, 2, 3)
        moves = np.random.default_rng(5).integers(-3, 4, (60, 3))
        for periodic in ("xyz", "xz", "y", ""):
            moved = inside + moves * [axis in periodic for axis in "xyz"] @ edges
            t = vt.tessellate(moved, cell=edges, origin=(1, 2, 3), periodic=periodic, want="areas", list_walls=True)
            np.testing.assert_allclose(t.wrapped_points, inside, rtol=0, atol=1e-14)
            pairs = t.pairs()
            self.assertEqual(len(pairs), np.count_nonzero(t.neighbors.indices >= 0))
            np.testing.assert_array_equal(pairs.area, t.areas[t.neighbors.indices >= 0])
            np.testing.assert_allclose(pairs.distance, np.linalg.norm(pairs.vector, axis=1), rtol=1e-15)
            # The image of the other seed, whole edges away along periodic edges.
            steps = (moved[pairs.i] + pairs.vector - moved[pairs.j]) @ np.linalg.inv(edges)
            np.testing.assert_allclose(steps, np.round(steps), rtol=0, atol=1e-13)
            self.assertFalse(np.any(np.round(steps)[:, [axis not in periodic for axis in "xyz"]]))
            if periodic:
                np.testing.assert_allclose(inside[pairs.j] + pairs.shift @ edges - inside[pairs.i], pairs.vector,
                                           rtol=0, atol=1e-13)
            else:
                self.assertIsNone(pairs.shift)

    def test_round_walls(self):
        for rows, count in ((vt.walls.sphere((5, 6, 7), 1), 300), (vt.walls.cylinder((5, 6, 7), (0, 0, 1), 1, 20), 20),
                            (vt.walls.cone((5, 6, 5), (0, 0, 1), 0.5, 25), 25)):
            self.assertEqual(rows.shape, (count, 4))
        with self.assertRaisesRegex(ValueError, "3 faces"):
            vt.walls.sphere((0, 0, 0), 1, 3)
        with self.assertRaisesRegex(ValueError, "center has shape"):
            vt.walls.sphere((0, 0), 1)

    def test_voronoi_indices(self):
        n = 4
        grid = np.array([(i, j, k) for i in range(n) for j in range(n) for k in range(n)], dtype=float)
        box = (0, 0, 0, n, n, n)
        self.assertEqual(np.unique(vt.tessellate(grid, box=box, periodic=True, want="faces").voronoi_indices(),
                                   axis=0).tolist(), [[0, 6]])
        bcc = vt.tessellate(np.concatenate((grid, grid + 0.5)), box=box, periodic=True, want="faces")
        self.assertEqual(np.unique(bcc.voronoi_indices(), axis=0).tolist(), [[0, 6, 0, 8]])
        t = vt.tessellate(points(100), box=UNIT, want="faces", min_area=1e-3)
        self.assertEqual(t.least_face, 1e-3)
        for threshold in (0, 0.02, 0.1):
            table = t.voronoi_indices(threshold)
            for i in range(len(t)):
                edges = []
                for face in t.faces[t.neighbors.indptr[i] : t.neighbors.indptr[i + 1]]:
                    corners = t.vertices[face]
                    lengths = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
                    edges.append(np.count_nonzero(lengths >= threshold))
                self.assertEqual(table[i].tolist(), [edges.count(k + 3) for k in range(table.shape[1])])

    def test_some_cells(self):
        p = points(500)
        all_cells = vt.tessellate(p, box=UNIT, periodic=True, device="cpu", want="neighbors,volumes,centroids")
        ids = np.array([400, 3, 77])
        mask = np.zeros(500, bool)
        mask[ids] = True
        for only, order in ((ids, ids), (ids.astype(np.int32), ids), (mask, np.sort(ids))):
            some = vt.tessellate(p, box=UNIT, periodic=True, want="neighbors,volumes,centroids", only=only)
            self.assertEqual(some.ids.tolist(), order.tolist())
            np.testing.assert_array_equal(some.volumes, all_cells.volumes[order])
            np.testing.assert_array_equal(some.centroids, all_cells.centroids[order])
            for k, i in enumerate(order):
                self.assertEqual(some.neighbors[k].tolist(), all_cells.neighbors[i].tolist())
            self.assertTrue(some.verify())
            for refused in (some.pairs, some.to_scipy):
                with self.assertRaisesRegex(ValueError, "some"):
                    refused()
            self.assertEqual(pickle.loads(pickle.dumps(some)).ids.tolist(), order.tolist())
        none = vt.tessellate(p, only=[])
        self.assertEqual((len(none), none.ids.tolist()), (0, []))
        for only, message in (([500], "seed 500 at place 0"), ([1, 1], "named before"), (mask[:3], "mask of shape"),
                              ([0.5], "give indices")):
            with self.assertRaisesRegex(ValueError, message):
                vt.tessellate(p, only=only)

    def test_mesh(self):
        vertices, triangles = CUBE
        p = points(200)
        want = "neighbors,volumes,areas,surfaces"
        t = vt.tessellate(p, mesh=(vertices, triangles), want=want, device="cpu")
        box = vt.tessellate(p, box=UNIT, want=want, device="cpu")
        np.testing.assert_array_equal(t.indices, box.indices)
        np.testing.assert_allclose(t.volumes, box.volumes, rtol=1e-12)
        np.testing.assert_allclose(t.surface_areas, box.surface_areas, rtol=1e-12)
        self.assertAlmostEqual(t.mesh_areas.sum(), 6, places=12)
        self.assertIsNone(box.mesh_areas)
        self.assertTrue(t.in_mesh)
        self.assertFalse(box.in_mesh)
        self.assertIn("mesh of volume 1 in a box", repr(t))
        for kind in (
            types.SimpleNamespace(vertices=vertices, faces=triangles.astype(np.uint64)),  # trimesh
            types.SimpleNamespace(vertices=vertices.tolist(), triangles=triangles.astype(np.int16)),  # Open3D
            types.SimpleNamespace(points=vertices.astype(np.float32), regular_faces=triangles, is_all_triangles=True),
            types.SimpleNamespace(points=vertices, cells_dict={"line": triangles[:, :2], "triangle": triangles}),  # meshio
            Scene(vertices, triangles),
            types.SimpleNamespace(  # tensors of Open3D
                vertex=types.SimpleNamespace(positions=Tensor(vertices)), triangle=types.SimpleNamespace(indices=Tensor(triangles))
            ),
        ):
            np.testing.assert_array_equal(vt.tessellate(p, mesh=kind, device="cpu").volumes, t.volumes)
        some = vt.tessellate(p, mesh=(vertices, triangles), want=want, device="cpu", only=[7, 3])
        np.testing.assert_array_equal(some.volumes, t.volumes[[7, 3]])
        corners = vertices[triangles.ravel()], np.arange(36).reshape(12, 3)
        merged = vt.tessellate(p, mesh=corners, mesh_repair="merge", want=want, device="cpu")
        np.testing.assert_array_equal(merged.indices, t.indices)
        np.testing.assert_allclose(merged.volumes, t.volumes, rtol=1e-13)
        for repair, message in ((None, "merge vertices at equal places"), ("holes", "mesh_repair is 'holes': the words are merge")):
            with self.assertRaisesRegex((ValueError, vt.VotessError), message):
                vt.tessellate(p, mesh=corners, mesh_repair=repair)
        rough = corners[0] + 1e-13 * np.random.default_rng(3).random((36, 3)), corners[1]
        with self.assertRaisesRegex(ValueError, "36 edges are open or turned.*mesh_tolerance"):
            vt.tessellate(p, mesh=rough, mesh_repair="merge")
        with self.assertRaisesRegex(ValueError, "mesh_tolerance needs mesh_repair"):
            vt.tessellate(p, mesh=rough, mesh_tolerance=1e-9)
        closed = vt.tessellate(p, mesh=rough, mesh_repair="merge", mesh_tolerance=1e-9, device="cpu")
        np.testing.assert_allclose(closed.volumes, t.volumes, rtol=1e-9)
        self.assertEqual((closed.stats.moved_vertices, merged.stats.moved_vertices), (28, 0))
        self.assertTrue(0 < closed.stats.moved_distance < 2e-13)
        again = pickle.loads(pickle.dumps(t))
        np.testing.assert_array_equal(again.mesh_areas, t.mesh_areas)
        with tempfile.TemporaryDirectory() as folder:
            t.save(folder + "/cells.npz")
            with np.load(folder + "/cells.npz") as file:
                np.testing.assert_array_equal(file["mesh_areas"], t.mesh_areas)
        self.assertTrue(t.verify().passed and again.verify().passed)
        with self.assertRaisesRegex((ValueError, vt.VotessError), "mesh"):
            t.delaunay()
        for mesh, message in (
            ((vertices, triangles[1:]), r"the edge between vertices 0 \(.*\) and 1 \(.*\) belongs to triangle 4 alone"),
            ((vertices, triangles + 1), "triangle 2 names vertex 8, but there are 8"),
            ((vertices, triangles - 1), "triangle 0 names vertex -1"),
            ((vertices, triangles.astype(np.int64) + 2**32), "names vertex 4294967296"),
            ((vertices, triangles[:, ::-1]), "face inward"),
            ((vertices[:, :1], triangles), "vertices of mesh have shape"),
            ((vertices[:, :2], triangles), "edges of mesh have shape"),
            ((vertices, triangles[:, :2]), "triangles of mesh have shape"),
            ((vertices, triangles.astype(float)), "give .T, 3. indices"),
            ((vertices * np.nan, triangles), "not finite"),
            (vertices, "mesh is a ndarray"),
            (7, "mesh is a int"),
            (MixedFaces(), "give mesh.triangulate"),
            (types.SimpleNamespace(points=vertices, extract_geometry=0), r"give its surface, mesh.extract_geometry\(\)"),
            (types.SimpleNamespace(combine=0, extract_geometry=0), r"mesh.combine\(\).extract_geometry\(\).triangulate"),
            (types.SimpleNamespace(GetCells=0), "pyvista.wrap"),
            (types.SimpleNamespace(points=vertices, cells_dict={"tetra": 0, "triangle": triangles}), r"\['tetra', 'triangle'\]"),
        ):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                vt.tessellate(p, mesh=mesh, device="cpu")
        with self.assertRaisesRegex((ValueError, vt.VotessError), "give box= with the mesh inside"):
            vt.tessellate(p, mesh=(vertices + 0.1, triangles), box=UNIT, periodic=True)

    def test_what_is_refused(self):
        for message, arguments in [
            ("periodic is 'xx'", {"periodic": "xx"}),
            ("periodic is 'none': give axes, such as 'xyz' or 'xy', or False", {"periodic": "none"}),
            ("one for each axis", {"box": UNIT, "periodic": (True, False)}),
            ("periodic has 2 dimensions, but points have 3", {"periodic": (True, False)}),
            ("cell has shape", {"cell": (1, 2, 3)}),
            ("one plane", {"cell": ((1, 0, 0), (2, 0, 0), (0, 0, 1))}),
            ("origin needs cell", {"origin": (0, 0, 0)}),
            ("box= and cell=", {"box": UNIT, "cell": np.eye(3)}),
            ("periodic= needs a box", {"periodic": True}),
            ("periodic= needs a box", {"periodic": "z"}),
            ("walls= and cell=", {"cell": np.eye(3), "walls": [(1, 0, 0, 1)]}),
            ("box has shape", {"box": np.zeros((3, 3))}),
            ("walls has shape", {"walls": (1, 0, 0)}),
            ("walls has 2 dimensions, but points have 3", {"walls": [(1, 0, 0)]}),
            ("normal is 0", {"walls": [(0, 0, 0, 1)]}),
            ("walls= and periodic=", {"box": UNIT, "periodic": True, "walls": [(1, 0, 0, 1)]}),
            (r"^points\[0\].*outside wall 0", {"walls": [(1, 0, 0, 0)]}),
            ("weights has shape", {"weights": [1, 2]}),
            ("weights= and radii=", {"weights": np.zeros(10), "radii": np.zeros(10)}),
            (r"^radii\[3\] = -1 is negative", {"radii": [0, 0, 0, -1, 0, 0, 0, 0, 0, 0]}),
            (r"^weights\[2\] = nan", {"weights": [0, 0, float("nan"), 0, 0, 0, 0, 0, 0, 0]}),
            ("outside is 'far'", {"outside": "far"}),
            ("min_face", {"min_face": -1}),
            ("min_area", {"min_area": float("nan")}),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                vt.tessellate(points(10), **arguments)


class Values(unittest.TestCase):
    """vt.Domain, and the short forms that make one."""

    PAIRS = (  # a domain, its short forms, and the dimensions of points
        (vt.Domain.box(UNIT, periodic="xy"), {"box": UNIT, "periodic": (True, True, False)}, 3),
        (vt.Domain.box(((0, 0, 0), (1, 1, 1)), outside="drop"), {"box": ((0, 1),) * 3, "outside": "drop"}, 3),
        (vt.Domain.box(UNIT, walls=[(1, 1, 0, 1.5)], outside="keep"), {"box": UNIT, "walls": np.array([[1, 1, 0, 1.5]]), "outside": "keep"}, 3),
        (vt.Domain.box(((0, 1), (0, 1), (-np.inf, np.inf)), periodic="xy"), {"box": (0, 0, -np.inf, 1, 1, np.inf), "periodic": "xy"}, 3),
        (vt.Domain.cell(2 * np.eye(3), origin=(-1, 0, 0)), {"cell": 2 * np.eye(3), "origin": [-1, 0, 0], "periodic": True}, 3),
        (vt.Domain.cell(2 * np.eye(3), periodic="x"), {"cell": 2 * np.eye(3), "periodic": [1, 0, 0]}, 3),
        (vt.Domain.hull(), {"box": "hull"}, 3),
        (vt.Domain.space(), {"box": "none"}, 3),
        (vt.Domain.mesh(CUBE), {"mesh": CUBE}, 3),
        (vt.Domain.mesh(CUBE, repair="merge", tolerance=1e-9, within=vt.Domain.box((-1, -1, -1, 2, 2, 2))),
         {"mesh": CUBE, "mesh_repair": "merge", "mesh_tolerance": 1e-9, "box": (-1, -1, -1, 2, 2, 2)}, 3),
        (vt.Domain.box((0, 0, 1, 1), periodic=True), {"box": (0, 0, 1, 1), "periodic": "xy"}, 2),
        (vt.Domain.cell([(1, 0), (0.2, 1)], periodic=False, outside="keep"),
         {"cell": [(1, 0), (0.2, 1)], "periodic": False, "outside": "keep"}, 2),
        (vt.Domain.box((0, 0, 1, 1), walls=[(1, 0, 0.9)], outside="drop"), {"box": (0, 0, 1, 1), "walls": [(1, 0, 0.9)], "outside": "drop"}, 2),
        (vt.Domain.hull(), {"box": "hull"}, 2),
        (vt.Domain.space(), {"box": "none", "periodic": False}, 2),
    )  # fmt: skip

    def test_short_forms_make_the_same_value(self):
        for domain, short, size in self.PAIRS:
            with self.subTest(domain):
                made = vt.Domain(**short)
                self.assertEqual((made, hash(made), repr(made)), (domain, hash(domain), repr(domain)))
                self.assertIn(domain.dimensions, (size, None))
                p = points(40)[:, :size]
                t, other = vt.tessellate(p, domain, device="cpu"), vt.tessellate(p, device="cpu", **short)
                self.assertEqual((t.domain, other.domain), (domain, domain))
                for name in ("indptr", "indices", "volumes", "status"):
                    np.testing.assert_array_equal(getattr(t, name), getattr(other, name))
        different = [domain for domain, _, size in self.PAIRS if size == 3]
        self.assertEqual(len(set(different)), len(different))
        self.assertNotEqual(vt.Domain.space(), "none")

    def test_a_result_reproduces_by_its_domain(self):
        for given, size in (({}, 3), ({}, 2), ({"outside": "drop"}, 3), *((short, size) for _, short, size in self.PAIRS)):
            t = vt.tessellate(points(30)[:, :size], device="cpu", **given)
            again = vt.tessellate(t.points, t.domain, device="cpu")
            self.assertEqual(again.domain, t.domain)
            np.testing.assert_array_equal(again.indices, t.indices)
            np.testing.assert_array_equal(again.volumes, t.volumes)
        self.assertEqual(vt.tessellate(points(8)).domain.limits.shape, (2, 3))

    def test_pickles_hold_the_domain(self):
        for domain, _, size in self.PAIRS:
            other = pickle.loads(pickle.dumps(domain))
            self.assertEqual((other, copy.deepcopy(domain), copy.copy(domain)), (domain,) * 3)
            self.assertEqual(other.periodic, domain.periodic)
        t = vt.tessellate(points(30), vt.Domain.mesh(CUBE), want="neighbors,volumes", device="cpu")
        again = pickle.loads(pickle.dumps(t))
        np.testing.assert_array_equal(again.pieces().volumes, t.pieces().volumes)
        self.assertTrue(again.verify())

    def test_what_it_tells(self):
        d = vt.Domain.box(((0, 2), (0, 1), (0, 1)), periodic="x", outside="keep")
        self.assertEqual((d.periodic, d.outside, d.walls.shape, d.vectors, d.origin), ((True, False, False), "keep", (0, 4), None, None))
        self.assertEqual(d.limits.tolist(), [[0, 0, 0], [2, 1, 1]])
        self.assertEqual(repr(d), "<pyvotess.Domain: box (0, 0, 0) to (2, 1, 1), periodic x, outside keep>")
        d = vt.Domain.cell([(1, 0), (0, 2)], origin=(3, 4))
        self.assertEqual((d.periodic, d.dimensions, d.origin.tolist(), d.vectors.tolist()), ((True, True), 2, [3, 4], [[1, 0], [0, 2]]))
        for d, text in ((vt.Domain.hull(), "convex hull"), (vt.Domain.space(), "domain without end"), (vt.Domain(), "default box"),
                        (vt.Domain.mesh(CUBE), "mesh of 12 triangles in a default box")):  # fmt: skip
            self.assertEqual(repr(d), f"<pyvotess.Domain: {text}>")
            self.assertEqual(d.periodic, (False,) * 3)

    def test_it_does_not_change(self):
        walls, box = np.array([(1, 1, 0, 1.5)]), np.array(UNIT, float)
        d = vt.Domain.box(box, walls=walls)
        box[:], walls[:] = 7, 7
        self.assertEqual(d, vt.Domain.box(UNIT, walls=[(1, 1, 0, 1.5)]))
        for name in ("periodic", "limits", "_values", "other"):
            with self.assertRaises(AttributeError):
                setattr(d, name, 1)
        for array in (d.limits, d.walls, *vt.Domain.mesh(CUBE).surface):
            with self.assertRaises(ValueError):
                array[0] = 0
        self.assertEqual(d.replace(walls=None, outside="drop"), vt.Domain.box(UNIT, outside="drop"))
        same = vt.Domain.cell(np.eye(3), origin=(0, 0, 0)), vt.Domain.cell(np.eye(3), periodic="xyz")
        self.assertEqual(len(set(same)), 1)
        flat = vt.Domain.box((0, 1, 2, 3))  # as corners; these numbers as limits of x and y would be another box
        self.assertEqual(flat.replace(periodic="x").limits.tolist(), [[0, 1], [2, 3]])

    def test_every_function_takes_it(self):
        p, unit, short = points(12), vt.Domain.box(UNIT, periodic=True), {"box": UNIT, "periodic": True}
        rows = []
        calls = {
            "tessellate": (lambda *a, **k: vt.tessellate(p, *a, device="cpu", **k).volumes),
            "Tessellator.tessellate": (lambda *a, **k: vt.Tessellator("cpu").tessellate(p, *a, **k).volumes),
            "Diagram": (lambda *a, **k: vt.Diagram(p, *a, **k).probe(p + 0.5, want="volumes").volumes),
            "lloyd": (lambda *a, **k: vt.lloyd(p, *a, steps=1, device="cpu", **k).energies),
            "fit_volumes": (lambda *a, **k: vt.fit_volumes(p, np.ones(12), *a, normalize=True, device="cpu", **k).weights),
            "stream": (lambda *a, **k: vt.tessellate_stream([p], rows.append, *a, memory=10**6, **k) and rows[-1].volumes),
            "forward": (lambda *a, **k: vt.autodiff.forward(p, *a, device="cpu", **k).volumes),
            "from_ase": (lambda *a, **k: vt.from_ase(Atoms(p), *a, device="cpu", **k).volumes),
        }
        for name, call in calls.items():
            with self.subTest(name):
                expected = call(**short)
                np.testing.assert_array_equal(call(unit), expected)
                np.testing.assert_array_equal(call(domain=unit), expected)
                for one, value in short.items():
                    with self.assertRaisesRegex(ValueError, f"^{one} and domain are both given: put {one} into the domain"):
                        call(unit, **{one: value})
                with self.assertRaisesRegex(TypeError, "domain is 'none': give a pyvotess.Domain"):
                    call("none")
                box, others = short["box"], {one: value for one, value in short.items() if one != "box"}
                np.testing.assert_array_equal(call(box, **others), expected)
                with self.assertRaisesRegex(ValueError, "^box and domain are both given: leave one out"):
                    call(box, box=box)
                with self.assertRaisesRegex(TypeError, r"unexpected keyword argument 'boxes': did you mean box\?"):
                    call(unit, boxes=UNIT)
        for name, function in (("tessellate", vt.tessellate), ("Diagram", vt.Diagram), ("lloyd", vt.lloyd), ("fit", vt.fit_volumes),
                               ("stream", vt.tessellate_stream), ("Tessellator", vt.Tessellator.tessellate)):  # fmt: skip
            parameters = inspect.signature(function).parameters
            behind = list(parameters)[list(parameters).index("domain") + 1 :]
            self.assertEqual({parameters[one].kind for one in behind}, {inspect.Parameter.KEYWORD_ONLY}, name)
            self.assertLessEqual({"box", "periodic", "cell", "origin", "walls", "mesh", "outside"}, set(behind), name)

    def test_refused_by_name(self):
        for short, text in (
            ({"box": (0, 0, 1, 1), "cell": np.eye(3)}, "cell has 3 dimensions, but box has 2: give both the same"),
            ({"box": UNIT, "walls": [(1, 0, 1)]}, "walls has 2 dimensions, but box has 3"),
            ({"mesh": CUBE, "box": (0, 0, 1, 1)}, "mesh has 3 dimensions, but box has 2"),
            ({"origin": (0, 0, 0)}, "origin needs cell"),
            ({"box": "sphere"}, "box is 'sphere': the words are none, hull"),
            ({"box": UNIT, "periodic": (True, False)}, "periodic holds 2 values"),
            ({"outside": "inside"}, "outside is 'inside'"),
        ):
            with self.assertRaisesRegex(ValueError, text):
                vt.Domain(**short)
        with self.assertRaisesRegex(ValueError, "box has 2 dimensions, but points have 3: give both the same"):
            vt.tessellate(points(5), vt.Domain.box((0, 0, 1, 1)))
        with self.assertRaisesRegex(TypeError, "within is 'box': give a pyvotess.Domain"):
            vt.Domain.mesh(CUBE, within="box")
        with self.assertRaisesRegex(ValueError, "give either box or cell|box.*cell|cell.*box"):
            vt.tessellate(points(5), vt.Domain(box=UNIT, cell=np.eye(3)))


    def test_every_change_is_refused_where_it_is_made(self):
        """What no points could mend raises in replace() what tessellate() raises for the same short forms."""
        kinds = (
            {}, {"box": UNIT}, {"box": (0, 0, 1, 1)}, {"box": UNIT, "periodic": "x"}, {"box": (0, 0, 0, 1, 1, np.inf)},
            {"cell": CELL, "periodic": True}, {"cell": CELL, "periodic": False}, {"cell": [(1, 0), (0.3, 1)], "periodic": (True, True)},
            {"cell": [(1, 0, 0), (0, 1, 0), (0, 0, 0)], "periodic": "xy"},
            {"box": "hull"}, {"box": "none"}, {"mesh": CUBE}, {"mesh": CUBE, "box": (-1, -1, -1, 2, 2, 2)},
            {"mesh": CUBE, "mesh_repair": "merge", "mesh_tolerance": 1e-9}, {"walls": [(1, 1, 1, 2.5)]},
            {"box": UNIT, "walls": [(1, 1, 1, 2.5)]}, {"box": UNIT, "outside": "drop"}, {"periodic": "xy"},
        )  # fmt: skip
        fields = {
            "box": (None, "none", "hull", UNIT, (0, 0, 1, 1), (0, 0, 0, 1, 1, np.inf), (1, 0, 0, 0, 1, 1), (np.nan, 0, 0, 1, 1, 1)),
            "periodic": (None, True, False, "x", "z", (True, False), (False,) * 3), "outside": (None, "error", "drop", "keep"),
            "cell": (None, CELL, [(1, 0), (0.3, 1)], [(1, 0, 0), (0, 1, 0), (0, 0, 0)], [(1, 0, 0), (2, 0, 0), (0, 0, 1)]),
            "origin": (None, (0, 0, 0), (0, 0)), "walls": (None, (), [(1, 1, 1, 2.5)], [(0, 0, 0, 1)], [(1, 1, 2)]),
            "mesh": (None, CUBE), "mesh_repair": (None, "merge"), "mesh_tolerance": (None, 0.0, 1e-9),
        }  # fmt: skip
        later = "periodic= needs a box|in one plane|box spans|outside of the cell|but points have"
        some, refused = points(9) * 0.3 + 0.2, set()

        def failure(call):
            try:
                call()
            except (ValueError, vt.VotessError) as error:
                return f"{type(error).__name__}: {error}"
            return ""

        for kind in kinds:
            domain = vt.Domain(**kind)
            for name, values in fields.items():
                for value in values:
                    at = some[:, : domain.dimensions or 3]
                    both = {**kind, name: value}
                    made = failure(lambda: domain.replace(**{name: value}))
                    used = failure(lambda: vt.tessellate(at, want=(), device="cpu", **both))
                    if not re.search(later, used):
                        self.assertEqual(made, used, f"{kind} {name}={value}")
                    refused.add(made)
        self.assertIn("ValueError: periodic: x repeats, but box has no end along it: give both of its bounds", refused)
        self.assertGreater(len(refused), 25)
        stated = vt.Domain(periodic="x")  # as some files do
        self.assertEqual(stated.replace(box=UNIT), vt.Domain.box(UNIT, periodic="x"))


class Atoms:
    """Atoms of ASE without a cell."""

    cell, pbc = np.zeros((3, 3)), (False,) * 3

    def __init__(self, positions):
        self.get_positions = lambda: positions


class NoBox(unittest.TestCase):
    def test_convex_hull(self):
        self.assertEqual(vt.Diagram(points(60), box="hull").locate([[9, 9, 9]]).tolist(), [-1])
        start = points(60)
        relaxed = vt.lloyd(start, steps=2, box="hull", device="cpu").tessellation  # the first hull stays
        np.testing.assert_array_equal(relaxed.walls, vt.tessellate(start, box="hull", device="cpu").walls)
        for arguments in ({"periodic": True}, {"walls": [(1, 0, 0, 9)]}, {"cell": np.eye(3)}, {"outside": "keep"}):
            with self.subTest(arguments), self.assertRaisesRegex(ValueError, "hull"):
                vt.tessellate(points(20), box="hull", **arguments)
        with self.assertRaisesRegex(ValueError, "in one plane"):
            vt.tessellate(points(20) * [1, 1, 0], box="hull")

    def test_walls_of_the_hull_in_any_unit(self):
        for dimensions in (2, 3):
            for seeds in (points(n)[:, :dimensions] for n in (4, 9, 30, 100)):
                walls = vt.tessellate(seeds, box="hull", device="cpu").walls
                for unit in 2.0 ** np.array([-300, -40, -3, 5, 300]):
                    scaled = vt.tessellate(seeds * unit, box="hull", device="cpu").walls
                    size = np.linalg.norm(scaled[:, :-1], axis=1, keepdims=True)
                    expected = walls / np.linalg.norm(walls[:, :-1], axis=1, keepdims=True)
                    np.testing.assert_allclose(scaled / size / np.append(np.ones(dimensions), unit), expected, rtol=1e-12)

    def test_what_needs_an_end(self):
        t = vt.tessellate(points(20), box="none", want="faces,volumes,areas", device="cpu")
        for call in (t.derivatives, t.voronoi_indices, lambda: t.save("x.ply")):
            with self.subTest(call), self.assertRaisesRegex(ValueError, "box with ends|open='skip', or give a box"):
                call()
        for arguments in ({"box": "all"}, {"box": "none", "periodic": True}, {"box": "none", "walls": [(1, 0, 0, 1)]}):
            with self.subTest(arguments), self.assertRaises(ValueError):
                vt.tessellate(points(20), **arguments)


if __name__ == "__main__":
    unittest.main()
