#!/usr/bin/env bash
# MDAnalysis turns the cell of FHI-aims and DL_POLY files and leaves the atoms: copper has neighbors at 0.44 angstrom.
#
# Surprise: both formats state three edges in any orientation, and primitive cells of cubic metals are written so. MDAnalysis
#   keeps lengths and angles, from which its vectors follow with the first edge along x. The positions stay where they were, so
#   the lattice is another one. ASE writes 27 atoms of copper, silicon, iron. MDAnalysis finds distances of 0.44, 0.66 and 0.83 for
#   2.55, 2.35 and 2.49, while volume, lengths and angles are right. Nothing warns. OVITO reads the files as they are. Magnesium,
#   whose first edge lies along x, is right.
# Versions: MDAnalysis 2.11.0, ASE 3.29.0, OVITO 3.17.2
# Seen: 2026-11
# Do: before writing, atoms.set_cell(atoms.cell.standard_form()[0], scale_atoms=True). Or give MDAnalysis arrays turned alike.
# Source: FHI-aims manual, geometry.in: lattice_vector x y z. DL_POLY manual, "The CONFIG file": imcon 3, parallelepiped, cell
#   vectors by their components. MDAnalysis manual, lib.mdamath.triclinic_vectors: the first vector lies along x.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet mdanalysis==2.11.0 ase==3.29.0 ovito==3.17.2 numpy==2.4.6
export QT_QPA_PLATFORM=offscreen

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import MDAnalysis
import numpy as np
from ase import Atoms
from ase.build import bulk
from ase.io import write
from ase.neighborlist import neighbor_list
from MDAnalysis.lib.distances import self_capped_distance
from ovito.io import import_file

print({name: version(name) for name in ("mdanalysis", "ase", "ovito")})


def nearest(atoms):
    return neighbor_list("d", atoms, 5.).min()


changed = False
for symbol, stated in (("Cu", .438), ("Si", .659), ("Fe", .828), ("Mg", 3.198)):
    crystal = bulk(symbol) * (3, 3, 3)
    write("aims.tmp", crystal, format="aims")
    with open("geometry.in", "w") as file:  # MDAnalysis refuses comments
        file.writelines(line for line in open("aims.tmp") if line.strip() and not line.startswith("#"))
    write("a.config", crystal, format="dlp4")
    for path, kind in (("geometry.in", "IN"), ("a.config", "CONFIG")):
        universe = MDAnalysis.Universe(path, format=kind, topology_format=kind)
        found = self_capped_distance(universe.atoms.positions, 4., box=universe.dimensions)[1].min()
        data = import_file(path).compute()
        by_ovito = nearest(Atoms(len(crystal) * ["X"], data.particles.positions[...], cell=data.cell[:, :3].T, pbc=True))
        right = nearest(crystal)
        same = abs(by_ovito - right) < 1e-3 and abs(found - stated) < .02 and \
            np.allclose(universe.dimensions, crystal.cell.cellpar(), rtol=1e-5) and (symbol != "Mg" or abs(found - right) < 1e-3)
        changed |= not same
        print(f"{symbol}, {path}: nearest neighbor at {right:.3f}; OVITO {by_ovito:.3f}, MDAnalysis {found:.3f}; volume "
              f"{universe.trajectory.ts.volume:.2f} for {crystal.cell.volume:.2f}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
