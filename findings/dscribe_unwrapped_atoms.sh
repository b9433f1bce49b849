#!/usr/bin/env bash
# DScribe's descriptors and structuretoolkit's neighbors of a periodic structure change when atoms have left the cell.
#
# Surprise: molecular dynamics leaves atoms where they went, some of them outside the cell; the periodic structure is the same as
#   with all atoms wrapped. Of 108 atoms of hot copper 12 are moved by up to two edges of the cell. DScribe's ACSF and SOAP are
#   other numbers for all 108 then, and the first number of ACSF, a sum over the neighbors, falls to 0 for one of them, with
#   periodic=True. structuretoolkit (pyiron) gives wrong distances of the 12 nearest neighbors for 66 atoms, up to 20 angstrom
#   instead of 3. ASE's neighbors, and the same sum over them, stay. Nothing warns. Atoms that leave the cell by a little do no
#   harm, so short runs show nothing.
# Versions: DScribe 2.1.2, structuretoolkit 0.1.0, ASE 3.29.0
# Seen: 2026-11
# Do: call atoms.wrap() on a copy before either of them.
# Source: DScribe manual, SOAP and ACSF, periodic ("Set to true if you want the descriptor output to respect the periodicity of
#   the atomic systems"). structuretoolkit's manual, analyse.get_neighbors, which states no restriction.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet dscribe==2.1.2 structuretoolkit==0.1.0 ase==3.29.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
from ase.build import bulk
from ase.neighborlist import neighbor_list
from dscribe.descriptors import ACSF, SOAP
from structuretoolkit.analyse import get_neighbors

print({name: version(name) for name in ("dscribe", "structuretoolkit", "ase")})
rng = np.random.default_rng(1)
wrapped = bulk("Cu", cubic=True).repeat(3)
wrapped.positions += rng.normal(scale=.1, size=(108, 3))
wrapped.wrap()
left = wrapped.copy()
left.positions[rng.choice(108, 12, replace=False)] += rng.integers(-2, 3, (12, 3)) @ left.cell
acsf = ACSF(species=["Cu"], r_cut=5., periodic=True)  # its first number is a sum over the neighbors, computed by hand below
soap = SOAP(species=["Cu"], r_cut=5., n_max=4, l_max=4, periodic=True)


def by_hand(atoms):
    i, distance = neighbor_list("id", atoms, 5.)
    return np.bincount(i, (np.cos(np.pi * distance / 5) + 1) / 2)[:, None]


def nearest(atoms):
    return np.sort(get_neighbors(atoms, num_neighbors=12).distances, axis=1)


def by_ase(atoms):
    i, distance = neighbor_list("id", atoms, 5.)
    return np.array([np.sort(distance[i == k])[:12] for k in range(108)])


changed = False
for name, f, stated in (("sum by ASE", by_hand, 0), ("ACSF of DScribe", acsf.create, 100), ("SOAP of DScribe", soap.create, 100),
                        ("12 nearest by ASE", by_ase, 0), ("12 nearest by structuretoolkit", nearest, 50)):
    before, after = f(wrapped), f(left)
    wrong = (abs(after - before) > 1e-6 * abs(before).max()).any(axis=1)
    ratio = (after / before)[wrong, -1] if "nearest" in name or "ACSF" in name else []
    same = wrong.sum() >= stated if stated else not wrong.any()
    if "ACSF" in name:
        same &= np.allclose(before, by_hand(wrapped)) and ratio.min() < .01 and ratio.max() < 1
    if "structuretoolkit" in name:
        same &= np.allclose(before, by_ase(wrapped)) and after.max() > 10
    changed |= not same
    print(f"{name}: {wrong.sum()} of 108 atoms change, largest {after.max():.4g} for {before.max():.4g}, ratios "
          f"{f'{min(ratio):.2f} to {max(ratio):.2f}' if len(ratio) else '-'}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
