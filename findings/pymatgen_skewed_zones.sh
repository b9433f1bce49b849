#!/usr/bin/env bash
# pymatgen and ASE return Wigner-Seitz cells and Brillouin zones that are too large when the cell of the lattice is skewed.
#
# Surprise: simple cubic, given by the edges (1, 0, 0), (s, 1, 0), (0, 0, 1), is one lattice for each whole s, and its zone has
#   the volume 1. pymatgen returns 2 for s = 2 and 5 for s = 3, ASE the same. A copper cell after a shear of 1.6 has a zone of
#   1.36 times the right size, and fcc by other edges one of 1.35. Both take the Voronoi cell among the 27 lattice points with
#   indices -1, 0 and 1, of the edges as given; nearer ones have larger indices. Nothing warns. seekpath is right. Standard
#   primitive cells were right in our trials.
# Versions: pymatgen 2026.10.24, ASE 3.29.0, seekpath 2.2.2, SciPy 1.17.1
# Seen: 2026-11
# Do: reduce the cell first: lattice.get_lll_reduced_lattice(), or cell.minkowski_reduce()[0]. Compare the volume of the zone
#   with (2 pi)^3 / volume.
# Source: pymatgen manual, Lattice.get_wigner_seitz_cell ("the Wigner-Seitz cell for the given lattice") and get_brillouin_zone.
#   ASE manual, "Brillouin zone sampling", which plots the zone of any cell by bz_vertices.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pymatgen==2026.10.24 ase==3.29.0 seekpath==2.2.2 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import itertools
import sys
from importlib.metadata import version

import numpy as np
from ase.dft.bz import bz_vertices
from pymatgen.core import Lattice
from scipy.spatial import ConvexHull, Voronoi
from seekpath.brillouinzone.brillouinzone import get_BZ

print({name: version(name) for name in ("pymatgen", "ase", "seekpath", "scipy")})


def volume(corners):
    return ConvexHull(np.concatenate([np.reshape(c, (-1, 3)) for c in corners])).volume


def oracle(edges):  # the Voronoi cell of the origin among 11**3 lattice points
    index = np.array(list(itertools.product(range(-5, 6), repeat=3)))
    cells = Voronoi(index @ edges)
    return volume([cells.vertices[cells.regions[cells.point_region[len(index) // 2]]]])


changed = False
cubic, fcc = np.eye(3), 1.8 * (np.ones((3, 3)) - np.eye(3))
trials = [(f"cubic, s = {s}", np.array([[1, 0, 0], [s, 1, 0], [0, 0, 1.0]]), ratio)
          for s, ratio in ((0, 1), (1, 1), (2, 2), (3, 5))]
trials += [(f"copper, tilt {t}", np.array([[3.6, 0, 0], [3.6 * t, 3.6, 0], [0, 0, 3.6]]), ratio)
           for t, ratio in ((0.5, 1), (1.6, 1.36), (2.5, 3.25))]
trials += [("fcc, other edges", np.array([[1, 0, 0], [1, 1, 0], [0, 0, 1]]) @ fcc, 65 / 48)]
for name, edges, stated in trials:
    size = abs(np.linalg.det(edges))
    reciprocal = 2 * np.pi * np.linalg.inv(edges).T
    zone = abs(np.linalg.det(reciprocal))
    lattice = Lattice(edges)
    seen = {"oracle": oracle(edges) / size, "Wigner-Seitz of pymatgen": volume(lattice.get_wigner_seitz_cell()) / size,
            "zone of pymatgen": volume(lattice.get_brillouin_zone()) / zone,
            "zone of ASE": volume([b[0] for b in bz_vertices(reciprocal)]) / zone,
            "zone of seekpath": volume([get_BZ(*reciprocal)["triangles_vertices"]]) / zone}
    cell = 7 / 6 if name.startswith("fcc") else stated  # of real space; the others are equal to their zones
    same = np.allclose(list(seen.values()), [1, cell, stated, stated, 1], rtol=1e-6)
    changed |= not same
    print(name, {k: round(float(v), 4) for k, v in seen.items()}, "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
