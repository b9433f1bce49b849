#!/usr/bin/env python3
"""Cells of equal masses under an image: votess alone, or beside POT's semi-discrete solver. See README.md.

    densities.py [--seeds 1e5] [--pixels 1024] [--space]   # CPU seconds of fit_volumes() on one thread, and its steps
    densities.py --pot 20000                               # pip install pot; that many iterations of 32 samples, 1000 seeds

The image is that of the page "Two dimensions". Seeds are uniform. With --space it is a field of pixels^3 with two blobs.
"""

import argparse
import time

import numpy as np

import pyvotess as vt


def blobs(pixels, dimensions):
    """Returns two blobs on black, x first."""
    x = np.indices((pixels,) * dimensions) / (pixels - 1)
    values = 0
    for sharpness, center in ((30, (0.3, 0.6, 0.4)), (60, (0.7, 0.3, 0.6))):
        values = values + np.exp(-sharpness * sum((along - at) ** 2 for along, at in zip(x, center)))
    values[values < 0.1] = 0
    return values / values.mean()


def fit(points, density):
    box = np.repeat((0, 1), points.shape[1])
    began = time.process_time()
    result = vt.fit_volumes(
        points, np.ones(len(points)), box=box, density=density, normalize=True, want="faces,volumes", threads=1
    )
    print(f"{len(points)} seeds, {density.shape}: {result}, {result.tessellations} tessellations,", end=" ")
    print(f"{time.process_time() - began:.2f} CPU s")
    return result


def beside_pot(iterations, pixels):
    from ot.semidiscrete import solve_semidiscrete

    points, density = np.random.default_rng(1).random((1000, 2)), blobs(pixels, 2)
    result = fit(points, density)
    cost = result.tessellation.masses(density).cost(points)
    random, sums = np.random.default_rng(2), np.cumsum(density / density.sum())

    def sample(count):
        pixel = np.searchsorted(sums, random.random(count) * sums[-1])
        return (np.stack(np.divmod(pixel, pixels), 1) + random.random((count, 2))) / pixels

    began = time.process_time()
    weights = np.asarray(solve_semidiscrete(points, sample, max_iter=iterations, batch_size=32))
    seconds = time.process_time() - began
    weights = weights - weights.mean()
    masses = vt.tessellate(points, weights=weights, box=(0, 0, 1, 1), want="faces,volumes").masses(density)
    dual = masses.cost(points) - weights @ masses.masses  # at most the cost, which the best weights reach
    print(f"cost {cost:.8f}, that of POT's weights {dual:.8f}: {1 - dual / cost:.1e} less; {seconds:.1f} CPU s")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=float, default=1e5)
    parser.add_argument("--pixels", type=int, default=1024)
    parser.add_argument("--space", action="store_true")
    parser.add_argument("--pot", type=int)
    given = parser.parse_args()
    if given.pot:
        beside_pot(given.pot, given.pixels)
    else:
        dimensions = 3 if given.space else 2
        fit(np.random.default_rng(1).random((int(given.seeds), dimensions)), blobs(given.pixels, dimensions))
