"""Looks at built pages in a browser: look.py CHROMIUM SITE TARGET

No heading may be narrower than 200 pixels, at two widths of the window. The page of t.view() must show cells, other ones after its
cut moves, and the number of a cell after a click. TARGET gets screenshots of some pages.
"""

from __future__ import annotations

import html
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import List

WIDTHS = (1360, 400)
LEAST = 200
AT_ONCE = 8  # pages in one run of the browser
SHOWN = ("index", "gallery", "python-results", "fracture", "notebook-materials", "exactness")

# Loads each page in a frame, and writes the headings that are too narrow into the document.
HEADINGS = """<!DOCTYPE html><body><script>
async function main() {
    const found = [];
    for (const [page, width] of PAGES) {
        const frame = document.createElement("iframe");
        frame.sandbox = "allow-same-origin";  // without scripts
        frame.style = `width:${width}px;height:900px;border:0`;
        frame.src = page;
        document.body.append(frame);
        await new Promise(done => frame.onload = done);
        for (const heading of frame.contentDocument.querySelectorAll("article :is(h1, h2, h3, h4, h5, h6)")) {
            const wide = heading.getBoundingClientRect().width;
            if (wide < LEAST) found.push(`${page} at ${width}: ${wide.toFixed(0)} pixels: ${heading.textContent.trim()}`);
        }
        frame.remove();
    }
    document.body.innerHTML = "<pre id=found></pre>";
    document.getElementById("found").textContent = JSON.stringify(found);
}
main();
</script>"""

# In the page of t.view(): counts the pixels that are not white, before and after the cut moves, and clicks in the middle.
CELLS = """<script>
window.onload = () => setTimeout(() => {
    const canvas = document.getElementById("canvas"), gl = canvas.getContext("webgl2");
    const seen = () => {
        const pixels = new Uint8Array(4 * canvas.width * canvas.height);
        gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        let sum = 0, dark = 0;
        for (let k = 0; k < pixels.length; k += 4) {
            dark += pixels[k] + pixels[k + 1] + pixels[k + 2] < 700;
            sum = (sum * 31 + pixels[k] + 256 * pixels[k + 1] + 65536 * pixels[k + 2]) % 4294967291;
        }
        return [dark / (canvas.width * canvas.height), sum];
    };
    const before = seen();
    document.getElementById("cut").value = 0.5;
    document.getElementById("cut").dispatchEvent(new Event("input"));
    setTimeout(() => {
        const after = seen();
        canvas.setPointerCapture = () => {};
        const [x, y] = [canvas.clientWidth / 2, canvas.clientHeight / 2];
        for (const type of ["pointerdown", "pointerup"]) canvas.dispatchEvent(new PointerEvent(type, {clientX: x, clientY: y}));
        const found = document.createElement("pre");
        found.id = "found";
        found.textContent = JSON.stringify([before, after, document.getElementById("text").textContent]);
        document.body.append(found);
    }, 500);
}, 1000);
</script>"""


def chromium(browser: str, *arguments: str) -> str:
    with tempfile.TemporaryDirectory() as profile:
        command = [
            browser, "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
            "--disable-web-security", "--allow-file-access-from-files", f"--user-data-dir={profile}", *arguments,
        ]  # fmt: skip
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, timeout=300).stdout


def found(browser: str, folder: Path, name: str, text: str) -> object:
    """Returns what a page writes into its element "found"."""
    page = folder / name
    page.write_text(text, "utf-8")
    try:
        document = chromium(browser, "--virtual-time-budget=20000", "--window-size=1400,900", "--dump-dom", page.as_uri())
    finally:
        page.unlink()
    answer = re.search(r'<pre id="found">(.*?)</pre>', document, re.S)
    return json.loads(html.unescape(answer[1])) if answer else None


def main() -> int:
    browser, site, target = sys.argv[1], Path(sys.argv[2]).resolve(), Path(sys.argv[3])
    target.mkdir(parents=True, exist_ok=True)
    complaints: List[str] = []

    pages = sorted(file.name for file in site.glob("*.html") if file.name != "404.html")
    for first in range(0, len(pages), AT_ONCE):
        pairs = [[page, width] for page in pages[first : first + AT_ONCE] for width in WIDTHS]
        script = HEADINGS.replace("PAGES", json.dumps(pairs)).replace("LEAST", str(LEAST))
        narrow = found(browser, site, "look-headings.html", script)
        complaints += narrow if isinstance(narrow, list) else [f"headings were not read: {pages[first : first + AT_ONCE]}"]

    cells = (site / "made/gallery/cells.html").read_text("utf-8")
    seen = found(browser, site / "made", "look-cells.html", cells.replace("</html>", CELLS + "</html>"))
    if not isinstance(seen, list):
        complaints.append("the page of cells was not read")
    else:
        before, after, text = seen
        if not 0.05 < before[0] < 0.95 or before[1] == after[1] or not 0.02 < after[0] < before[0]:
            complaints.append(f"the page of cells: {before} before the cut, {after} after it")
        if not re.match(r"cell \d+, ", text):
            complaints.append(f"the page of cells: a click says {text!r}")

    for name in SHOWN:
        for width in WIDTHS:
            with tempfile.TemporaryDirectory() as folder:
                frame = Path(folder, "frame.html")  # a window is at least 500 pixels wide
                address = (site / f"{name}.html").as_uri()
                frame.write_text(f'<body style="margin:0"><iframe src="{address}" style="border:0;width:{width}px;height:1000px">')
                size = f"--window-size={max(width, 500)},1000"
                chromium(browser, "--virtual-time-budget=3000", size, f"--screenshot={target / f'{name}-{width}.png'}", frame.as_uri())

    print("".join(f"FAILED: {complaint}\n" for complaint in complaints), end="")
    print(f"{len(pages)} pages at {' and '.join(map(str, WIDTHS))} pixels, {len(complaints)} complaints")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
