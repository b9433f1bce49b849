"""Polygons as the domain in the plane, against clipping in rational arithmetic."""

import itertools
import json
import math
import pickle
import tempfile
import unittest
from fractions import Fraction
from pathlib import Path

import numpy as np
from plane_oracle import cut, moments

import pyvotess as vt
from pyvotess._input import as_mesh

CITY = {
    "type": "Polygon",
    "coordinates": [[(0, 0), (4, 0), (4, 3), (2, 1), (0, 3), (0, 0)], [(1, 0.5), (1.5, 1), (2, 0.5)]],
}


def half_planes(points, weights, i, shift, period):
    """Yields n, d of n.x <= d, of the cell of seed i moved by a shift."""

    def place(j, s):
        return tuple(points[j][k] + s[k] * period[k] for k in range(2))

    x, y = place(i, shift)
    reach = [range(-2, 3) if p else (0,) for p in period]
    for j, s in itertools.product(range(len(points)), itertools.product(*reach)):
        if (j, s) == (i, shift):
            continue
        u, v = place(j, s)
        yield (2 * (u - x), 2 * (v - y)), u * u + v * v - x * x - y * y - weights[j] + weights[i]


def clip(polygon, planes):
    for (a, b), d in planes:
        polygon = cut(polygon, a, b, d)
    return polygon


def signed_area(polygon):
    return moments(polygon)[0]


def part_of_segment(p, q, planes):
    """Returns the length of a segment inside, without what lies on a plane."""
    begin, end = Fraction(0), Fraction(1)
    for (a, b), d in planes:
        s, t = d - a * p[0] - b * p[1], d - a * q[0] - b * q[1]
        if s == t:
            if s < 0:
                return 0.0
        elif s < t:
            begin = max(begin, s / (s - t))
        else:
            end = min(end, s / (s - t))
    return float(max(end - begin, 0)) * math.hypot(float(q[0] - p[0]), float(q[1] - p[1]))


def random_sets(count, first=0):
    """Yields points, keyword arguments, and the rings of a polygon: lattices, decimals and any; holes, islands, periods."""
    for number in range(first, first + count):
        random = np.random.default_rng(number)
        side = random.choice([4, 8, 10, 100, 2**40])
        points = random.integers(0, side + 1, (int(random.integers(1, 9)), 2)) / side
        points = np.unique(points, axis=0)

        def star(center, inner, outer, corners):
            angles = np.sort(random.random(corners)) * 2 * np.pi
            radii = random.uniform(inner, outer, corners)
            ring = center + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
            return np.round(ring * side) / side

        rings = [star(0.5, 0.3, 0.5, int(random.integers(3, 9)))]
        if number % 3 == 1:
            rings.append(star(0.5, 0.05, 0.2, int(random.integers(3, 6)))[::-1])
        if number % 5 == 2:
            rings.append(star(np.array([1.5, 0.25]), 0.2, 0.4, 5))
        keywords, period = {}, (0, 0)
        if number % 4 == 3:
            rings = rings[:1]
            keywords = {"box": (0, 0, 1, 1), "periodic": random.choice(["x", "y", "xy"])}
            rings[0] = np.clip(rings[0], 0.125, 0.875)
            period = tuple(int(axis in keywords["periodic"]) for axis in "xy")
            points = points[(points < 1).all(axis=1) & (points > 0).all(axis=1)]
            if not len(points):
                continue
        if number % 6 == 5:
            keywords["weights"] = random.integers(0, 8, len(points)) / 64
        yield number, points, rings, keywords, period


def mesh_of(rings):
    vertices = np.concatenate(rings)
    edges, first = [], 0
    for ring in rings:
        own = np.arange(len(ring))
        edges.append(first + np.stack([own, np.roll(own, -1)], axis=1))
        first += len(ring)
    return vertices, np.concatenate(edges)


def exact(rows):
    return [tuple(map(Fraction, row)) for row in np.asarray(rows).tolist()]


