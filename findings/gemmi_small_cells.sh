#!/usr/bin/env bash
# gemmi's neighbor search loses neighbors where the radius is longer than the unit cell is wide.
#
# Surprise: crystals that ASE writes as CIF are read by gemmi and searched up to the radius that NeighborSearch was made for. In
#   the primitive cell of copper 24 of the 42 neighbors within 5 angstrom are found, in the cubic cell of iron 92 of 116. The
#   search visits the 27 bins around an atom, and a cell has at least three bins along each edge, so no image is farther than
#   about one cell. Tilted cells are narrower than their edges: graphite (edges 2.46, 2.46, 6.71) lacks 4 of 48 within 3 angstrom.
#   A repeated cell has all of them. Nothing is printed. Coordination numbers and distributions of distances are too small.
# Versions: gemmi 0.7.5, ASE 3.29.0
# Seen: 2026-11
# Do: repeat the cell until each of its three heights exceeds the radius, or search with ase.neighborlist.neighbor_list().
# Source: gemmi manual, "Structure analysis", "Neighbor search": it needs the largest radius and the unit cell, works with small
#   molecule structures too, and can find neighbors any number of unit cells apart.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet gemmi==0.7.5 ase==3.29.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import gemmi
import numpy as np
from ase import Atoms
from ase.build import bulk
from ase.io import write
from ase.neighborlist import neighbor_list

print({name: version(name) for name in ("gemmi", "ase")})
copper, iron = bulk("Cu"), bulk("Fe", cubic=True)
graphite = Atoms("C4", cell=[2.46, 2.46, 6.71, 90, 90, 120], pbc=True,
                 scaled_positions=[[0, 0, .25], [0, 0, .75], [1 / 3, 2 / 3, .25], [2 / 3, 1 / 3, .75]])
changed = False
for name, atoms, radius, all_of_them, stated in (("copper, primitive", copper, 3, 12, 12),
                                                 ("copper, primitive", copper, 5, 42, 24),
                                                 ("copper, 3 x 3 x 3 of them", copper * (3, 3, 3), 5, 27 * 42, 27 * 42),
                                                 ("iron, cubic", iron, 5, 116, 92),
                                                 ("graphite", graphite, 3, 48, 44),
                                                 ("graphite", graphite, 6, 376, 200)):
    write("crystal.cif", atoms)
    crystal = gemmi.read_small_structure("crystal.cif")
    search = gemmi.NeighborSearch(crystal, radius).populate()
    found = sum(len(search.find_site_neighbors(site, min_dist=.1, max_dist=radius)) for site in crystal.sites)
    by_ase = len(neighbor_list("i", atoms, float(radius)))
    heights = atoms.cell.volume / np.linalg.norm(np.cross(atoms.cell[[1, 2, 0]], atoms.cell[[2, 0, 1]]), axis=1)
    same = by_ase == all_of_them and found == stated
    changed |= not same
    print(f"{name}, {radius} angstrom: ASE {by_ase} neighbors, gemmi {found}; heights of the cell {heights.round(2).tolist()}",
          "" if same else "CHANGED")
sys.exit(changed)
EOF
