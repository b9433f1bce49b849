#!/usr/bin/env bash
# ProDy bends every DCD cell that is not a box: it reads 94.8 degrees for 120, and writes angles that no cell can have.
#
# Surprise: DCD files of CHARMM and NAMD hold the angles of the cell by their cosines. ProDy's formula has the square of pi where
#   half of pi belongs. It reads the 120 degrees of a hexagonal cell as 94.77, and the 109.47 of a truncated octahedron as 93.10,
#   a volume of 997 for 866, and of 995 for 770. chemfiles and MDAnalysis read the same file right. When it writes, the same
#   mistake turns 120 into 81.50, and 109.47 into 147.66, from which no cell follows. ProDy names the angles in the order gamma,
#   beta, alpha. Nothing warns, and boxes with right angles are right.
# Versions: ProDy 2.6.1, MDTraj 1.11.1.post2, MDAnalysis 2.11.0, chemfiles 0.10.4
# Seen: 2026-11
# Do: take the cell from MDAnalysis or chemfiles. Or undo it: an angle that ProDy read is 90 + 2 pi (its value - 90).
# Source: MDAnalysis manual, "DCD trajectory I/O": unit cells of CHARMM and NAMD, [A, gamma, B, beta, alpha, C] with cosines;
#   NAMD user's guide, "DCD trajectory files". ProDy manual, Frame.getUnitcell() and DCDFile.write().
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet prody==2.6.1 mdtraj==1.11.1.post2 mdanalysis==2.11.0 chemfiles==0.10.4 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
import warnings
from importlib.metadata import version

import chemfiles
import mdtraj
import numpy as np
import prody
from MDAnalysis.coordinates.DCD import DCDReader

print({name: version(name) for name in ("prody", "mdtraj", "mdanalysis", "chemfiles")})
warnings.simplefilter("ignore")
prody.confProDy(verbosity="none")
top = mdtraj.Topology()
residue = top.add_residue("X", top.add_chain())
for _ in range(4):
    top.add_atom("C", mdtraj.element.carbon, residue)
points = np.random.default_rng(1).random((4, 3)).astype(np.float32)


def volume(cell):
    """Returns the volume of a cell from its lengths and alpha, beta, gamma in degrees."""
    a, b, c = np.cos(np.radians(cell[3:]))
    return np.prod(cell[:3]) * np.sqrt(1 + 2 * a * b * c - a * a - b * b - c * c)


changed = False
for angles, stated, written in (((90, 90, 90), 90, 90), ((90, 90, 120), 94.7746, 81.5044), ((109.4712,) * 3, 93.0989, 147.6588)):
    cell = np.array([10., 10, 10, *angles])
    mdtraj.Trajectory(points[None] / 10, top, unitcell_lengths=[cell[:3] / 10], unitcell_angles=[angles]).save("a.dcd")
    frame = chemfiles.Trajectory("a.dcd").read()
    by_chemfiles = np.array([*frame.cell.lengths, *frame.cell.angles])
    by_mdanalysis = DCDReader("a.dcd").ts.dimensions
    by_prody = next(iter(prody.DCDFile("a.dcd"))).getUnitcell()[[0, 1, 2, 5, 4, 3]]
    file = prody.DCDFile("b.dcd", "w")
    file.write(points, unitcell=cell[[0, 1, 2, 5, 4, 3]])
    file.close()
    gamma = DCDReader("b.dcd").ts.dimensions[5]
    same = np.allclose(by_chemfiles, cell, atol=1e-3) and np.allclose(by_mdanalysis, cell, atol=1e-3) and \
        abs(by_prody[5] - stated) < 1e-3 and abs(gamma - written) < 1e-3
    changed |= not same
    print(f"{angles}, volume {volume(cell):.1f}: chemfiles gamma {by_chemfiles[5]:.4f}, MDAnalysis {by_mdanalysis[5]:.4f}, ProDy "
          f"{by_prody[5]:.4f}, volume {volume(by_prody):.1f}; written by ProDy {gamma:.4f}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
