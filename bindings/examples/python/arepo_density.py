"""Densities of the cells of a snapshot of AREPO or Gadget: the mass of each cell divided by its volume.

    python arepo_density.py [SNAPSHOT.hdf5] [PartType0]     default: makes a small snapshot and reads it

Needs h5py. The box is periodic, as in cosmological runs; its side is BoxSize of the header. If the snapshot has
densities, the example compares both.
"""

import pathlib
import sys
import tempfile

import h5py
import numpy as np
import pyvotess as vt


def read_snapshot(path, kind):
    """Returns coordinates, masses, the side of the box, and the densities or None."""
    with h5py.File(path) as file:
        header, group = file["Header"].attrs, file[kind]
        points = group["Coordinates"][:]
        if "Masses" in group:
            masses = group["Masses"][:].astype(float)
        else:  # then all particles of a kind have the same mass
            masses = np.full(len(points), header["MassTable"][int(kind[len("PartType"):])])
        density = group["Density"][:] if "Density" in group else None
        return points, masses, float(header["BoxSize"]), density


def write_small_snapshot(path):
    """Writes gas in a box of side 100. Half of it lies in a clump around a corner of the periodic box."""
    rng = np.random.default_rng(1)
    side = 100.0
    points = np.concatenate([rng.random((2000, 3)) * side, rng.normal(0, 8, (2000, 3)) % side])
    points[points >= side] = 0.0  # % rounds a tiny negative number up to the side
    with h5py.File(path, "w") as file:
        header = file.create_group("Header").attrs
        header["BoxSize"] = side
        header["NumPart_ThisFile"] = header["NumPart_Total"] = np.array([len(points), 0, 0, 0, 0, 0])
        header["MassTable"] = np.zeros(6)
        gas = file.create_group("PartType0")
        gas["Coordinates"] = points
        gas["Masses"] = np.full(len(points), 0.5, dtype=np.float32)
        gas["ParticleIDs"] = np.arange(1, len(points) + 1, dtype=np.uint64)


def densities(path, kind="PartType0"):
    points, masses, side, stored = read_snapshot(path, kind)
    cells = vt.tessellate(points, box=(0, 0, 0, side, side, side), periodic=True, want="volumes", precision="double")
    # A duplicate has an empty cell and no density.
    density = np.divide(masses, cells.volumes, out=np.full(len(masses), np.nan), where=cells.volumes > 0)

    print(f"{len(points)} cells of {kind} in a periodic box of {side:g}; mean density {masses.sum() / side**3:.6g}")
    print("volumes fill the box:", bool(np.isclose(cells.volumes.sum(), side**3, rtol=1e-9)))
    low, middle, high = np.nanquantile(density, [0.01, 0.5, 0.99])
    print(f"density: 1 % below {low:.6g}, half below {middle:.6g}, 1 % above {high:.6g}")
    if stored is not None:
        difference = np.nanmax(np.abs(density / stored - 1))
        print(f"largest relative difference from the densities of the file: {difference:.2g}")
    return density


def main():
    if len(sys.argv) > 1:
        densities(*sys.argv[1:3])
        return
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "snapshot.hdf5"
        write_small_snapshot(path)
        densities(path)


if __name__ == "__main__":
    main()
