"""HTML of results for notebooks: a table, and a small picture, drawn without another package."""

from __future__ import annotations

import base64
from html import escape
from typing import TYPE_CHECKING, Any, Callable, List, Tuple

import numpy as np

from .colors import map_values
from .columns import color_values
from .plot import sections_in_box

if TYPE_CHECKING:
    from .._state import SeedCells
    from .._types import Float64Array

    Rows = List[Tuple[str, str]]

_PIXELS = 260  # of the longer side
_MAX_SEEDS = 200_000  # the section takes well below a second
_MAX_POLYGONS = 3_000
_EDGE = "#1f4e5f"


def _rows(t: SeedCells) -> Rows:
    stats = t.stats
    rows = [("seeds", f"{len(t)}"), ("domain", t._where()), ("arrays", ", ".join(t.wanted) or "status only")]
    if "neighbors" in t.wanted:
        rows.append(("mean faces", f"{stats.mean_faces:.4f}"))
    if "volumes" in t.wanted:
        rows.append(("volume sum", f"{stats.volume_sum:.10g} of {stats.box_volume:.10g}"))
    if stats.duplicates:
        rows.append(("duplicates", f"{stats.duplicates}"))
    if stats.empty_cells:
        rows.append(("empty cells", f"{stats.empty_cells}"))
    rows.append(("device", f"{stats.device}, {stats.seconds.total:.3g} s"))
    return rows


def _picture(t: SeedCells) -> str:
    """Returns the section through the middle, across the shortest side of the domain; "" without one."""
    if t.planar or "faces" not in t.wanted or not 0 < len(t) <= _MAX_SEEDS:
        return ""
    box = np.asarray(t.box)
    sides = np.ptp(box, axis=0)
    axis = 2 if sides[2] <= sides.min() * (1 + 1e-9) else int(np.argmin(sides))
    cells, polygons = sections_in_box(t, axis, float(box[:, axis].mean()))
    if not 0 < len(polygons) <= _MAX_POLYGONS:
        return ""
    others = [k for k in range(3) if k != axis]
    lower, upper = box[:, others]
    scale = _PIXELS / float((upper - lower).max())
    width, height = (float(x) for x in (upper - lower) * scale)
    color: Any = "volumes" if "volumes" in t.wanted else "neighbors"
    rgb = map_values(color_values(t, color)[0], "tide")[cells]
    shapes = []
    for polygon, (red, green, blue) in zip(polygons, rgb.tolist()):
        places = (polygon - lower) * scale
        points = " ".join(f"{x:.1f},{height - y:.1f}" for x, y in places.tolist())
        shapes.append(f'<polygon points="{points}" fill="#{red:02x}{green:02x}{blue:02x}"/>')
    names = "".join("xyz"[k] for k in others)
    title = f"section {names} at {'xyz'[axis]} = {box[:, axis].mean():g}, colored by {color}"
    return _svg(title, shapes, width, height, ' stroke="black" stroke-width="0.5" stroke-opacity="0.6"')


def _page(thing: object, rows: Callable[[], Rows], picture: Callable[[], str]) -> str:
    """Returns the HTML. It never raises: after an error the picture is missing, or the text is plain."""
    try:
        table = "".join(
            f'<tr><th style="text-align:left">{escape(name)}</th><td style="text-align:left">{escape(text)}</td></tr>'
            for name, text in rows()
        )
    except Exception:
        return f"<pre>{escape(object.__repr__(thing))}</pre>"
    try:
        drawn = picture()
    except Exception:
        drawn = ""
    return (
        '<div style="display:flex;gap:1.5em;align-items:center">'
        f"<table><caption>pyvotess.{type(thing).__name__}</caption>{table}</table>{drawn}</div>"
    )


def as_html(t: SeedCells) -> str:
    return _page(t, lambda: _rows(t), lambda: _picture(t))


def html_of_fit(fit: Any) -> str:
    def rows() -> Rows:
        return [
            ("residual", f"{fit.residual:.1e} of a volume"),
            ("steps", f"{fit.steps}, {fit.tessellations} tessellations"),
            ("weights", f"{fit.weights.min():.6g} to {fit.weights.max():.6g}" if len(fit.weights) else "none"),
            *_rows(fit.tessellation),
        ]

    return _page(fit, rows, lambda: _picture(fit.tessellation))


