"""shapes(): bodies of known moments, sampled cells, bad input."""

import unittest

import numpy as np
from helpers import CELL, ELL, UNIT_BOX, lattice, uniform

import pyvotess as vt


class ShapesTest(unittest.TestCase):
    def test_boxes(self):
        """Cells are boxes of 1 x 2 x 4, turned by the cell of the domain."""
        turn, _ = np.linalg.qr(uniform(3))
        sides = np.array([4.0, 2.0, 1.0])
        edges = (turn * sides).T * 3
        points = (lattice(3) / 3) @ edges
        for periodic in (True, False):
            s = vt.tessellate(points, cell=edges, periodic=periodic, want="faces").shapes()
            np.testing.assert_allclose(s.sphericity, (36 * np.pi * 64) ** (1 / 3) / 28, rtol=1e-12)
            np.testing.assert_allclose(s.semi_axes, np.tile(np.sqrt(5 / 12) * sides, (27, 1)), rtol=1e-12)
            np.testing.assert_allclose(s.aspect_ratio, 4, rtol=1e-12)
            np.testing.assert_allclose(np.abs(np.einsum("nij,ji->ni", s.directions, turn)), 1, rtol=1e-12)
            np.testing.assert_allclose(s.moments, np.tile((turn * sides**2 / 12) @ turn.T, (27, 1, 1)), atol=1e-13)

    def test_units(self):
        """Any unit of length for which volumes are numbers."""
        points = uniform(20)
        near = vt.tessellate(points, box=UNIT_BOX, want="faces").shapes()
        for unit in (2.0**-300, 2.0**300):
            far = vt.tessellate(points * unit, box=np.asarray(UNIT_BOX) * unit, want="faces").shapes()
            np.testing.assert_allclose(far.sphericity, near.sphericity, rtol=1e-9)
            np.testing.assert_allclose(far.semi_axes / unit, near.semi_axes, rtol=1e-9)

    def test_a_ball(self):
        walls = vt.walls.sphere((3, 4, 5), 2, 2000)
        s = vt.tessellate([(3, 4, 5)], box=(0, 0, 0, 9, 9, 9), walls=walls, want="faces").shapes()
        np.testing.assert_allclose(s.sphericity, 1, atol=2e-3)
        np.testing.assert_allclose(s.semi_axes, 2, rtol=2e-3)

    def test_samples(self):
        """Moments of places that locate() puts into each cell."""
        points, radii = uniform(12), 0.3 * uniform(12)[:, 0]
        places = np.random.default_rng(3).random((200_000, 3))
        for options in ({}, {"radii": radii}):
            t = vt.tessellate(points, box=UNIT_BOX, want="faces,volumes,surfaces", **options)
            s = t.shapes()
            seed = vt.Diagram(points, box=UNIT_BOX, **options).locate(places)
            for i in np.flatnonzero(t.volumes > 0.03):
                inside = places[np.asarray(seed) == i]
                np.testing.assert_allclose(s.moments[i], np.cov(inside.T, ddof=0), atol=1.2e-3)
            held = t.volumes > 0
            self.assertEqual(np.isnan(s.sphericity).tolist(), (~held).tolist())
            np.testing.assert_allclose((s.sphericity * t.surface_areas)[held], (36 * np.pi * t.volumes[held] ** 2) ** (1 / 3))

    def test_domains(self):
        plane = vt.tessellate((lattice(3) * [2, 1, 1])[::3, :2], box=(0, 0, 6, 3), periodic=True, want="faces").shapes()
        np.testing.assert_allclose(plane.sphericity, 2 * np.sqrt(np.pi * 2) / 6)
        np.testing.assert_allclose(plane.semi_axes, [[2 / np.sqrt(3), 1 / np.sqrt(3)]] * 9)
        self.assertEqual(plane.directions.shape, (9, 2, 2))
        for box, periodic in ((None, False), ((0, 0, 0, 2, 2, 1.5), True)):
            t = vt.tessellate(uniform(20) * [2, 2, 1], mesh=ELL, box=box, periodic=periodic, want="volumes,surfaces")
            s = t.shapes()
            held = t.volumes > 0
            np.testing.assert_allclose((s.sphericity * t.surface_areas)[held], (36 * np.pi * t.volumes[held] ** 2) ** (1 / 3))
        all_of = vt.tessellate(uniform(40), cell=CELL, periodic=True, want="faces").shapes()
        some = vt.tessellate(uniform(40), cell=CELL, periodic=True, only=[3, 7], want="faces").shapes()
        np.testing.assert_allclose(some.moments, all_of.moments[[3, 7]], rtol=1e-9, atol=1e-12)
        dropped = vt.tessellate(uniform(40), cell=CELL, periodic=True, min_face=0.1, want="faces").shapes()
        np.testing.assert_allclose(dropped.semi_axes, all_of.semi_axes, rtol=1e-9)

    def test_columns(self):
        t = vt.tessellate(uniform(10), want="faces")
        s = t.shapes()
        self.assertEqual({name: c.shape for name, c in s.columns.items()}, {
            "sphericity": (10,), "aspect_ratio": (10,), "semi_axes": (10, 3), "directions": (10, 9), "moments": (10, 9)})  # fmt: skip
        self.assertEqual((len(s), repr(s)), (10, "<pyvotess.Shapes of 10 cells>"))
        self.assertEqual(len(vt.tessellate(np.empty((0, 3)), want="faces").shapes()), 0)

    def test_refusals(self):
        with self.assertRaisesRegex(ValueError, "put 'faces' into want"):
            vt.tessellate(uniform(10)).shapes()
        with self.assertRaisesRegex(ValueError, "infinity"):
            vt.tessellate(uniform(10), box="none", want="faces").shapes()
        t = vt.tessellate(uniform(60), box="none", want="faces,volumes")
        self.assertEqual(np.isnan(t.shapes(open="skip").aspect_ratio).tolist(), t.open_cells.tolist())


if __name__ == "__main__":
    unittest.main()
