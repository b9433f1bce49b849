#!/usr/bin/env bash
# The cells of pyvoro2 are in another order than the points, which pyvoro keeps, once there are enough points.
#
# Surprise: pyvoro returns a list of cells, cell k of point k. pyvoro2 has `result.cells`, dicts with the same keys. For 20 points
#   they are in the order of the points, so a trial looks right. For 200 points nearly all stand at another place: volumes go to
#   the wrong points, and their sum is right.
# Versions: pyvoro2 0.8.0, pyvoro-rimoli 1.4.1 (pyvoro for current Pythons), SciPy 1.17.1
# Seen: 2026-11
# Do: use result.cell_measures, which is in the order of the points, or sort the cells by their "id".
# Source: pyvoro2 manual, TessellationResult: cells are "raw user-visible cell dictionaries", without an order; cell_measures are
#   "input-aligned". pyvoro's README, compute_voronoi().
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pyvoro2==0.8.0 pyvoro-rimoli==1.4.1 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import pyvoro
import pyvoro2
from scipy.spatial import ConvexHull, Voronoi

print({name: version(name) for name in ("pyvoro2", "pyvoro-rimoli", "scipy")})


def by_scipy(points, side):  # with the 26 copies around a periodic cube
    shifts = np.stack(np.meshgrid(*[(0, -side, side)] * 3, indexing="ij"), -1).reshape(-1, 1, 3)
    diagram = Voronoi((points + shifts).reshape(-1, 3))
    return np.array([ConvexHull(diagram.vertices[diagram.regions[diagram.point_region[k]]]).volume for k in range(len(points))])


changed = False
for count, moved in ((20, False), (200, True), (1000, True)):
    side = 20.
    points = np.random.default_rng(1).random((count, 3)) * side
    right = by_scipy(points, side)
    old = np.array([cell["volume"] for cell in pyvoro.compute_voronoi(points, [[0, side]] * 3, 2., periodic=[True] * 3)])
    result = pyvoro2.compute(points, domain=pyvoro2.OrthorhombicCell(bounds=((0, side),) * 3, periodic=(True,) * 3))
    new = np.array([cell["volume"] for cell in result.cells])
    displaced = np.mean([cell["id"] != k for k, cell in enumerate(result.cells)])
    same = (np.allclose(old, right) and np.allclose(np.array(result.cell_measures), right) and np.isclose(new.sum(), right.sum())
            and np.allclose(np.sort(new), np.sort(right)) and (displaced > .9 if moved else displaced == 0))
    changed |= not same
    print(f"{count} points: {displaced:.0%} of pyvoro2's cells at another place, volumes off by up to {abs(new - right).max():.3g}, pyvoro's by "
          f"{abs(old - right).max():.1e}, cell_measures by {abs(np.array(result.cell_measures) - right).max():.1e}; sum {new.sum():.3f}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
