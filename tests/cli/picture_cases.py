"""--image: a PNG file of the requested size and content."""

import os
import struct
import zlib

import numpy as np

from cli_test import HIDDEN, CliTest, random_points


def read_png(path):
    """Returns (height, width, 3) uint8, by the PNG specification: chunks, zlib, one filter for each row."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, header = 8, b"", None
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + size]
        assert struct.unpack(">I", data[at + 8 + size : at + 12 + size])[0] == zlib.crc32(kind + body)
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        if kind == b"IDAT":
            packed += body
        at += 12 + size
    assert kind == b"IEND"
    width, height, depth, color, compression, filters, interlace = header
    assert (depth, color, compression, filters, interlace) == (8, 2, 0, 0, 0)
    raw, size = zlib.decompress(packed), 3 * width
    assert len(raw) == height * (size + 1)
    image, above = bytearray(), bytes(size)
    for y in range(height):
        kind, line = raw[y * (size + 1)], bytearray(raw[y * (size + 1) + 1 : (y + 1) * (size + 1)])
        for x in range(size if kind else 0):
            left, up, corner = (line[x - 3], above[x], above[x - 3]) if x >= 3 else (0, above[x], 0)
            nearest = min((abs(up - corner), 0, left), (abs(left - corner), 1, up), (abs(left + up - 2 * corner), 2, corner))
            line[x] = (line[x] + (0, left, up, (left + up) // 2, nearest[2])[kind]) & 255
        above = line
        image += line
    return np.frombuffer(bytes(image), np.uint8).reshape(height, width, 3)


def colored(image):
    """Returns where the picture is colored: not background, text or lines."""
    wide = image.astype(np.int64)
    return wide.max(axis=2) - wide.min(axis=2) > 40


class Pictures(CliTest):
    def picture(self, *arguments, size="200x150", **options):
        self.run_cli(*arguments, "-q", "--image", "a.png", "--image-size", size, **options)
        return read_png(self.folder / "a.png")

    def test_solid(self):
        image = self.picture("--random", 500, size="400x300")
        self.assertEqual(image.shape, (300, 400, 3))
        self.assertTrue((image[[0, 0, -1, -1], [0, -1, 0, -1]] == 255).all())
        self.assertGreater(colored(image).mean(), 0.3)
        self.assertGreater(len(np.unique(image.reshape(-1, 3), axis=0)), 1000)
        self.assertEqual(self.files(), ["a.png"])

    def test_options_matter(self):
        plain = self.picture("--random", 200)
        for options in [["--cut", "none"], ["--cut", "half"], ["--cut", "cells"], ["--view", "120,-20"],
                        ["--color", "neighbors"], ["--color", "area"], ["--color", "x"], ["--color", "index"],
                        ["--colormap", "ember"], ["--colormap", "gray"], ["--slice", "x=0.5"]]:
            with self.subTest(options):
                other = self.picture("--random", 200, *options)
                self.assertEqual(other.shape, plain.shape)
                self.assertGreater(np.abs(other.astype(int) - plain.astype(int)).mean(), 1)

    def test_slice(self):
        # Each cell has one color, constant along z: a slice by z shows stripes along y, a slice by x one color.
        points = np.stack([np.arange(8) + 0.5, np.full(8, 4.0), np.full(8, 4.0)], axis=1)
        self.put("row.npy", points)
        box = ["--box", "0,0,0,8,8,8"]
        image = self.picture("row.npy", *box, "--color", "x", "--slice", "z=3", size="600x480")
        rows, columns = np.nonzero(colored(image))
        used = np.unique(columns)
        gap = used[np.flatnonzero(np.diff(used) > 3)[0]]  # before the color bar
        rows, columns = rows[columns <= gap], columns[columns <= gap]
        self.assertAlmostEqual(np.ptp(rows), np.ptp(columns), delta=2)
        middle = image[(rows.min() + rows.max()) // 2, columns.min() + 4 : columns.max() - 4].astype(int)
        steps = np.flatnonzero(np.abs(np.diff(middle, axis=0)).sum(axis=1) > 60)
        self.assertEqual(1 + np.count_nonzero(np.diff(steps) > 10), 7, "lines between eight stripes")
        one = self.picture("row.npy", *box, "--color", "x", "--slice", "x=2.2", size="600x480")
        shades = np.unique(one[100:300, 200:380].reshape(-1, 3), axis=0)
        self.assertEqual(len(shades), 1)
        dots = self.picture("row.npy", *box, "--color", "x", "--slice", "z=4", "--seeds", size="600x480")
        bare = self.picture("row.npy", *box, "--color", "x", "--slice", "z=4", size="600x480")
        self.assertGreater((dots != bare).any(axis=2).sum(), 8 * 4)

    def test_beside_outputs(self):
        """The picture changes nothing in the other files."""
        self.run_cli("--random", 300, "-q", "-o", "plain.txt", "-o", "plain.npz")
        self.run_cli("--random", 300, "-q", "-o", "with.txt", "-o", "with.npz", "--image", "a.png")
        for kind in ["txt", "npz"]:
            self.assertEqual((self.folder / f"plain.{kind}").read_bytes(), (self.folder / f"with.{kind}").read_bytes())

    def test_bad_calls(self):
        self.put("p.npy", random_points(20))
        call = ["p.npy", "--image", "a.png"]
        for arguments, says in [
            (["p.npy", "--image", "a.jpg"], ["a.jpg", ".png"]),
            (["p.npy", "--image", "none/a.png"], "none"),
            (["p.npy", "--slice", "x=0.5"], ["--slice", "--image"]),
            (["p.npy", "--image-size", "100x100"], "--image"),
            (["p.npy", "--seeds"], "--image"),
            (["p.npy", "--color", "area"], ["--image", ".glb"]),
            (["p.npy", "--colormap", "gray", "-o", "a.ply"], ["--colormap", ".glb"]),
            ([*call, "--seeds"], "--slice"),
            ([*call, "--slice", "w=1"], ["--slice", "w=1"]),
            ([*call, "--slice", "x="], "x="),
            ([*call, "--slice", "x=nan"], "x"),
            ([*call, "--slice", "z=7"], ["z = 7", "spans"]),
            ([*call, "--slice", "z=0.5", "--cut", "none"], "--cut"),
            ([*call, "--slice", "z=0.5", "--view", "1,2"], "--view"),
            ([*call, "--image-size", "40x400"], "40x400"),
            ([*call, "--image-size", "400"], "400"),
            ([*call, "--image-size", "400x99999"], "99999"),
            ([*call, "--color", "mass"], ["mass", "volume"]),
            ([*call, "--colormap", "jet"], ["jet", "tide"]),
            ([*call, "--cut", "all"], ["all", "corner"]),
            ([*call, "--view", "10"], "10"),
            ([*call, "--view", "10,95"], "10,95"),
        ]:
            with self.subTest(arguments):
                self.refuse(*arguments, says=says)
        self.put("empty.txt", "")
        self.refuse("empty.txt", "--image", "a.png", says="no cell")

    def test_without_driver(self):
        """Pictures need no Vulkan."""
        seen = self.picture("--random", 300)
        self.run_cli("--random", 300, "-q", "--image", "b.png", "--image-size", "200x150",
                     env={**os.environ, **HIDDEN})
        self.assertTrue((read_png(self.folder / "b.png") == seen).all())
