"""Outputs of the plane by definition, in rational arithmetic: for small sets whose seeds lie inside the domain."""

import itertools
from fractions import Fraction

import numpy as np

REACH = 2  # box vectors


class Seeds:
    """The seeds that have a cell, and their images, as fractions."""

    def __init__(self, t, points):
        self.t = t
        self.points = [tuple(map(Fraction, row)) for row in points.tolist()]
        self.weights = [Fraction(0)] * len(points) if t.weights is None else list(map(Fraction, t.weights.tolist()))
        if t.cell is not None:
            self.edges = [tuple(map(Fraction, row)) for row in t.cell.tolist()]
        elif any(t.periodic):
            lower, upper = ([Fraction(x) for x in row] for row in t.box.tolist())
            self.edges = [(upper[0] - lower[0], 0), (0, upper[1] - lower[1])]
        else:
            self.edges = [(0, 0), (0, 0)]
        reach = [range(-REACH, REACH + 1) if repeats else (0,) for repeats in t.periodic]
        self.shifts = list(itertools.product(*reach))
        self.alive = [i for i in range(len(points)) if t.status[i] == 0]

    def place(self, seed, shift=(0, 0)):
        return tuple(self.points[seed][k] + sum(int(s) * e[k] for s, e in zip(shift, self.edges)) for k in range(2))

    def images(self):
        """Yields seed, shift and place."""
        for i in self.alive:
            for shift in self.shifts:
                yield i, shift, self.place(i, shift)

    def circle(self, members):
        """Returns center and squared radius of the smallest circle orthogonal to the members: seeds with shifts."""
        (x, y), own = self.place(*members[0]), self.weights[members[0][0]]
        rows = []
        for member in members[1:]:
            a, b = self.place(*member)
            rows.append((a - x, b - y, ((a - x) ** 2 + (b - y) ** 2 + own - self.weights[member[0]]) / 2))
        if not rows:
            u = v = Fraction(0)
        elif len(rows) == 1:
            (a, b, h), = rows
            u, v = a * h / (a * a + b * b), b * h / (a * a + b * b)
        else:
            (a, b, h), (c, d, g) = rows
            u, v = (h * d - b * g) / (a * d - b * c), (a * g - h * c) / (a * d - b * c)
        return (x + u, y + v), u * u + v * v - own

    def power(self, center, square, seed, place):
        """Returns the power of a seed against a circle: negative inside, 0 where it is orthogonal."""
        return (place[0] - center[0]) ** 2 + (place[1] - center[1]) ** 2 - self.weights[seed] - square


def cross(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def cut(polygon, a, b, h):
    """Returns the part of a polygon where a x + b y <= h."""
    sides = [a * x + b * y - h for x, y in polygon]
    part = []
    for k, (x, y) in enumerate(polygon):
        (u, v), s, before = polygon[k - 1], sides[k], sides[k - 1]
        if (s > 0) != (before > 0):
            share = before / (before - s)
            part.append((u + share * (x - u), v + share * (y - v)))
        if s <= 0:
            part.append((x, y))
    return part


def moments(polygon):
    """Returns the integrals of 1, x, y and x^2 + y^2."""
    sums = [Fraction(0)] * 4
    for (a, b), (c, d) in zip(polygon, polygon[1:] + polygon[:1]):
        twice = a * d - b * c
        terms = (twice / 2, twice * (a + c) / 6, twice * (b + d) / 6, twice * (a * a + a * c + c * c + b * b + b * d + d * d) / 12)
        sums = [s + t for s, t in zip(sums, terms)]
    return sums


def simplices_of(dual):
    """Returns triangles and polygons as lists of (seed, shift), and their vertices."""
    found = []
    for k, row in enumerate(dual.triangles.tolist()):
        shifts = [(0, 0)] * 3 if dual.shifts is None else list(map(tuple, dual.shifts[k].tolist()))
        found.append((list(zip(row, shifts)), int(dual.centers[k])))
    for k, row in enumerate(dual.polytopes):
        begin = dual.polytopes.indptr[k]
        shifts = [(0, 0)] * len(row)
        if dual.polytope_shifts is not None:
            shifts = list(map(tuple, dual.polytope_shifts[begin : begin + len(row)].tolist()))
        found.append((list(zip(row.tolist(), shifts)), int(dual.polytope_centers[k])))
    return found


def hull_area(points):
    """Returns the area of the convex hull."""
    ordered = sorted(set(points))
    chain = []
    for part in (ordered, ordered[::-1]):
        side = []
        for x in part:
            while len(side) > 1 and cross(side[-2], side[-1], x) <= 0:
                side.pop()
            side.append(x)
        chain += side[:-1]
    return sum((a[0] * b[1] - a[1] * b[0] for a, b in zip(chain, chain[1:] + chain[:1])), Fraction(0)) / 2


def check_delaunay(t, points):
    """Returns the number of triangles and polygons. Raises AssertionError unless they are the dual.

    Without end or in a fully periodic domain they fill the hull or the domain. Elsewhere those with a center inside, off the
    walls, must be there; ``check_in_box()`` compares with the plane without end.
    """
    seeds, dual = Seeds(t, points), t.delaunay()
    area = Fraction(0)
    for members, vertex in simplices_of(dual):
        places = [seeds.place(*m) for m in members]
        assert members[0][0] == min(m[0] for m in members), members
        for k in range(len(places)):  # strictly convex, counterclockwise
            assert cross(places[k - 2], places[k - 1], places[k]) > 0, members
        area += sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(places, places[1:] + places[:1])) / 2
        center, square = seeds.circle(members[:3])
        on = set()
        for seed, shift, place in seeds.images():
            power = seeds.power(center, square, seed, place)
            assert power >= 0, (members, seed, shift)
            if power == 0:
                on.add((seed, shift))
        inside = {m for m in members if max(map(abs, m[1])) <= REACH}
        assert inside <= on and all(m in set(members) for m in on), (members, on)
        vertex_place = t.vertices[vertex]
        size = max(1, abs(float(center[0])), abs(float(center[1])))
        assert np.abs(vertex_place - [float(x) for x in center]).max() < 1e-9 * size, (members, vertex_place, center)
    if all(t.periodic):
        assert area == abs(seeds.edges[0][0] * seeds.edges[1][1] - seeds.edges[0][1] * seeds.edges[1][0]), area
    elif np.isinf(t.box).all():
        assert area == hull_area([seeds.points[i] for i in seeds.alive]), area
    return len(dual.triangles), len(dual.polytopes)


