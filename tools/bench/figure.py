#!/usr/bin/env python3
"""Draws time per point over the number of points from a JSON file of votess_bench.

    votess_bench --sweep --json speed.json && figure.py speed.json speed.png

Needs matplotlib (Debian, Ubuntu: python3-matplotlib). Exit codes: 0 drawn, 2 bad input or usage.
"""

import argparse
import json
import sys
import textwrap

try:
    import matplotlib
except ImportError:
    sys.exit("figure: needs matplotlib (Debian, Ubuntu: apt-get install python3-matplotlib)")
matplotlib.use("Agg")
from matplotlib import colors, pyplot, ticker  # noqa: E402

PANELS = [
    ("uniform", "neighbors", ("Uniform points", "neighbor lists")),
    ("uniform", "full", ("Uniform points", "lists, volumes, centroids, areas")),
    ("clustered", "neighbors", ("50 normal clusters", "neighbor lists")),
    ("radii", "neighbors", ("Power diagram, random radii", "neighbor lists")),
    ("smooth", "neighbors", ("Power diagram, smooth weights", "neighbor lists, periodic box")),
]
# Colors of Okabe and Ito, which the color-blind can distinguish; each has a marker too.
STYLES = {
    "votess": ("votess", "#0072B2", "o"),
    "voro++": ("Voro++", "#D55E00", "s"),
    "qhull": ("Qhull", "#009E73", "^"),
    "cgal": ("CGAL", "#CC79A7", "D"),
    "geogram": ("GEOGRAM", "#E69F00", "v"),
}
DASHES_OF_VOTESS = ["solid", (0, (4, 1.2)), (0, (2, 1)), (0, (1, 1))]  # fewest threads first
WIDTH_INCHES, ROW_INCHES, PRINT_INCHES, DOTS_PER_INCH = 8.0, 3.0, 0.75, 200
COLUMNS = 3
LABEL_POINTS, SMALL_PRINT_POINTS, SMALL_PRINT_LETTERS = 8, 6, 175


def curves_of(measurements, name, want):
    """{(peer, threads): [(n, median, fastest, slowest)]} in microseconds a point."""
    curves = {}
    for m in measurements:
        if m["input"] == name and m["want"] == want and m["seconds"] and m["peer"] in STYLES:
            per_point = [1e6 * s / m["n"] for s in m["seconds"]]
            point = (m["n"], 1e6 * m["median"] / m["n"], min(per_point), max(per_point))
            curves.setdefault((m["peer"], m["threads"]), []).append(point)
    return {key: sorted(points) for key, points in curves.items()}


def spread(positions, heights):
    """Moves the middles of labels as little as it takes for none to overlap; keeps their order."""
    order = sorted(range(len(positions)), key=positions.__getitem__)
    offsets = [0.0]  # of each label above the lowest, when they touch
    for below, above in zip(order, order[1:]):
        offsets.append(offsets[-1] + (heights[below] + heights[above]) / 2)
    blocks = []  # labels that touch: mean of where their lowest would like to be, how many
    for i, offset in zip(order, offsets):
        mean, count = positions[i] - offset, 1
        while blocks and blocks[-1][0] > mean:
            other_mean, other_count = blocks.pop()
            mean = (mean * count + other_mean * other_count) / (count + other_count)
            count += other_count
        blocks.append((mean, count))
    means = [mean for mean, count in blocks for _ in range(count)]
    moved = list(positions)
    for i, mean, offset in zip(order, means, offsets):
        moved[i] = mean + offset
    return moved


def draw_curves(axes, curves):
    """Returns the last point of each curve, with label and color."""
    threads_of_votess = sorted({threads for peer, threads in curves if peer == "votess"})
    ends = []
    for (peer, threads), points in curves.items():
        n, middle, fastest, slowest = zip(*points)
        label, color, marker = STYLES[peer]
        looks = {"linewidth": 1.2, "markersize": 3, "zorder": 2, "markerfacecolor": color}
        if peer == "votess":
            place = threads_of_votess.index(threads)
            label += f"\n{threads} thread{'s' if threads > 1 else ''}"
            looks = {"linewidth": 1.9, "markersize": 4, "zorder": 3, "markerfacecolor": "white" if place else color,
                     "linestyle": DASHES_OF_VOTESS[place % len(DASHES_OF_VOTESS)]}
        axes.fill_between(n, fastest, slowest, color=color, alpha=0.13, linewidth=0)
        axes.plot(n, middle, color=color, marker=marker, markeredgewidth=0.9, clip_on=False, **looks)
        ends.append((n[-1], middle[-1], label, color))
    return ends


