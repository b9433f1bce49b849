#!/usr/bin/env bash
# floodlight measures distances in the units of the pitch: players' areas in coordinates of Opta are those of a square pitch.
#
# Surprise: Opta counts both sides of the pitch from 0 to 100, so a step in x is 1.05 m and one in y 0.68 m. floodlight knows
#   length and width of such a pitch and its example of the Voronoi model uses it, but distances are plain differences. Of 22
#   players at random places, 15 % of the pitch goes to another player than the nearest; one player has 4.9 % for 7.2 %. The
#   shares sum to 100 %. In meters the same model is right. mplsoccer turns such coordinates into meters first.
# Versions: floodlight 1.2.0, mplsoccer 1.8.1, SciPy 1.17.1
# Seen: 2026-11
# Do: turn the positions into meters, with Pitch(xlim=(0, 105), ylim=(0, 68), unit="m", boundaries="fixed"), before the model.
# Source: floodlight manual, DiscreteVoronoiModel (the controlling player is the nearest by Euclidean distance; example with
#   Pitch.from_template("opta", length=105, width=68)) and Pitch. mplsoccer manual, "Pitch Basics", and Pitch.voronoi.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet floodlight==1.2.0 mplsoccer==1.8.1 scipy==1.17.1 shapely==2.2.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import shapely
from floodlight import XY, Pitch
from floodlight.models.space import DiscreteVoronoiModel
from mplsoccer import Pitch as OtherPitch
from scipy.spatial import cKDTree

print({name: version(name) for name in ("floodlight", "mplsoccer", "scipy")})
opta = np.random.default_rng(3).random((22, 2)) * 100
meters = opta * [1.05, 0.68]


def shares(pitch, places):
    model = DiscreteVoronoiModel(pitch, xpoints=1000)
    model.fit(XY(places[:11].reshape(1, -1)), XY(places[11:].reshape(1, -1)))
    return np.concatenate([team.property[0] for team in model.player_controls()])


x, y = np.meshgrid((np.arange(2100) + 0.5) / 20, (np.arange(1360) + 0.5) / 20)
grid = np.column_stack([x.ravel(), y.ravel()])
nearest = cKDTree(meters).query(grid)[1]
right = 100 * np.bincount(nearest, minlength=22) / len(grid)
other = np.mean(cKDTree(opta).query(grid / [1.05, 0.68])[1] != nearest)
by_opta = shares(Pitch.from_template("opta", length=105, width=68), opta)
by_meters = shares(Pitch((0, 105), (0, 68), "m", "fixed"), meters)
first = np.arange(22) < 11
polygons = np.empty(22, object)
polygons[first], polygons[~first] = OtherPitch("opta").voronoi(*opta.T, first)
by_mplsoccer = np.array([shapely.Polygon(p).area / 100 for p in polygons])
errors = [abs(s - right).max() for s in (by_opta, by_meters, by_mplsoccer)]
worst = abs(by_opta / right - 1).argmax()
print("largest error of a share, in points of percent: floodlight with Opta {:.2f}, with meters {:.2f}, mplsoccer {:.2f}"
      .format(*errors))
print(f"player {worst}: {by_opta[worst]:.2f} % for {right[worst]:.2f} %; for {other:.1%} of the pitch another player is nearer in "
      f"the units of Opta; floodlight's sum {by_opta.sum():.1f} %")
same = 2.2 < errors[0] < 2.5 and errors[1] < 0.01 and errors[2] < 0.5 and 0.14 < other < 0.17 and \
    abs(by_opta.sum() - 100) < 1e-6
print("as stated" if same else "CHANGED")
sys.exit(not same)
EOF
