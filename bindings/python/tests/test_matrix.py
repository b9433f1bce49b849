"""Every kind of domain with every output and place: an answer that another way confirms, or the refusal that README states.

README's table "What does not go together" names the refused pairs. Each output has tests of its own beside this one, with
exact oracles; here the oracles are short, and what counts is that no pair is forgotten.
"""

import importlib.util
import itertools
import re
import tempfile
import unittest
from pathlib import Path

import numpy as np
from helpers import CELL, CUBE

import pyvotess as vt

INF = float("inf")
COUNT = 60
ROOT = Path(__file__).resolve().parents[3]
FULL = "neighbors,volumes,centroids,counts,areas,normals,surfaces,radii,faces"


class Kind:
    """A kind of domain, with sixty seeds in it."""

    def __init__(self, name, dimensions=3, periods=(), inside=None, size=None, seeds=None, like=None, **keywords):
        self.like = like or name  # in README
        self.name, self.keywords, self.periods, self.size = name, keywords, np.array(periods, float), size
        self.dimensions = dimensions
        if seeds is None:
            seeds = np.random.default_rng(5).random((COUNT, dimensions)) * 0.98 + 0.01
        self.seeds = seeds
        self.inside = inside if inside is not None else lambda places: np.all((places > 0) & (places < 1), axis=1)
        self.open = size is None  # cells reach infinity
        self.in_mesh = "mesh" in keywords
        self.weights = np.random.default_rng(6).random(COUNT) * 0.004

    def images(self, reach=2):
        """Returns the shifts of the images of the seeds, as vectors."""
        if not len(self.periods):
            return np.zeros((1, self.dimensions))
        axes = [np.arange(-reach, reach + 1)] * len(self.periods)
        return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(self.periods)) @ self.periods

    def powers(self, places, weights):
        """Returns the least power of each seed or image of it at each place, (Q, N)."""
        shift = self.images()
        best = np.full((len(places), len(self.seeds)), INF)
        for s in shift:
            d = places[:, None, :] - (self.seeds + s)[None, :, :]
            best = np.minimum(best, (d**2).sum(2))
        return best - (0 if weights is None else weights)

    def places(self, count, seed=9):
        """Returns places inside."""
        random = np.random.default_rng(seed)
        found = np.empty((0, self.dimensions))
        while len(found) < count:
            some = random.random((4 * count, self.dimensions)) * 1.2 - 0.1
            found = np.concatenate([found, some[self.inside(some)]])
        return found[:count]


def everywhere(places):
    return np.ones(len(places), bool)


