#!/usr/bin/env bash
# natinterp3d's natural neighbor values are wrong within the convex hull near its border, and slightly so on lattices.
#
# Surprise: natural neighbor interpolation reproduces a linear function anywhere in the hull of the data. With 300 random points
#   in a cube, 7 % of places in their hull are off, by up to 0.11 where values range over 6; with 20 points 22 % are. Weights sum
#   to 1, and none is negative, so nothing shows it. On a cubic lattice errors are about 1e-5 everywhere, as if points were
#   moved. SciPy's linear interpolation is exact at all of these places.
# Versions: natinterp3d 1.0.9, SciPy 1.17.1
# Seen: 2026-11
# Do: surround the data by points of known values, or take scipy.interpolate.LinearNDInterpolator near the border.
# Source: Sibson (1980), "A vector identity for the Dirichlet tessellation": a point is the mean of its natural neighbors with
#   these weights. natinterp3d's manual, interpolate(), which refers to Sibson and states no limit.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet natinterp3d==1.0.9 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import natinterp3d
import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay

print({name: version(name) for name in ("natinterp3d", "scipy")})


def linear(x):
    return 1 + x @ [1, 2, 3]


def errors(points, places):
    places = places[Delaunay(points).find_simplex(places) >= 0]
    seen = natinterp3d.interpolate(places, points, linear(points)) - linear(places)
    scipys = LinearNDInterpolator(points, linear(points))(places) - linear(places)
    return abs(seen), np.abs(scipys).max()


rng = np.random.default_rng(0)
lattice = np.stack(np.meshgrid(*[np.arange(6.0)] * 3), -1).reshape(-1, 3)
trials = {f"{n} random points": (rng.random((n, 3)), rng.random((3000, 3))) for n in (20, 300, 3000)}
trials["a lattice, deep inside"] = lattice, 2 + rng.random((500, 3))
seen = {}
for name, (points, places) in trials.items():
    off, scipys = errors(points, places)
    seen[name] = np.mean(off > 1e-6), off.max(), scipys
    print(f"{name}: {len(off)} places in the hull, {np.mean(off > 1e-6):.0%} off by more than 1e-6, at most {off.max():.1e}; "
          f"SciPy {scipys:.0e}")
few, some, many, on_lattice = seen.values()
same = 0.15 < few[0] < 0.3 and 0.05 < some[0] < 0.1 and 0.02 < many[0] < 0.04 and some[1] > 0.05 and \
    1e-6 < on_lattice[1] < 1e-3 and max(s[2] for s in seen.values()) < 1e-12
print("as stated" if same else "CHANGED")
sys.exit(not same)
EOF
