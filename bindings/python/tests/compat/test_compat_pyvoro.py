"""pyvoro's list of dicts: compared with pyvoro if it is installed, and checked by itself."""

import copy
import json
import pickle
import unittest

import numpy as np
from helpers import lattice, uniform
from pyvotess.compat import pyvoro as ours

try:
    import pyvoro as peer
except ImportError:
    peer = None

LIMITS = [[0.0, 1.0], [0.0, 1.0], [0.0, 1.0]]


def ring(ids):
    """Returns the polygon from its smallest corner, in its direction."""
    first = ids.index(min(ids))
    return tuple(ids[first:] + ids[:first])


class Vector:
    """A class of points that a program may use."""

    def __init__(self, xyz):
        self.xyz = tuple(xyz)

    def __getitem__(self, axis):
        return self.xyz[axis]


class Pyvoro(unittest.TestCase):
    def check_cell(self, cell):
        """Asserts a closed polyhedron with its volume; faces are clockwise seen from outside, as in Voro++."""
        vertices = np.array([list(v) for v in cell["vertices"]])
        edges = set()
        volume = 0.0
        for face in cell["faces"]:
            corners = face["vertices"]
            edges |= set(zip(corners, corners[1:] + corners[:1]))
            base = vertices[corners[0]]
            for a, b in zip(corners[1:], corners[2:]):
                volume -= np.dot(base - vertices[0], np.cross(vertices[a] - base, vertices[b] - base)) / 6
        self.assertEqual(len(edges), sum(len(face["vertices"]) for face in cell["faces"]))
        self.assertEqual(edges, {(b, a) for a, b in edges})
        self.assertEqual(len(vertices) - len(edges) // 2 + len(cell["faces"]), 2)
        self.assertAlmostEqual(volume, cell["volume"], delta=1e-9 * abs(cell["volume"]))
        for vertex, around in enumerate(cell["adjacency"]):
            self.assertEqual(sorted(around), sorted(b for a, b in edges if a == vertex))
            # A face is between an edge and the next one.
            for a, b in zip(around, around[1:] + around[:1]):
                together = [f for f in cell["faces"] if {vertex, a, b} <= set(f["vertices"])]
                self.assertTrue(together)

    def test_cells_are_polyhedra(self):
        for points, limits in ((uniform(100), LIMITS), (lattice(3), [[0, 3]] * 3)):
            for periodic in ([False] * 3, [True, False, True]):
                cells = ours.compute_voronoi(points.tolist(), limits, 0.2, periodic=periodic)
                for cell in cells:
                    self.check_cell(cell)
                self.assertAlmostEqual(sum(c["volume"] for c in cells), np.prod(np.diff(limits)), places=9)
        # Every vertex of these cells has more than three edges, or some have three and some four.
        points = np.concatenate([lattice(2) + s for s in ((0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5))])
        cells = ours.compute_voronoi(points, [[0, 2]] * 3, 0.5, periodic=[True] * 3)
        for cell in cells:
            self.check_cell(cell)
        self.assertEqual(sorted(len(a) for a in cells[0]["adjacency"]), [3] * 8 + [4] * 6)

    def test_adjacent_cells_are_mutual(self):
        cells = ours.compute_voronoi(uniform(60), LIMITS, 0.2)
        pairs = {(i, f["adjacent_cell"]) for i, c in enumerate(cells) for f in c["faces"]}
        inner = {(i, j) for i, j in pairs if j >= 0}
        self.assertEqual(inner, {(j, i) for i, j in inner})
        self.assertEqual({j for _, j in pairs if j < 0}, {-1, -2, -3, -4, -5, -6})
        for i, cell in enumerate(cells):
            for face in cell["faces"]:
                corners = np.array(cell["vertices"])[face["vertices"]]
                if face["adjacent_cell"] < 0:  # -1, -2: x = 0, x = 1, and so on
                    axis, side = divmod(-1 - face["adjacent_cell"], 2)
                    np.testing.assert_allclose(corners[:, axis], side, atol=1e-12)

    def test_documented_call(self):
        # Two points of radii 1.3 and 1.4: the plane of equal power cuts the cube of side 10.
        points = [[1.0, 2.0, 3.0], [4.0, 5.5, 6.0]]
        cells = ours.compute_voronoi(points, [[0.0, 10.0], [0.0, 10.0], [0.0, 10.0]], 2.0, radii=[1.3, 1.4])
        self.assertAlmostEqual(cells[0]["volume"], 207.1020518571429)
        self.assertAlmostEqual(cells[1]["volume"], 792.8979481428571)
        self.assertIs(cells[0]["original"], points[0])
        self.assertEqual(sorted(f["adjacent_cell"] for f in cells[0]["faces"]), [-6, -5, -3, -2, -1, 1])
        self.assertEqual(len(cells[1]["vertices"]), 10)
        self.assertEqual(set(cells[1]), {"original", "volume", "vertices", "adjacency", "faces"})
        self.assertIs(type(cells), list)

    def compare(self, points, limits, **words):
        mine, theirs = (module.compute_voronoi(points, limits, 0.1, **words) for module in (ours, peer))
        for a, b in zip(mine, theirs):
            self.assertAlmostEqual(a["volume"], b["volume"], places=12)
            distance = np.linalg.norm(np.array(b["vertices"])[:, None] - np.array(a["vertices"]), axis=2)
            place = distance.argmin(axis=1).tolist()
            self.assertEqual(sorted(place), list(range(len(a["vertices"]))))
            self.assertLess(distance.min(axis=1).max(), 1e-9)
            faces = sorted((f["adjacent_cell"], ring([place[v] for v in f["vertices"]])) for f in b["faces"])
            self.assertEqual(sorted((f["adjacent_cell"], ring(f["vertices"])) for f in a["faces"]), faces)
            for vertex, around in enumerate(b["adjacency"]):
                self.assertEqual(ring(a["adjacency"][place[vertex]]), ring([place[v] for v in around]))

    @unittest.skipUnless(peer, "pyvoro is not installed")
    def test_equals_pyvoro(self):
        points = uniform(300, seed=5).tolist()
        radii = (0.05 * uniform(300, seed=2)[:, 0]).tolist()
        for periodic in ([False] * 3, [True] * 3, [True, False, True]):
            moved = [[x + periodic[0], y, z] for x, y, z in points]  # outside, along a periodic axis
            self.compare(moved, LIMITS, periodic=periodic)
            self.compare(moved, LIMITS, periodic=periodic, radii=radii)
        self.compare(uniform(50).tolist(), [[-1, 2], [0, 1], [0, 1.5]])
        self.compare([[0.5, 0.5, 0.5]], LIMITS)
        self.compare([(0.2, 0.5, 0.5), (0.7, 0.5, 0.5)], LIMITS)

    def test_kinds_of_points(self):
        expected = ours.compute_voronoi(uniform(20).tolist(), LIMITS, 0.2)
        kinds = {
            np.ndarray: uniform(20),
            tuple: [tuple(p) for p in uniform(20)],
            list: uniform(20).tolist(),
            Vector: [Vector(p) for p in uniform(20)],
        }
        for kind, points in kinds.items():
            cells = ours.compute_voronoi(points, LIMITS, 0.2)
            self.assertIs(type(cells[3]["original"]), kind)
            for a, b in zip(cells, expected):
                self.assertIs(type(a["vertices"][0]), kind)
                self.assertEqual([list(v[k] for k in range(3)) for v in a["vertices"]], b["vertices"])
                self.assertEqual(a["faces"], b["faces"])
            self.assertIs(type(cells[0]["vertices"]), list)

    def test_a_cell_is_a_dict_however_it_is_used_first(self):
        def cells():
            return ours.compute_voronoi(uniform(300).tolist(), LIMITS, 0.2)

        names = ["original", "volume", "vertices", "adjacency", "faces"]
        expected = [{name: cell[name] for name in names} for cell in cells()]
        first_uses = (
            lambda c: c,
            dict,
            copy.copy,
            copy.deepcopy,
            lambda c: c.copy(),
            lambda c: json.loads(json.dumps(c)),
            lambda c: pickle.loads(pickle.dumps(c)),
            lambda c: {**c},
            lambda c: {name: c[name] for name in c},
            lambda c: dict(zip(c.keys(), c.values())),
            lambda c: dict(c.items()),
            lambda c: {name: c.get(name) for name in names},
            lambda c: c | {},
            lambda c: {} | c,
            lambda c: {name: c[name] for name in reversed(c)},
            lambda c: {name: c.pop(name) for name in names},
            lambda c: eval(repr(c)),
        )
        for use in first_uses:
            self.assertEqual(use(cells()[200]), expected[200])
            self.assertTrue(expected[200] == cells()[200])
        self.assertEqual(cells(), expected)
        self.assertFalse(cells()[0] != expected[0])
        self.assertEqual(len(cells()[0]), 5)
        self.assertIn("faces", cells()[299])
        self.assertEqual(list(cells()[7]), names)
        self.assertIsInstance(cells()[7], dict)
        with self.assertRaises(KeyError):
            cells()[0]["neighbors"]
        cell = cells()[5]
        cell["faces"] = 1
        cell["label"] = 2
        del cell["adjacency"]
        self.assertEqual(cell, {**{k: expected[5][k] for k in names if k != "adjacency"}, "faces": 1, "label": 2})
        mixed = cells()[::-1]
        del mixed[10:]
        self.assertEqual([c["faces"] for c in mixed], [c["faces"] for c in expected[::-1][:10]])

    def test_what_is_refused(self):
        points = uniform(10).tolist()
        self.assertEqual(ours.compute_voronoi([], LIMITS, 0.1), [])
        with self.assertRaisesRegex(ours.VoronoiPlusPlusError, r"points\[10\]"):
            ours.compute_voronoi(points + [[2.0, 0.5, 0.5]], LIMITS, 0.1)
        with self.assertRaisesRegex(ours.VoronoiPlusPlusError, "larger radii"):
            ours.compute_voronoi(points, LIMITS, 0.1, radii=[5.0] + [0.1] * 9)
        with self.assertRaises(ValueError):
            ours.compute_voronoi(points + points[:1], LIMITS, 0.1)
        with self.assertRaises(ValueError):
            ours.compute_voronoi(points, LIMITS, 0.1, radii=[0.1] * 3)
        with self.assertRaises(NotImplementedError):
            ours.compute_2d_voronoi([[0.5, 0.5]], LIMITS[:2], 0.1)


if __name__ == "__main__":
    unittest.main()
