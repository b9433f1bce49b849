#!/usr/bin/env bash
# pymatgen reads a tilted box that OVITO wrote for LAMMPS as a cube of 1 angstrom, or as a negative length, without a message.
#
# Surprise: since 2024 LAMMPS files may state the edges of a box in any orientation, as avec, bvec, cvec in data files and as
#   "abc origin" in dumps. OVITO writes those for every tilted box. OVITO and ASE read them back. pymatgen gives a cube of
#   volume 1 for the data file and a box with the length -1.8 for the dump. Boxes without tilt are read by all.
# Versions: OVITO 3.17.2, ASE 3.29.0, pymatgen-core 2026.10.16
# Seen: 2026-11
# Do: read by ASE or OVITO, or hand over extended XYZ or POSCAR; in LAMMPS leave triclinic/general out.
# Source: LAMMPS manual, "read_data command" (avec, bvec, cvec, abc origin), "dump command" (BOX BOUNDS abc origin), "Howto
#   triclinic" (general triclinic boxes).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ovito==3.17.2 ase==3.29.0 pymatgen-core==2026.10.16 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase.build
import ase.io
import numpy as np
from ovito.io import export_file, import_file
from ovito.io.ase import ase_to_ovito
from ovito.pipeline import Pipeline, StaticSource
from pymatgen.io.lammps.data import LammpsData
from pymatgen.io.lammps.outputs import parse_lammps_dumps

print({name: version(name) for name in ("ovito", "ase", "pymatgen-core")})
primitive = ase.build.bulk("Cu", a=3.6) * (2, 1, 1)
straight = ase.build.bulk("Cu", a=3.6, cubic=True)
changed = False
for name, atoms in (("general", primitive), ("straight", straight)):
    pipeline = Pipeline(source=StaticSource(data=ase_to_ovito(atoms)))
    columns = ["Particle Identifier", "Particle Type", "Position.X", "Position.Y", "Position.Z"]
    export_file(pipeline, "box.dump", "lammps/dump", columns=columns)
    export_file(pipeline, "box.data", "lammps/data", atom_style="atomic")
    print("".join(open("box.dump").readlines()[4:8]), end="")
    seen = {
        "dump, OVITO": import_file("box.dump").compute().cell[:, :3].T,
        "dump, ASE": ase.io.read("box.dump", format="lammps-dump-text").cell[:],
        "dump, pymatgen": next(parse_lammps_dumps("box.dump")).box.to_lattice().matrix,
        "data, OVITO": import_file("box.data").compute().cell[:, :3].T,
        "data, ASE": ase.io.read("box.data", format="lammps-data", atom_style="atomic").cell[:],
        "data, pymatgen": LammpsData.from_file("box.data", atom_style="atomic").structure.lattice.matrix,
    }
    for way, edges in seen.items():
        right = np.allclose(edges, atoms.cell[:], atol=1e-4)
        same = right == (name == "straight" or "pymatgen" not in way) and \
            (right or np.allclose(edges, np.eye(3) if "data" in way else np.diag([3.6, -1.8, 0])))
        changed |= not same
        print(f"{name}, {way}: volume {np.linalg.det(edges):.3f}, the edges are {'right' if right else 'wrong: ' + str(edges.tolist())}",
              "" if same else "CHANGED")
sys.exit(changed)
EOF
