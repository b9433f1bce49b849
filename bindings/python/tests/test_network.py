"""network(): radii by brute force, largest spheres, walls, other packages, bad input."""

import itertools
import copy
import pickle
import unittest

import numpy as np
from helpers import CELL, UNIT_BOX, have, lattice, uniform

import pyvotess as vt

BCC = np.array([(0, 0, 0), (0.5, 0.5, 0.5)])
DOMAINS = (
    {"box": UNIT_BOX, "periodic": True},
    {"cell": CELL, "periodic": "xy"},
    {"box": UNIT_BOX},
)
# The siliceous framework EDI in fractions of its edges: ten oxygen atoms, five of silicon.
EDI_EDGES = np.array([6.926, 6.926, 6.41])
EDI = np.array([
    (0.1898, 0, 0.355), (0, 0.8102, 0.645), (0, 0.1898, 0.645), (0.8102, 0, 0.355), (0.1897, 0.1897, 0),
    (0.1897, 0.8103, 0), (0.8103, 0.1897, 0), (0.8103, 0.8103, 0), (0.5, 0, 0.1183), (0, 0.5, 0.8817),
    (0.2679, 0, 0.1184), (0, 0.7321, 0.8816), (0, 0.2679, 0.8816), (0.7321, 0, 0.1184), (0, 0, 0.5),
])  # fmt: skip


# Edges, sites and symmetries of two more. A symmetry multiplies the fractions of a site and adds to them.
JBW = (
    (5.256, 7.45, 8.159),
    [(0, 0.2612, 0), (0, 0.5, 0.5), (0.25, 0, 0.1455), (0.25, 0.3235, 0.2728), (0.25, 0.2111, 0.1042),
     (0.25, 0.5, 0.3865)],
    [((1, -1, 1), (0, 0, 0)), ((-1, 1, -1), (0, 0, 0)), ((-1, 1, 1), (0.5, 0, 0))],
)  # fmt: skip
BIK = (
    (7.54, 16.222, 5.256),
    [(0, 0.1714, 0.25), (0, 0.5, 0), (0.1744, 0.3857, 0.75), (0.25, 0.25, 0), (0, 0.4429, 0.75),
     (0.2065, 0.1966, 0.25)],
    [((1, 1, 1), (0.5, 0.5, 0)), ((-1, -1, -1), (0, 0, 0)), ((-1, 1, 1), (0, 0, 0)), ((1, 1, -1), (0, 0, 0.5))],
)  # fmt: skip


def framework(sites, symmetries):
    """Returns the images of sites under all symmetries."""
    points = {tuple(site) for site in sites}
    for factors, add in 4 * symmetries:
        moved = np.array(sorted(points)) * factors + add
        points |= {tuple(point) for point in (moved % 1).round(6) % 1}
    return np.array(sorted(points))


def crystal(basis, cells, edge=1.0, **options):
    """Returns cells of a cubic crystal."""
    corners = np.array(list(itertools.product(range(cells), repeat=3)))
    points = (corners[:, None] + basis).reshape(-1, 3) * edge
    side = cells * edge
    return vt.tessellate(points, box=(0, 0, 0, side, side, side), periodic=True, want="faces", **options)


def euler(t, n):
    """Returns vertices - edges + faces - cells."""
    return len(n.points) - len(n.edges) + np.sum(t.indices >= 0) // 2 - np.sum(t.status == 0)


def images(t):
    """Returns centers and radii of the spheres around the domain."""
    edges = t.cell if t.cell is not None else np.diag(t.box[1] - t.box[0])
    reach = [range(-2, 3) if repeats else (0,) for repeats in t.periodic]
    moves = np.array(list(itertools.product(*reach))) @ edges
    radii = np.zeros(len(t)) if t.weights is None else np.sqrt(t.weights)
    return (t.wrapped_points + moves[:, None]).reshape(-1, 3), np.tile(radii, len(moves))


def room(a, b, centers, radii):
    """Returns the distance from the segment a b to the nearest sphere."""
    along = b - a
    t = np.clip((centers - a) @ along / max(along @ along, 1e-300), 0, 1)
    return (np.linalg.norm(centers - a - t[:, None] * along, axis=1) - radii).min()


def goes_on(n, radius, axis):
    """Returns whether edges of at least this radius lead from a vertex to an image of it, by flooding."""
    kept = n.edge_radii >= radius
    near = {}
    for (a, b), s in zip(n.edges[kept].tolist(), n.shifts[kept].astype(int)):
        near.setdefault(a, []).append((b, s))
        near.setdefault(b, []).append((a, -s))
    at = {}
    for start in near:
        if start in at:
            continue
        at[start] = np.zeros(3, int)
        stack = [start]
        while stack:
            a = stack.pop()
            for b, s in near[a]:
                if b not in at:
                    at[b] = at[a] + s
                    stack.append(b)
                net = at[a] + s - at[b]
                if net.any() if axis is None else net[axis]:
                    return True
    return False


