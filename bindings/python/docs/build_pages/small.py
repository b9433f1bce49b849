"""Writes small copies of the pictures of pages, for readers of the sources on GitHub: small.py MADE PAGES

They go to PAGES/made, where the links of the pages find them. The site has the pictures as they were made.
"""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parents[4]
OTHERS = {"speed.png": ROOT / "tools/bench/results/speed.png", "frame.png": ROOT / "tests/embed/frame.png"}
LINK = re.compile(r"\]\(made/([^)\s]+\.(?:png|svg))\)")
WIDTH, HEIGHT = 320, 260  # pixels at most
COLORS = 40


def main() -> None:
    made, pages = map(Path, sys.argv[1:])
    target = pages / "made"
    shutil.rmtree(target, ignore_errors=True)
    names = sorted({name for page in pages.glob("*.md") for name in LINK.findall(page.read_text("utf-8"))})
    for name in names:
        source, copy = OTHERS.get(name, made / name), target / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        if name.endswith(".svg"):
            shutil.copy(source, copy)
            continue
        with Image.open(source) as picture:
            opaque = Image.new("RGB", picture.size, "white")
            opaque.paste(picture, mask=picture.convert("RGBA").getchannel("A"))
        opaque.thumbnail((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
        opaque.quantize(COLORS, dither=Image.Dither.NONE).save(copy, optimize=True)
    size = sum(file.stat().st_size for file in target.rglob("*.*"))
    print(f"{len(names)} pictures, {size} bytes")


if __name__ == "__main__":
    main()
