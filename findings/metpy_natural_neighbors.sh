#!/usr/bin/env bash
# MetPy's natural neighbors have no value at the observations themselves: NaN, or a ZeroDivisionError.
#
# Surprise: Sibson's interpolant passes through its data. startinpy returns each observation at its own place, and both agree to
#   1e-12 elsewhere. MetPy returns NaN at all nodes inside a regular field. At 100 scattered stations, half of the calls return
#   NaN and the others raise ZeroDivisionError: rounding decides. One such place ends the call for all places, for instance for
#   a grid with a node at a station.
# Versions: MetPy 1.7.1, startinpy 0.12.3, SciPy 1.17.1
# Seen: 2026-11
# Do: take the observation itself where a place coincides with it (scipy.spatial.cKDTree finds it), and ask only for the others.
# Source: R. Sibson, "A brief description of natural neighbour interpolation", 1981: the interpolant equals the data at their
#   places. MetPy manual, natural_neighbor_to_points, without a restriction. startinpy manual, DT.interpolate, "NNI".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet metpy==1.7.1 startinpy==0.12.3 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import logging
import sys
from importlib.metadata import version

import numpy as np
import startinpy
from metpy.interpolate import natural_neighbor_to_points

logging.disable(logging.CRITICAL)  # MetPy prints Qhull's complaint for every node of the regular field
print({name: version(name) for name in ("metpy", "startinpy", "scipy")})


def by_metpy(points, values, places):  # one call for each place; infinity where it raises
    found = []
    for place in places:
        try:
            found.append(natural_neighbor_to_points(points, values, place[None])[0])
        except ZeroDivisionError:
            found.append(np.inf)
    return np.array(found)


def by_startinpy(points, values, places):
    triangulation = startinpy.DT()
    triangulation.snap_tolerance = 1e-9
    triangulation.insert(np.column_stack([points, values]))
    return np.array(triangulation.interpolate({"method": "NNI"}, places))


axis = np.arange(8.)
field = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
inner = field[((field > 0) & (field < 7)).all(1)]
scattered = np.random.default_rng(1).random((100, 2))
between = np.random.default_rng(2).random((50, 2)) * .6 + .2
changed = False
for name, points, places, nan, raised in (("between the nodes of a regular field", field, between + 3, 0, 0),
                                          ("nodes inside a regular field", field, inner, 36, 0),
                                          ("between scattered stations", scattered, between, 0, 0),
                                          ("at scattered stations", scattered, scattered, 50, 50)):
    values, right = (2 * x[:, 0] - 3 * x[:, 1] + 1 for x in (points, places))
    metpy, start = by_metpy(points, values, places), by_startinpy(points, values, places)
    counts = int(np.isnan(metpy).sum()), int(np.isinf(metpy).sum())
    good = np.isfinite(metpy)
    off = abs(metpy - right)[good].max(initial=0), abs(start - right).max()
    same = abs(counts[0] - nan) <= 10 and abs(counts[1] - raised) <= 10 and sum(counts) == nan + raised and max(off) < 1e-9
    changed |= not same
    print(f"{len(places)} places {name}: MetPy {counts[0]} NaN, {counts[1]} ZeroDivisionError, others within {off[0]:.0e}; "
          f"startinpy all within {off[1]:.0e}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
