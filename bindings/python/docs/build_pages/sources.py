"""Hooks of mkdocs: pages show parts of the sources, and the output of their code.

A line of its own in a page

    [[section README.md: Speed]]     that section of a Markdown file, without its heading
    [[header votess.hpp]]            that public header, in parts with headings
    [[help]]                         the output of `clvotess --help-all`
    [[notebook materials]]           the cells of that notebook, with the output of each

is replaced. The folder VOTESS_DOCS_MADE holds pictures, made/page/picture.png in links, the output of each block of
code, which appears below the block, and the notebooks as they ran. The folder pages/made has small copies of some
pictures, for readers of the sources.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any, Dict, Iterator, List, Tuple

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[4]
MADE = Path(os.environ.get("VOTESS_DOCS_MADE", ROOT / "build/docs/made"))
PLACE = re.compile(r"^\[\[(\w+)(?: ([^\]:]+))?(?:: ([^\]]+))?\]\]$", re.MULTILINE)
PICTURE = re.compile(r"^(!\[[^\]]*\]\([^)]+\))$", re.MULTILINE)
LONGEST_OUTPUT = 16  # lines

sys.path.insert(0, str(ROOT / "tests/readme"))
from check_readme import FENCED, TESTED  # noqa: E402


def _with_outputs(markdown: str, page: str) -> str:
    """Shows the output of each tested block below it, in place of its lines `# prints: ...`."""
    file = MADE / page / "outputs.json"
    outputs: Dict[str, str] = json.loads(file.read_text("utf-8")) if file.exists() else {}

    def block(found: re.Match[str]) -> str:
        if not TESTED.fullmatch(found[1] or ""):
            return found[0]
        code = re.sub(r"^\s*(?:#|//) prints: .*\n", "", found[3], flags=re.M)
        lines = outputs.get(str(markdown.count("\n", 0, found.start(3)) + 1), "").splitlines()
        if len(lines) > LONGEST_OUTPUT:
            lines[LONGEST_OUTPUT - 1 :] = ["..."]
        shown = "\n```{ .text .output }\n" + "\n".join(lines) + "\n```\n" if lines else ""
        return f"```{found[2]}\n{code.rstrip()}\n```\n{shown}"

    return FENCED.sub(block, markdown)


def _section(name: str, title: str) -> str:
    """A section of a Markdown file without its links."""
    found = re.search(rf"^(#+) {re.escape(title)}\n(.*?)(?=^#{{1,2}} |\Z)", (ROOT / name).read_text("utf-8"), re.M | re.S)
    if not found:
        raise PluginError(f"{name} has no section {title!r}")
    return re.sub(r" ?\[[^\]]*\]\((?!https?:)[^)]+\)", "", found[2])


#: Pictures of the repository that pages show, as made/NAME.
PICTURES = ("tools/bench/results/speed.png", "tests/embed/frame.png")

# Declarations in a header, at the left edge.
_TYPE = re.compile(r"^(?:enum class|struct|class|using|typedef (?:enum|struct))\s+(?:VOTESS_API\s+)?(\w+)(?!.*;$)", re.M)
_FUNCTION = re.compile(r"^(?:\[\[nodiscard\]\] )?VOTESS_API [^(;]*?\b(\w+)\(", re.M)


def _parts(text: str) -> Iterator[Tuple[str, str]]:
    """Yields the declared name and the text of each part of a header: a paragraph, or several with open braces between."""
    part: List[str] = []
    depth = 0
    for paragraph in text.split("\n\n"):
        part.append(paragraph)
        code = re.sub(r"//.*", "", paragraph)
        # Namespaces and extern "C" stay open. Of a comment behind the end of a namespace two blanks are left.
        code = re.sub(r"^namespace [\w:]+ \{[^{}]*^\}$", "", code, flags=re.M)
        code = re.sub(r"^(?:namespace [\w:]+|extern \"C\") \{|^\}  $|(?<=__cplusplus\n)\}$", "", code, flags=re.M)
        depth += code.count("{") - code.count("}")
        if depth == 0:
            whole = "\n\n".join(part)
            names = _TYPE.findall(whole) + _FUNCTION.findall(whole)
            yield (names[0] if names else ""), whole
            part = []
    if part:
        raise PluginError(f"a header with braces that stay open: {part[0][:60]}")


def _header(name: str) -> str:
    """Returns a header in parts with headings, in C++ without its includes. A part without a declaration joins the part before it."""
    text = (ROOT / "include/votess" / name).read_text("utf-8").strip("\n")
    text = re.sub(r"^#pragma once\n|^#include .*\n+", "", text, flags=re.M) if name.endswith(".hpp") else text
    language = "c" if name.endswith(".h") else "cpp"
    parts: List[Tuple[str, str]] = []
    for title, part in _parts(text):
        if parts and (not title or title in (known for known, _ in parts)):
            parts[-1] = (parts[-1][0], parts[-1][1] + "\n\n" + part)
        else:
            parts.append((title, part))
    if "\n\n".join(part for _, part in parts) != text:
        raise PluginError(f"{name}: its parts are not the whole")
    return "\n".join(
        (f"### {title} {{ #{Path(name).suffix[1:]}-{title} }}\n\n" if title else "") + f"```{language}\n{part}\n```\n"
        for title, part in parts
    )


def _help() -> str:
    text = subprocess.run(["clvotess", "--help-all"], check=True, capture_output=True, text=True).stdout
    return f"```text\n{text}```"


#: HTML of notebooks, which takes the place of a comment with its number.
_HTML: List[str] = []


def _output(output: Dict[str, Any]) -> str:
    """Returns the output of a cell as Markdown."""
    data = output.get("data", {})
    html = "".join(data.get("text/html", ()))
    if "image/png" in data:
        html = f'<img alt="picture" src="data:image/png;base64,{"".join(data["image/png"]).strip()}">'
    if html:
        _HTML.append(f'<div class="notebook-output">{html}</div>')
        return f"\n<!-- output {len(_HTML) - 1} -->\n"
    text = "".join(output.get("text", data.get("text/plain", ())))
    return f"\n```{{ .text .output }}\n{text.rstrip()}\n```\n" if text else ""


def _notebook(name: str) -> str:
    file = MADE / "notebooks" / f"{name}.ipynb"
    if not file.exists():
        raise PluginError(f"there is no {file}: run the notebooks by tools/docs.sh")
    parts = [f"[Download this notebook](made/notebooks/{name}.ipynb)\n"]
    for cell in json.loads(file.read_text("utf-8"))["cells"]:
        source = "".join(cell["source"])
        parts.append(source + "\n" if cell["cell_type"] == "markdown" else f"```python\n{source}\n```\n")
        parts += map(_output, cell.get("outputs", ()))
    return "\n".join(parts)


def _scripts() -> Dict[str, str]:
    """Returns the scripts of the gallery by the names of their pictures."""
    text = (ROOT / "bindings/python/docs/pages/gallery.md").read_text("utf-8")
    scripts = {}
    for section in text.split("\n## ")[1:]:
        picture, code = re.search(r"\(made/gallery/(\w+)\.png\)", section), re.search(r"```python\n(.*?)```", section, re.S)
        if not picture or not code:
            raise PluginError(f"gallery.md: {section.splitlines()[0]} needs a picture and a script")
        scripts[picture[1]] = re.sub(r"^# prints: .*\n", "", code[1], flags=re.M)
    return scripts


def on_files(files: Files, config: Any) -> Files:
    """Pictures that were made, and those of the repository, become files of the site."""
    for file in [file for file in files if file.src_uri.startswith("made/")]:
        files.remove(file)
    for path in sorted(MADE.rglob("*.*")):
        if path.suffix != ".json":
            files.append(File.generated(config, f"made/{path.relative_to(MADE).as_posix()}", abs_src_path=str(path)))
    for name, code in _scripts().items():
        files.append(File.generated(config, f"made/gallery/{name}.py", content=code))
    for name in PICTURES:
        files.append(File.generated(config, f"made/{Path(name).name}", abs_src_path=str(ROOT / name)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:
    def source(place: re.Match[str]) -> str:
        if place[1] == "section":
            return _section(place[2], place[3])
        if place[1] == "header":
            return _header(place[2])
        if place[1] == "help":
            return _help()
        if place[1] == "notebook":
            return _notebook(place[2])
        raise PluginError(f"{page.file.src_uri}: {place[0]} is not known")

    if page.file.src_uri == "python.md":
        _all_documented("".join(file.content_string for file in files if re.fullmatch(r"python.*\.md", file.src_uri)))
    if page.file.src_uri != "gallery.md":
        # The picture before the first heading.
        head, heading, rest = markdown.partition("\n## ")
        look = "beside" if page.file.src_uri == "index.md" else "lead"
        markdown = PICTURE.sub(rf"\1{{ .votess-{look} }}", head, count=1) + heading + rest
    else:
        # Each picture of a section is followed by its script.
        markdown = re.sub(r"^(!\[.*\]\(made/gallery/(\w+)\.png\))$", r"\1\n\n[Download the script](made/gallery/\2.py)", markdown, flags=re.M)
    return PLACE.sub(source, _with_outputs(markdown, Path(page.file.src_uri).stem))


def _all_documented(markdown: str) -> None:
    """Every name that the package shows must stand in the reference."""
    init = (ROOT / "bindings/python/pyvotess/__init__.py").read_text("utf-8")
    lists = re.findall(r"^(?:__all__|_RECORDS) = \[(.*?)\]", init, re.S | re.M)
    names = [name for part in lists for name in re.findall(r'"(\w+)"', part)]
    missing = [name for name in names if f"::: pyvotess.{name}\n" not in markdown and name != "__version__"]
    if missing:
        raise PluginError(f"the pages of Python lack {', '.join(missing)}, which pyvotess shows")


def on_page_content(html: str, page: Any, config: Any, files: Files) -> str:
    """Roles of Sphinx in docstrings become plain code. Outputs of notebooks take their places."""
    html = re.sub(r"<!-- output (\d+) -->", lambda place: _HTML[int(place[1])], html)
    return re.sub(r":(?:func|class|meth|attr):(<code)", r"\1", html)
