#!/usr/bin/env bash
# Voronoi volumes of peclet.voro sum to more than the box in crystals, often without a warning.
#
# Surprise: iron, bcc, from ASE in a periodic box. Each atom has the same volume. peclet.voro says that cells fill the box, but
#   those of 10 x 10 x 10 unit cells sum to 1.17 times the box, single ones are up to 1.7 times too large, and neighbors number
#   14 to 23. Nothing warns, though a build warns when its cells are no exact partition. Other sizes and places of the lattice
#   sum to 1.0 to 1.3, some with that warning. fcc copper sums to 1.2, with cells of volume 0. Random points are right, and so
#   are atoms moved by 1e-6 of the box. Voro++ is right in all. The cause are vertices where more than four cells meet.
# Versions: peclet-voro 1.0.4, pyvoro2 0.8.0, ASE 3.29.0
# Seen: 2026-11
# Do: compare the sum of the volumes with the box; move the points a little before the build.
# Source: peclet.voro reference, Tessellation.get_volumes ("sums to the box volume (space-filling)") and build, which warns when
#   the result is "not a guaranteed-exact partition".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet peclet-voro==1.0.4 pyvoro2==0.8.0 ase==3.29.0 scipy==1.17.1 numpy==2.4.6
export OMP_NUM_THREADS=1

venv/bin/python - <<'EOF' 2> errors || { cat errors; exit 1; }
import sys
import warnings
from importlib.metadata import version

import numpy as np
import pyvoro2
from ase.build import bulk
from peclet.voro import Tessellation

print({name: version(name) for name in ("peclet-voro", "pyvoro2", "ase")})


def compare(name, points, side):
    """Prints sums of volumes as shares of the box. Returns that of peclet.voro and whether it warned."""
    points = np.ascontiguousarray(points % side)
    voro = Tessellation()
    voro.set_domain([side] * 3)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        voro.build(points)
    volumes, counts = voro.get_volumes(), voro.get_neighbor_counts()
    box = pyvoro2.OrthorhombicCell(bounds=((0, side),) * 3, periodic=(True,) * 3)
    by_voropp = pyvoro2.compute(points, domain=box).cell_measures.sum() / side**3
    share, shares = volumes.sum() / side**3, volumes * len(points) / side**3
    print(f"{name}: {len(points)} points, sum {share:.4f}, by Voro++ {by_voropp:.4f}; cells {shares.min():.2f} to {shares.max():.2f} "
          f"of the mean, {counts.min()} to {counts.max()} neighbors, {len(caught)} warnings")
    if abs(by_voropp - 1) > 1e-9:
        sys.exit("CHANGED: Voro++")
    return share, bool(caught)


seen = []
for metal in ("Fe", "Cu"):
    for count in (6, 8, 10):
        crystal = bulk(metal, cubic=True).repeat(count)
        side = crystal.cell[0, 0]
        seen.append(compare(f"{metal}, {count}^3 cells", crystal.positions + side / count / 40, side))
random = np.random.default_rng(1)
moved = crystal.positions + random.normal(scale=1e-6 * side, size=crystal.positions.shape)
right = [compare("Cu, moved by 1e-6", moved, side), compare("random", 10 * random.random((2000, 3)), 10.)]
silent = max(share for share, warned in seen if not warned)
if not (silent > 1.01 and sum(share > 1.01 for share, _ in seen) >= 4 and all(abs(share - 1) < 1e-6 for share, _ in right)):
    sys.exit("CHANGED: sums of peclet.voro")
EOF
