"""HTML of a result for notebooks: a table, and a section as SVG, drawn without another package."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any, List, Tuple

import numpy as np

from .colors import map_values
from .columns import color_values
from .plot import sections_in_box

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._state import SeedCells

    Float64Array = npt.NDArray[np.float64]

_PIXELS = 260  # of the longer side
_MAX_SEEDS = 200_000  # the section takes well below a second
_MAX_POLYGONS = 3_000


def _rows(t: SeedCells) -> List[Tuple[str, str]]:
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
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.1f} {height:.1f}" stroke="black" stroke-width="0.5" stroke-opacity="0.6">'
        f"<title>section {names} at {'xyz'[axis]} = {box[:, axis].mean():g}, colored by {color}</title>"
        f"{''.join(shapes)}</svg>"
    )


def as_html(t: SeedCells) -> str:
    """Returns the HTML. It never raises: after an error the picture is missing, or the text is plain."""
    try:
        rows = "".join(
            f'<tr><th style="text-align:left">{escape(name)}</th><td style="text-align:left">{escape(text)}</td></tr>'
            for name, text in _rows(t)
        )
    except Exception:
        return f"<pre>{escape(object.__repr__(t))}</pre>"
    try:
        picture = _picture(t)
    except Exception:
        picture = ""
    return (
        '<div style="display:flex;gap:1.5em;align-items:center">'
        f"<table><caption>pyvotess.Tessellation</caption>{rows}</table>{picture}</div>"
    )