class Network(unittest.TestCase):
    def test_radii(self):
        for domain in DOMAINS:
            for radii in (None, uniform(30, seed=3)[:, 0] ** 3 * 0.25):
                t = vt.tessellate(uniform(30, seed=2), want="faces", radii=radii, **domain)
                n = t.network()
                spheres = images(t)
                outside = n.vertex_radii > 0
                own = [room(x, x, *spheres) for x in n.points]
                np.testing.assert_allclose(n.vertex_radii[outside], np.array(own)[outside], atol=1e-12)
                np.testing.assert_array_equal(outside, np.array(own) > 0)
                first = n.points[n.edges[:, 0]]
                own = np.array([room(a, a + v, *spheres) for a, v in zip(first, n.vectors)])
                outside = n.edge_radii > 0
                np.testing.assert_allclose(n.edge_radii[outside], own[outside], atol=1e-12)
                np.testing.assert_array_equal(outside, own > 0)
                samples = first[:, None] + np.linspace(0, 1, 9)[:, None] * n.vectors[:, None]
                for radius, places in zip(n.edge_radii[::7], samples[::7]):
                    self.assertLessEqual(radius, min(room(x, x, *spheres) for x in places) + 1e-12)

    def test_largest_free(self):
        for domain in DOMAINS[:2]:
            for radii in (None, uniform(60, seed=3)[:, 0] * 0.2):
                n = vt.tessellate(uniform(60, seed=4), want="faces", radii=radii, **domain).network()
                for axis in (None, 0, 1, 2):
                    if axis == 2 and domain["periodic"] == "xy":
                        with self.assertRaisesRegex(ValueError, "along axis 2: give a domain that is periodic"):
                            n.largest_free(axis)
                        continue
                    radius = n.largest_free(axis).radius
                    self.assertTrue(goes_on(n, radius, axis))
                    self.assertFalse(goes_on(n, np.nextafter(radius, np.inf), axis))

    def test_equal_radii_as_zeo(self):
        """`network -r radii -res` of Zeo++ 0.3 with 1.35 for all atoms prints these diameters."""
        frameworks = {
            (5.65992, 3.37868): (EDI_EDGES, EDI),
            (4.22882, 3.66384): (JBW[0], framework(*JBW[1:])),
            (4.10701, 3.49002): (BIK[0], framework(*BIK[1:])),
        }
        self.assertEqual([len(f[1]) for f in frameworks.values()], [15, 18, 36])
        for (included, free), (edges, fractions) in frameworks.items():
            t = vt.tessellate(
                fractions * edges, box=(0, 0, 0, *edges), periodic=True, radii=np.full(len(fractions), 1.35), want="faces"
            )
            self.assertAlmostEqual(2 * t.network().largest_included().radius, included, delta=6e-6)
            self.assertAlmostEqual(2 * t.network().largest_free().radius, free, delta=6e-6)

    def test_walls(self):
        t = vt.tessellate(lattice(3), box=(0, 0, 0, 3, 3, 3), want="faces")
        n = t.network()
        self.assertIsNone(n.shifts)
        self.assertEqual((len(n.points), len(n.edges), n.at_walls.sum()), (64, 144, 56))
        self.assertEqual(euler(t, n) + np.sum(t.indices < 0), 1)
        with self.assertRaisesRegex(ValueError, "no edges lead"):
            n.largest_free()
        n = vt.tessellate(uniform(30), box="none", want="faces").network()
        self.assertTrue(np.isfinite(n.points).all() and n.edges.min() >= 0)

    def test_bad_input(self):
        t = vt.tessellate(uniform(20), box=UNIT_BOX, periodic=True, want="faces")
        n = t.network()
        with self.assertRaisesRegex(ValueError, "axis is 3"):
            n.largest_free(3)
        with self.assertRaisesRegex(ValueError, 'set want="faces"'):
            vt.tessellate(uniform(20)).network()
        with self.assertRaisesRegex(ValueError, "weight of seed 4 is negative"):
            vt.tessellate(uniform(5), weights=[0, 0, 0, 0, -0.01], want="faces").network()
        self.assertEqual(copy.copy(n).largest_included(), n.largest_included())
        copied = pickle.loads(pickle.dumps(n))
        np.testing.assert_array_equal(copied.edge_radii, n.edge_radii)
        with self.assertRaisesRegex(ValueError, "pickle"):
            copied.largest_included()
        empty = vt.tessellate(np.zeros((0, 3)), box=UNIT_BOX, want="faces").network()
        self.assertEqual(len(empty.points), 0)
        with self.assertRaisesRegex(ValueError, "no vertices"):
            empty.largest_included()

    @have("networkx")
    def test_networkx(self):
        n = crystal(BCC, 1).network()
        graph = n.to_networkx()
        self.assertEqual((graph.number_of_nodes(), graph.number_of_edges()), (12, 24))
        self.assertEqual(sorted(tuple(e) for e in graph.edges()), sorted(map(tuple, n.edges.tolist())))
        self.assertEqual({d for _, d in graph.degree()}, {4})
        self.assertEqual(graph.nodes[3]["radius"], n.vertex_radii[3])
        shifts = sorted((u, v, d["shift"], d["radius"]) for u, v, d in graph.edges(data=True))
        expected = zip(*n.edges.T.tolist(), map(tuple, n.shifts.tolist()), n.edge_radii.tolist())
        self.assertEqual(shifts, sorted(expected))

    @have("openpnm")
    def test_openpnm(self):
        n = vt.tessellate(uniform(40), box=UNIT_BOX, want="faces").network()
        network = n.to_openpnm()
        np.testing.assert_array_equal(network["throat.conns"], n.edges)
        np.testing.assert_array_equal(network["pore.coords"], n.points)
        np.testing.assert_array_equal(network["pore.inscribed_diameter"], 2 * n.vertex_radii)
        np.testing.assert_array_equal(network["pore.surface"], n.at_walls)
        self.assertFalse(network["throat.periodic"].any())


if __name__ == "__main__":
    unittest.main()
