"""plot(): sections compared with plain geometry, and the arguments of matplotlib."""

import importlib.util
import subprocess
import sys
import unittest

import numpy as np
from helpers import ELL
from helpers import uniform as seeds
from test_export_solvers import torus

import pyvotess as vt
from pyvotess.export import plot as _plot

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    plt = None

BOX = (0, 0, 0, 1, 1, 1)
WANT = ("neighbors", "volumes", "faces")


def area(polygon):
    x, y = polygon.T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


class Sections(unittest.TestCase):
    def test_fills_the_plane(self):
        points = seeds(500)
        t = vt.tessellate(points, box=BOX, want=WANT)
        for axis in range(3):
            for value in (0.001, 0.37, 0.5):
                cells, polygons = _plot.section(t, axis, value)
                self.assertEqual(len(cells), len(polygons))
                self.assertTrue((np.diff(cells) > 0).all())
                areas = [area(p) for p in polygons]
                self.assertGreater(min(areas), 0, "counterclockwise")
                self.assertAlmostEqual(sum(areas), 1, places=10)

    def test_polygons_belong_to_the_nearest_seed(self):
        points = seeds(300, 2)
        t = vt.tessellate(points, box=BOX, want=WANT)
        others = {0: [1, 2], 1: [0, 2], 2: [0, 1]}
        for axis, value in ((0, 0.3), (1, 0.6), (2, 0.9)):
            for cell, polygon in zip(*_plot.section(t, axis, value)):
                middle = np.full(3, value)
                middle[others[axis]] = polygon.mean(axis=0)
                self.assertEqual(np.argmin(((points - middle) ** 2).sum(axis=1)), cell)

    def test_periodic_images_fill_the_box(self):
        sheared = np.array([[1.0, 0, 0], [0.3, 1, 0], [0.2, 0.4, 1]])
        for domain, size in (({"box": BOX, "periodic": True}, np.eye(3)), ({"cell": sheared}, sheared)):
            t = vt.tessellate(seeds(200, 3) @ size, want=WANT, **domain)
            np.testing.assert_allclose(_plot._periods(t), size, atol=1e-12)
            for axis, value in ((0, 0.01), (1, 0.5), (2, 0.99)):
                # Points of the unit square in no polygon, or in more than one.
                at = np.stack(np.meshgrid(np.linspace(0.013, 0.987, 23), np.linspace(0.017, 0.991, 23)), -1)
                held = np.zeros(at.shape[:2], int)
                for _, polygons in _plot._images(t, axis, value):
                    for p in polygons:
                        side = np.roll(p, -1, axis=0) - p
                        off = at[..., None, :] - p
                        held += (side[:, 0] * off[..., 1] - side[:, 1] * off[..., 0] > 0).all(axis=-1)
                self.assertTrue((held == 1).all(), (axis, np.unique(held)))
        t = vt.tessellate(seeds(50, 4), box=BOX, periodic="xy", want=WANT)
        np.testing.assert_allclose(_plot._periods(t), np.eye(3)[:2], atol=1e-12)
        self.assertEqual(len(_plot._periods(vt.tessellate(seeds(50), box=BOX, want=WANT))), 0)

    def test_outside_there_is_nothing(self):
        t = vt.tessellate(seeds(20), box=BOX, want=WANT)
        cells, polygons = _plot.section(t, 0, 2.0)
        self.assertEqual((len(cells), len(polygons)), (0, 0))

    def test_polyhedra(self):
        t = vt.tessellate(np.concatenate([seeds(30), seeds(3)]), box=BOX, want=WANT)  # the last three are duplicates
        cells, words, vertices = _plot._polyhedra(t)
        self.assertEqual(list(cells), list(range(30)))
        at, volumes = 0, []
        for _ in cells:
            end, count = at + 1 + words[at], words[at + 1]
            at, volume = at + 2, 0.0
            for _ in range(count):
                corners = vertices[words[at + 1 : at + 1 + words[at]]]
                at += 1 + words[at]
                for a, b in zip(corners[1:], corners[2:]):
                    volume += np.dot(corners[0], np.cross(a, b)) / 6
            self.assertEqual(at, end)
            volumes.append(volume)
        self.assertEqual(at, len(words))
        np.testing.assert_allclose(volumes, t.volumes[:30], rtol=1e-10)


class SectionsInMesh(unittest.TestCase):
    def test_areas(self):
        """Areas of sections, times the distance between them, sum to the volumes of pieces; holes count as such."""
        for axis, mesh in (("x", ELL), ("y", torus(24, 10)), ("z", torus(24, 10))):
            k = "xyz".index(axis)
            low, high = mesh[0].min(axis=0), mesh[0].max(axis=0)
            pieces = vt.tessellate(low + (high - low) * seeds(20), mesh=mesh).pieces()
            places = np.linspace(low[k], high[k], 201)
            sums = np.zeros(len(pieces))
            for value in (places[1:] + places[:-1]) / 2:
                for piece, rings in zip(*_plot._sections(pieces, k, value)):
                    sums[piece] += sum(x @ np.roll(y, -1) - y @ np.roll(x, -1) for x, y in (ring.T for ring in rings)) / 2
            np.testing.assert_allclose(abs(sums) * (places[1] - places[0]), pieces.volumes, atol=2e-4)
        # A plane through vertices of the mesh, and one through a hole.
        for value, count in ((0.4, 2), (0.4 + 1e-9, 2)):
            _, rings = _plot._sections(vt.tessellate([(1, 1, 0.4)], mesh=torus(24, 10)).pieces(), 2, value)
            self.assertEqual([len(one) for one in rings], [count])