def check_network(t, points):
    """Returns the number of edges. Raises AssertionError unless vertices and edges have their room.

    The radii of a power diagram are lower bounds inside of the spheres.
    """
    n = t.network()
    radii = np.zeros(len(t)) if t.weights is None else np.sqrt(t.weights)
    alive = t.status == 0
    edges = t.cell if t.cell is not None else np.diag(np.where(t.periodic, t.box[1] - t.box[0], 0))
    moves = np.array(list(itertools.product(*(range(-3, 4) if repeats else (0,) for repeats in t.periodic)))) @ edges
    centers = (points[alive] + moves[:, None]).reshape(-1, 2)
    radius = np.tile(radii[alive], len(moves))

    def room(a, b):
        along = b - a
        part = np.clip((centers - a) @ along / max(along @ along, 1e-300), 0, 1)
        return (np.linalg.norm(centers - a - part[:, None] * along, axis=1) - radius).min()

    size = np.abs(n.points).max(initial=1)
    for v, place in enumerate(n.points):
        expected = room(place, place)
        assert expected < 0 or abs(n.vertex_radii[v] - expected) < 1e-11 * size, (v, n.vertex_radii[v], expected)
    for e, (i, _) in enumerate(n.edges.tolist()):
        expected = room(n.points[i], n.points[i] + n.vectors[e])
        assert n.edge_radii[e] < 0 or abs(n.edge_radii[e] - expected) < 1e-11 * size, (e, n.edge_radii[e], expected)
    if all(t.periodic):  # Euler's formula on the torus
        assert len(n.points) - len(n.edges) + alive.sum() == 0
        assert (np.bincount(n.edges.ravel(), minlength=len(n.points)) >= 3).all()
    return len(n.edges)


def check_alpha(t, points):
    """Returns the complex. Raises AssertionError unless it is closed, and values and flags are those of the circles."""
    seeds, a = Seeds(t, points), t.alpha_complex()
    rows = [list(map(tuple, simplices.tolist())) for simplices in a.simplices]
    assert len(rows) == 3 and all(r == sorted(set(r)) for r in rows)
    members = []
    for k, simplices in enumerate(rows):
        shifts = [[(0, 0)] * (k + 1)] * len(simplices) if a.shifts is None else a.shifts[k].tolist()
        members.append([[(i, tuple(s)) for i, s in zip(row, shift)] for row, shift in zip(simplices, shifts)])
    own = {}  # value of each simplex
    for k in (2, 1, 0):
        above = {}
        if k < 2:
            for row in rows[k + 1]:
                for omitted in range(k + 2):
                    face = row[:omitted] + row[omitted + 1 :]
                    above[face] = min(own[row], above.get(face, own[row]))
            assert k == 0 or set(above) <= set(rows[k])
        for number, row in enumerate(rows[k]):
            center, square = seeds.circle(members[k][number])
            powers = [seeds.power(center, square, seed, place) for seed, _, place in seeds.images()]
            empty = min(powers) >= 0
            value = square if empty else above[row]
            assert bool(a.gabriel[k][number]) == empty, (row, empty)
            scale = max(abs(value), max(map(abs, seeds.weights)), Fraction(1, 10**300))
            assert abs(Fraction(float(a.values[k][number])) - value) <= scale * Fraction(1, 10**12), (row, value)
            own[row] = value
    assert sorted(i for i, in rows[0]) == seeds.alive
    return a
