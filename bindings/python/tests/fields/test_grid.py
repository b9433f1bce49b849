"""Diagram.to_grid(): totals, projections, closed forms, arguments."""

import unittest
import warnings

import numpy as np
from helpers import CELL, UNIT_BOX, lattice, uniform

import pyvotess as vt

METHODS = ("mean", "dtfe", "nearest", "sibson")


class Totals(unittest.TestCase):
    def test_mean_keeps_values_times_volumes(self):
        points = uniform(300, seed=3)
        for domain in ({"box": UNIT_BOX}, {"box": UNIT_BOX, "periodic": True}, {"cell": CELL, "periodic": "xz"}):
            places = points @ np.asarray(CELL, float) if "cell" in domain else points
            volumes = vt.tessellate(places, **domain).volumes
            values = np.c_[1 / volumes, np.arange(300)]
            grid = vt.Diagram(places, **domain).to_grid(values, (8, 5, 6))
            self.assertEqual(grid.shape, (8, 5, 6, 2))
            np.testing.assert_allclose(
                grid.mean((0, 1, 2)) * volumes.sum(), volumes @ values, rtol=1e-12, err_msg=str(domain)
            )

    def test_dtfe_keeps_the_mass(self):
        points, masses = uniform(300, seed=4), np.arange(1, 301)
        grid = vt.Diagram(points, box=UNIT_BOX, periodic=True).to_grid(masses, 16, "dtfe")
        np.testing.assert_allclose(grid.mean(), masses.sum(), rtol=1e-12)

    def test_seeds_without_a_tetrahedron_warn(self):
        plane = uniform(40, seed=5) * (1, 1, 0) + (0, 0, 0.5)
        with self.assertWarnsRegex(UserWarning, "mass of 40 of 40 seeds, which are in no"):
            grid = vt.Diagram(plane, box=UNIT_BOX).to_grid(np.ones(40), 2, "dtfe")
        self.assertTrue((grid == 0).all())

    def test_projections_sum_along_an_axis(self):
        diagram = vt.Diagram(uniform(200, seed=6), box=((0, 0, 0), (1, 2, 3)))
        values = uniform(200, seed=7)[:, 0]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # omitted mass
            for method in METHODS:
                whole = diagram.to_grid(values, (4, 6, 5), method)
                for axis in range(3):
                    projected = diagram.to_grid(values, (4, 6, 5), method, project=axis)
                    expected = whole.mean(axis) * (axis + 1)
                    np.testing.assert_allclose(projected, expected, rtol=1e-11, err_msg=f"{method} {axis}")


class Fields(unittest.TestCase):
    def test_a_grid_as_fine_as_a_lattice_has_its_values(self):
        points = lattice(5) / 5
        values = np.arange(125.0)
        diagram = vt.Diagram(points, box=UNIT_BOX)
        for method in ("mean", "nearest", "sibson"):
            grid = diagram.to_grid(values, 5, method)
            at = tuple(np.rint(points.T * 5 - 0.5).astype(int))
            np.testing.assert_allclose(grid[at], values, rtol=1e-12, atol=1e-12, err_msg=method)

    def test_centers_are_asked(self):
        points = uniform(100, seed=8)
        diagram, values = vt.Diagram(points, box=UNIT_BOX), uniform(100, seed=9)
        centers = (np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 3) + 0.5) / 4
        nearest = diagram.to_grid(values, 4, "nearest").reshape(-1, 3)
        np.testing.assert_array_equal(nearest, values[diagram.locate(centers)])
        smooth = diagram.to_grid(values, 4, "sibson").reshape(-1, 3)
        np.testing.assert_allclose(smooth, diagram.interpolate(values, centers), rtol=1e-11)


class Input(unittest.TestCase):
    def test_refused(self):
        diagram = vt.Diagram(uniform(10), box=UNIT_BOX)
        ones = np.ones(10)
        for message, values, shape, options in (
            ("values has shape", np.ones(9), 4, {}),
            ("values has shape", np.ones((10, 1, 1)), 4, {}),
            ("shape is 0", ones, 0, {}),
            ("shape is 2.5", ones, 2.5, {}),
            ("1048576", ones, (1, 1, 2**21), {}),
            (r"shape is \(2, 2\)", ones, (2, 2), {}),
            ("method", ones, 2, {"method": "cic"}),
            ("project is 3", ones, 2, {"project": 3}),
            ("columns", np.ones((10, 0)), 2, {}),
        ):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                diagram.to_grid(values, shape, **options)

    def test_no_seeds(self):
        diagram = vt.Diagram(np.empty((0, 3)), box=UNIT_BOX)
        for method in METHODS:
            self.assertTrue((diagram.to_grid([], 3, method) == 0).all())