@unittest.skipUnless(plt, "matplotlib is not installed")
class Plot(unittest.TestCase):
    def tearDown(self):
        plt.close("all")

    def test_slice(self):
        t = vt.tessellate(seeds(200), box=BOX, want=WANT)
        axes = t.plot(slice=("y", 0.4))
        cells, polygons = _plot.section(t, 1, 0.4)
        collection = axes.collections[0]
        self.assertEqual(len(collection.get_paths()), len(polygons))
        np.testing.assert_array_equal(collection.get_array(), t.volumes[cells])
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel()), ("x", "z"))
        self.assertEqual((*axes.get_xlim(), *axes.get_ylim()), (0, 1, 0, 1))
        axes.figure.canvas.draw()

    def test_colors_and_axes(self):
        t = vt.tessellate(seeds(100), box=BOX, want=WANT)
        _, ax = plt.subplots()
        self.assertIs(t.plot(("z", 0.5), color="neighbors", ax=ax, cmap="magma"), ax)
        self.assertEqual(ax.collections[0].get_cmap().name, "magma")
        cells, _ = _plot.section(t, 2, 0.5)
        rows = [t.neighbors[i] for i in cells]
        np.testing.assert_array_equal(ax.collections[0].get_array(), [(row >= 0).sum() for row in rows])
        values = np.arange(100.0)
        np.testing.assert_array_equal(t.plot(("z", 0.5), color=values).collections[0].get_array(), values[cells])
        wide = t.plot(("z", 0.5), color=10.0 ** (values / 10))
        self.assertIsInstance(wide.collections[0].norm, matplotlib.colors.LogNorm)

    def test_refused(self):
        points = seeds(50)
        t = vt.tessellate(points, box=BOX, want=WANT)
        for where in (("w", 0.5), ("z",), "z", ("z", "a"), 3):
            with self.assertRaisesRegex(ValueError, "slice is"):
                t.plot(slice=where)
        with self.assertRaisesRegex(ValueError, "0 to 1"):
            t.plot(slice=("x", 1.5))
        with self.assertRaisesRegex(ValueError, "mass"):
            t.plot(("x", 0.5), color="mass")
        with self.assertRaisesRegex(ValueError, r"\(3,\).*50"):
            t.plot(("x", 0.5), color=[1, 2, 3])
        with self.assertRaisesRegex(ValueError, "'faces' into want"):
            vt.tessellate(points, box=BOX).plot(("x", 0.5))


class Space(unittest.TestCase):
    def test_frame_ends_at_the_opening(self):
        """Twelve edges of the box, of which three end halfway to the open corner."""
        ends = _plot._frame(np.array([(1.0, 2, 3), (3, 4, 5)])).reshape(12, 2, 3)
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        self.assertEqual(sorted(lengths), [1.0] * 3 + [2.0] * 9)
        self.assertFalse((ends == (3, 4, 5)).all(axis=2).any())
        self.assertEqual((ends == (1, 2, 3)).all(axis=2).sum(), 3)

    @unittest.skipUnless(importlib.util.find_spec("pyvista"), "pyvista is not installed")
    def test_plotter(self):
        t = vt.tessellate(np.random.default_rng(3).random((50, 3)), box=(0, 0, 0, 1, 1, 1), want="faces,volumes")
        plotter = t.plot(scalar_bar_args={"title": "size"})
        self.addCleanup(plotter.close)
        self.assertEqual(list(plotter.scalar_bars.keys()), ["size"])
        cells = plotter.meshes[0]
        solid = vt.tessellate(t.points, mesh=([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]), want="volumes")
        pieces = solid.plot(color=np.arange(50))
        self.addCleanup(pieces.close)
        self.assertEqual(set(pieces.meshes[0].cell_data["value"]), set(np.flatnonzero(solid.volumes)))
        self.assertAlmostEqual(pieces.meshes[0].volume, 1 / 6, delta=1e-6)
        np.testing.assert_allclose(np.sort(cells.cell_data["volume"]), np.sort(t.volumes[~(t.points > 0.5).all(axis=1)]))


class Imports(unittest.TestCase):
    def run_without(self, *hidden):
        code = (
            f"import sys; sys.modules.update(dict.fromkeys({hidden!r}))\n"
            "import numpy as np, pyvotess as vt\n"
            f"t = vt.tessellate(np.random.default_rng(1).random((20, 3)), want={WANT!r})\n"
            "try:\n    t.plot()\nexcept ImportError as error:\n    print(error)\n"
        )
        return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout

    def test_neither_is_needed_to_import(self):
        self.assertIn("PyVista or matplotlib", self.run_without("matplotlib", "matplotlib.pyplot", "pyvista"))


if __name__ == "__main__":
    unittest.main()
