#!/usr/bin/env bash
# freud and OVITO report distances in tilted cells that are not the shortest: of another image, up to half an edge too long.
#
# Surprise: Box.compute_distances, compute_all_distances and wrap of freud, and SimulationCell.delta_vector of OVITO, round
#   the fractional coordinates of the difference. The result lies in the cell around 0, which is not where the shortest vectors
#   are. In a hexagonal cell a sixth of random pairs is too far, in a rhombic dodecahedron or the primitive cell of fcc more
#   than a quarter. freud disagrees with itself: its neighbor queries in the same box find the right distances. ASE agrees
#   with a search over all near images.
# Versions: freud 3.4.0, OVITO 3.17.2, ASE 3.29.0
# Seen: 2026-11
# Do: trust distances below half the least spacing of the cell's faces, which are right; else use a neighbor query, or ASE.
# Source: freud manual, Box.wrap ("equivalent to applying the minimum image convention") and Box.compute_distances ("using
#   periodic boundaries"), without a restriction. OVITO manual, SimulationCell.delta_vector: the image "that is closest", with
#   "as short as possible (in reduced coordinate space)" in brackets. By convention, the nearest image counts.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet freud-analysis==3.4.0 ovito==3.17.2 ase==3.29.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import itertools
import sys
from importlib.metadata import version

import freud
import numpy as np
from ase.geometry import find_mic
from ovito.data import SimulationCell

print({name: version(name) for name in ("freud-analysis", "ovito", "ase")})
shifts = np.array(list(itertools.product(range(-3, 4), repeat=3)))
first, second = np.random.default_rng(1).random((2, 1000, 3))
cells = {
    "straight": [[10, 0, 0], [0, 10, 0], [0, 0, 10]],
    "hexagonal": [[10, 0, 0], [5, 75 ** .5, 0], [0, 0, 10]],
    "rhombic dodecahedron": [[10, 0, 0], [0, 10, 0], [5, 5, 50 ** .5]],
    "primitive fcc": [[10, 0, 0], [5, 75 ** .5, 0], [5, 75 ** .5 / 3, (200 / 3) ** .5]],
}
stated = {"straight": 0, "hexagonal": .16, "rhombic dodecahedron": .28, "primitive fcc": .28}  # share of wrong distances
changed = False
for name, cell in cells.items():
    cell = np.array(cell, float)
    a, b = first @ cell, second @ cell
    right = np.linalg.norm((b - a)[:, None] + shifts @ cell, axis=2).min(1)
    height = 1 / np.linalg.norm(np.linalg.inv(cell), axis=0).max()  # least spacing of faces
    box = freud.box.Box(*cell.diagonal(), cell[1, 0] / cell[1, 1], cell[2, 0] / cell[2, 2], cell[2, 1] / cell[2, 2])
    assert np.allclose(box.to_matrix(), cell.T, atol=1e-5)
    middle = cell.sum(0) / 2  # freud's boxes are centered at 0
    of_ovito = SimulationCell(pbc=(True, True, True))
    of_ovito[...] = np.c_[cell.T, np.zeros(3)]
    near = np.flatnonzero(right < .45 * height)
    query = freud.locality.AABBQuery(box, a[near] - middle).query(b[near] - middle, {"r_max": float(.46 * height)})
    found = {(i, j): d for i, j, d in query}
    distances = {
        "freud": box.compute_distances(a - middle, b - middle),
        "freud, all pairs": box.compute_all_distances(a - middle, b - middle).diagonal(),
        "OVITO": np.linalg.norm(of_ovito.delta_vector(a, b), axis=1),
        "ASE": find_mic(b - a, cell, pbc=True)[1],
    }
    same = np.allclose([found[k, k] for k in range(len(near))], right[near], atol=1e-4)
    text = [f"freud's query right within {.45 * height:.2f}: {same}"]
    for tool, distance in distances.items():
        wrong = abs(distance - right) > 1e-3
        expected = 0 if tool == "ASE" else stated[name]
        same &= not wrong[near].any() and abs(wrong.mean() - expected) < (.05 if expected else 1e-9) and \
            (not expected or (distance - right).max() > 2)
        text.append(f"{tool} {wrong.mean():.1%} too far, by up to {(distance - right).max():.2f}")
    changed |= not same
    print(f"{name}: {'; '.join(text)}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
