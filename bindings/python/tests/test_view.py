"""Pages of view(): what they hold, read again without the code under test. No browser is needed."""

import base64
import json
import re
import unittest
import zlib

import numpy as np
from helpers import ELL, UNIT_BOX, Folder, cells, uniform

import pyvotess as vt

TYPES = {"vertices": "<f4", "loops": "<u4", "drawn": "u1", "sizes": "<u2", "faces": "<u4", "centers": "<f4"}


def unpacked(text, dtype):
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype)


def read(html):
    """Returns the data of a page, with arrays."""
    data = json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', html, re.S)[1])
    data.update({name: unpacked(data[name], dtype) for name, dtype in TYPES.items()})
    data["vertices"], data["centers"] = data["vertices"].reshape(-1, 3), data["centers"].reshape(-1, 3)
    for column in data["columns"]:
        column["steps"] = unpacked(column["steps"], "u1")
        if "values" in column:
            column["values"] = unpacked(column["values"], "<f4")
    return data


def volumes(data):
    """Returns the volumes of the polyhedra, in the units of the page."""
    found, face, first = [], 0, 0
    for count in data["faces"].tolist():
        volume = 0.0
        for size in data["sizes"][face : face + count].tolist():
            a, *others = data["vertices"][data["loops"][first : first + size]].astype(float)
            volume += sum(np.dot(a, np.cross(b, c)) for b, c in zip(others, others[1:])) / 6
            first += size
        found.append(volume)
        face += count
    return np.array(found)


class Page(Folder):
    def test_cells(self):
        for options in ({}, {"periodic": True}, {"walls": [(1, 1, 1, 2.2)], "outside": "drop"}):
            t = cells(**options)
            data = read(t.view(columns={"mass": np.arange(62.0)}).html)
            kept = np.flatnonzero(t.volumes > 0)
            self.assertEqual(data["names"], [f"cell {k}" for k in kept])
            shown = volumes(data)
            np.testing.assert_allclose(shown / shown.sum(), t.volumes[kept] / t.volumes.sum(), atol=1e-6)
            columns = {column["name"]: column for column in data["columns"]}
            self.assertEqual(next(iter(columns)), "volume")
            np.testing.assert_array_equal(columns["mass"]["values"], kept)
            np.testing.assert_array_equal(columns["volume"]["values"], t.volumes[kept].astype(np.float32))
            self.assertEqual(len(data["map"]), 256)
            # All lie in the unit ball, centers within their cells' bounds. Each edge of a cell is drawn once.
            self.assertLessEqual(np.linalg.norm(data["vertices"][data["loops"]], axis=1).max(), 1.0001)
            corners, edges = len(data["loops"]), int(data["drawn"].sum())
            self.assertEqual(corners, 2 * edges)

    def test_colors(self):
        t = vt.tessellate(uniform(9), box=UNIT_BOX, want="faces,volumes")
        steps = read(t.view(color=[1, 2, 3, 4, 5, 6, 7, 8, np.nan]).html)["columns"][0]["steps"]
        self.assertEqual((steps[0], steps[7], steps[8]), (0, 254, 255))
        self.assertTrue((np.diff(steps[:8].astype(int)) > 20).all())
        self.assertEqual(read(t.view(color=np.ones(9)).html)["columns"][0]["steps"].tolist(), [127] * 9)
        red = read(t.view(color=np.tile(np.array([255, 0, 0], np.uint8), (9, 1)), colormap="gray").html)
        self.assertEqual(red["columns"][0]["steps"].tolist(), 9 * [255, 0, 0])
        self.assertTrue(all(len(set(color)) == 1 for color in red["map"]))
        bad = '<script><!--<b>"'
        self.assertEqual(read(t.view(columns={bad: np.ones(9)}).html)["columns"][1]["name"], bad)

    def test_mesh(self):
        t = vt.tessellate(uniform(30) * (2, 2, 1), mesh=ELL, want="volumes")
        pieces = t.pieces()
        for data in (read(t.view().html), read(pieces.view().html)):
            shown = volumes(data)
            np.testing.assert_allclose(shown / shown.sum(), pieces.volumes / pieces.volumes.sum(), atol=1e-6)
        pieces.save(self.path("a.html"), ids=100 + np.arange(30))
        names = read((self.folder / "a.html").read_text("utf-8"))["names"]
        self.assertEqual(names[0], f"piece 0 of cell {100 + pieces.cells[0]}")

    def test_files(self):
        t = cells()
        t.save(self.path("a.html"), color="x", columns={"mass": np.ones(62)})
        html = (self.folder / "a.html").read_text("utf-8")
        self.assertEqual(html, t.view(color="x", columns={"mass": np.ones(62)}).html)
        self.assertIsNone(re.search(r"https?://|src=|@import|import\(", html), "the page needs nothing else")
        self.assertIn("srcdoc", t.view()._repr_html_())
        endless = vt.tessellate(uniform(62), box="none", want="faces,volumes")
        with self.assertRaisesRegex(ValueError, "reach infinity"):
            endless.view()
        self.assertEqual(len(read(endless.view(open="skip").html)["faces"]), int((~endless.open_cells).sum()))
        for points in (np.empty((0, 3)), uniform(1), np.full((3, 3), 0.5)):
            data = read(vt.tessellate(points, box=UNIT_BOX, want="faces,volumes").view().html)
            self.assertEqual(len(data["faces"]), min(len(points), 1))

    def test_sizes(self):
        """The page is the same for any unit of length that is a power of two."""
        pages = [read(vt.tessellate(s * uniform(20), box=s * np.reshape(UNIT_BOX, (2, 3)), want="faces").view().html)
                 for s in (1.0, 2.0**-600, 2.0**600)]
        for data in pages[1:]:
            for name in TYPES:
                np.testing.assert_array_equal(data[name], pages[0][name])

    def test_refused(self):
        t = cells()
        for arguments, says in [
            ({"columns": {"m": np.ones((62, 3))}}, r"'m'.*\(62, 3\)"), ({"columns": {"x": np.ones(62)}}, "'x'"),
            ({"color": "mass"}, "'mass'"), ({"colormap": "jet"}, "'jet'"),
        ]:
            with self.assertRaisesRegex(ValueError, says):
                t.view(**arguments)
        with self.assertRaisesRegex(ValueError, "'faces' into want"):
            vt.tessellate(uniform(9)).view()
        with self.assertRaisesRegex(ValueError, "leave out only="):
            vt.tessellate(uniform(9), only=[5], want="faces").view()
        with self.assertRaisesRegex(ValueError, "three dimensions"):
            vt.tessellate(uniform(9)[:, :2], want="faces").view()
        with self.assertRaisesRegex(ValueError, r"a\.htm.*\.html"):
            t.view().save(self.path("a.htm"))


if __name__ == "__main__":
    unittest.main()
