#!/usr/bin/env bash
# moleculekit writes every box of a .gro file with right angles: a rhombic dodecahedron grows by 41 percent.
#
# Surprise: GROMACS runs most solvated proteins in a truncated octahedron or a rhombic dodecahedron, whose cells are tilted. moleculekit
#   reads lengths and angles of such a box, and its .xtc is right. Its .gro has the three lengths and six zeros. MDTraj and ASE
#   then read a box with right angles: 30 percent more volume for the octahedron, 41 for the dodecahedron, 15 for a hexagonal
#   cell. The new space is empty, and pairs across the sides are lost. The .gro and the .xtc of one frame contradict each
#   other. Nothing warns. Boxes with right angles are right.
# Versions: moleculekit 1.17.19, MDTraj 1.11.1.post2, ASE 3.29.0
# Seen: 2026-11
# Do: write the .gro by MDTraj, from moleculekit's .pdb or .xtc.
# Source: GROMACS manual, "gro file format": "box vectors (free format, space separated reals), values: v1(x) v2(y) v3(z) v1(y) ...",
#   and "Periodic boundary conditions". moleculekit manual, Molecule.write, Molecule.box, Molecule.boxangles.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet moleculekit==1.17.19 mdtraj==1.11.1.post2 ase==3.29.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import logging
import sys
from importlib.metadata import version

import mdtraj
import numpy as np
from ase.io import read
from moleculekit.molecule import Molecule
from scipy.spatial import cKDTree

print({name: version(name) for name in ("moleculekit", "mdtraj", "ase")})
logging.disable(logging.CRITICAL)
topology = mdtraj.Topology()
chain = topology.add_chain()
count = 200
for _ in range(count):
    topology.add_atom("Ar", mdtraj.element.argon, topology.add_residue("AR", chain))


def volume(lengths, angles):
    a, b, c = np.cos(np.radians(angles))
    return np.prod(lengths) * np.sqrt(1 + 2 * a * b * c - a * a - b * b - c * c)


def pairs(frame):
    """Returns how many pairs lie within 0.3 nm, over all sides."""
    rows = frame.unitcell_vectors[0]
    shifts = np.stack(np.meshgrid(*3 * [[-1, 0, 1]], indexing="ij"), -1).reshape(-1, 3) @ rows
    return cKDTree(frame.xyz[0]).count_neighbors(cKDTree((frame.xyz[0] + shifts[:, None]).reshape(-1, 3)), .3) - count


changed = False
rng = np.random.default_rng(1)
for name, lengths, angles, stated in (("box", (2, 2.2, 2.4), (90, 90, 90), 1), ("hexagonal", (2, 2, 2.4), (90, 90, 120), 1.155),
                                      ("truncated octahedron", (2.2,) * 3, (109.4712206,) * 3, 1.299),
                                      ("rhombic dodecahedron", (2.2,) * 3, (60, 60, 90), 1.414)):
    start = mdtraj.Trajectory(np.zeros((1, count, 3)), topology, unitcell_lengths=[lengths], unitcell_angles=[angles])
    start.xyz = (rng.random((count, 3)) @ start.unitcell_vectors[0])[None]
    start.save("start.pdb")
    start.save("start.xtc")
    molecule = Molecule("start.pdb")
    molecule.read("start.xtc")
    kept = np.allclose(molecule.box[:, 0], 10 * np.array(lengths), atol=.01) and np.allclose(molecule.boxangles[:, 0], angles, atol=.01)
    molecule.write("a.gro")
    molecule.write("a.xtc")
    right = volume(lengths, angles)
    gro, xtc = mdtraj.load("a.gro"), mdtraj.load("a.xtc", top=topology)
    ratios = gro.unitcell_volumes[0] / right, read("a.gro").cell.volume / 1000 / right, xtc.unitcell_volumes[0] / right
    found = pairs(start), pairs(gro), pairs(xtc)
    same = kept and np.allclose(ratios[:2], stated, rtol=.01) and abs(ratios[2] - 1) < 1e-3 and abs(found[2] - found[0]) <= 4 and \
        (found[1] < .97 * found[0] if stated > 1 else abs(found[1] - found[0]) <= 4)
    changed |= not same
    print(f"{name}: volume over right one, .gro by MDTraj {ratios[0]:.3f}, by ASE {ratios[1]:.3f}, .xtc {ratios[2]:.3f}; pairs within 3 angstrom "
          f"{found[0]}, .gro {found[1]}, .xtc {found[2]}; last line of .gro: {open('a.gro').read().splitlines()[-1]}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
