#!/usr/bin/env bash
# mdapy's Voronoi volumes sum to 3, 9 or 27 times the box, where a side of a tilted box is open.
#
# Surprise: 80 atoms in a tilted box, read from ASE. With three periodic axes the volumes sum to the box. If one axis is
#   open, as for a slab, they sum to 3 times the box, with two to 9 times, with three to 27 times: the atoms at open sides get
#   all the room up to neighbors one box away. A third of the atoms of the slab is off, some by a factor of 50. OVITO
#   ends the cells at the open sides. In boxes with right angles mdapy does too, and both agree.
# Versions: mdapy 1.0.9, ASE 3.29.0, OVITO 3.17.2
# Seen: 2026-11
# Do: compare the sum of the volumes with the box; take OVITO's analysis, or add vacuum and leave out the atoms at the sides.
# Source: mdapy's manual, System.cal_voronoi_volume, and its class Box (boundary: 1 is periodic, 0 is not), without a restriction.
#   OVITO manual, "Voronoi analysis" (a cell that is not periodic ends at its sides).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet mdapy==1.0.9 ase==3.29.0 ovito==3.17.2 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase
import mdapy
import numpy as np
from ovito.io.ase import ase_to_ovito
from ovito.modifiers import VoronoiAnalysisModifier
from ovito.pipeline import Pipeline, StaticSource

print({name: version(name) for name in ("mdapy", "ase", "ovito")})


def by_ovito(atoms):
    pipeline = Pipeline(source=StaticSource(data=ase_to_ovito(atoms)))
    pipeline.modifiers.append(VoronoiAnalysisModifier())
    return np.array(pipeline.compute().particles["Atomic Volume"])


changed = False
for name, cell in (("right angles", np.diag([10., 11, 12])), ("hexagonal", np.array([[10, 0, 0], [-5, 75 ** .5, 0], [0, 0, 12]])),
                   ("tilted", np.array([[10., 0, 0], [4, 9, 0], [-3, 4, 11]]))):
    for periodic in ((1, 1, 1), (1, 1, 0), (1, 0, 0), (0, 0, 0)):
        atoms = ase.Atoms("Ar80", positions=np.random.default_rng(1).random((80, 3)) @ cell, cell=cell, pbc=periodic)
        system = mdapy.System(ase_atom=atoms)
        system.cal_voronoi_volume()
        found, right = system.data["volume"].to_numpy(), by_ovito(atoms)
        factor = 1 if name == "right angles" else 3 ** periodic.count(0)
        off = np.mean(abs(found / right - 1) > .01)
        sums = found.sum() / atoms.get_volume(), right.sum() / atoms.get_volume()
        same = np.allclose(sums, (factor, 1), rtol=1e-3) and (off == 0 if factor == 1 else off > .2)
        changed |= not same
        print(f"{name}, periodic {periodic}: the sum is {sums[0]:.3f} of the box by mdapy, {sums[1]:.3f} by OVITO; {off:.0%} of "
              f"the volumes differ, by up to a factor of {(found / right).max():.3g}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