def _svg(title: str, shapes: List[str], width: float = _PIXELS, height: float = _PIXELS, style: str = "") -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.1f} {height:.1f}"{style}><title>{escape(title)}</title>{"".join(shapes)}</svg>'
    )


def _seen(points: Float64Array) -> Float64Array:
    """Returns (K, 3) pixels to the right, pixels down, and nearness, as seen from the front above."""
    if points.shape[1] == 2:
        seen = np.insert(points, 2, 0.0, axis=1)
    else:
        (c, s), (e, f) = ((np.cos(angle), np.sin(angle)) for angle in np.radians((36.0, 27.0)))
        seen = points @ np.array([(-s, c, 0), (-f * c, -f * s, e), (e * c, e * s, f)]).T
    lower, upper = seen.min(axis=0)[:2], seen.max(axis=0)[:2]
    scale = (_PIXELS - 8) / max(float((upper - lower).max()), float(np.finfo(float).tiny))
    middle = (lower + upper) / 2
    seen[:, :2] = _PIXELS / 2 + (seen[:, :2] - middle) * (scale, -scale)
    return seen


def html_of_network(n: Any) -> str:
    def rows() -> Rows:
        found = [("vertices", f"{len(n.points)}, {int(n.at_walls.sum())} at walls"), ("edges", f"{len(n.edges)}")]
        if len(n.points):
            found.append(("largest sphere", f"radius {n.vertex_radii.max():.6g}"))
        if len(n.edges):
            found.append(("edges' radii", f"{n.edge_radii.min():.6g} to {n.edge_radii.max():.6g}"))
        return found

    def picture() -> str:
        if not 0 < len(n.edges) <= _MAX_POLYGONS:
            return ""
        first = n.points[n.edges[:, 0]]
        ends = _seen(np.concatenate((first, first + n.vectors))).reshape(2, -1, 3)
        widest = max(float(n.edge_radii.max()), float(np.finfo(float).tiny))
        widths = 0.4 + 3.6 * np.clip(n.edge_radii / widest, 0, 1)
        red, green, blue = map_values(n.edge_radii, "tide").T.tolist()
        lines = [
            f'<line x1="{ends[0, k, 0]:.1f}" y1="{ends[0, k, 1]:.1f}" x2="{ends[1, k, 0]:.1f}" y2="{ends[1, k, 1]:.1f}" '
            f'stroke="#{red[k]:02x}{green[k]:02x}{blue[k]:02x}" stroke-width="{widths[k]:.1f}"/>'
            for k in np.argsort(ends[:, :, 2].sum(axis=0)).tolist()
        ]
        return _svg("edges, wide where there is room", lines)

    return _page(n, rows, picture)


def html_of_pieces(pieces: Any) -> str:
    def rows() -> Rows:
        found = [("pieces", f"{len(pieces)} of {int((pieces.counts > 0).sum())} cells")]
        if len(pieces):
            found += [
                ("most of one cell", f"{pieces.counts.max()}"),
                ("edges" if pieces.planar else "triangles", f"{len(pieces.triangles)}, {int(pieces.on_surface.sum())} on the surface"),
                ("area sum" if pieces.planar else "volume sum", f"{pieces.volumes.sum():.10g}"),
                ("areas" if pieces.planar else "volumes", f"{pieces.volumes.min():.6g} to {pieces.volumes.max():.6g}"),
            ]
        return found

    def picture() -> str:
        if pieces.planar:
            return ""
        triangles = pieces._corners
        a, b, c = np.moveaxis(_seen(pieces.vertices)[triangles], 1, 0)
        one, two = b - a, c - a
        turn = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
        front = np.flatnonzero(turn < 0)  # y goes down
        if not 0 < len(front) <= _MAX_POLYGONS:
            return ""
        normals = np.cross(*(pieces.vertices[triangles[front, k]] - pieces.vertices[triangles[front, 0]] for k in (1, 2)))
        normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
        light = 0.6 + 0.4 * np.abs(normals @ (0.48, 0.36, 0.8))
        shown = (map_values(pieces.volumes, "tide")[pieces._piece_of[front]] * light[:, None]).astype(int)
        order = np.argsort((a + b + c)[front, 2])
        corners = np.stack((a, b, c), axis=1)[front, :, :2]
        shapes = []
        for k in order.tolist():
            color = "#{:02x}{:02x}{:02x}".format(*shown[k])
            points = " ".join(f"{x:.1f},{y:.1f}" for x, y in corners[k].tolist())
            shapes.append(f'<polygon points="{points}" fill="{color}" stroke="{color}" stroke-width="0.5"/>')
        return _svg("pieces, colored by volume", shapes)

    return _page(pieces, rows, picture)


