#!/usr/bin/env bash
# FloPy's Voronoi grids for the DISU package of MODFLOW 6 have lengths of twice the size: half of the water flows.
#
# Surprise: DISU asks for the length between the center of a cell and the face that it shares with each neighbor, cl12. For a Voronoi
#   grid that is half of the distance between two seeds. VoronoiGrid.get_disu6_gridprops() returns the whole distance, so every
#   conductance is half of what it should be, and so is the flow. The angles of the faces, angldegx, are compass bearings, and not
#   counted from the x axis: 90 for east and 0 for north, so conductivities along x and y change places. FloPy's own
#   get_disu_kwargs has both right for the same squares. Nothing warns. Areas, widths and neighbors are right.
# Versions: FloPy 3.11.0, triangle 20250106, SciPy 1.17.1
# Seen: 2026-11
# Do: halve cl12, and replace angldegx by (90 - angldegx) % 360; or take get_disv_gridprops(), from which MODFLOW finds both itself.
# Source: MODFLOW 6, Description of Input and Output, GWF DISU: CL12, "connection lengths between the center of cell n and the shared
#   face with each adjacent m cell"; ANGLDEGX, "zero degrees points in the positive x-axis direction". Both stand in FloPy's manual,
#   ModflowGwfdisu. FloPy manual, VoronoiGrid.get_disu6_gridprops.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet flopy==3.11.0 triangle==20250106 scipy==1.17.1 shapely==2.2.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import triangle
from flopy.utils.gridutil import get_disu_kwargs
from flopy.utils.triangle import Triangle
from flopy.utils.voronoi import VoronoiGrid
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

print({name: version(name) for name in ("flopy", "triangle", "scipy")})
size, count = 100., 10


class Meshed(Triangle):
    """A mesh by the package triangle in place of the program of that name, which FloPy runs."""

    def __init__(self, points):
        self._initialize_vars()
        self._polygons, self._holes = [[(0., 0.), (size, 0.), (size, size), (0., size)]], []
        mesh = triangle.triangulate({"vertices": points}, "ec")
        self.verts, self.iverts = mesh["vertices"], mesh["triangles"].tolist()
        self.edge = np.array([(i, *ends, mark) for i, (ends, mark) in enumerate(zip(mesh["edges"], np.ravel(mesh["edge_markers"])))],
                             dtype=[(name, int) for name in ("iedge", "endpoint1", "endpoint2", "boundary_marker")])


def connections(props):
    """Returns the two cells of each connection, its length in the first, its width and its angle."""
    off = np.ones(len(props["ja"]), bool)
    off[np.cumsum([0, *props["iac"][:-1]])] = False
    rows = np.repeat(np.arange(len(props["iac"])), props["iac"])
    return (np.asarray(each)[off] for each in (rows, props["ja"], props["cl12"], props["hwva"], props["angldegx"]))


def flow(seeds, i, j, lengths, widths):
    """Returns the flow from a head of 1 on the left to 0 on the right: 1 for a square with conductivity and thickness 1."""
    other = {(a, b): length for a, b, length in zip(i, j, lengths)}
    each = widths / (lengths + np.array([other[b, a] for a, b in zip(i, j)]))
    total = coo_matrix((np.r_[-each, each], (np.r_[i, i], np.r_[j, i])), shape=(len(seeds),) * 2).tocsr()
    fixed = np.isin(seeds[:, 0], (0, size))
    heads = np.where(seeds[:, 0] == 0, 1., 0.)
    heads[~fixed] = spsolve(total[~fixed][:, ~fixed], -total[~fixed] @ heads)
    return (total @ heads)[seeds[:, 0] == 0].sum()


line = np.arange(count + 1) * size / count
lattice = np.array([(x, y) for y in line[::-1] for x in line])
side, zero = line[:-1], np.zeros(count)
border = np.concatenate([np.c_[side, zero], np.c_[zero + size, side], np.c_[size - side, zero + size], np.c_[zero, size - side]])
inner = 4 + np.random.default_rng(1).random((300, 2)) * (size - 8)
by_structure = get_disu_kwargs(1, count + 1, count + 1, size / count, size / count, 1., [0.], return_vertices=True)
right = {(a, b): (length, angle) for a, b, length, _, angle in zip(*connections(by_structure))}
changed = False
for name, points in (("lattice", lattice), ("random", np.r_[border, inner])):
    grid = VoronoiGrid(Meshed(points))
    seeds = grid.points
    i, j, lengths, widths, angles = connections(grid.get_disu6_gridprops())
    steps = seeds[j] - seeds[i]
    halves = np.linalg.norm(steps, axis=1) / 2
    true_angles = np.degrees(np.arctan2(steps[:, 1], steps[:, 0])) % 360
    if name == "lattice":
        own = np.array([right[pair] for pair in zip(i, j)])
        agree = np.allclose(seeds, lattice) and len(i) == len(right) and np.allclose(own, np.c_[halves, true_angles])
        some = [(seeds[i[k]].tolist(), seeds[j[k]].tolist(), lengths[k], angles[k], *own[k]) for k in range(40, 44)]
        print("from, to, length and angle, those of get_disu_kwargs:", *(f"{a} {b} {c:g} {d:g}, {e:g} {f:g};" for a, b, c, d, e, f in some))
    ratios = lengths / halves
    water = flow(seeds, i, j, lengths, widths), flow(seeds, i, j, halves, widths)
    bearings = np.allclose((90 - angles) % 360, true_angles)
    same = agree and np.allclose(ratios, 2) and bearings and abs(water[0] / water[1] - .5) < 1e-6 and abs(water[1] - 1) < .02
    changed |= not same
    print(f"{name}: {len(seeds)} cells, lengths over right ones {ratios.min():.3f} to {ratios.max():.3f}, angles right "
          f"{np.mean(abs(angles - true_angles) < 1e-3):.2%}, bearings {bearings}; flow {water[0]:.4f}, with right lengths {water[1]:.4f}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
