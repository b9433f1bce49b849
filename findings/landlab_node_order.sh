#!/usr/bin/env bash
# landlab sorts the arrays of the caller: heights of a table belong to other points once its Voronoi grid is made.
#
# Surprise: VoronoiDelaunayGrid(x, y) numbers its nodes by y and then by x. It does so in place, within the arrays that it is given.
#   Afterwards x and y of the caller are in another order, and so are these two columns of a pandas DataFrame. The heights in
#   a third column stay where they were. grid.add_field() takes them without a word, for the lengths agree. Of 500 points
#   on a plane nearly all get the height of another point, and a table that is saved afterwards is wrong too. y is also
#   rounded to 6 decimals. SciPy's Voronoi, which landlab calls, changes neither. Lists are not changed, but the nodes are sorted.
# Versions: landlab 2.11.0, SciPy 1.17.1, pandas 3.1.1
# Seen: 2026-11
# Do: sort first, order = numpy.lexsort((x, y)), and give copies: VoronoiDelaunayGrid(x[order], y[order]), with z[order].
# Source: landlab manual, VoronoiDelaunayGrid: "x: array_like, x-coordinate of points", and ModelGrid.add_field. Neither page
#   says that arrays are changed or that values must be sorted; only an example prints node_x in another order.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet landlab==2.11.0 requireit==0.4.0 scipy==1.17.1 pandas==3.1.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import pandas
from landlab import VoronoiDelaunayGrid
from scipy.spatial import Voronoi

print({name: version(name) for name in ("landlab", "scipy", "pandas")})
rng = np.random.default_rng(1)
count = 500


def plane(x, y):
    return x + 2 * y


def table():
    x, y = (100 * rng.random(count) for _ in range(2))
    return pandas.DataFrame({"x": x, "y": y, "z": plane(x, y)})


changed = False
for name in ("arrays", "columns of a table", "lists", "sorted copies"):
    data = table()
    before = data.copy(deep=True)
    if name == "arrays":
        x, y, z = (data[column].to_numpy(copy=True) for column in "xyz")
        Voronoi(np.c_[x, y])
        kept_by_scipy = np.array_equal(x, before.x) and np.array_equal(y, before.y)
        grid = VoronoiDelaunayGrid(x, y)
    elif name == "columns of a table":
        grid = VoronoiDelaunayGrid(data.x, data.y)
        x, y, z = data.x, data.y, data.z
    elif name == "lists":
        x, y, z = (data[column].tolist() for column in "xyz")
        grid = VoronoiDelaunayGrid(x, y)
        x, y, z = map(np.array, (x, y, z))
    else:
        order = np.lexsort((data.x, data.y))
        x, y, z = (data[column].to_numpy()[order] for column in "xyz")
        grid = VoronoiDelaunayGrid(x.copy(), y.copy())
        before = before.iloc[order]
    grid.add_field("topographic__elevation", z, at="node")
    at_nodes = abs(grid.at_node["topographic__elevation"] - plane(grid.x_of_node, grid.y_of_node))
    in_table = abs(plane(np.asarray(x), np.asarray(y)) - np.asarray(z))
    moved = np.mean(np.asarray(x) != np.asarray(before.x))
    wrong = np.mean(at_nodes > 1e-3), np.mean(in_table > 1e-3)
    stated = {"arrays": (1, 1, 1), "columns of a table": (1, 1, 1), "lists": (0, 1, 0), "sorted copies": (0, 0, 0)}[name]
    same = np.allclose((moved, *wrong), stated, atol=.02) and kept_by_scipy
    changed |= not same
    print(f"{name}: coordinates of the caller moved {moved:.1%}; heights wrong at nodes {wrong[0]:.1%}, by up to {at_nodes.max():.0f} of 300, in the "
          f"data of the caller {wrong[1]:.1%}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
