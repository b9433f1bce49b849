#!/usr/bin/env bash
# The areas of spherical Voronoi cells by GMT's sphtriangulate are several times too large.
#
# Surprise: sphtriangulate -Qv -A writes each Voronoi polygon with its area in the header. The polygons are right to 1e-11. For
#   20 points the areas sum to 2.8 times the sphere, for 200 points to 13 times, for 1000 to 36 times; single ones are wrong by
#   factors up to 900, some are right. So weights of stations by area are worthless. Areas of Delaunay triangles (-Qd) are right,
#   and so are those that GMT's own module spatial finds for the same polygons, and those of SciPy.
# Versions: GMT 6.4.0 (Debian 12: gmt 6.4.0+dfsg-2), SciPy 1.17.1
# Seen: 2026-11
# Do: gmt sphtriangulate points.txt -Qv | gmt spatial -Qk -fg, or scipy.spatial.SphericalVoronoi.calculate_areas().
# Source: GMT manual, sphtriangulate, option -A (areas of triangles or polygons in the headers, in square meters). SciPy manual,
#   SphericalVoronoi.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
[[ $(gmt --version 2>/dev/null) == 6.4.0 ]] || { echo "needs GMT 6.4.0: apt-get install gmt on Debian 12" >&2; exit 1; }
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import re
import subprocess
import sys
from importlib.metadata import version

import numpy as np
from scipy.spatial import SphericalVoronoi

print("GMT", subprocess.run(["gmt", "--version"], capture_output=True, text=True).stdout.strip(), "scipy", version("scipy"))
sphere = 4 * np.pi * 6371007.1809**2  # square meters, of GMT's sphere of the area of the Earth


def gmt(*words, text=None):
    return subprocess.run(["gmt", *words], input=text, capture_output=True, text=True, check=True).stdout


def areas(kind, label):
    text = gmt("sphtriangulate", "points.txt", kind, "-A")
    return {int(k): float(area) for k, area in re.findall(rf"> {label}: (\d+) .*Area: (\S+)", text)}


changed = False
for n, stated in ((20, 2.752), (200, 12.902), (1000, 36.182)):
    points = np.random.default_rng(1).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    lon, lat = np.degrees(np.arctan2(points[:, 1], points[:, 0])), np.degrees(np.arcsin(points[:, 2]))
    np.savetxt("points.txt", np.column_stack([lon, lat]), fmt="%.12f")
    voronoi = SphericalVoronoi(points)
    voronoi.sort_vertices_of_regions()
    right = voronoi.calculate_areas() / (4 * np.pi)
    cells = areas("-Qv", "Pol")
    ratio = np.array([cells[k] for k in range(n)]) / sphere / right
    triangles = sum(areas("-Qd", "Triangle").values()) / sphere
    polygons = gmt("sphtriangulate", "points.txt", "-Qv")
    own = sum(float(line.split()[2]) for line in gmt("spatial", "-Qk", "-fg", text=polygons).splitlines()) * 1e6 / sphere
    total = sum(cells.values()) / sphere
    same = abs(total / stated - 1) < 0.01 and abs(triangles - 1) < 1e-4 and abs(own - 1) < 1e-4 and len(cells) == n
    changed |= not same
    print(f"{n} points, in spheres: cells {total:.2f}, one by one {ratio.min():.3f} to {ratio.max():.1f} times the right area; "
          f"triangles {triangles:.5f}; the same cells by gmt spatial {own:.5f}", "" if same else "CHANGED")
sys.exit(changed)
EOF
