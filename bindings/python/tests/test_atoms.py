"""Atoms of other packages: imitations, and real objects if the packages are installed."""

import types
import unittest

import numpy as np
import pyvotess as vt

EDGES = np.array([(9.0, 0, 0), (2.0, 8.0, 0), (-1.5, 1.0, 7.0)])


def alloy(count=1000):
    return np.random.default_rng(11).random((count, 3)) @ EDGES


def fcc111_slab():
    """Returns six layers of 4 x 4 copper atoms with 5 Angstrom of vacuum on each side: ASE's fcc111('Cu', (4, 4, 6), vacuum=5)."""
    spacing, layer = 3.61 / np.sqrt(2), 3.61 / np.sqrt(3)
    cell = np.array([(4 * spacing, 0, 0), (2 * spacing, 2 * np.sqrt(3) * spacing, 0), (0, 0, 5 * layer + 10)])
    places = [
        ((i + k % 3 / 3 + (j + k % 3 / 3) / 2) * spacing, (j + k % 3 / 3) * np.sqrt(3) / 2 * spacing, 5 + k * layer)
        for k in range(6) for j in range(4) for i in range(4)
    ]
    return np.array(places), cell


def looks_like(kind, positions, cell, pbc, corner=(0.0, 0.0, 0.0)):
    if kind == "ase":
        displacement = np.reshape(corner, (3, 1))
        return types.SimpleNamespace(
            get_positions=lambda: positions, cell=cell, pbc=np.array(pbc), get_celldisp=lambda: displacement
        )
    if kind == "pymatgen":  # a lattice begins at 0
        positions = positions - np.array(corner)
        return types.SimpleNamespace(cart_coords=positions, lattice=types.SimpleNamespace(matrix=cell, pbc=pbc))

    class Cell:
        def __init__(self):
            self.pbc = pbc

        def __array__(self, dtype=None, copy=None):
            return np.column_stack((cell.T, corner))

    return types.SimpleNamespace(particles=types.SimpleNamespace(positions=positions), cell=Cell())


def real(kind, positions, cell, pbc, corner):
    """Returns the object of the package; None if it is not installed or cannot hold such a system."""
    try:
        if kind == "ase":
            import ase

            return ase.Atoms(f"X{len(positions)}", positions=positions, cell=cell, pbc=pbc, celldisp=corner)
        if kind == "pymatgen":
            from pymatgen.core import Lattice, Structure

            places = positions - corner
            return Structure(Lattice(cell, pbc=pbc), ["Cu"] * len(places), places, coords_are_cartesian=True)
        import ovito.data
    except ImportError:
        return None
    data = ovito.data.DataCollection()
    data.create_cell(np.column_stack((cell.T, corner)), pbc=pbc)
    data.create_particles(count=len(positions)).create_property("Position", data=positions)
    return data


