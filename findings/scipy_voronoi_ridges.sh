#!/usr/bin/env bash
# SciPy's Voronoi lists fewer neighbors than SciPy's Delaunay of the same points, in general position.
#
# Surprise: two points joined by a Delaunay edge share a Voronoi face, and conversely. In 3D, ridge_points lacks unbounded faces
#   with a single vertex: an edge of the hull that belongs to one tetrahedron. 5 of 32 neighbor pairs of 10 random points are
#   missing, 18 of 7445 of 1000 points. Networks of neighbors from ridge_points lose pairs at the hull. In 2D none is lost.
#   The manual of SciPy does not say so.
# Versions: SciPy 1.17.1 (its Qhull 2020.2), NumPy 2.4.6
# Seen: 2026-11
# Do: take neighbors from Delaunay, or surround the points by a large cube and skip the ridges of its corners.
# Source: SciPy manual, scipy.spatial.Voronoi, ridge_points. Qhull manual, "qvoronoi", notes on option Fv: ridges that need more
#   than one midpoint are not listed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet scipy==1.17.1 numpy==2.4.6

venv/bin/python - <<'EOF'
import itertools
import sys

import numpy as np
import scipy
from scipy.spatial import Delaunay, Voronoi

print("SciPy", scipy.__version__, "NumPy", np.__version__)


def edges(points):
    return {pair for simplex in Delaunay(points).simplices for pair in itertools.combinations(sorted(simplex.tolist()), 2)}


def ridges(points):
    return {tuple(sorted(pair)) for pair in Voronoi(points).ridge_points.tolist()}


stated = {(10, 3): (32, 27), (50, 3): (283, 275), (1000, 3): (7445, 7427), (1000, 2): None}
changed = False
for (count, dimension), lost in stated.items():
    points = np.random.default_rng(count).random((count, dimension))
    of_delaunay, of_voronoi = edges(points), ridges(points)
    same = of_voronoi <= of_delaunay and \
        (of_voronoi == of_delaunay if lost is None else (len(of_delaunay), len(of_voronoi)) == lost)
    simplices = [set(s) for s in Delaunay(points).simplices.tolist()]
    owners = [sum(set(pair) <= s for s in simplices) for pair in of_delaunay - of_voronoi]
    same &= all(n == 1 for n in owners)  # each lost pair belongs to one tetrahedron
    # A cube around the points brings them back.
    corners = 1e3 * (np.array(list(itertools.product((-1, 1), repeat=dimension))) + .01 * points[:2 ** dimension])
    boxed = {pair for pair in ridges(np.concatenate([points, corners])) if pair[1] < count}
    same &= (of_delaunay - of_voronoi) <= boxed
    changed |= not same
    print(f"{count} points in {dimension}D: {len(of_delaunay)} edges, {len(of_voronoi)} ridges; "
          f"lost with a cube around: {len((of_delaunay - of_voronoi) - boxed)}", "" if same else f"CHANGED, was {lost}")
sys.exit(bool(changed))
EOF
