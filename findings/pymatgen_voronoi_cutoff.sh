#!/usr/bin/env bash
# The Voronoi cells of pymatgen's VoronoiNN overlap in slabs and other structures with empty space.
#
# Surprise: VoronoiNN clips a cell by the atoms within 13 angstrom, and takes it if it is closed. A closed cell may still reach
#   beyond the half of that, where farther atoms cut it. The cells of 40 argon atoms at random places in a cube of 25 sum to 102
#   to 104 % of it, and two thirds of the lists of neighbors are wrong. Methods of the class disagree: for two layers of copper
#   with 12 angstrom of vacuum those for one site sum to 100 %, and those for all sites, which get_all_nn_info() takes, to 113 %.
#   VoronoiAnalyzer takes 5 angstrom: potassium becomes an octahedron, [8, 0, 0, 0] for [0, 6, 0, 8]. Denser crystals are right.
#   Nothing warns. Voro++ sums to 100 % in each.
# Versions: pymatgen 2026.10.24, pyvoro-rimoli 1.4.1 (Voro++), NumPy 2.4.6
# Seen: 2026-11
# Do: compare the sum of volumes with structure.volume, and raise cutoff until they agree; or take Voro++.
# Source: pymatgen manual, VoronoiNN (a Voronoi-based near neighbor finder; cutoff: radius "to look for near-neighbor atoms"),
#   and get_all_voronoi_polyhedra ("Get the Voronoi polyhedra for all site in a simulation cell"). VoronoiAnalyzer.analyze
#   (Voronoi indices).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pymatgen==2026.10.24 pyvoro-rimoli==1.4.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import pyvoro
from pymatgen.analysis.local_env import VoronoiNN
from pymatgen.analysis.structure_analyzer import VoronoiAnalyzer
from pymatgen.core import Lattice, Structure

print({name: version(name) for name in ("pymatgen", "pyvoro-rimoli")})


def sums(cells):
    return sum(face["volume"] for cell in cells for face in cell.values())


def seen(structure):
    nn = VoronoiNN(compute_adj_neighbors=False)
    ones = [nn.get_voronoi_polyhedra(structure, i) for i in range(len(structure))]
    alls = nn.get_all_voronoi_polyhedra(structure)
    limits = [[0, a] for a in structure.lattice.abc]
    right = pyvoro.compute_voronoi(structure.cart_coords.tolist(), limits, 3.0, periodic=[True] * 3)
    wrong = sum(sorted(face["site"].index for face in cell.values()) != sorted(f["adjacent_cell"] for f in own["faces"])
                for cell, own in zip(ones, right))
    return [sums(ones) / structure.volume, sums(alls) / structure.volume,
            sum(c["volume"] for c in right) / structure.volume], wrong


def slab(layers, vacuum):
    corners = [(0, 0), (0.5, 0.5)], [(0.5, 0), (0, 0.5)]
    places = [(3.6 * x, 3.6 * y, 1.8 * k) for k in range(layers) for x, y in corners[k % 2]]
    lattice = Lattice.orthorhombic(3.6, 3.6, 1.8 * layers + vacuum)
    return Structure(lattice, ["Cu"] * len(places), places, coords_are_cartesian=True)


changed = False
salt = Structure.from_spacegroup("Fm-3m", Lattice.cubic(5.64), ["Na", "Cl"], [[0, 0, 0], [0.5, 0.5, 0.5]])
trials = [("rock salt", salt, 1, 1, 0), ("2 layers of copper", slab(2, 12), 1, 1.134, 0), ("3 layers", slab(3, 14), 1, 1.079, 0)]
trials += [(f"40 argon atoms, seed {seed}", Structure(Lattice.cubic(25), ["Ar"] * 40, np.random.default_rng(seed).random((40, 3))),
            *stated) for seed, stated in enumerate([(1.025, 1.004, 26), (1.036, 1.007, 27), (1.023, 1.004, 26)])]
for name, structure, one_by_one, at_once, wrong in trials:
    volumes, lists = seen(structure)
    same = np.allclose(volumes, [one_by_one, at_once, 1], atol=2e-3) and (lists == wrong or name == "rock salt")
    changed |= not same
    print(name, "- volumes one by one {:.4f}, all at once {:.4f}, Voro++ {:.4f};".format(*volumes),
          f"{lists} of {len(structure)} lists of neighbors differ from Voro++", "" if same else "CHANGED")
for name, edge, stated in (("Fe", 2.87, [0, 6, 0, 8]), ("K", 5.33, [8, 0, 0, 0])):
    index = VoronoiAnalyzer().analyze(Structure.from_spacegroup("Im-3m", Lattice.cubic(edge), [name], [[0, 0, 0]]), 0)[:4].tolist()
    cells = pyvoro.compute_voronoi([[x + 0.5, y, z] for k in (0, 0.5) for x, y, z in np.add(k, list(np.ndindex(3, 3, 3)))],
                                   [[0, 3]] * 3, 1.0, periodic=[True] * 3)
    sizes = [len(face["vertices"]) for face in cells[0]["faces"]]
    right = [sizes.count(k) for k in range(3, 7)]
    same = index == stated and right == [0, 6, 0, 8]
    changed |= not same
    print(f"faces of 3, 4, 5, 6 edges around {name}, bcc: {index}, Voro++ {right}", "" if same else "CHANGED")
sys.exit(changed)
EOF
