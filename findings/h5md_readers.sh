#!/usr/bin/env bash
# Valid H5MD files are refused without words by MDAnalysis, and rows that pad a frame become its atoms.
#
# Surprise: H5MD 1.1 lets a box be constant in time, and lets step be one number for even steps. pyh5md writes both. MDAnalysis
#   raises a KeyError of HDF5 for the first, and an OSError without any text for the second. ZnH5MD uses even steps by default,
#   so its files are refused too. Its files with store="time" are read, and a frame with fewer atoms has atoms at NaN.
#   ZnH5MD refuses all files of pyh5md, because they have no species, which H5MD does not require.
# Versions: pyh5md 1.2.0, ZnH5MD 0.4.8, MDAnalysis 2.11.0, h5py 3.16.0
# Seen: 2026-11
# Do: write step, time and the box for each frame. Drop rows that are NaN after reading.
# Source: H5MD 1.1, "Time-dependent data" (step and time as scalars of constant increments), "Simulation box" (edges constant
#   or time-dependent), "Particles group" (elements such as species are optional). H5MD states no fill value: NaN is ZnH5MD's.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pyh5md==1.2.0 znh5md==0.4.8 MDAnalysis==2.11.0 h5py==3.16.0 ase==3.29.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase
import MDAnalysis
import numpy as np
import pyh5md
import znh5md

print({name: version(name) for name in ("pyh5md", "znh5md", "MDAnalysis", "h5py")})
places = np.random.default_rng(0).random((2, 4, 3)) * 4


def by_pyh5md(name, steps, box):
    file = pyh5md.File(name, "w", author="A", creator="finding", creator_version="1")
    group = file.particles_group("all")
    boundary = ["periodic"] * 3
    if box == "constant":
        group.create_box(dimension=3, boundary=boundary, store="fixed", data=np.array([4., 4., 4.]))
    else:
        group.create_box(dimension=3, boundary=boundary, store="time", time=True, shape=(3,), dtype=float)
    stored = dict(store="linear", step=10, time=.5) if steps == "even" else dict(store="time", time=True)
    position = pyh5md.element(group, "position", shape=(4, 3), dtype=float, **stored)
    for k in range(2):
        position.append(places[k], 10 * k, time=.5 * k)
        if box != "constant":
            group.box.edges.append(np.array([4., 4., 4.]), 10 * k, time=.5 * k)
    file.close()


def by_znh5md(name, **options):
    frames = [ase.Atoms("H4", positions=places[0], cell=[4] * 3, pbc=True),
              ase.Atoms("H2", positions=places[1][:2], cell=[4] * 3, pbc=True)]
    znh5md.IO(name, **options).extend(frames)


def read(name, atoms=4):
    """Returns the number of rows that are NaN by frame, or the exception."""
    try:
        universe = MDAnalysis.Universe.empty(atoms)
        universe.load_new(name, convert_units=False)
        return [int(np.isnan(ts.positions).any(axis=1).sum()) for ts in universe.trajectory]
    except Exception as error:
        return type(error).__name__, len(str(error)) > 0


def read_znh5md(name):
    try:
        return [len(atoms) for atoms in znh5md.IO(name)[:]]
    except Exception as error:
        return type(error).__name__, len(str(error)) > 0


by_pyh5md("listed.h5md", "listed", "by frame")
by_pyh5md("constant_box.h5md", "listed", "constant")
by_pyh5md("even_steps.h5md", "even", "by frame")
by_znh5md("znh5md.h5md")
by_znh5md("znh5md_listed.h5md", store="time")
stated = {
    "listed": ([0, 0], ("KeyError", True)),
    "constant_box": (("KeyError", True), ("KeyError", True)),
    "even_steps": (("OSError", False), ("KeyError", True)),
    "znh5md": (("OSError", False), [4, 2]),
    "znh5md_listed": ([0, 2], [4, 2]),
}
changed = False
for name, (mdanalysis, zn) in stated.items():
    seen = read(f"{name}.h5md"), read_znh5md(f"{name}.h5md")
    same = seen == (mdanalysis, zn)
    changed |= not same
    print(f"{name:13} MDAnalysis, rows of NaN or (exception, has text): {seen[0]}; ZnH5MD, atoms or exception: {seen[1]}",
          "" if same else f"CHANGED, was {mdanalysis}, {zn}")
sys.exit(bool(changed))
EOF
