"""Cells on small surfaces in fractions, by definition: each triangle clipped by the bisectors of all seeds.

Ties: the weight of seed i is larger by 2**(-700 (i + 1)), which is less than any difference that the inputs can make.
"""

from fractions import Fraction
from math import sqrt


def _root(parents, i):
    while parents[i] != i:
        i = parents[i]
    return i


def _groups(count, keys):
    """Returns the sets of numbers below count that share keys: pairs (key, number)."""
    parents, first = list(range(count)), {}
    for key, i in keys:
        parents[_root(parents, i)] = _root(parents, first.setdefault(key, i))
    groups = {}
    for i in range(count):
        groups.setdefault(_root(parents, i), []).append(i)
    return list(groups.values())


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _minus(a, b):
    return [x - y for x, y in zip(a, b)]


class Part:
    """A polygon in one triangle. Places are weights of its second and third vertex."""

    def __init__(self, t, seed, places, labels):
        self.t, self.seed, self.places, self.labels = t, seed, places, labels


def _clip(t, i, values):
    """Returns the part of cell i. values: by seed, at the three vertices."""
    places, labels = [(Fraction(0), Fraction(0)), (Fraction(1), Fraction(0)), (Fraction(0), Fraction(1))], [-1, -2, -3]
    for k, value in enumerate(values):
        if k == i:
            continue
        d = _minus(values[i], value)
        at = [d[0] + (d[1] - d[0]) * b + (d[2] - d[0]) * c for b, c in places]
        assert all(at)
        next_places, next_labels = [], []
        for j, (place, label) in enumerate(zip(places, labels)):
            to, f, g = places[(j + 1) % len(places)], at[j], at[(j + 1) % len(places)]
            meets = tuple(x + (y - x) * f / (f - g) for x, y in zip(place, to)) if f * g < 0 else None
            if f < 0:
                next_places.append(place)
                next_labels.append(label)
                if g > 0:
                    next_places.append(meets)
                    next_labels.append(k)
            elif g < 0:
                next_places.append(meets)
                next_labels.append(label)
        places, labels = next_places, next_labels
        if not places:
            return None
    return Part(t, i, places, labels)


class Oracle:
    """``areas``, ``lengths``, ``dual`` and so on, as dictionaries of floats and whole numbers."""

    def __init__(self, points, vertices, triangles, weights=None):
        seeds = [[Fraction(float(x)) for x in p] for p in points]
        x = [[Fraction(float(c)) for c in v] for v in vertices]
        power = [Fraction(float(w)) for w in weights] if weights is not None else [Fraction(0)] * len(seeds)
        power = [w + Fraction(1, 2 ** (700 * (i + 1))) for i, w in enumerate(power)]
        self.parts, kept, self.area_of = [], [], {}
        for t, corners in enumerate(triangles):
            u = [x[v] for v in corners]
            normal = _cross(_minus(u[1], u[0]), _minus(u[2], u[0]))
            if not any(normal):
                continue
            kept.append(t)
            self.area_of[t] = sqrt(sum(c * c for c in normal)) / 2
            values = [[sum(d * d for d in _minus(v, p)) - w for v in u] for p, w in zip(seeds, power)]
            self.parts += [part for i in range(len(seeds)) if (part := _clip(t, i, values))]
        edges = [frozenset((triangles[t][s], triangles[t][(s + 1) % 3])) for t in kept for s in range(3)]
        is_border = {edge: edges.count(edge) == 1 for edge in edges}
        n = len(seeds)
        self.areas, self.borders, self.polygons, self.dual = [0.0] * n, [0.0] * n, {}, {}
        moments = [[0.0] * 3 for _ in seeds]
        sides, of_cell = {}, [[] for _ in seeds]

        def place(t, at):
            b, c = at
            return [u + b * (v - u) + c * (w - u) for u, v, w in zip(*(x[v] for v in triangles[t]))]

        def edge_of(t, label):
            s = -1 - label
            return frozenset((triangles[t][s], triangles[t][(s + 1) % 3]))

        for part in self.parts:
            t, i, count = part.t, part.seed, len(part.places)
            of_cell[i].append(part)
            (ob, oc), share = part.places[0], Fraction(0)
            for j in range(1, count - 1):
                (vb, vc), (wb, wc) = part.places[j], part.places[j + 1]
                piece = (vb - ob) * (wc - oc) - (vc - oc) * (wb - ob)
                share += piece
                for k in range(3):
                    middle = sum(place(t, part.places[m])[k] for m in (0, j, j + 1)) / 3
                    moments[i][k] += float(piece * middle) * self.area_of[t]
            area = float(share) * self.area_of[t]
            part.keys = []
            for j in range(count):
                before, label = part.labels[j - 1], part.labels[j]
                if before < 0 and label < 0:
                    key = triangles[t][-1 - label]
                elif before < 0 or label < 0:
                    key = (edge_of(t, min(before, label)), *place(t, part.places[j]))
                else:
                    key = (t, *place(t, part.places[j]))
                    if i < before and i < label:
                        self.dual.setdefault(tuple(sorted((i, before, label))), []).append((i, before, label))
                part.keys.append(key)
            if area > 1e-100:
                self.areas[i] += area
                self.polygons[t, i] = area
            for j, label in enumerate(part.labels):
                way = _minus(place(t, part.places[(j + 1) % count]), place(t, part.places[j]))
                length = sqrt(sum(c * c for c in way))
                if label >= 0:
                    sides.setdefault((i, label), []).append((length, part.keys[j], part.keys[(j + 1) % count]))
                elif is_border[edge_of(t, label)]:
                    self.borders[i] += length
        self.centroids = [[m / a for m in moment] if a else None for moment, a in zip(moments, self.areas)]
        self.pieces, self.euler = [], []
        for own in of_cell:
            on_edges = [(edge_of(p.t, label), k) for k, p in enumerate(own) for label in p.labels if label < 0]
            self.pieces.append(len(_groups(len(own), on_edges)))
            corners = {key for part in own for key in part.keys}
            lines = {edge for edge, _ in on_edges}
            inner = sum(label >= 0 for part in own for label in part.labels)
            self.euler.append(len(corners) - len(lines) - inner + len(own))
        self.rows = {}
        for pair, of_pair in sides.items():
            length = sum(side[0] for side in of_pair)
            if length < 1e-60:
                continue
            ends = [(key, k) for k, side in enumerate(of_pair) for key in side[1:]]
            curves = _groups(len(of_pair), ends)
            keys = [key for key, _ in ends]
            loops = sum(all(keys.count(key) > 1 for k in curve for key in of_pair[k][1:]) for curve in curves)
            self.rows[pair] = (length, len(curves), loops)
