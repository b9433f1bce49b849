"""Looks at built pages in a browser: look.py CHROMIUM SITE TARGET

No heading may be narrower than 200 pixels, at two widths of the window. The page of t.view() must show cells, other ones
after its cut moves, and the number of a cell after a click. The search must find a word, without a server. TARGET gets
screenshots of some pages. The browser is driven by its own protocol, https://chromedevtools.github.io/devtools-protocol/.
"""

from __future__ import annotations

import asyncio
import base64
import itertools
import json
import re
import sys
import tempfile
from pathlib import Path
from typing import Any, List

from tornado.websocket import websocket_connect

WIDTHS = (1360, 400)
LEAST = 200
SHOWN = ("index", "gallery", "python-results", "fracture", "notebook-materials", "exactness")
FLAGS = (
    "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
    "--remote-debugging-port=0", "--no-first-run",
)  # fmt: skip

NARROW = f"""[...document.querySelectorAll("article :is(h1, h2, h3, h4, h5, h6)")]
    .map(heading => [heading.getBoundingClientRect().width, heading.textContent.trim()]).filter(([width]) => width < {LEAST})"""

# The share of pixels of the canvas that are not white, and a sum over all.
PIXELS = """(() => {
    const canvas = document.getElementById("canvas"), gl = canvas.getContext("webgl2");
    const pixels = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let sum = 0, dark = 0;
    for (let k = 0; k < pixels.length; k += 4) {
        dark += pixels[k] + pixels[k + 1] + pixels[k + 2] < 700;
        sum = (sum * 31 + pixels[k] + 256 * pixels[k + 1] + 65536 * pixels[k + 2]) % 4294967291;
    }
    return [dark / (canvas.width * canvas.height), sum];
})()"""
CUT = """new Promise(done => {
    document.getElementById("cut").value = 0.5;
    document.getElementById("cut").dispatchEvent(new Event("input"));
    requestAnimationFrame(() => requestAnimationFrame(done));
})"""


# Searches for a word, and returns the number of pages that are found.
SEARCH = """new Promise(done => {
    const input = document.querySelector(".md-search__input");
    input.focus();
    input.value = "watershed";
    input.dispatchEvent(new Event("keyup", {bubbles: true}));
    const begin = Date.now(), timer = setInterval(() => {
        const found = parseInt(document.querySelector(".md-search-result__meta").textContent);
        if (found || Date.now() > begin + 30000) { clearInterval(timer); done(found || 0); }
    }, 100);
})"""


class Browser:
    """One page of a browser."""

    def __init__(self, socket: Any) -> None:
        self._socket, self._numbers, self._session = socket, itertools.count(1), ""

    async def call(self, method: str, **arguments: Any) -> Any:
        """Returns the answer to a command."""
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": arguments}
        if self._session:
            message["sessionId"] = self._session
        await self._socket.write_message(json.dumps(message))
        while True:
            answer = json.loads(await asyncio.wait_for(self._socket.read_message(), 60))
            if answer.get("id") == number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    async def begin(self) -> None:
        target = await self.call("Target.createTarget", url="about:blank")
        attached = await self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)
        self._session = attached["sessionId"]

    async def open(self, file: Path, width: int, height: int = 1000) -> None:
        """Shows a page, and returns when all of it is there."""
        await self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False
        )
        answer = await self.call("Page.navigate", url=file.resolve().as_uri())
        if "errorText" in answer:
            raise RuntimeError(f"{file}: {answer['errorText']}")
        while not await self.get(f"location.href.includes({json.dumps(file.name)}) && document.readyState == 'complete'"):
            await asyncio.sleep(0.05)

    async def get(self, expression: str) -> Any:
        """Returns the value of an expression in the page."""
        answer = await self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(str(answer["exceptionDetails"]))
        return answer["result"].get("value")

    async def click(self, x: float, y: float) -> None:
        for kind in ("mousePressed", "mouseReleased"):
            await self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    async def screenshot(self, file: Path) -> None:
        file.write_bytes(base64.b64decode((await self.call("Page.captureScreenshot"))["data"]))


async def look_at_cells(page: Browser, file: Path, target: Path) -> List[str]:
    await page.open(file, 900, 650)
    for _ in range(600):
        before = await page.get(PIXELS)
        if before[0] < 1:  # drawn: an empty canvas is black
            break
        await asyncio.sleep(0.1)
    await page.screenshot(target / "cells.png")
    await page.get(CUT)
    after = await page.get(PIXELS)
    await page.screenshot(target / "cells-cut.png")
    await page.click(450, 325)
    text = await page.get('document.getElementById("text").textContent')
    complaints = []
    if not 0.02 < after[0] < before[0] < 0.95 or before[1] == after[1]:
        complaints.append(f"the page of cells: {before} before the cut, {after} after it")
    if not re.match(r"cell \d+, ", text):
        complaints.append(f"the page of cells: a click says {text!r}")
    return complaints


async def look(address: str, site: Path, target: Path) -> List[str]:
    """Returns the complaints."""
    page = Browser(await websocket_connect(address, max_message_size=1 << 28))
    await page.begin()
    complaints = []
    for width in WIDTHS:
        for file in pages_of(site):
            await page.open(file, width)
            for found, text in await page.get(NARROW):
                complaints.append(f"{file.name} at {width} pixels: a heading of {found:.0f} pixels: {text}")
            if file.stem in SHOWN:
                await asyncio.sleep(1)  # frames inside, and pictures that load late
                await page.screenshot(target / f"{file.stem}-{width}.png")
    await page.open(site / "index.html", WIDTHS[0])
    if not await page.get(SEARCH):
        complaints.append("the search finds nothing")
    return complaints + await look_at_cells(page, site / "made/gallery/cells.html", target)


def pages_of(site: Path) -> List[Path]:
    return sorted(file for file in site.glob("*.html") if file.name != "404.html")


async def main() -> int:
    browser, site, target = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    target.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = await asyncio.create_subprocess_exec(
            browser, *FLAGS, f"--user-data-dir={profile}", stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.PIPE
        )
        try:
            assert process.stderr is not None
            found = None
            while found is None:
                line = await asyncio.wait_for(process.stderr.readline(), 60)
                if not line:
                    raise RuntimeError(f"{browser} ended")
                found = re.search(r"DevTools listening on (\S+)", line.decode("utf-8", "replace"))
            complaints = await look(found[1], site, target)
        finally:
            if process.returncode is None:
                process.terminate()
            await process.wait()
    print("".join(f"FAILED: {complaint}\n" for complaint in complaints), end="")
    print(f"{len(pages_of(site))} pages at {' and '.join(map(str, WIDTHS))} pixels, {len(complaints)} complaints")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(asyncio.run(main()))
