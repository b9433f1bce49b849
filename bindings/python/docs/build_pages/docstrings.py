"""For mkdocstrings: how docstrings of pyvotess are read.

A comment "#: text" behind an attribute, or in the lines above it, is its docstring. In the lists of parameters and exceptions "name : text" has a
description behind the colon; types are those of the signature. Paragraphs behind the list of parameters, which is the
end of a docstring for griffe, go in front of it. Examples become blocks of code, before the lists.
"""

from __future__ import annotations

import re
import textwrap
from typing import Any, List

import griffe

ENTRY = re.compile(r"^(\w[\w, ]*) : (.*)$", re.MULTILINE)
HEADING = re.compile(r"^(\w+)\n-+\n")


def rearranged(text: str) -> str:
    """The docstring as griffe expects it."""
    prose: List[str] = []
    lists: List[str] = []
    examples: List[str] = []
    for paragraph in text.split("\n\n"):
        if HEADING.match(paragraph):
            lists.append(ENTRY.sub(r"\1\n    \2", paragraph))
        elif lists and (paragraph.startswith(" ") or ENTRY.match(paragraph)):
            lists[-1] += "\n\n" + ENTRY.sub(r"\1\n    \2", paragraph)
        elif paragraph.lstrip().startswith(">>>"):
            examples.append(f"```pycon\n{textwrap.dedent(paragraph).strip()}\n```")
        else:
            prose.append(paragraph)
    return "\n\n".join(prose + examples + lists)


class Docstrings(griffe.Extension):
    def on_instance(self, *, obj: griffe.Object, **kwargs: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = rearranged(obj.docstring.value)

    def on_attribute_instance(self, *, attr: griffe.Attribute, **kwargs: Any) -> None:
        if attr.docstring is not None or attr.lineno is None:
            return
        lines, at = attr.lines_collection[attr.filepath], attr.lineno - 1
        text = lines[at].partition("#: ")[2]
        while not lines[at].partition("#: ")[2] or lines[at].lstrip().startswith("#: "):
            at -= 1
            if not lines[at].lstrip().startswith("#: "):
                break
            text = f"{lines[at].strip()[3:]} {text}"
        if text:
            attr.docstring = griffe.Docstring(text.strip(), lineno=attr.lineno, parent=attr)