class Atoms(unittest.TestCase):
    def test_displaced_cell_of_ase(self):
        positions = np.array([(-1, -1, 1), (1, 1, 2.5), (1, -1, 4.5)], float)
        atoms = looks_like("ase", positions, np.diag([4.0, 4, 8]), (True, True, False), (-2, -2, -3))
        t = vt.from_ase(atoms)
        np.testing.assert_allclose(t.volumes, [75.1378, 29.5088, 23.3534], rtol=2e-6)
        np.testing.assert_array_equal(t.origin, [-2, -2, -3])
        del atoms.get_celldisp  # other objects may lack it
        atoms.get_positions = lambda: positions + (2, 2, 3)
        np.testing.assert_allclose(vt.from_ase(atoms).volumes, t.volumes, rtol=1e-13)

    def test_corner_in_info(self):
        """ASE 3.29 reads Origin of extended XYZ into info, OVITO 3.17 makes cell_origin of it, while celldisp stays 0."""
        positions, edges = np.array([(-1, -1, 1), (1, 1, 2.5), (1, -1, 4.5)], float), np.diag([4.0, 4, 8])
        expected = vt.tessellate(positions, cell=edges, origin=(-2, -2, -3), periodic="xy").volumes
        atoms = looks_like("ase", positions, edges, (True, True, False))
        for key in ("Origin", "origin", "cell_origin"):
            for corner in (np.array([-2, -2, -3]), np.array([-2.0, -2.0, -3.0]), (-2, -2, -3.0)):
                atoms.info = {"energy": 1.0, key: corner}
                np.testing.assert_array_equal(vt.from_ase(atoms).volumes, expected)
        atoms = looks_like("ase", positions, edges, (True, True, False), (-2, -2, -3))
        atoms.info = {"Origin": np.array([7, 7, 7])}  # celldisp counts
        np.testing.assert_array_equal(vt.from_ase(atoms).volumes, expected)
        for other in ("Freiburg", np.eye(3), None, [True, False, True]):
            atoms.info = {"Origin": other}
            np.testing.assert_array_equal(vt.from_ase(atoms).volumes, expected)

    def test_shifted_tilted_partly_periodic(self):
        corner = np.array((-31.0, 17.5, 4.25))
        positions = corner + alloy(200)
        for pbc in ((True, False, True), (False, True, False), (True, True, True)):
            expected = vt.tessellate(positions, cell=EDGES, origin=corner, periodic=pbc)
            for kind in ("ase", "pymatgen", "ovito"):
                for make in (looks_like, real):
                    atoms = make(kind, positions, EDGES, pbc, corner)
                    if atoms is None:
                        continue
                    t = vt.from_ase(atoms)
                    self.assertEqual(t.periodic, pbc)
                    np.testing.assert_array_equal(t.neighbors.indices, expected.neighbors.indices)
                    np.testing.assert_allclose(t.volumes, expected.volumes, rtol=1e-12)

    def test_periodic_overrides_the_atoms(self):
        positions, cell = fcc111_slab()
        atoms = looks_like("ase", positions, cell, (True, True, False))
        self.assertEqual(vt.from_ase(atoms).periodic, (True, True, False))
        self.assertEqual(vt.from_ase(atoms, periodic=True).periodic, (True, True, True))

    def test_surface_without_vacuum(self):
        positions = alloy(50)
        flat = EDGES.astype(float)
        flat[:2, 2], flat[2] = 0, 0
        t = vt.from_ase(looks_like("ase", positions, flat, (True, True, False)), list_walls=True)
        self.assertEqual(np.isinf(t.volumes).sum(), np.sum([-5 in row for row in t.neighbors]))
        self.assertTrue(t.verify().passed)
        np.testing.assert_array_equal(t.cell[2], 0)

    def test_objects_of_all_packages_give_the_same(self):
        positions = alloy(200)
        expected = vt.tessellate(positions, cell=EDGES, periodic="xz", outside="drop")
        for kind in ("ase", "pymatgen", "ovito"):
            t = vt.from_ase(looks_like(kind, positions, EDGES, (True, False, True)), outside="drop")
            np.testing.assert_array_equal(t.neighbors.indices, expected.neighbors.indices)
            np.testing.assert_array_equal(t.volumes, expected.volumes)
        group = types.SimpleNamespace(positions=positions, dimensions=(9, 8, 7, 90, 60, 90))
        t = vt.from_ase(types.SimpleNamespace(atoms=group))
        np.testing.assert_allclose(t.cell, [(9, 0, 0), (0, 8, 0), (3.5, 0, 7 * np.sqrt(0.75))], rtol=1e-15, atol=1e-15)
        self.assertEqual(t.periodic, (True, True, True))
        group.dimensions = None
        self.assertIsNone(vt.from_ase(types.SimpleNamespace(atoms=group)).cell)

    def test_what_is_refused(self):
        positions = alloy(10)
        with self.assertRaisesRegex(TypeError, "atoms are a str"):
            vt.from_ase("Cu")
        with self.assertRaisesRegex(ValueError, "cell: c is 0, but the cell repeats along it"):
            vt.from_ase(looks_like("ase", positions, EDGES * [[1], [1], [0]], True))
        with self.assertRaisesRegex(ValueError, "periodic= needs a box"):
            vt.from_ase(looks_like("ase", positions, np.zeros((3, 3)), (True, True, False)))
        self.assertIsNone(vt.from_ase(looks_like("ase", positions, np.zeros((3, 3)), (False,) * 3)).cell)
        for name in ("cell", "origin"):
            with self.assertRaisesRegex(TypeError, f"takes {name} from the atoms"):
                vt.from_ase(looks_like("ase", positions, EDGES, (True,) * 3), **{name: None})

    def compare(self, atoms):
        t = vt.from_ase(atoms)
        expected = vt.tessellate(alloy(), cell=EDGES)
        np.testing.assert_allclose(t.volumes, expected.volumes, rtol=1e-5)
        np.testing.assert_array_equal(np.diff(t.neighbors.indptr), np.diff(expected.neighbors.indptr))
        self.assertEqual(t.periodic, (True, True, True))

    def test_ase(self):
        try:
            import ase
            import ase.build
        except ImportError:
            self.skipTest("ASE is not installed")
        self.compare(ase.Atoms("X1000", positions=alloy(), cell=EDGES, pbc=True))
        slab = ase.build.fcc111("Cu", (4, 4, 6), vacuum=5)
        t = vt.from_ase(slab, min_face=1e-6)
        ours, cell = fcc111_slab()
        np.testing.assert_allclose(slab.cell[:], cell, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(
            np.diff(t.neighbors.indptr),
            np.diff(vt.tessellate(ours, cell=cell, periodic="xy", min_face=1e-6).neighbors.indptr),
        )

    def test_pymatgen(self):
        try:
            from pymatgen.core import Lattice, Structure
        except ImportError:
            self.skipTest("pymatgen is not installed")
        self.compare(Structure(Lattice(EDGES), ["Cu"] * 1000, alloy(), coords_are_cartesian=True))

    def test_mdanalysis(self):
        try:
            import MDAnalysis
        except ImportError:
            self.skipTest("MDAnalysis is not installed")
        universe = MDAnalysis.Universe.empty(1000, trajectory=True)
        universe.atoms.positions = alloy()
        lengths = np.linalg.norm(EDGES, axis=1)
        angles = [np.degrees(np.arccos(EDGES[i] @ EDGES[j] / lengths[i] / lengths[j])) for i, j in ((1, 2), (0, 2), (0, 1))]
        universe.dimensions = [*lengths, *angles]  # float32
        t = vt.from_ase(universe)
        np.testing.assert_allclose(t.volumes, vt.tessellate(alloy(), cell=EDGES).volumes, rtol=1e-3)

    def test_ovito_and_freud(self):
        try:
            import freud
            import ovito.data
            import ovito.modifiers
        except ImportError:
            self.skipTest("OVITO and freud are not installed")
        data = ovito.data.DataCollection()
        data.create_cell(np.column_stack((EDGES.T, np.zeros(3))), pbc=(True, True, True))
        particles = data.create_particles(count=1000)
        particles.create_property("Position", data=alloy())
        self.compare(data)
        t = vt.from_ase(data, want="areas,volumes")
        data.apply(ovito.modifiers.VoronoiAnalysisModifier())
        np.testing.assert_allclose(t.volumes, data.particles["Atomic Volume"], rtol=1e-6)
        np.testing.assert_array_equal(np.diff(t.neighbors.indptr), data.particles["Coordination"])
        # freud's box is centered.
        box = freud.box.Box.from_matrix(EDGES.T)
        cells = freud.locality.Voronoi().compute((box, box.wrap(alloy() - EDGES.sum(axis=0) / 2)))
        np.testing.assert_allclose(t.volumes, cells.volumes, rtol=1e-4)


if __name__ == "__main__":
    unittest.main()
