#!/usr/bin/env bash
# A CIF that names its space group by the full symbol is another crystal in ASE, pymatgen and OVITO, mostly without a word.
#
# Surprise: gemmi writes the symbol with its setting, such as "R -3 m:R" or "P 1 21/n 1", and no list of operations. OVITO
#   gives the asymmetric unit alone: 1 atom for 2 of arsenic. ASE refuses all three files. With the number of the group
#   added, ASE follows the number and ignores the setting: 36 atoms of arsenic, 16 for 8 of silicon, and monazite with the right
#   number of atoms at wrong places. pymatgen gives 1 atom with a warning, or 36 and 16 with the number. gemmi reads all
#   as written. With the operations listed, everyone agrees.
# Versions: gemmi 0.7.5, ASE 3.29.0, pymatgen-core 2026.10.16, OVITO 3.17.2
# Seen: 2026-11
# Do: add the loop _symmetry_equiv_pos_as_xyz before such a file is handed on, as below, and compare the number of atoms with
#   Z. Shortest distances show the rest.
# Source: CIF core dictionary 2.4, _symmetry_space_group_name_H-M (the full symbol, with origin and setting where they are not
#   implicit) and _symmetry_Int_Tables_number (the type of the group, which has no setting). International Tables for
#   Crystallography, volume A, groups 14, 166 and 227.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet gemmi==0.7.5 ase==3.29.0 pymatgen-core==2026.10.16 ovito==3.17.2 numpy==2.4.6

venv/bin/python - <<'EOF'
import sys
import warnings
from importlib.metadata import version

import ase.io
import gemmi
import numpy as np
from ase import Atoms
from ovito.io import import_file
from pymatgen.core import Structure
from pymatgen.io.ase import AseAtomsAdaptor

print({name: version(name) for name in ("gemmi", "ase", "pymatgen-core", "ovito")})
crystals = {  # symbol, number, cell, sites
    "arsenic": ("R -3 m:R", 166, (4.13, 4.13, 4.13, 54.2, 54.2, 54.2), {"As1": (.227, .227, .227)}),
    "silicon": ("F d -3 m:2", 227, (5.43, 5.43, 5.43, 90, 90, 90), {"Si1": (.125, .125, .125)}),
    "monazite": ("P 1 21/n 1", 14, (6.831, 7.071, 6.503, 90, 103.27, 90), {
        "La1": (.2815, .1593, .1007), "P1": (.3048, .1630, .6121), "O1": (.2503, .0068, .4477), "O2": (.3799, .3315, .4964),
        "O3": (.4745, .1054, .8018), "O4": (.1277, .2168, .7101)}),
}


def write(name, symbol, number, cell, sites, add):
    structure = gemmi.SmallStructure()
    structure.cell = gemmi.UnitCell(*cell)
    structure.spacegroup_hm = symbol
    structure.determine_and_set_spacegroup("2")
    for label, place in sites.items():
        site = gemmi.SmallStructure.Site()
        site.label = label
        site.type_symbol = label.rstrip("1234")
        site.element = gemmi.Element(site.type_symbol)
        site.fract = gemmi.Fractional(*place)
        site.occ = 1
        structure.add_site(site)
    block = structure.make_cif_block()
    block.name = name
    if "number" in add:
        block.set_pair("_symmetry_Int_Tables_number", str(number))
    if "operations" in add:
        loop = block.init_loop("_symmetry_", ["equiv_pos_as_xyz"])
        for operation in gemmi.SpaceGroup(symbol).operations():
            loop.add_row([gemmi.cif.quote(operation.triplet())])
    file = gemmi.cif.Document()
    file.add_copied_block(block)
    file.write_file("crystal.cif")


def by_gemmi():
    structure = gemmi.read_small_structure("crystal.cif")
    sites = structure.get_all_unit_cell_sites()
    return Atoms([site.element.name for site in sites], scaled_positions=[site.fract.tolist() for site in sites],
                 cell=structure.cell.parameters, pbc=True)


def by_ovito():
    data = import_file("crystal.cif").compute()
    edges = np.array(data.cell[...])
    kinds = data.particles.particle_types
    return Atoms([kinds.type_by_id(k).name for k in kinds], positions=data.particles.positions - edges[:, 3],
                 cell=edges[:, :3].T, pbc=True)


readers = {
    "ASE": lambda: ase.io.read("crystal.cif"),
    "pymatgen": lambda: AseAtomsAdaptor.get_atoms(Structure.from_file("crystal.cif")),
    "OVITO": by_ovito,
}


def places(atoms):
    return atoms.positions @ np.linalg.inv(np.array(atoms.cell))


def summary(atoms, right):
    found = 0
    for place, kind in zip(places(right), right.numbers):
        apart = places(atoms)[atoms.numbers == kind] - place
        found += bool(len(apart)) and abs(apart - np.round(apart)).max(axis=1).min() < 1e-3
    return len(atoms), found


stated = {  # atoms, and how many of the right ones are among them
    ("arsenic", "symbol"): (None, (1, 1), (1, 1)),
    ("arsenic", "symbol, number"): ((36, 2), (36, 2), (1, 1)),
    ("silicon", "symbol"): (None, (1, 1), (1, 1)),
    ("silicon", "symbol, number"): ((16, 4), (16, 4), (1, 1)),
    ("monazite", "symbol"): (None, (24, 24), (6, 6)),
    ("monazite", "symbol, number"): ((24, 12), (24, 24), (6, 6)),
}
changed = False
for name, crystal in crystals.items():
    for add in ("symbol", "symbol, number", "symbol, number, operations"):
        write(name, *crystal, add)
        right = by_gemmi()
        expected = stated.get((name, add), ((len(right), len(right)),) * 3)
        for (text, read), wanted in zip(readers.items(), expected):
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                try:
                    seen = summary(read(), right)
                except Exception as error:
                    seen, kind = None, type(error).__name__
            changed |= seen != wanted
            what = f"refused: {kind}" if seen is None else f"{seen[0]} atoms, {seen[1]} of the right {len(right)} among them"
            print(f"{name:8} {add:26} {text:8} {what}{', warns' if said else ''}", "" if seen == wanted else "CHANGED")
sys.exit(bool(changed))
EOF
