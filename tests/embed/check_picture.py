"""Compares a PNG file that bindings/examples/vulkan_frames drew with the one that the README shows.

Usage: check_picture.py DRAWN EXPECTED. Blocks of 8 x 8 pixels are compared, because the drawn picture may have fewer
rays a pixel. That makes a mean difference of 1.4 levels; the same scene with other seeds differs by 13.
"""

import sys

import matplotlib.image
import numpy as np

drawn, expected = (255.0 * matplotlib.image.imread(file)[:, :, :3] for file in sys.argv[1:])
if drawn.shape != expected.shape:
    sys.exit(f"{sys.argv[1]} has shape {drawn.shape}, not {expected.shape}")
height, width, _ = drawn.shape
blocks = (drawn - expected).reshape(height // 8, 8, width // 8, 8, 3).mean(axis=(1, 3))
difference = np.abs(blocks).mean()
print(f"mean difference from {sys.argv[2]}: {difference:.2f} of 255 levels")
if difference > 3:
    sys.exit("more than 3: another picture")
