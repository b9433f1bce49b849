#!/usr/bin/env bash
# Densities in .xsf: ASE and sisl write them stretched, OVITO reads valid ones squeezed, and the grids of ASE are lost or refused.
#
# Surprise: grids of .xsf have points on both ends of each vector, so a periodic density of n points is written as n + 1 over the
#   edges of the cell. ASE writes n points over n + 1 steps, and sisl n points over n steps. In a cell of 5.64 angstrom with 20
#   points, a density that lies around an atom then lies 0.61 and 0.31 angstrom from it, and its integral is 1.35 and 1.17 instead of 1.
#   OVITO takes all points for one period: it reads sisl's file as meant, and a valid one 0.28 angstrom off. pymatgen returns
#   the numbers as they are. ASE also leaves an underscore out of BEGIN_DATAGRID_3D_: OVITO then has a grid of no points,
#   without a word, and pymatgen a ValueError. The atoms are right.
# Versions: ASE 3.29.0, sisl 0.20.0, OVITO 3.17.2, pymatgen 2026.10.24
# Seen: 2026-12
# Do: use .cube. For a valid .xsf pass np.pad(data, (0, 1), mode="wrap"), origin=(0, 0, 0) and span_vectors=atoms.cell to ASE and mend
#   the keyword; for OVITO drop the last points and shorten the vectors.
# Source: xcrysden.org/doc/XSF.html, sections General vs. Periodic grids, and Datagrids (files hold general grids, also of periodic
#   functions). A comment in ase/io/xsf.py of 3.29.0 doubts its own vectors.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ase==3.29.0 sisl==0.20.0 ovito==3.17.2 pymatgen==2026.10.24 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version
from pathlib import Path

import ase
import numpy as np
import sisl
from ase.io.cube import write_cube
from ase.io.xsf import write_xsf
from ovito.io import import_file
from ovito.modifiers import CreateIsosurfaceModifier
from pymatgen.io.xcrysden import XSF

print({name: version(name) for name in ("ase", "sisl", "ovito", "pymatgen")})
edge = 5.64
place = np.array([.75, .5, .5]) * edge
atoms = ase.Atoms("Ar", positions=[place], cell=[edge] * 3, pbc=True)


def density(count):
    """Returns a periodic density around the atom, of integral 1, at count points along each edge."""
    x, y, z = (np.exp(6 * np.cos(2 * np.pi * (np.arange(count) / count - each / edge))) for each in place)
    values = x[:, None, None] * y[:, None] * z
    return values / values.sum() / (edge / count) ** 3


def by_format(name):
    """Returns how far the peak is from the atom, and the integral, by the format and the numbers that pymatgen reads."""
    try:
        grid = next(iter(XSF.from_file(name).grids.values()))
    except ValueError:
        return "refused", "refused"
    values = grid.data[0]
    steps = grid.lattice / (np.array(values.shape)[:, None] - 1)
    peak = np.array(np.unravel_index(values.argmax(), values.shape)) @ steps + grid.origin
    period = values[:-1, :-1, :-1] if np.allclose(values[0], values[-1]) else values
    return np.linalg.norm(peak - place), period.sum() * abs(np.linalg.det(steps))


def by_ovito(name):
    """Returns how far the middle of the surface at half of the peak is from the atom."""
    pipeline = import_file(name)
    grid = next(iter(pipeline.compute().grids.values()))
    if not grid.keys():
        return "no points"
    field = list(grid.keys())[0]
    pipeline.modifiers.append(CreateIsosurfaceModifier(operate_on=f"voxels:{grid.identifier}", property=field,
                                                       isolevel=float(np.max(grid[field])) / 2))
    corners = np.asarray(pipeline.compute().surfaces["isosurface"].vertices["Position"])
    return np.linalg.norm((corners.min(axis=0) + corners.max(axis=0)) / 2 - place)


def mend(name, into):
    Path(into).write_text(Path(name).read_text().replace("DATAGRID_3Dgrid", "DATAGRID_3D_grid"))


changed = False
for count, stated in ((20, {"ase": ("refused", "refused", "no points"), "ase, keyword mended": (.6107, 1.350, .2908),
                            "sisl": (.3054, 1.166, 0), "valid": (0, 1, .2763)}),
                      (40, {"ase": ("refused", "refused", "no points"), "ase, keyword mended": (.2976, 1.162, .1451),
                            "sisl": (.1488, 1.079, 0), "valid": (0, 1, .1416)})):
    values = density(count)
    with open("ase.xsf", "w") as file:
        write_xsf(file, [atoms], data=values)
    with open("padded.xsf", "w") as file:
        write_xsf(file, [atoms], data=np.pad(values, (0, 1), mode="wrap"), origin=np.zeros(3), span_vectors=atoms.cell)
    mend("ase.xsf", "ase, keyword mended.xsf")
    mend("padded.xsf", "valid.xsf")
    grid = sisl.Grid((count,) * 3, geometry=sisl.Geometry.new(atoms))
    grid.grid[...] = values
    grid.write("sisl.xsf")
    with open("one.cube", "w") as file:
        write_cube(file, atoms, data=values)
    off = by_ovito("one.cube")
    changed |= off > .001
    print(f"{count} points, .cube: OVITO {off:.4f} angstrom off")
    for name, figures in stated.items():
        seen = *by_format(f"{name}.xsf"), by_ovito(f"{name}.xsf")
        same = all(a == b if isinstance(a, str) or isinstance(b, str) else abs(a - b) < .002 for a, b in zip(seen, figures))
        changed |= not same
        peak, integral, off = (each if isinstance(each, str) else f"{each:.4f}" for each in seen)
        print(f"{count} points, {name}: by the format {peak} angstrom off, integral {integral}; OVITO {off}",
              "" if same else f"CHANGED, was {figures}")
sys.exit(bool(changed))
EOF