def touches(place, ring):
    """Returns whether a place lies on a ring."""
    for p, q in zip(ring, ring[1:] + ring[:1]):
        on_line = (q[0] - p[0]) * (place[1] - p[1]) == (q[1] - p[1]) * (place[0] - p[0])
        if on_line and all(min(p[k], q[k]) <= place[k] <= max(p[k], q[k]) for k in range(2)):
            return True
    return False


class Polygons(unittest.TestCase):
    def check(self, number, points, rings, keywords, period):
        loops = [exact(ring) for ring in rings]
        area = sum(signed_area(loop) for loop in loops)
        if area <= 0:
            with self.assertRaisesRegex(ValueError, "mesh: it"):
                vt.tessellate(points, mesh=mesh_of(rings), **keywords)
            return False
        t = vt.tessellate(points, mesh=mesh_of(rings), want="neighbors,volumes,centroids,areas,surfaces", **keywords)
        places, weights = exact(points), keywords.get("weights", np.zeros(len(points)))
        weights = list(map(Fraction, weights.tolist()))
        size = float(area)
        origin = loops[0][0]
        shifts = list(itertools.product(*[range(-1, 2) if p else (0,) for p in period]))
        perimeter = sum(math.dist(p, q) for loop in rings for p, q in zip(loop, np.roll(loop, -1, axis=0)))
        self.assertAlmostEqual(t.mesh_areas.sum(), perimeter, delta=1e-12 * max(perimeter, 1))
        energy = Fraction(0)
        for i in range(len(points)):
            inside, moment = Fraction(0), [Fraction(0), Fraction(0)]
            lengths = 0.0
            for shift in shifts:
                planes = list(half_planes(places, weights, i, shift, period))
                for loop in loops:
                    for p, q in zip(loop, loop[1:] + loop[:1]):
                        part = clip([origin, p, q], planes)
                        if len(part) > 2:
                            piece, *first, second = moments(part)
                            inside += piece
                            energy += second
                            for k, m in enumerate(first):
                                x = places[i][k] + shift[k] * period[k]
                                energy += x * (x * piece - 2 * m)
                                moment[k] += m - shift[k] * period[k] * piece
                        lengths += part_of_segment(p, q, planes)
            self.assertAlmostEqual(t.volumes[i], float(inside), delta=1e-12 * size)
            if t.status[i] != 0:
                self.assertEqual(inside, 0)
            if abs(inside) > 1e-3 * size:
                np.testing.assert_allclose(t.centroids[i], [float(m / inside) for m in moment], atol=1e-10)
            self.assertLessEqual(t.mesh_areas[i], lengths + 1e-10)  # ties are of one cell
        self.assertAlmostEqual(vt.transport_cost(t), float(energy), delta=1e-11)
        pieces = t.pieces()
        sums = np.bincount(pieces.cells, pieces.volumes, minlength=len(points))
        np.testing.assert_allclose(sums, t.volumes, atol=1e-12 * size)
        for k in range(len(pieces)):
            of_rings = sum(float(signed_area(exact(ring))) for ring in pieces.rings(k))
            self.assertAlmostEqual(of_rings, pieces.volumes[k], delta=1e-11 * size)
        return True

    def test_random_polygons_are_those_of_rational_arithmetic(self):
        checked = 0
        for case in random_sets(14):
            with self.subTest(case[0]):
                checked += self.check(*case)
        self.assertGreater(checked, 9)

    def test_a_city(self):
        random = np.random.default_rng(3)
        points = random.uniform(0, 4, (300, 2))
        t = vt.tessellate(points, mesh=CITY, want="neighbors,volumes,centroids,areas,surfaces")
        self.assertAlmostEqual(t.volumes.sum(), 7.75, delta=1e-12)
        self.assertEqual(t.stats.box_volume, 7.75)
        self.assertAlmostEqual(t.mesh_areas.sum(), 10 + 4 * math.sqrt(2) + 1 + math.sqrt(2), delta=1e-12)
        np.testing.assert_allclose(t.surface_areas, t.mesh_areas + [t.face_areas[a:b].sum() for a, b in zip(t.indptr, t.indptr[1:])], atol=1e-12)
        self.assertTrue(t.verify())
        # Probes are the cells that queries would have; rays have their parts inside.
        d = vt.Diagram(points, mesh=CITY)
        self.assertTrue((d.locate([(2, 2), (1.5, 0.75), (5, 5)]) == -1).all())
        inside = (points[:, 1] < 0.4) & (points[:, 0] > 0) & (points[:, 1] > 0)  # below the notch and the hole
        np.testing.assert_array_equal(d.locate(points[inside]), np.flatnonzero(inside))
        rays = d.trace([(-1, 0.25)], [(1, 0)], 10.0)
        self.assertAlmostEqual(rays.lengths.sum(), 4, delta=1e-12)
        grid = vt.Diagram(points, mesh=CITY, box=(-1, -1, 5, 5)).to_grid(np.ones(300), shape=(40, 30), method="mean")
        self.assertAlmostEqual(grid.sum() * 36 / grid.size, 7.75, delta=1e-9)
        probes = d.probe(points[:9])
        np.testing.assert_array_equal(probes.volumes, t.volumes[:9])
        empty = vt.tessellate(np.empty((0, 2)), mesh=CITY)
        self.assertEqual((len(empty), empty.stats.box_volume), (0, 7.75))
        whole = vt.tessellate(points, box=(-1, -1, 5, 5))
        self.assertTrue((t.volumes <= whole.volumes + 1e-12).all())

    def test_pieces_are_polygons(self):
        points = np.array([(1, 0.25), (3.5, 0.25), (2, 10)])
        t = vt.tessellate(points, mesh=CITY)
        pieces = t.pieces()
        self.assertTrue(pieces.planar)
        self.assertEqual(pieces.counts.tolist(), [1, 1, 0])
        outline, hole = pieces.rings(0)
        self.assertGreater(signed_area(exact(outline)), 0)
        self.assertLess(signed_area(exact(hole)), 0)
        self.assertEqual({tuple(row) for row in hole.tolist()}, {(1, 0.5), (1.5, 1), (2, 0.5)})
        features = pieces.__geo_interface__["features"]
        self.assertEqual([feature["id"] for feature in features], [0, 1])
        again = vt.tessellate(points, mesh=pieces.__geo_interface__)
        np.testing.assert_allclose(again.volumes, t.volumes, atol=1e-13)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "cells.geojson")
            pieces.save(file)
            self.assertEqual(json.loads(file.read_text()), json.loads(json.dumps(pieces.__geo_interface__)))
            with self.assertRaisesRegex(ValueError, "known for pieces of the plane are .geojson"):
                pieces.save(Path(folder, "cells.obj"))
            with self.assertRaisesRegex(ValueError, r"save t.pieces\(\)"):
                t.save(file)
            with self.assertRaisesRegex(ValueError, "a list of polygons: give a MultiPolygon"):
                vt.tessellate(points, mesh=[CITY, CITY])
        self.assertEqual(pickle.loads(pickle.dumps(vt.Domain.mesh(CITY))), vt.Domain.mesh(CITY))

    def test_parts_that_meet_in_one_place_are_two_pieces(self):
        """A hole touches the outline in a vertex, or with one. The cell of seed 0 is x < 2."""
        for outline in ([(0, 0), (4, 0), (4, 4), (0, 4)], [(0, 0), (4, 0), (4, 4), (0, 4), (0, 2)]):
            for hole in ([(0, 2), (3, 1), (3, 3)], [(0, 2), (3, 3), (3, 1)]):
                mesh = {"type": "Polygon", "coordinates": [outline, hole]}
                t = vt.tessellate([(1, 2), (3, 2)], mesh=mesh)
                pieces = t.pieces()
                self.assertEqual(pieces.counts.tolist(), [2, 1])
                self.assertTrue(set(pieces.sources[pieces.on_surface].tolist()) <= set(range(len(outline) + 3)))
                for k in range(3):
                    (ring,) = pieces.rings(k)
                    self.assertEqual(len({tuple(place) for place in ring.tolist()}), len(ring))
                    self.assertAlmostEqual(float(signed_area(exact(ring))), pieces.volumes[k], delta=1e-12)
                self.assertTrue(t.verify())

    def test_no_ring_visits_a_place_twice(self):
        """Holes that touch the outline or each other in a point are rings of their own, as RFC 7946 and OGC demand."""
        square = [(0, 0), (4, 0), (4, 4), (0, 4)]
        triangle, pair = [[(0, 2), (2, 1), (2, 3)]], [[(1, 1), (2, 1), (2, 2), (1, 2)], [(2, 2), (3, 2), (3, 3), (2, 3)]]
        loop = [[(1, 1), (2, 1), (1, 2)], [(2, 1), (3, 1), (2.5, 2)], [(1, 2), (2, 2.5), (1, 3)]]
        for holes, points in itertools.product((triangle, pair, loop, triangle + [[(4, 4), (3.5, 3), (3, 3.5)]]), ([(1, 0.5)], [(1, 2.5), (3, 1)])):
            for outline in (square, square + [(0, 2)]):
                t = vt.tessellate(points, mesh={"type": "Polygon", "coordinates": [outline, *holes]})
                pieces = t.pieces()
                for k in range(len(pieces)):
                    rings = pieces.rings(k)
                    for ring in rings:
                        self.assertEqual(len({tuple(place) for place in ring.tolist()}), len(ring))
                    areas = [float(signed_area(exact(ring))) for ring in rings]
                    self.assertEqual([area > 0 for area in areas], [True] + [False] * (len(rings) - 1))
                    self.assertAlmostEqual(sum(areas), pieces.volumes[k], delta=1e-12)
                if len(points) == 1:
                    self.assertEqual([len(pieces), len(pieces.rings(0))], [1, 1 + len(holes)])

    def check_connected(self, pieces):
        """Asserts in fractions that the rings of a piece touch in no cycle, which would cut its inside in two."""
        for k in range(len(pieces)):
            rings = [exact(ring) for ring in pieces.rings(k)]
            group = list(range(len(rings)))
            for place in sorted({place for ring in rings for place in ring}):
                groups = [group[number] for number, ring in enumerate(rings) if touches(place, ring)]
                self.assertEqual(len(set(groups)), len(groups), (k, [float(x) for x in place]))
                group = [groups[0] if g in groups else g for g in group]

    def test_rings_that_share_corners_do_not_cut_a_piece(self):
        """Holes that touch the outline or each other in two places make parts of a cell, each a piece."""
        square = [(0, 0), (4, 0), (4, 4), (0, 4)]
        corners = [(0, 0), (4, 0), (4, 2), (4, 4), (0, 4), (0, 2)]
        wide, upper = [(0, 2), (2, 1), (4, 2), (2, 3)], [(2, 1), (3, 1), (3, 3), (2, 3)]
        around = [[(1, 1), (3, 1), (2, 0.5)], [(3, 1), (3, 3), (3.5, 2)], [(3, 3), (1, 3), (2, 3.5)], [(1, 3), (1, 1), (0.5, 2)]]
        for outline, holes, parts in ((square, [wide], 2), (corners, [wide], 2), (square, [around[0], around[1]], 1), (square, around, 2),
                                      (square, [[(1, 1), (2, 1), (2, 3), (1, 3)], upper], 1), (square, [[(0, 1), (2, 1), (2, 3), (0, 3)][::-1]], 1)):
            for point in ((1, 0.25), (3.5, 3.75), (2, 2)):
                with self.subTest(holes=holes, point=point):
                    t = vt.tessellate([point], mesh={"type": "Polygon", "coordinates": [outline, *holes]})
                    self.assertEqual(len(t.pieces()), parts)
                    self.check_simple(t.pieces())
                    self.check_connected(t.pieces())

    def test_rings_that_rounding_lets_touch_do_not_cut_a_piece(self):
        """A bisector along sides of a hole, and across the outline, moved by less than their digits."""
        square, hole = [(0, 0), (6, 0), (6, 6), (0, 6)], [(3, 3), (1, 3), (1, 1), (3, 1)]
        for h in (0, 2.0**-60, -(2.0**-60), 2.0**-54, -(2.0**-54), 2.0**-50):
            for mesh in ([square, hole], [square[:2] + [(6, 3), (6, 6), (3, 6), (0, 6)], hole]):
                t = vt.tessellate([(4, 0), (4, 4), (2, 2)], weights=[-2 * h, -2 * h, 2 * h], mesh={"type": "Polygon", "coordinates": mesh})
                self.check_simple(t.pieces())
                self.check_connected(t.pieces())
                np.testing.assert_allclose(np.bincount(t.pieces().cells, t.pieces().volumes, 3), t.volumes, atol=1e-12)

    def check_simple(self, pieces):
        """Asserts in fractions that no ring touches itself, none crosses another, and that their areas are those of the pieces."""

        def turn(a, b, c):
            product = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            return (product > 0) - (product < 0)

        def overlap(e, f, closed):
            gaps = [min(max(p[k] for p in e), max(p[k] for p in f)) - max(min(p[k] for p in e), min(p[k] for p in f)) for k in range(2)]
            return min(gaps) >= 0 if closed else max(gaps) > 0

        for k in range(len(pieces)):
            rings = pieces.rings(k)
            edges = [(number, i, len(ring), (p, q)) for number, ring in enumerate(map(exact, rings))
                     for i, (p, q) in enumerate(zip(ring, ring[1:] + ring[:1]))]
            for (r, i, size, e), (s, j, _, f) in itertools.combinations(edges, 2):
                if not overlap(e, f, closed=True):
                    continue
                signs = [turn(*e, f[0]), turn(*e, f[1]), turn(*f, e[0]), turn(*f, e[1])]
                touch = signs[0] * signs[1] <= 0 and signs[2] * signs[3] <= 0
                if not any(signs):
                    self.assertFalse(overlap(e, f, closed=False), (k, e, f))
                elif r == s and (j - i) % size not in (1, size - 1):
                    self.assertFalse(touch, (k, e, f))
                else:
                    self.assertFalse(touch and all(signs), (k, e, f))
            areas = [signed_area(exact(ring)) for ring in rings]
            self.assertEqual([area > 0 for area in areas], [True] + [False] * (len(rings) - 1))
            around = sum(float(np.hypot(*(ring - np.roll(ring, -1, axis=0)).T).sum()) for ring in rings)
            self.assertAlmostEqual(float(sum(areas)), pieces.volumes[k], delta=2.0**-45 * around * np.abs(rings[0]).max())

    def test_parts_that_touch_in_any_unit(self):
        """Two parts of a cell touch in a point. Products of their areas underflow in small units."""
        outline = np.array([(0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)]) + 64
        for unit in (1.0, 2.0**-250, 2.0**-300, 2.0**300):
            t = vt.tessellate(np.array([(64.125, 64.125), (64.375, 64.375)]) * unit, mesh=mesh_of([outline * unit]),
                              weights=np.array([0, -0.25 + 2**-54]) * unit * unit)
            pieces = t.pieces()
            self.assertEqual(pieces.counts.tolist(), [1, 2])
            np.testing.assert_allclose(pieces.volumes / unit / unit, [0.5, 0.125, 0.125], rtol=1e-12)

    def test_no_ring_crosses_itself(self):
        """Seeds that nearly tie, about a point, in lattices and about corners of the polygon, far from the origin too."""
        split = 0
        for number in range(90):
            random = np.random.default_rng(number)
            n = int(random.integers(2, 6))
            turns = np.arange(4 * n) * (np.pi / (2 * n))
            points = [np.stack([np.cos(turns), np.sin(turns)], axis=1) * n / 2 + n / 2,
                      np.stack(np.meshgrid(np.arange(n), np.arange(n)), axis=-1).reshape(-1, 2),
                      np.unique(random.integers(0, n + 1, (n + 3, 2)), axis=0)][number % 3]
            points = points + 10.0 ** -random.uniform(12, 17) * random.normal(size=points.shape)
            rings = [[(0, 0), (n, 0), (n, n), (n / 2, n / 2), (0, n)], [(-1, -1), (n, -1), (n, n), (-1, n)]][number % 2 :][:1]
            if number % 2:
                rings.append([(n / 2, n / 2), (n / 4, n / 2), (n / 4, 3 * n / 4), (n / 2, 3 * n / 4)][:: random.choice([1, -1])])
                if signed_area(exact(rings[1])) > 0:
                    rings[1].reverse()
            turned = random.choice([0, 0.3, np.arctan2(3, 4)])
            axes = np.array([(np.cos(turned), np.sin(turned)), (-np.sin(turned), np.cos(turned))]) * random.choice([1, 0.1])
            move = random.choice([0, 1, 1e3, 1e6])
            with self.subTest(number):
                t = vt.tessellate(points @ axes + move, mesh=mesh_of([np.array(ring) @ axes + move for ring in rings]))
                pieces = t.pieces()
                self.check_simple(pieces)
                self.check_connected(pieces)
                for row in range(len(t)):
                    volumes = pieces.volumes[pieces.indptr[row] : pieces.indptr[row + 1]]
                    self.assertTrue((np.diff(volumes) <= 0).all())
                np.testing.assert_allclose(np.bincount(pieces.cells, pieces.volumes, len(t)), t.volumes, atol=1e-12 * t.volumes.sum())
                split += (np.diff(pieces.indptr) > 1).sum()
        self.assertGreater(split, 5)

    def test_a_piece_as_narrow_as_rounding_is_two(self):
        """The inward corner of the second outline lies on the bisector by its last digits alone."""
        for away in 2.0 ** np.arange(-54, -38, 1.0):
            for move in (0.0, 1000.0):
                outline = np.array([(0, 0), (2, 0), (2, 2), (1.25, 0.5 + away), (1, 2), (0, 2)]) + move
                t = vt.tessellate(np.array([(1, 0.2), (1, 0.8)]) + move, mesh=mesh_of([outline]))
                self.check_simple(t.pieces())
                outline = np.array([(0, 0), (2, 0), (2, 2), (0, 2)]) + move
                hole = np.array([(0.5, 0.5 + away), (0.5, 1.5), (1.5, 1.5), (1.5, 0.5 + away)]) + move  # along the bisector
                pieces = vt.tessellate(np.array([(1, 0.2), (1, 0.8)]) + move, mesh=mesh_of([outline, hole])).pieces()
                self.check_simple(pieces)
                self.assertAlmostEqual(pieces.volumes.sum(), 3, 9)

    def test_the_outline_is_first_also_where_a_hole_is_longer(self):
        turns = np.arange(200) * (np.pi / 100)
        star = np.stack([np.cos(turns), np.sin(turns)], axis=1) * np.where(np.arange(200) % 2, 0.9, 0.1)[:, None]
        t = vt.tessellate([(0.95, 0.95)], mesh=mesh_of([np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]), star[::-1]]))
        self.assertEqual([len(ring) for ring in t.pieces().rings(0)], [4, 200])
        self.check_simple(t.pieces())

    def test_rings_keep_the_area_where_an_inward_corner_touches_a_side(self):
        """Two long edges beside a long one cross by their last digits."""
        outline = [(1.9900083305560516, 0.1996668332936563), (0.7953373319843695, 2.08984174720288), (0.5956704986907132, 4.079850077758931),
                   (1.6905080806155672, 3.184679329127734), (2.585678829246765, 4.279516911052588), (3.580682994524791, 4.379350327699416)]
        points = [(0.6455872070141273, 3.5823479951199184), (1.2928394146233826, 2.139758455526294), (3.730433119495033, 2.886844079782377)]
        for turned in np.linspace(0, 1, 12):
            axes = np.array([(np.cos(turned), np.sin(turned)), (-np.sin(turned), np.cos(turned))])
            mesh = {"type": "Polygon", "coordinates": [(np.array(outline)[::-1] @ axes).tolist()]}
            pieces = vt.tessellate(points @ axes, mesh=mesh).pieces()
            for k in range(len(pieces)):
                x, y = np.transpose([np.asarray(corner) for ring in pieces.rings(k)[:1] for corner in ring])
                self.assertAlmostEqual(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y), pieces.volumes[k], 12)

    def test_corners_of_polygons_keep_their_places(self):
        outline = [(0.1, 0.3), (3.7, 0.2), (4.1, 2.9), (0.7, 3.3)]
        pieces = vt.tessellate([(0.9, 0.9), (3.1, 1.7)], mesh={"type": "Polygon", "coordinates": [outline]}).pieces()
        places = {tuple(place) for k in range(2) for place in pieces.rings(k)[0].tolist()}
        self.assertTrue(set(outline) <= places)

    def test_thin_and_large_rings_turn_as_they_are(self):
        for scale in (1e-150, 1.0, 1e150):
            for thin in (1.0, 2.0**-40, 2.0**-51):
                ring = np.array([(1, 1), (2, 2), (2, 2 + thin)]) * scale
                meshes = [as_mesh({"type": "Polygon", "coordinates": [way]}) for way in (ring, ring[::-1])]
                for vertices, _ in meshes:
                    self.assertGreater(signed_area(exact(vertices)), 0)
        nested = {"type": "Polygon", "coordinates": [[(0, 0), (1, 0), (0, 1)]]}
        for _ in range(5000):
            nested = {"type": "GeometryCollection", "geometries": [nested]}
        with self.assertRaisesRegex(ValueError, "too deep"):
            as_mesh(nested)

    def test_refusals(self):
        square = [(0, 0), (1, 0), (1, 1), (0, 1)]
        points = [(0.5, 0.5)]
        for mesh, message in (
            ((square, [(0, 1), (1, 2), (2, 3)]), "vertex 0 .* begins 1 edge more than it ends: give closed rings"),
            ((square, [(1, 0), (2, 1), (3, 2), (0, 3)]), "rings run clockwise.*reverse them"),
            ((square, [(0, 1), (1, 0)]), "enclose no area"),
            ((square, np.empty((0, 2), int)), "no edges: give closed rings"),
            (([(0, 0), (1, 0), (1, np.nan)], [(0, 1), (1, 2), (2, 0)]), "vertex 2: y = nan is not finite"),
        ):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                vt.tessellate(points, mesh=mesh)
        for mesh, message in (
            ({"type": "Point", "coordinates": (0, 0)}, "the type 'Point': give polygons"),
            ({"type": "Polygon"}, "not GeoJSON of polygons"),
            ({"type": "Polygon", "coordinates": [[(0, 0), (1, 1)]]}, "ring 0 of mesh has 2 places"),
            ({"type": "FeatureCollection", "features": [
                {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [square]}},
                {"type": "Feature", "geometry": {"type": "MultiPolygon", "coordinates": [[square], [square, [(0, 0)]]]}}]},
             "feature 1, polygon 1, ring 1 of mesh has 1 place: give"),
            ({"type": "FeatureCollection", "features": []}, "no polygon"),
            ((square, [(0, 1, 2)]), r"edges of mesh have shape \(1, 3\)"),
            ((square, [(0, 1), (1, 4), (4, 0)]), "edge 1 names vertex 4"),
        ):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                vt.tessellate(points, mesh=mesh)
        with self.assertRaisesRegex(ValueError, "mesh has 2 dimensions, but points have 3"):
            vt.tessellate([(0, 0, 0)], mesh=CITY)
        with self.assertRaisesRegex(vt.VotessError, "a triclinic box needs three dimensions"):
            vt.tessellate(points, mesh=CITY, cell=((9, 0), (1, 9)))


if __name__ == "__main__":
    unittest.main()