def draw_labels(axes, ends):
    """At the ends of the lines, moved apart where they would overlap; needs the final limits of the axes."""
    last = max(n for n, *_ in ends)
    to_pixels, to_data = axes.transData, axes.transData.inverted()
    edge, pixels = to_pixels.transform([(last, y) for _, y, *_ in ends]).T
    heights = [1.25 * LABEL_POINTS * DOTS_PER_INCH / 72 * (1 + label.count("\n")) for *_, label, _ in ends]
    for (n, y, label, color), x, pixel in zip(ends, edge, spread(list(pixels), heights)):
        moved = to_data.transform((x, pixel))[1]
        if n < last:  # a line that ends early is led to its label
            axes.plot([n, last], [y, moved], color="#999999", linewidth=0.6, linestyle=(0, (1, 2)), zorder=1)
        darker = [0.78 * part for part in colors.to_rgb(color)]
        axes.annotate(label, (last, moved), xytext=(6, 0), textcoords="offset points", color=darker, va="center",
                      fontsize=LABEL_POINTS, fontweight="bold" if "votess" in label else "normal", linespacing=1.05,
                      annotation_clip=False)


def dress(axes, title, first):
    axes.set_xscale("log")
    axes.set_yscale("log")
    for line, text, weight in ((1, title[0], "bold"), (0, title[1], "normal")):
        axes.annotate(text, (0, 1), xytext=(0, 8 + 12 * line), xycoords="axes fraction", textcoords="offset points",
                      fontsize=9, fontweight=weight)
    axes.set_xlabel("points", fontsize=8.5)
    if first:
        axes.set_ylabel("time per point, µs", fontsize=8.5)
    axes.tick_params(labelsize=8, which="both", length=2.5, labelleft=first)
    axes.yaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5), numticks=20))
    axes.yaxis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_major_locator(ticker.LogLocator(numticks=12))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(ticker.NullLocator())
    axes.grid(True, which="major", color="#E2E2E2", linewidth=0.5)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def small_print(data, drawn):
    machine, versions = data["machine"], data["versions"]
    cores = machine["logical_cores"]
    names = ", ".join(f"{STYLES[peer][0]} {versions[peer].removeprefix('qhull_r ').split(' (')[0]}"
                      for peer in STYLES if peer in drawn and peer in versions)
    unbounded = [STYLES[peer][0] for peer in STYLES
                 if any(m["peer"] == peer and not m.get("bounded", True) for m in data["measurements"])]
    flags = " ".join(flag for flag in machine["flags"].split() if not flag.startswith("-W"))
    text = (f"{machine['cpu']}, {cores} logical core{'s' if cores > 1 else ''}; {machine['system']}; "
            f"{machine['compiler']}, {flags}; {machine['date']}. {names}. "
            "Medians of runs that took turns, shaded from the fastest to the slowest; all but votess use one thread.")
    if unbounded:
        listed = " and ".join([", ".join(unbounded[:-1]), unbounded[-1]][-len(unbounded):])
        text += f" {listed} compute the unbounded diagram where the box is not periodic."
    return textwrap.fill(text, SMALL_PRINT_LETTERS)


def draw(data, file):
    panels = [(title, curves_of(data["measurements"], name, want)) for name, want, title in PANELS]
    panels = [(title, curves) for title, curves in panels if curves]
    if not panels:
        raise ValueError("no measurements of any panel: run votess_bench --sweep --json FILE")
    rows, columns = -(-len(panels) // COLUMNS), min(len(panels), COLUMNS)
    height = rows * ROW_INCHES + PRINT_INCHES
    figure, grid = pyplot.subplots(rows, columns, figsize=(WIDTH_INCHES, height), dpi=DOTS_PER_INCH, sharey=True,
                                   squeeze=False)
    figure.subplots_adjust(left=0.066, right=0.887, top=1 - 0.48 / height, bottom=(PRINT_INCHES + 0.25) / height,
                           wspace=0.53, hspace=0.42)
    for axes in grid.flat[len(panels):]:
        axes.set_axis_off()
    ends = []
    for k, (axes, (title, curves)) in enumerate(zip(grid.flat, panels)):
        dress(axes, title, k % columns == 0)
        ends.append(draw_curves(axes, curves))
    for axes, (_, curves) in zip(grid.flat, panels):
        numbers = [n for points in curves.values() for n, *_ in points]
        axes.set_xlim(min(numbers) / 1.15, max(numbers) * 1.0001)
    lowest, highest = grid[0][0].get_ylim()
    grid[0][0].set_ylim(lowest / 1.15, highest)
    figure.canvas.draw()  # settles the limits
    for axes, panel_ends in zip(grid.flat, ends):
        draw_labels(axes, panel_ends)
    drawn = {peer for _, curves in panels for peer, _ in curves}
    figure.text(0.01, 0.022, small_print(data, drawn), fontsize=SMALL_PRINT_POINTS, color="#555555", linespacing=1.5)
    figure.savefig(file, dpi=DOTS_PER_INCH)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("json", help="written by votess_bench --sweep --json FILE")
    parser.add_argument("image", help="a .png, .pdf or .svg file")
    arguments = parser.parse_args()
    try:
        with open(arguments.json, encoding="utf-8") as file:
            data = json.load(file)
        draw(data, arguments.image)
    except (OSError, ValueError, KeyError) as error:
        print(f"figure: {arguments.json}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