SQUARE = ((0, 0), (1, 1))
SLANTED = np.array([(1, 0.1, 0.2), (0.3, 0.9, 0), (0, 0, 0)])
# An octahedron without its tips.
ROUND = np.array([(x, y, z, 0.6 + (x + y + z) / 2) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
ROUND_VOLUME = 4 / 3 * 0.6**3 - 6 * 0.02 * 0.1 / 3
OUTER = np.random.default_rng(5).random((COUNT, 3)) * 1.4 - 0.2


def hull_of(seeds):
    """Returns a test of being inside and the volume of the convex hull, from all triples of seeds in general position."""
    triples = np.array(list(itertools.combinations(range(len(seeds)), 3)))
    a, b, c = (seeds[triples[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    heights = np.einsum("tk,nk->tn", normals, seeds) - np.einsum("tk,tk->t", normals, a)[:, None]
    low, high = heights.min(1) >= -1e-12, heights.max(1) <= 1e-12
    sides = low | high
    normals, a = normals[sides] * np.where(low[sides], -1, 1)[:, None], a[sides]
    middle = seeds.mean(0)
    volume = np.einsum("tk,tk->t", normals, a - middle).sum() / 6
    return lambda places: np.all(np.einsum("tk,qk->qt", normals, places) < np.einsum("tk,tk->t", normals, a), axis=1), volume


def kinds():
    seeds = np.random.default_rng(5).random((COUNT, 3)) * 0.98 + 0.01
    inside_hull, hull_volume = hull_of(seeds)
    unit = np.eye(3)
    inner = lambda low, high: lambda places: np.all((places > low) & (places < high), axis=1)  # noqa: E731
    return [
        Kind("box", size=1, box=(0, 0, 0, 1, 1, 1)),
        Kind("periodic", size=1, periods=unit, inside=everywhere, box=(0, 0, 0, 1, 1, 1), periodic=True),
        Kind("slab", size=1, periods=unit[:2], inside=lambda p: (p[:, 2] > 0) & (p[:, 2] < 1), box=(0, 0, 0, 1, 1, 1), periodic="xy"),
        Kind("triclinic", size=1, periods=CELL, inside=everywhere, cell=CELL, periodic=True, seeds=seeds @ np.array(CELL)),
        Kind("walls", size=ROUND_VOLUME, inside=lambda p: np.all(p @ ROUND[:, :3].T < ROUND[:, 3], axis=1) & np.all((p > 0) & (p < 1), axis=1),
             box=(0, 0, 0, 1, 1, 1), walls=ROUND, seeds=seeds * 0.3 + 0.35),
        Kind("outside", size=1, box=(0, 0, 0, 1, 1, 1), outside="keep", seeds=OUTER),
        Kind("hull", size=hull_volume, inside=inside_hull, box="hull"),
        Kind("space", inside=everywhere, box="none"),
        Kind("slab without end", inside=everywhere, periods=unit[:2], box=(0, 0, -INF, 1, 1, INF), periodic="xy"),
        Kind("cell that lacks an edge", like="slab without end", inside=everywhere, periods=SLANTED[:2], cell=SLANTED),
        Kind("plane", 2, size=1, box=SQUARE),
        Kind("periodic plane", 2, size=1, inside=everywhere, periods=unit[:2, :2], box=SQUARE, periodic=True),
        Kind("plane without end", 2, inside=everywhere, box="none"),
        Kind("mesh", size=0.512, inside=inner(0.1, 0.9), mesh=(CUBE[0] * 0.8 + 0.1, CUBE[1]), box=(0, 0, 0, 1, 1, 1)),
        Kind("polygons", 2, size=0.8836, inside=inner(0.03, 0.97), box=SQUARE,
             mesh=([(0.03, 0.03), (0.97, 0.03), (0.97, 0.97), (0.03, 0.97)], [(0, 1), (1, 2), (2, 3), (3, 0)])),
    ]


def finite(values):
    return np.asarray(values)[np.isfinite(values)]


class Outputs:
    """Each method makes one output of a kind of domain, and returns whether another way confirms it."""

    def __init__(self, kind, weighted):
        self.kind, self.weights = kind, kind.weights if weighted else None
        self.given = dict(kind.keywords, **({"weights": self.weights} if weighted else {}))
        self.made = {}

    def run(self, want="neighbors,volumes", **more):
        key = (want, *sorted(more))
        if key not in self.made:
            self.made[key] = vt.tessellate(self.kind.seeds, want=want, **self.given, **more)
        return self.made[key]

    def diagram(self):
        if "diagram" not in self.made:
            self.made["diagram"] = vt.Diagram(self.kind.seeds, **self.given)
        return self.made["diagram"]

    def owners(self, places):
        return self.kind.powers(places, self.weights).argmin(1)

    def is_size(self, total):
        return np.isclose(total, self.kind.size, rtol=1e-9)

    def lists(self):
        t = self.run()
        for place, owner in zip(self.kind.places(50), self.owners(self.kind.places(50))):
            second = np.argsort(self.kind.powers(place[None], self.weights)[0])[1]
            if t.status[owner] == vt.CellStatus.CERTIFIED and second in t.neighbors[owner]:
                return True  # most places are near a face
        return False

    def sizes(self):
        t = self.run(FULL if not self.kind.in_mesh else "neighbors,volumes,centroids,areas,surfaces")
        cells = np.isfinite(t.volumes) & (t.volumes > 0)
        self.assert_cells_hold_their_centroids(t, cells)
        return (self.kind.open and np.isinf(t.volumes).any()) or self.is_size(t.volumes.sum())

    def assert_cells_hold_their_centroids(self, t, cells):
        ids = np.flatnonzero(cells)
        if len(ids) and not np.array_equal(self.owners(t.centroids[ids]), ids):
            raise AssertionError("a centroid lies in another cell")

    def polygons(self):
        if self.kind.in_mesh:
            return self.is_size(self.run().pieces().volumes.sum())
        t = self.run(FULL)
        corners = t.vertices[t.faces.indices[t.faces.indices >= 0]]
        own = self.kind.powers(corners, self.weights)
        cell = np.repeat(np.arange(COUNT), np.diff(t.neighbors.indptr))
        cell = np.repeat(cell, np.diff(t.faces.indptr))[t.faces.indices >= 0]
        return len(cell) > 0 and np.allclose(own[np.arange(len(cell)), cell], own.min(1), atol=1e-8)

    def only(self):
        ids = np.array([7, 3, 50])
        some, whole = self.run(only=ids), self.run()
        return all(np.array_equal(some.neighbors[k], whole.neighbors[i]) for k, i in enumerate(ids)) and np.array_equal(
            some.volumes, whole.volumes[ids]
        )

    def verify(self):
        return self.run().verify(sample=COUNT).passed

    def verify_of_a_subset(self):
        return self.run(only=np.array([7, 3, 50])).verify(sample=COUNT).passed

    def min_face(self):
        t, whole = self.run("neighbors,volumes,areas", min_area=0.02), self.run("neighbors,volumes,areas")
        kept = whole.face_areas >= 0.02
        return 0 < kept.sum() < len(kept) and np.array_equal(whole.face_areas[kept], t.face_areas)

    def watershed(self):
        """Its cores are the seeds without a lower neighbor."""
        t, values = self.run(), np.random.default_rng(8).permutation(COUNT).astype(float)
        cells = np.flatnonzero(t.status == vt.CellStatus.CERTIFIED)
        low = [i for i in cells if np.all(values[t.neighbors[i]] >= values[i])]
        return np.array_equal(np.sort(t.watershed(values).cores), low)

    def delaunay(self):
        """Spheres are empty."""
        t = self.run("neighbors,faces")
        dual = t.delaunay()
        simplices = dual.triangles if self.kind.dimensions == 2 else dual.tetrahedra
        centers = t.vertices[dual.centers]
        powers = self.kind.powers(centers, self.weights)
        own = np.take_along_axis(powers, simplices, 1)
        return len(simplices) > 0 and np.allclose(own, powers.min(1)[:, None], atol=1e-8)

    def network(self):
        net = self.run("neighbors,faces").network()
        room = np.full(len(net.points), INF)  # up to the nearest sphere
        for shift in self.kind.images():
            away = np.linalg.norm(net.points[:, None] - (self.kind.seeds + shift), axis=2)
            room = np.minimum(room, (away - (0 if self.weights is None else np.sqrt(self.weights))).min(1))
        return len(net.edges) > 0 and np.allclose(net.vertex_radii, room, atol=1e-8)

    def alpha(self):
        partly = 0 < len(self.kind.periods) < self.kind.dimensions  # few seeds along the axes that repeat
        complex_ = self.run("neighbors,faces").alpha_complex(3 if partly else 1)
        edges, values = complex_.simplices[1], complex_.values[1]
        if self.weights is not None or len(self.kind.periods):
            return len(edges) > 0 and np.all(np.diff([len(v) for v in complex_.values]) != 0)
        lengths = ((self.kind.seeds[edges[:, 0]] - self.kind.seeds[edges[:, 1]]) ** 2).sum(1) / 4
        return len(edges) > 0 and np.allclose(values[complex_.gabriel[1]], lengths[complex_.gabriel[1]])

    def derivatives(self):
        """Against a difference of volumes."""
        t = self.run("neighbors,volumes" if self.kind.in_mesh else "neighbors,volumes,faces")
        more = {"open": "skip"} if self.kind.open else {}
        matrix = t.derivatives("volumes", **more).toarray()
        step, seed = 1e-6, 11
        moved = [self.kind.seeds.copy() for _ in range(2)]
        moved[0][seed, 0] += step
        moved[1][seed, 0] -= step
        a, b = (vt.tessellate(points, **self.given).volumes for points in moved)
        with np.errstate(invalid="ignore"):
            slope = (a - b) / (2 * step)
        known = np.isfinite(slope) & np.isfinite(t.volumes)
        return np.any(slope[known] != 0) and np.allclose(matrix[known, self.kind.dimensions * seed], slope[known], atol=1e-5)

    def lloyd(self):
        given = {key: value for key, value in self.kind.keywords.items()}
        one = vt.lloyd(self.kind.seeds, steps=1, **given)
        t = vt.tessellate(self.kind.seeds, want="neighbors,volumes,centroids", **given)
        cells = np.isfinite(t.centroids[:, 0])
        apart = (one.points - t.centroids)[cells]
        if len(self.kind.periods):
            turns = np.linalg.solve(np.array(self.kind.periods)[:, : len(self.kind.periods)].T, apart[:, : len(self.kind.periods)].T).T
            apart -= np.round(turns) @ np.array(self.kind.periods)
        return cells.sum() > 20 and abs(apart).max() < 1e-9

    def fit_volumes(self):
        given = {key: value for key, value in self.kind.keywords.items()}
        fit = vt.fit_volumes(self.kind.seeds, np.ones(COUNT), normalize=True, **given)
        return np.allclose(fit.tessellation.volumes, self.kind.size / COUNT)

    def masses(self):
        """The parts of the domain in the boxes of the grid have them too."""
        t, values = self.run("neighbors,volumes" if self.kind.in_mesh else "faces"), np.random.default_rng(8).random((4,) * self.kind.dimensions)
        masses = t.masses(values)
        size = abs(np.linalg.det(t.cell)) if t.cell is not None else np.prod(t.box[1] - t.box[0])
        return np.isclose(masses.masses.sum(), (self.diagram().to_grid(np.ones(COUNT), 4) * values).mean() * size)

    def locate(self):
        places = self.kind.places(40)
        return np.array_equal(self.diagram().locate(places), self.owners(places))

    def probe(self):
        place = self.kind.places(5)
        weights = None if self.weights is None else np.full(5, 0.001)
        probes = self.diagram().probe(place, **({} if weights is None else {"weights": weights}))
        given = dict(self.given)
        if weights is not None:
            given["weights"] = np.append(self.weights, 0.001)
        if self.kind.name == "hull":
            return bool(np.all(probes.volumes > 0))
        t = vt.tessellate(np.concatenate([self.kind.seeds, place[:1]]), **given)
        return np.array_equal(t.neighbors[COUNT], probes.neighbors[0]) and np.isclose(t.volumes[COUNT], probes.volumes[0])

    def natural_neighbors(self):
        """Sibson's weights sum to one, and give back a linear field away from walls."""
        places = self.kind.places(200)
        if self.kind.like == "slab without end":  # so few seeds know no coordinates where the cell of a query is as wide
            places = places[(places[:, 2] > 0.3) & (places[:, 2] < 0.7)]
        found = self.diagram().natural_neighbors(places, at_walls=False)
        good = 0
        for q, place in enumerate(places):
            seeds = found.neighbors[q]
            weights = found.weights[found.neighbors.indptr[q] : found.neighbors.indptr[q + 1]]
            if len(seeds) == 0:
                continue
            if not np.isclose(weights.sum(), 1):
                return False
            if not len(self.kind.periods) and self.weights is None:
                good += np.allclose(weights @ self.kind.seeds[seeds], place)
            else:
                good += 1
        return good > 5

    def grid(self, method):
        return self.diagram().to_grid(np.ones(COUNT), 4, method)

    def grids(self):
        grid = finite(self.grid("nearest"))  # 0 or nothing beyond walls
        return grid.max() == 1 and np.all((grid == 0) | (grid == 1))

    def dtfe(self):
        import warnings

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            grid = self.grid("dtfe")
        if len(self.kind.periods) == self.kind.dimensions and self.weights is None:  # no mass is lost
            return np.isclose(grid.mean() * self.kind.size, COUNT)
        return bool(np.all(finite(grid) >= 0) and finite(grid).max() > 0)

    def trace(self):
        origin = self.kind.places(6)
        target = self.kind.places(6, 10)
        way = target - origin
        rays = self.diagram().trace(origin, way, lengths=np.linalg.norm(way, axis=1), middles=True)
        for r in range(6):
            part = slice(rays.offsets[r], rays.offsets[r + 1])
            ends = np.concatenate([[0], np.cumsum(rays.lengths[part])])
            if not np.isclose(ends[-1], np.linalg.norm(way[r])):
                return False
            middles = origin[r] + np.outer((ends[1:] + ends[:-1]) / 2, way[r] / np.linalg.norm(way[r]))
            if not np.array_equal(self.owners(middles), rays.seeds[part]):
                return False
        return True

    def vtu(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "cells.vtu"
            more = {"open": "skip"} if self.kind.open else {}
            self.run("neighbors,volumes,faces" if not self.kind.in_mesh else "neighbors,volumes").save(path, **more)
            count = int(re.search(rb'NumberOfCells="(\d+)"', path.read_bytes())[1])
        return 10 < count <= 2 * COUNT if not self.kind.in_mesh else count > 10

    def groups(self):
        """Two halves share the area that their seeds do."""
        t = self.run("neighbors,volumes,areas,surfaces")
        half = np.arange(COUNT) % 2
        found = t.groups(half)
        cells = np.repeat(np.arange(COUNT), np.diff(t.indptr))
        between = (t.indices >= 0) & (half[cells] != half[t.indices])
        return np.allclose(found.areas[-1], t.face_areas[between].sum() / 2) and np.allclose(
            found.volumes, [t.volumes[half == k].sum() for k in (0, 1)]
        )

    def shapes(self):
        """Sphericity has a closed form of volume and surface."""
        t = self.run("neighbors,volumes,surfaces" if self.kind.in_mesh else "neighbors,volumes,surfaces,faces")
        s = t.shapes(**({"open": "skip"} if self.kind.open else {}))
        held = np.isfinite(s.sphericity)
        volumes, surfaces = t.volumes[held], t.surface_areas[held]
        ball = (36 * np.pi * volumes**2) ** (1 / 3) if self.kind.dimensions == 3 else 2 * np.sqrt(np.pi * volumes)
        return held.sum() > 10 and np.allclose(s.sphericity[held], ball / surfaces)

    def solver_file(self, name, pattern):
        with tempfile.TemporaryDirectory() as folder:
            more = {"open": "skip"} if self.kind.open else {}
            t = self.run("neighbors,volumes" if self.kind.in_mesh else "neighbors,volumes,faces")
            t.save(Path(folder) / name, **more)
            path = Path(folder) / ("constant/polyMesh/owner" if name.endswith(".foam") else name)
            count = int(re.search(pattern, path.read_text())[1])
        if self.kind.in_mesh:
            return count == len(t.pieces())
        return count == np.count_nonzero((t.volumes > 0) & np.isfinite(t.volumes))

    def foam(self):
        return self.solver_file("case.foam", r"nCells:(\d+)")

    def msh(self):
        return self.solver_file("a.msh", r"\$Entities\n\d+ \d+ \d+ (\d+)")

    def tess(self):
        return self.solver_file("a.tess", r"\*\*polyhedron\n *(\d+)")

    def stream(self):
        rows = {}

        def take(part):
            for k in range(len(part.status)):
                rows[part.first + k] = part.neighbors[k].tolist()

        given = dict(self.given)
        points = self.kind.seeds
        if given.pop("weights", None) is not None:
            points = (points, self.weights)
            given["beside"] = "weights"
        vt.tessellate_stream([points], take, memory=10**8, **given)
        t = self.run()
        return all(rows[i] == t.neighbors[i].tolist() for i in range(COUNT))


OUTPUTS = [name for name in vars(Outputs) if not name.startswith("_") and name not in
           ("run", "diagram", "owners", "is_size", "assert_cells_hold_their_centroids", "grid", "solver_file")]


def refused_in_readme():
    """Returns the pairs that README names, as (domain, output)."""
    text = (ROOT / "README.md").read_text()
    found = set()
    for domains, outputs in re.findall(r"^\| ([^|]+) \| ([^|]+) \| [^|]+\|$", text.partition("What does not go together")[2], re.MULTILINE):
        for domain in domains.split(", "):
            found |= {(domain, output.replace(" ", "_")) for output in outputs.split(", ")}
    return found


@unittest.skipUnless((ROOT / "README.md").is_file(), "README.md is not there")
class Matrix(unittest.TestCase):
    def test_each_pair_is_answered_or_named(self):
        refused = refused_in_readme()
        for kind in kinds():
            for weighted in (False, True):
                made = Outputs(kind, weighted)
                for output in OUTPUTS:
                    if output == "derivatives" and importlib.util.find_spec("scipy") is None:
                        continue
                    with self.subTest(domain=kind.name, output=output, weighted=weighted):
                        if (kind.like, output) in refused:
                            with self.assertRaises((vt.VotessError, ValueError, TypeError)):  # or has no such parameter
                                getattr(made, output)()
                        else:
                            self.assertTrue(getattr(made, output)())


if __name__ == "__main__":
    unittest.main()
