"""Draws the pictures of exactness.md as SVG, from diagrams that votess computes: pictures.py FOLDER

Seeds lie in the plane z = 0 in the middle of a flat box, so that their cells are prisms over the cells in that plane.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, Iterable, List, Sequence

import numpy as np

import pyvotess as vt

SIZE = 360  # of a panel, pixels
BOX = np.array([[0.0, 0.0], [1.0, 1.0]])
CELL, CELL_2, LINE, FAINT, SEED, OTHER, WRONG = "#9fd0c7", "#dcebe8", "#1f4e5f", "#b8c4c8", "#12303b", "#8b999e", "#c8553d"


class Panel:
    """One square of a picture; the unit square fills it."""

    def __init__(self, number: int = 0) -> None:
        self._shift = number * (SIZE + 20) + 10
        self.shapes: List[str] = []

    def _at(self, p: Sequence[float]) -> str:
        return f"{self._shift + SIZE * p[0]:.2f},{10 + SIZE * (1 - p[1]):.2f}"

    def _put(self, shape: str, style: str) -> None:
        self.shapes.append(f"<{shape} {style}/>")

    def polygon(self, corners: Iterable[Sequence[float]], fill: str = "none", stroke: str = LINE) -> None:
        self._put(f'polygon points="{" ".join(map(self._at, corners))}"', f'fill="{fill}" stroke="{stroke}"')

    def line(self, p: Sequence[float], q: Sequence[float], color: str = LINE, width: float = 1, dashes: str = "") -> None:
        (x1, y1), (x2, y2) = (self._at(end).split(",") for end in (p, q))
        style = f'stroke="{color}" stroke-width="{width}" stroke-dasharray="{dashes}"'
        self._put(f'line x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}"', style)

    def circle(self, center: Sequence[float], radius: float, color: str, dashes: str = "") -> None:
        x, y = self._at(center).split(",")
        style = f'fill="none" stroke="{color}" stroke-width="1.5" stroke-dasharray="{dashes}"'
        self._put(f'circle cx="{x}" cy="{y}" r="{SIZE * radius:.2f}"', style)

    def dot(self, p: Sequence[float], color: str = SEED, pixels: float = 4) -> None:
        x, y = self._at(p).split(",")
        self._put(f'circle cx="{x}" cy="{y}" r="{pixels}"', f'fill="{color}"')

    def text(self, p: Sequence[float], words: str, color: str = SEED) -> None:
        x, y = self._at(p).split(",")
        self.shapes.append(
            f'<text x="{x}" y="{y}" fill="{color}" stroke="none" font-family="sans-serif" font-size="15">{words}</text>'
        )


def write(path: Path, title: str, panels: Sequence[Panel]) -> None:
    width, height = len(panels) * (SIZE + 20), SIZE + 20
    clips = "".join(
        f'<clipPath id="p{k}"><rect x="{k * (SIZE + 20) + 10}" y="10" width="{SIZE}" height="{SIZE}"/></clipPath>'
        for k in range(len(panels))
    )
    groups = "".join(f'<g clip-path="url(#p{k})">{"".join(panel.shapes)}</g>' for k, panel in enumerate(panels))
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">'
        f'<title>{title}</title><rect width="{width}" height="{height}" fill="white"/><defs>{clips}</defs>{groups}</svg>\n',
        encoding="utf-8",
    )


def tessellate(points: Any, want: str = "faces,radii") -> vt.Tessellation:
    """The cells of points in the plane; the box is so flat that distances are those in the plane."""
    seeds = np.column_stack((points, np.zeros(len(points))))
    return vt.tessellate(seeds, box=(*BOX[0], -1e-9, *BOX[1], 1e-9), want=want, device="cpu")


def outline(t: vt.Tessellation, i: int) -> Any:
    """The cell of seed i in the plane: the face on the lower wall of z."""
    first, last = t.neighbors.indptr[i : i + 2]
    face = first + int(np.flatnonzero(t.neighbors.indices[first:last] == -5)[0])
    return t.vertices[t.faces[face]][:, :2]


def neighbors(t: vt.Tessellation, i: int) -> List[int]:
    return [int(j) for j in t.neighbors[i] if j >= 0]


def scattered(count: int, rng_seed: int) -> Any:
    """Points that keep apart, one of them in the middle."""
    points = np.random.default_rng(rng_seed).random((count, 2))
    points[0] = 0.5
    for _ in range(2):
        t = tessellate(points, "faces")
        points[1:] = [outline(t, i).mean(axis=0) for i in range(1, count)]
    return points


def bisectors(points: Any) -> Panel:
    t, panel = tessellate(points), Panel()
    for i in range(len(points)):
        panel.polygon(outline(t, i), stroke=FAINT)
    panel.polygon(outline(t, 0), CELL, "none")
    for j in neighbors(t, 0):
        middle, to = (points[0] + points[j]) / 2, points[j] - points[0]
        along = np.array([-to[1], to[0]]) / np.linalg.norm(to)
        panel.line(middle - along, middle + along, LINE, 0.7, "5 4")
        panel.line(points[0], points[j], WRONG, 1)
    panel.polygon(outline(t, 0))
    for j, p in enumerate(points):
        panel.dot(p, SEED if j == 0 or j in neighbors(t, 0) else OTHER)
    return panel


def security_radius(points: Any) -> Panel:
    t, panel = tessellate(points), Panel()
    radius = float(t.security_radii[0])
    panel.polygon(outline(t, 0), CELL)
    corners = outline(t, 0)
    far = corners[np.argmax(np.linalg.norm(corners - points[0], axis=1))]
    panel.circle(points[0], radius / 2, LINE, "4 4")
    panel.circle(points[0], radius, WRONG)
    panel.line(points[0], far)
    for p in points:
        panel.dot(p, SEED if np.linalg.norm(p - points[0]) <= radius else FAINT)
    return panel


def vertex_balls(points: Any) -> List[Panel]:
    """A vertex of the cell without one of its neighbors, whose ball holds that one; and one of the cell."""
    t = tessellate(points)
    panels = []
    gone = max(neighbors(t, 0), key=lambda j: -np.linalg.norm(points[j] - points[0]))
    for number, kept in enumerate((np.arange(len(points)) != gone, np.ones(len(points), bool))):
        u, panel = tessellate(points[kept]), Panel(number)
        corners = outline(u, 0)
        vertex = corners[np.argmin(np.linalg.norm(corners - points[gone], axis=1))]
        panel.polygon(corners, CELL)
        panel.circle(vertex, float(np.linalg.norm(vertex - points[0])), LINE if number else WRONG)
        for p in points:
            panel.dot(p)
        if not number:
            panel.dot(points[gone], WRONG, 6)
        panel.dot(vertex, LINE if number else WRONG, 3)
        panels.append(panel)
    return panels


def ties() -> List[Panel]:
    lattice = np.stack(np.meshgrid(*2 * [(np.arange(5) + 0.5) / 5], indexing="ij"), -1).reshape(-1, 2)
    panels = []
    for number, move in enumerate((0.0, 0.03)):
        points, panel = lattice.copy(), Panel(number)
        points[12] += (move, move)
        t = tessellate(points)
        listed = neighbors(t, 12)
        for i in range(len(points)):
            panel.polygon(outline(t, i), CELL if i == 12 else CELL_2 if i in listed else "none", FAINT)
        panel.polygon(outline(t, 12))
        for i, p in enumerate(points):
            panel.dot(p, SEED if i == 12 or i in listed else OTHER)
        panel.text((0.03, 0.03), f"{len(listed)} neighbors")
        panels.append(panel)
    return panels


def circle_center(p: Any, q: Any, r: Any) -> Any:
    """The center of the circle through three points, as float64 has it."""
    u, v = q - p, r - p
    uu, vv = u @ u, v @ v
    return p + np.array([v[1] * uu - u[1] * vv, u[0] * vv - v[0] * uu]) / (2 * (u[0] * v[1] - u[1] * v[0]))


def signs() -> List[Panel]:
    """Does a fourth seed lie in the circle of three? For places one float64 apart: in float64, and by votess."""
    count = 40
    p, a, c = np.array([0.1, 0.1]), np.array([12.3, 1.7]), np.array([3.1, 9.9])
    opposite = 2 * circle_center(p, a, c) - p
    panels, found = [Panel(0), Panel(1)], np.empty((2, count, count), int)
    with vt.Tessellator(device="cpu", threads=1) as kept:
        for i in range(count):
            for j in range(count):
                d = opposite + np.spacing(opposite) * (i - count // 2, j - count // 2)
                center = circle_center(p, a, d)
                rough = -np.sign((c - center) @ (c - center) - (p - center) @ (p - center))
                seeds = np.column_stack((np.array([p, a, c, d]), np.zeros(4)))
                t = kept.tessellate(seeds, box=(-30, -30, -1, 40, 40, 1), want="neighbors")
                exact = -1 if 3 in t.neighbors[0] else int(2 in t.neighbors[1])
                found[:, i, j] = rough, exact
    for panel, some in zip(panels, found):
        for i, column in enumerate(some):
            ends = [0, *(np.flatnonzero(np.diff(column)) + 1).tolist(), count]
            for low, high in zip(ends, ends[1:]):  # a run of equal signs
                fill = {-1: CELL, 0: WRONG, 1: "#f4f4f0"}[int(column[low])]
                corners = np.array([(i, low), (i + 1, low), (i + 1, high), (i, high)]) / count
                panel.polygon(corners, fill, fill)
    return panels


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    points = scattered(16, 4)
    write(folder / "bisectors.svg", "A cell and the bisectors that bound it", [bisectors(points)])
    write(folder / "security.svg", "A cell and its security radius", [security_radius(scattered(45, 8))])
    write(folder / "balls.svg", "A vertex that is cut off, and one that is proven", vertex_balls(points))
    write(folder / "ties.svg", "A square lattice, and one with a seed that is moved", ties())
    write(folder / "signs.svg", "The sign of a difference, in float64 and exactly", signs())


if __name__ == "__main__":
    main()
