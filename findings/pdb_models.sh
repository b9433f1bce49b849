#!/usr/bin/env bash
# A PDB file with models has no cell for MDAnalysis, one cell for the first model only elsewhere, and an empty structure in ASE.
#
# Surprise: the format states CRYST1 once, before the models, and it holds for all. MDTraj and gemmi have it so. MDAnalysis has no
#   cell for any model, not even of the file that it wrote itself: distances are no longer periodic. ASE, OVITO and chemfiles have
#   one for the first model only. ASE also takes END after ENDMDL for the end of another structure. So read("a.pdb"), which
#   returns the last one, has 0 atoms, and so it is for a file of one model by chemfiles. No program says a word.
# Versions: ASE 3.29.0, MDAnalysis 2.11.0, OVITO 3.17.2, chemfiles 0.10.4, MDTraj 1.11.1.post2, gemmi 0.7.5
# Seen: 2026-11
# Do: read the cell by gemmi and set it in each frame: MDAnalysis.transformations.set_dimensions(). ASE: read(path, ":")[:-1].
# Source: wwPDB, "PDB file format" 3.30: order of records, CRYST1 (mandatory, once) before MODEL, ENDMDL for each model, and END,
#   "mandatory", as the last record of the file.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ase==3.29.0 mdanalysis==2.11.0 mdtraj==1.11.1.post2 chemfiles==0.10.4 ovito==3.17.2 gemmi==0.7.5 numpy==2.4.6
export QT_QPA_PLATFORM=offscreen

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import chemfiles
import gemmi
import MDAnalysis
import mdtraj
import numpy as np
from ase.io import read
from ovito.io import import_file

print({name: version(name) for name in ("ase", "mdanalysis", "ovito", "chemfiles", "mdtraj", "gemmi")})
rng = np.random.default_rng(1)
frames = 10 * rng.random((3, 8, 3))

universe = MDAnalysis.Universe.empty(8, n_residues=1, atom_resindex=[0] * 8, trajectory=True)
for name, values in (("names", ["C"] * 8), ("elements", ["C"] * 8), ("resnames", ["UNK"]), ("resids", [1]), ("chainIDs", ["A"] * 8)):
    universe.add_TopologyAttr(name, values)
with MDAnalysis.Writer("mdanalysis.pdb", n_atoms=8, multiframe=True) as writer:
    for points in frames:
        universe.atoms.positions = points
        universe.dimensions = [10, 10, 10, 90, 90, 90]
        writer.write(universe.atoms)

top = mdtraj.Topology()
residue = top.add_residue("UNK", top.add_chain())
for _ in range(8):
    top.add_atom("C", mdtraj.element.carbon, residue)
mdtraj.Trajectory(frames / 10, top, unitcell_lengths=np.ones((3, 3)), unitcell_angles=np.full((3, 3), 90)).save("mdtraj.pdb")

with chemfiles.Trajectory("chemfiles.pdb", "w") as file:  # one model
    frame = chemfiles.Frame()
    frame.cell = chemfiles.UnitCell([10., 10, 10])
    for point in frames[0]:
        frame.add_atom(chemfiles.Atom("C"), point)
    file.write(frame)

changed = False
for name, count in (("mdanalysis", 3), ("mdtraj", 3), ("chemfiles", 1)):
    path = f"{name}.pdb"
    records = [line.split()[0] for line in open(path)]
    valid = (records.count("CRYST1"), records.count("MODEL"), records.count("ENDMDL"), records[-1]) == (1, count, count, "END")
    file, pipeline = chemfiles.Trajectory(path), import_file(path)
    volumes = {
        "MDTraj": [round(1000 * v) for v in mdtraj.load(path).unitcell_volumes],
        "gemmi": [round(gemmi.read_structure(path).cell.volume)] * len(gemmi.read_structure(path)),
        "MDAnalysis": [0 if ts.dimensions is None else round(ts.volume) for ts in MDAnalysis.Universe(path).trajectory],
        "OVITO": [round(data.cell.volume) if (data := pipeline.compute(k)).cell else 0 for k in range(pipeline.num_frames)],
        "chemfiles": [round(file.read().cell.volume) for _ in range(file.nsteps)],
        "ASE": [round(atoms.cell.volume) for atoms in read(path, ":")],
    }
    first = [1000] + [0] * (count - 1)
    stated = {"MDTraj": [1000] * count, "gemmi": [1000] * count, "OVITO": first, "chemfiles": first, "ASE": first + [0],
              "MDAnalysis": [1000] if name == "chemfiles" else [0] * count}
    same = valid and volumes == stated and len(read(path)) == 0 and [len(atoms) for atoms in read(path, ":")] == [8] * count + [0]
    changed |= not same
    print(f"{path}: {count} models of 8 atoms in a cell of 1000. Volumes: {volumes}; atoms by ASE: {len(read(path))}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