def html_of_zones(zones: Any) -> str:
    def rows() -> Rows:
        sizes = np.bincount(zones.labels[zones.labels >= 0], minlength=len(zones))
        found = [("zones", f"{len(zones)}, of {'maxima' if zones.maxima else 'minima'}"), ("cells", f"{len(zones.labels)}")]
        if len(zones):
            found += [("cells of a zone", f"{sizes.min()} to {sizes.max()}"), ("adjacent pairs", f"{len(zones.pairs)}")]
        deep = np.sort(zones.persistence[np.isfinite(zones.persistence)])[::-1]
        if len(deep):
            found.append(("persistence", ", ".join(f"{x:.4g}" for x in deep[:4]) + (", ..." if len(deep) > 4 else "")))
        return found

    def picture() -> str:
        deep = np.sort(zones.persistence[np.isfinite(zones.persistence)])[::-1]
        if not len(deep) or not deep[0] > 0:
            return ""
        # How many zones remain at each threshold, on a logarithmic scale.
        height, some = _PIXELS / 2, deep[np.unique(np.linspace(0, len(deep) - 1, 200).astype(int))]
        remain = 1 + np.searchsorted(-deep, -some, side="right")
        x = 4 + (_PIXELS - 8) * some / deep[0]
        y = height - 4 - (height - 24) * np.log(remain) / np.log(len(deep) + 1.0)
        line = " ".join(f"{across:.1f},{up:.1f}" for across, up in zip(x.tolist(), y.tolist()))
        shapes = [
            f'<polyline points="{line}" fill="none" stroke="{_EDGE}" stroke-width="1.5"/>',
            f'<text x="{_PIXELS - 4}" y="14" font-size="11" text-anchor="end" fill="{_EDGE}">'
            f"zones after merge(0 to {deep[0]:.3g})</text>",
        ]
        return _svg("number of zones that remain, by threshold", shapes, _PIXELS, height)

    return _page(zones, rows, picture)


def html_of_diagram(d: Any) -> str:
    def picture() -> str:
        from .image import Image

        low, high = d._shown
        if not (high > low).all():
            return ""
        # The cell of each pixel, in the plane through the middle across the last axis.
        across, up = (high - low)[:2] / float((high - low)[:2].max()) * _PIXELS / 2
        width, height = max(int(across), 1), max(int(up), 1)
        x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height)[::-1] + 0.5) / height)
        middle = np.full(x.shape, 0.5)
        places = low + np.stack((x, y, middle)[: len(low)], axis=-1).reshape(-1, len(low)) * (high - low)
        cells = d.locate(places)
        spread = cells.astype(np.float64) * 0.6180339887498949 % 1  # neighbors in number have colors far apart
        colors = np.append(map_values(np.where(cells >= 0, spread, np.nan), "tide"), np.full((len(cells), 1), 255, np.uint8), 1)
        png = Image(colors.reshape(height, width, 4).astype(np.uint8), 0)._repr_png_()
        data = base64.b64encode(png).decode()
        return f'<img width="{2 * width}" height="{2 * height}" alt="cells of a section" src="data:image/png;base64,{data}">'

    return _page(d, lambda: [("seeds", f"{len(d)}"), ("domain", d._where)], picture)
