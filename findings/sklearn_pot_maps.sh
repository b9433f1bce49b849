#!/usr/bin/env bash
# Nearest points and transport costs are wrong for dense points in coordinates of maps: scikit-learn and POT expand the square.
#
# Surprise: 5000 points of a laser scan in a room, 6 cm apart, at northing 5,500,000 m, in float64. SciPy's tree finds each
#   nearest point. scikit-learn's pairwise_distances_argmin and NearestNeighbors(algorithm="brute") compute
#   |a|^2 - 2 a.b + |b|^2, whose rounding is about 5 cm at such coordinates: three of four nearest points are others. The default
#   of NearestNeighbors is a tree here, and right. POT's dist() expands the square too: the cost of the best plan between two
#   such sets is 5 % too low, and right for the same sets near 0. No call warns.
# Versions: scikit-learn 1.9.1, POT 0.9.7.post1, SciPy 1.17.1
# Seen: 2026-11
# Do: subtract a corner of the data from all points first, which costs nothing; or take scipy.spatial.
# Source: scikit-learn manual, pairwise_distances_argmin ("the smallest distance") and NearestNeighbors; that of
#   euclidean_distances alone mentions cancellation. POT manual, ot.dist.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet scikit-learn==1.9.1 POT==0.9.7.post1 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import ot
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist
from sklearn.metrics import pairwise_distances_argmin
from sklearn.neighbors import NearestNeighbors

print({name: version(name) for name in ("scikit-learn", "POT", "scipy")})
random = np.random.default_rng(1)
room, queries = random.random((5000, 3)), random.random((400, 3))
changed = False
for corner, wrong in ((0., False), (np.array([450_000., 5_500_000, 300]), True)):
    points, asked = room + corner, queries + corner
    distance = cKDTree(points).query(asked)[0]

    def missed(found):
        return float(np.mean(np.linalg.norm(points[np.ravel(found)] - asked, axis=1) > distance + 1e-6))

    seen = {
        "argmin": missed(pairwise_distances_argmin(asked, points)),
        "brute": missed(NearestNeighbors(n_neighbors=1, algorithm="brute").fit(points).kneighbors(asked)[1]),
        "tree": missed(NearestNeighbors(n_neighbors=1).fit(points).kneighbors(asked)[1])}
    cost = ot.emd2([], [], ot.dist(points[:400], asked))
    right = ot.emd2([], [], cdist(points[:400], asked, "sqeuclidean"))
    same = seen["tree"] == 0 and all((seen[name] > .3) == wrong and (seen[name] == 0) == (not wrong) for name in ("argmin", "brute")) \
        and (abs(cost / right - 1) > .01) == wrong
    changed |= not same
    print(f"corner {corner}: other points than the nearest {seen}; cost by POT {cost:.6f}, right {right:.6f}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
