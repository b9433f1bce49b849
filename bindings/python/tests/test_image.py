"""image(): what the library draws, as an array, a PNG and in notebooks. Pictures themselves are tested in C++."""

import struct
import tempfile
import unittest
import zlib
from pathlib import Path

import numpy as np
from helpers import CUBE, uniform
from test_export_solvers import torus

import pyvotess as vt

BOX = (0, 0, 0, 1, 1, 1)


def decoded(png):
    """Returns the pixels of a PNG of RGBA whose rows have no filter."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    at, data, size = 8, b"", None
    while at < len(png):
        length, name = struct.unpack(">I4s", png[at:at + 8])
        body = png[at + 8:at + 8 + length]
        assert struct.unpack(">I", png[at + 8 + length:at + 12 + length])[0] == zlib.crc32(name + body)
        size = struct.unpack(">IIBBBBB", body) if name == b"IHDR" else size
        data += body if name == b"IDAT" else b""
        at += 12 + length
    width, height, *form = size
    assert form == [8, 6, 0, 0, 0]
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + 4 * width)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(height, width, 4)


class Images(unittest.TestCase):
    def setUp(self):
        self.points = np.random.default_rng(1).random((60, 3))
        self.t = vt.tessellate(self.points, box=BOX, want="volumes,faces")

    def test_png(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "a.png")
            image = self.t.image(file, size=(120, 90), threads=1)
            self.assertEqual(image.pixels.shape, (90, 120, 4))
            np.testing.assert_array_equal(decoded(file.read_bytes()), image.pixels)
            self.assertEqual(file.read_bytes(), image._repr_png_())
            np.testing.assert_array_equal(self.t.image(size=(120, 90), threads=2).pixels, image.pixels)
            with self.assertRaisesRegex(ValueError, r"path is .*a.jpg.*\.png"):
                image.save(Path(folder, "a.jpg"))
            self.assertEqual([path.name for path in Path(folder).iterdir()], ["a.png"])

    def test_colors(self):
        """Two cells side by side have the colors of their values, in space, in a section and in the plane."""
        t = vt.tessellate([[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]], box=BOX, want="volumes,faces")
        flat = vt.tessellate([[0.25, 0.5], [0.75, 0.5]], box=(0, 0, 1, 1), want="volumes,faces,vertices")
        both = {"color": [1, 2], "limits": (1, 2), "size": (200, 200)}
        for pixels in (t.image(slice=("z", 0.5), **both).pixels, flat.image(**both).pixels):
            left, right = pixels[95, 75, :3], pixels[95, 125, :3]
            self.assertGreater(abs(left.astype(int) - right).max(), 80)
            for value, found in zip((1, 2), (left, right)):
                one = t.image(color=[value, value], limits=(1, 2), slice=("z", 0.5), size=(200, 200)).pixels[95, 75, :3]
                np.testing.assert_array_equal(one, found)
        looks = [self.t.image(size=(80, 80), **options).pixels.tobytes() for options in (
            {}, {"cut": "none"}, {"cut": "cells"}, {"cut": "half"}, {"view": (80, 10)}, {"colormap": "ember"}, {"color": "neighbors"},
            {"limits": (0, 1)}, {"slice": ("x", 0.5)}, {"slice": ("x", 0.5), "seeds": True})]
        self.assertEqual(len(set(looks)), len(looks))

    def test_domains(self):
        cube = ([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)],
                [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
        t = vt.tessellate(self.points, mesh=cube, want="volumes")
        whole, pieces = t.image(size=(80, 80), cut="none").pixels, t.image(size=(80, 80), cut="none", gap=0.1).pixels
        self.assertFalse((whole == pieces).all())
        with self.assertRaisesRegex(ValueError, "slice at z = 2 is not inside"):
            t.image(slice=("z", 2))

    def test_section_in_a_mesh(self):
        """A section has the shape of the mesh, holes too, and in a cube that of the box."""
        ring = vt.tessellate(2 * uniform(30), mesh=torus(24, 10))
        options = {"slice": ("z", 0.4), "color": np.ones(30), "limits": (0, 2), "size": (400, 300)}
        pixels = ring.image(**options).pixels[:, :, :3].astype(int)
        colored = np.ptp(pixels, axis=2) > 20
        rows, columns = np.nonzero(colored[:, :330])
        middle = (rows.min() + rows.max()) // 2, (columns.min() + columns.max()) // 2
        self.assertFalse(colored[middle[0] - 5 : middle[0] + 6, middle[1] - 5 : middle[1] + 6].any())
        share = colored[:, :330].sum() / ((np.ptp(rows) + 1) * (np.ptp(columns) + 1))
        self.assertAlmostEqual(share, np.pi * (0.99**2 - 0.41**2) / 1.98**2, delta=0.12)  # lines are not colored
        self.assertFalse((ring.image(**options, seeds=True).pixels[:, :, :3] == pixels).all())
        for axis in "xyz":
            options = {"slice": (axis, 0.3), "color": "x", "limits": (0, 1), "size": (200, 150)}
            solid = vt.tessellate(self.points, mesh=CUBE, want="volumes").image(**options).pixels
            whole = vt.tessellate(self.points, box=BOX, want="volumes,faces").image(**options).pixels
            self.assertLess((abs(solid.astype(int) - whole).max(axis=2) > 60).mean(), 0.03, axis)

    def test_endless(self):
        endless = vt.tessellate(self.points, box="none", want="volumes,faces")
        with self.assertRaisesRegex(ValueError, "reach infinity"):
            endless.image()
        self.assertEqual(endless.image(size=(80, 80), open="skip").left_out, endless.open_cells.sum())
        with self.assertRaisesRegex(ValueError, r"leave out such cells by open='skip', or give a box"):
            endless.image()
        for size, counts in ((3, (1, 3)), (2, (1, 2))):
            for count in counts:
                few = vt.tessellate(self.points[:count, :size], box="none", want="volumes,faces")
                with self.assertRaisesRegex(ValueError, "all cells reach infinity"):
                    few.image(open="skip")

    def test_wrong_values(self):
        for argument, value in [("cut", "all"), ("colormap", "jet"), ("slice", "z"), ("slice", ("w", 0.5)), ("slice", ("z", 2)), ("view", (1, 2, 3)),
                                ("size", 100), ("size", (10, 10)), ("color", [1, 2]), ("limits", (2, 1)), ("open", "keep"), ("gap", -1)]:
            with self.subTest(argument=argument, value=value), self.assertRaisesRegex((ValueError, TypeError), argument):
                self.t.image(**{argument: value})
        with self.assertRaisesRegex(ValueError, "faces"):
            vt.tessellate(self.points, box=BOX).image(color=np.zeros(60))

    def test_polygons(self):
        """Each place of a polygon with a hole has the color of its cell; the hole and the outside have none."""
        outline, hole = [(0, 0), (4, 0), (4, 3), (2, 1), (0, 3)], [(1, 0.25), (1.5, 1), (2, 0.5)]
        city = {"type": "Polygon", "coordinates": [outline, hole]}
        seeds = np.random.default_rng(3).uniform(0, 4, (12, 2))
        t = vt.tessellate(seeds, mesh=city, want="volumes")
        pieces, diagram = t.pieces(), vt.Diagram(seeds, mesh=city)
        look = {"color": np.arange(12.0), "limits": (-0.5, 11.5), "size": (640, 480)}
        pixels = t.image(**look).pixels[:, :, :3].astype(int)
        np.testing.assert_array_equal(pieces.image(**{**look, "color": pieces.cells}).pixels[:, :, :3], pixels)
        # The frame is dark and straight: its corners place the polygon.
        dark = (pixels < 130).all(axis=2) & (np.ptp(pixels, axis=2) < 30)
        columns, rows = np.flatnonzero(dark.sum(axis=0) > 200), np.flatnonzero(dark.sum(axis=1) > 300)
        corner, size = np.array([columns[0], rows[-1]]), np.array([columns[-1] - columns[0], rows[-1] - rows[0]])
        places = np.random.default_rng(4).uniform((0.05, 0.05), (3.95, 2.95), (4000, 2))
        x, y = np.rint(corner + places / (4, 3) * size * (1, -1)).astype(int).T
        cells, found = diagram.locate(places), pixels[y, x]
        means = {cell: np.median(found[cells == cell], axis=0) for cell in np.unique(cells)}
        np.testing.assert_array_equal(means[-1], 255)
        self.assertGreater(min(np.abs(means[a] - means[b]).max() for a in means for b in means if a < b), 5)
        expected = np.array([means[cell] for cell in cells])
        # Lines and their soft borders are the rest.
        self.assertGreater((np.abs(found - expected).max(axis=1) < 4).mean(), 0.93)
        for more in ({"gap": 0.1}, {"seeds": True}):
            self.assertGreater((t.image(**look, **more).pixels[:, :, :3] != pixels).any(axis=2).sum(), 100)

    def test_lines_around_pieces(self):
        """A joint is a line without gaps, also where the mesh has triangles that are thinner than it."""
        around = np.array([(-1, -1), (-0.02, -1), (0.03, -1), (1, -1), (1, 1), (-1, 1)])
        vertices = np.concatenate([np.column_stack((around, np.full(6, height))) for height in (-1, 1)])
        first, beside = np.arange(6), np.roll(np.arange(6), -1)
        sides = np.concatenate((np.column_stack((first, beside, beside + 6)), np.column_stack((first, beside + 6, first + 6))))
        top = np.array([(4, 5, 0), (4, 0, 1), (4, 1, 2), (4, 2, 3)])
        solid = (vertices, np.concatenate((sides, top + 6, top[:, ::-1])))
        t = vt.tessellate([(-0.5, 0, 0), (0.5, 0, 0)], mesh=solid, want="volumes")
        pixels = t.image(cut="none", view=(-90, 0), color=[1, 1], limits=(0, 2), size=(300, 300)).pixels[:, :, :3].astype(int)
        rows = np.flatnonzero((pixels[:, 100:180] != 255).any(axis=2).all(axis=1))[5:-5]
        self.assertGreater(len(rows), 200)
        near = pixels[rows, 100:180].sum(axis=2)
        self.assertGreater((np.median(near, axis=1) - near.min(axis=1)).min(), 80)

    def test_pieces_and_networks(self):
        """A tetrahedron in two pieces; edges of a lattice along the axes."""
        corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        solid = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        t = vt.tessellate([(0.2, 0.2, 0.2), (0.8, 0.2, 0.2)], mesh=solid)
        pieces, look = t.pieces(gap=0.05), {"size": (160, 120)}
        # The default look of a result in a mesh draws the same pieces.
        same = {"color": t.volumes[pieces.cells], "cut": "corner", "limits": (0, 0.2)}
        of_cells = t.image(gap=0.05, color=t.volumes, limits=(0, 0.2), **look).pixels
        np.testing.assert_array_equal(pieces.image(**same, **look).pixels, of_cells)
        first, second = (pieces.image(color=[k, 1 - k], limits=(0, 1), **look).pixels for k in (0, 1))
        self.assertGreater((first != second).any(axis=2).mean(), 0.05)
        for color, message in (("area", "'volume', or a value"), ([1.0], r"\(1,\) for 2 pieces")):
            with self.assertRaisesRegex(ValueError, message):
                pieces.image(color=color)
        lattice = np.stack(np.meshgrid(*[np.arange(3) + 0.5] * 3), -1).reshape(-1, 3)
        network = vt.tessellate(lattice, box=(0, 0, 0, 3, 3, 3), want="faces").network()
        thin, thick = (network.image(width=width, view=(0, 0), size=(200, 200)).pixels for width in (0.02, 0.1))
        shares = [(pixels[:, :150, :3] != 255).any(axis=2).mean() for pixels in (thin, thick)]
        self.assertGreater(shares[1], 2 * shares[0])
        self.assertGreater(shares[0], 0)
        with self.assertRaisesRegex(ValueError, "width is 0"):
            network.image(width=0)


if __name__ == "__main__":
    unittest.main()
