"""Diagram.to_grid(): projections, arguments."""

import unittest
import warnings

import numpy as np
from helpers import UNIT_BOX, uniform

import pyvotess as vt

METHODS = ("mean", "dtfe", "nearest", "sibson")


class Totals(unittest.TestCase):
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
            (r"values has shape \(10, 0\)", np.ones((10, 0)), 2, {}),
        ):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                diagram.to_grid(values, shape, **options)
