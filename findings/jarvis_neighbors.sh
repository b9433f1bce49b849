#!/usr/bin/env bash
# JARVIS-tools' analysis of neighbors loses most of them: with its own default radius, and in rhombohedral cells.
#
# Surprise: NeighborsAnalysis.nbor_list() searches within 10 angstrom by default, in a cell that is repeated to 12 only, and takes
#   the nearest image of each atom: 233 of the 368 neighbors of an atom in copper. get_rdf() repeats further, by the lengths of
#   the edges, and copper is right. The primitive cell of bismuth telluride has edges of 10 angstrom and heights of 4: of its
#   pairs from 8 to 10 angstrom an eighth is left, while the hexagonal cell of the same crystal has all of them.
#   Atoms.get_all_neighbors() is right in both, but loses pairs where atoms have left the cell. Nothing warns.
# Versions: JARVIS-tools 2026.6.12, ASE 3.29.0
# Seen: 2026-11
# Do: ase.neighborlist.neighbor_list(); or for get_rdf() a conventional cell, and for get_all_neighbors() wrapped atoms.
# Source: JARVIS-tools' manual, jarvis.analysis.structure.neighbors (distributions of distances of any Atoms object; nbor_list
#   with rcut=10.0 and c_size=12.0) and jarvis.core.atoms, get_all_neighbors ("out to a distance r").
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet jarvis-tools==2026.6.12 ase==3.29.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
from ase import Atoms
from ase.build import bulk, make_supercell
from ase.neighborlist import neighbor_list
from jarvis.analysis.structure.neighbors import NeighborsAnalysis
from jarvis.core.atoms import ase_to_atoms

print({name: version(name) for name in ("jarvis-tools", "ase")})
u, v = .4, .21
primitive = Atoms("Bi2Te3", scaled_positions=np.outer([u, -u, 0, v, -v], [1, 1, 1]) % 1, cell=[10.48] * 3 + [24.16] * 3, pbc=True)
crystals = {"copper": bulk("Cu", cubic=True), "bismuth telluride, primitive": primitive,
            "bismuth telluride, hexagonal": make_supercell(primitive, [[1, -1, 0], [0, 1, -1], [1, 1, 1]])}
stated = {"copper": (.6, .7, .99, 1.01), "bismuth telluride, primitive": (.1, .3, .05, .2),
          "bismuth telluride, hexagonal": (.6, .8, .99, 1.01)}  # least and largest share of the neighbors, then of far pairs
changed = False
for name, crystal in crystals.items():
    analysis = NeighborsAnalysis(ase_to_atoms(crystal))
    share = analysis.nbor_list()["nn"].mean() / (len(neighbor_list("i", crystal, 10.)) / len(crystal))
    start, rdf, _ = analysis.get_rdf()
    edges = np.append(start, start[-1] + .1)
    count = np.histogram(neighbor_list("d", crystal, 10.2), edges)[0] / len(crystal)
    right = count / (4 / 3 * np.pi * np.diff(edges ** 3)) * crystal.get_volume() / len(crystal)
    near, far = (float(rdf[part].sum() / right[part].sum()) for part in (start < 5.95, (start > 7.95) & (start < 9.85)))
    least, largest, far_least, far_largest = stated[name]
    same = least < share < largest and abs(near - 1) < .01 and far_least < far < far_largest
    changed |= not same
    print(f"{name}: nbor_list() has {share:.0%} of the neighbors; get_rdf() has {near:.1%} of the pairs up to 6 and {far:.1%} of those "
          "from 8 to 10 angstrom", "" if same else "CHANGED")
inside = crystals["copper"].repeat(3)
outside = inside.copy()
outside.positions += np.random.default_rng(1).integers(-2, 3, (len(inside), 3)) @ inside.cell[:]
numbers = [(sum(map(len, ase_to_atoms(atoms).get_all_neighbors(5.))), len(neighbor_list("i", atoms, 5.))) for atoms in (inside, outside)]
same = numbers[0][0] == numbers[0][1] == numbers[1][1] > numbers[1][0]
changed |= not same
print(f"get_all_neighbors() and ASE: {numbers[0]} with wrapped atoms, {numbers[1]} with the same ones moved by edges of the cell", ""
      if same else "CHANGED")
sys.exit(bool(changed))
EOF
