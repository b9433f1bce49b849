#!/usr/bin/env bash
# MDTraj's compute_neighborlist() loses neighbors across the boundary, unless the box is rectangular with all atoms inside.
#
# Surprise: MDTraj's own compute_distances() and compute_neighbors(), MDAnalysis and ASE agree with brute force, and
#   compute_neighborlist() has fewer pairs. Chains of ten atoms that are kept whole reach over the sides of a rectangular box: 2 %
#   of the pairs are missing. Atoms that moved on by a box edge, as in unwrapped trajectories: more than half. In a rhombic
#   dodecahedron 8 % and in a truncated octahedron 15 % are missing, with all atoms wrapped into the parallelepiped of its edges.
#   Nothing warns. Atoms inside a rectangular box are right, so a first trial shows nothing.
# Versions: MDTraj 1.11.1.post2, MDAnalysis 2.11.0, ASE 3.29.0
# Seen: 2026-11
# Do: take MDAnalysis.lib.distances.self_capped_distance(), or md.compute_neighbors() atom by atom.
# Source: MDTraj manual, compute_neighborlist, periodic: distances are computed under the minimum image convention, and
#   neighbors[i] has all atoms within the cutoff of atom i.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet mdtraj==1.11.1.post2 MDAnalysis==2.11.0 ase==3.29.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import itertools
import sys
from importlib.metadata import version

import mdtraj
import numpy as np
from ase import Atoms
from ase.neighborlist import neighbor_list
from MDAnalysis.lib.distances import self_capped_distance

print({name: version(name) for name in ("mdtraj", "MDAnalysis", "ase")})
rng = np.random.default_rng(1)
images = np.array(list(itertools.product(range(-3, 4), repeat=3)))
cube = np.diag([20.] * 3)
cells = {
    "rectangular": cube,
    "rhombic dodecahedron": np.array([[20, 0, 0], [0, 20, 0], [10, 10, 200 ** .5]]),
    "truncated octahedron": np.array([[20, 0, 0], [20 / 3, 20 * 8 ** .5 / 3, 0], [-20 / 3, 20 * 2 ** .5 / 3, 20 * 6 ** .5 / 3]]),
}
radius = 4.


def counts(points, cell):
    """Ordered pairs within the radius: by brute force, then by the tools."""
    n = len(points)
    difference = points[:, None] - points
    difference -= np.round(difference @ np.linalg.inv(cell)) @ cell
    near = np.linalg.norm(difference[:, :, None] + images @ cell, axis=3) < radius
    topology = mdtraj.Topology()
    chain = topology.add_chain()
    for _ in range(n):
        topology.add_atom("Ar", mdtraj.element.argon, topology.add_residue("Ar", chain))
    trajectory = mdtraj.Trajectory(points[None] / 10, topology)
    trajectory.unitcell_vectors = cell[None] / 10
    pairs = np.array(list(itertools.combinations(range(n), 2)))
    box = np.r_[trajectory.unitcell_lengths[0] * 10, trajectory.unitcell_angles[0]].astype("f4")
    return {
        "brute force": int(near.sum()) - n,
        "ASE": len(neighbor_list("i", Atoms(f"Ar{n}", positions=points, cell=cell, pbc=True), radius)),
        "MDAnalysis": 2 * len(self_capped_distance(points.astype("f4"), radius, box=box, return_distances=False)),
        "compute_distances": 2 * int((mdtraj.compute_distances(trajectory, pairs)[0] < radius / 10).sum()),
        "compute_neighbors": sum(len(mdtraj.compute_neighbors(trajectory, radius / 10, [k])[0]) for k in range(n)),
        "compute_neighborlist": sum(map(len, mdtraj.compute_neighborlist(trajectory, radius / 10))),
    }


def inside(cell):
    return rng.random((150, 3)) @ cell


def molecules(cell):
    return (rng.random((15, 1, 3)) @ cell + rng.normal(scale=1.2, size=(15, 10, 3)).cumsum(1)).reshape(-1, 3)


def unwrapped(cell):
    return inside(cell) + rng.integers(-1, 2, (150, 3)) @ cell


changed = False
for name, make, least, largest in (("rectangular", inside, 0, 0), ("rectangular", molecules, .005, .1), ("rectangular", unwrapped, .3, .8),
                                   ("rhombic dodecahedron", inside, .05, .3), ("truncated octahedron", inside, .05, .4)):
    found = counts(make(cells[name]), cells[name])
    right = found.pop("brute force")
    listed = found.pop("compute_neighborlist")
    missing = 1 - listed / right
    same = all(n == right for n in found.values()) and least <= missing <= largest
    changed |= not same
    print(f"{name}, {make.__name__}: {right} by brute force, {found}; compute_neighborlist {listed}, {missing:.1%} missing", "" if same
          else "CHANGED")
sys.exit(bool(changed))
EOF
