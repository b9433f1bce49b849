"""Coordination of the atoms of a slab, from the Voronoi cells of its atoms.

    python ase_slab.py [FILE]     any file that ASE reads; default: 5 layers of Pt(111)

Needs ASE. ASE says along which edges a slab repeats: a and b. Along c its cells end at the walls of the box.
"""

import sys

import ase.build
import ase.io
import numpy as np
import pyvotess as vt


def coordination(atoms):
    """Returns the number of neighbors and the volume of each atom's cell.

    Positions of a crystal are rounded. So cells that should touch in an edge or a corner share a tiny face; min_face
    drops faces below this share of the mean face.
    """
    cells = vt.from_ase(atoms, want="neighbors,volumes", min_face=1e-3)
    return np.diff(cells.neighbors.indptr), cells.volumes


def main():
    if len(sys.argv) > 1:
        atoms = ase.io.read(sys.argv[1])
    else:
        atoms = ase.build.fcc111("Pt", size=(4, 4, 5), vacuum=6.0)
    neighbors, volumes = coordination(atoms)

    heights = np.round(atoms.positions[:, 2], 3)
    print(f"{len(atoms)} atoms of {atoms.get_chemical_formula()}, periodic along {atoms.pbc}")
    for height in np.unique(heights):
        layer = heights == height
        counts = ", ".join(f"{n} ({k} atoms)" for n, k in zip(*np.unique(neighbors[layer], return_counts=True)))
        print(f"layer at {height:8.3f}: neighbors {counts}; mean volume {volumes[layer].mean():.3f}")


if __name__ == "__main__":
    main()
