#!/usr/bin/env python3
"""Counts the way of a parameter through the engine.

    tools/walk.py TYPE

Begins at each function with a parameter of that type that gets it from no other one, and follows the calls that pass it
on, in their order. A stay is a stretch of the way in one folder of engine/. A return is a stay in a folder where it
was before, as after each call into another folder. Each function is entered once. Calls are found by their names.
"""
import pathlib
import re
import sys

ENGINE = pathlib.Path(__file__).resolve().parents[1] / "engine"
DEFINITION = re.compile(r"([\w:]+)\(([^;{}()]*(?:\([^()]*\)[^;{}()]*)*)\)(?:\s|const|noexcept|override)*(?::[^;]*?)?\{")
OTHERS = {"if", "for", "while", "switch", "catch", "return"}


def closed(text, start, brackets):
    """The place after the bracket that closes the one at start."""
    depth = 0
    for at in range(start, len(text)):
        depth += (text[at] == brackets[0]) - (text[at] == brackets[1])
        if depth == 0:
            return at + 1
    return len(text)


def functions(kind):
    """(name, folder, parameter, body) of each function with a parameter of the type."""
    found = []
    for path in sorted(ENGINE.rglob("*")):
        if path.suffix not in (".cpp", ".hpp", ".inl"):
            continue
        text = re.sub(r'//[^\n]*|"(?:[^"\\\n]|\\.)*"', "", path.read_text())
        for match in DEFINITION.finditer(text):
            parameter = re.search(rf"\b{kind}\b[\s&]*(\w+)\b", match[2])
            if parameter and match[1] not in OTHERS:
                body = text[match.end(2):closed(text, match.end() - 1, "{}")]
                found.append((match[1], path.relative_to(ENGINE).parts[0], parameter[1], body))
    return found


def calls(function, by_name):
    """The functions that get the parameter, in the order of the calls."""
    _, _, parameter, body = function
    passed = re.compile(rf"(?<![\w.>]){parameter}\b(?!\s*(?:\.|->|\[))")
    for match in re.finditer(r"(?:\b(\w+)\s+)?(\w+)\s*[({]", body):
        # The second may be a variable of the type of the first.
        names = [name for name in match.groups() if name in by_name]
        brackets = "()" if match[0].endswith("(") else "{}"
        if names and passed.search(body[match.end():closed(body, match.end() - 1, brackets)]):
            yield from by_name[names[-1]]


def main():
    kind, by_name = sys.argv[1], {}
    all_of_them = functions(kind)
    for function in all_of_them:
        by_name.setdefault(function[0].split("::")[-1], []).append(function)
    way, seen = [], set()

    def enter(function):
        if id(function) in seen:
            return
        seen.add(id(function))
        way.append(function[1])
        for callee in calls(function, by_name):
            enter(callee)
            way.append(function[1])

    called = {id(callee) for function in all_of_them for callee in calls(function, by_name) if callee is not function}
    for function in all_of_them:
        if id(function) not in called:
            enter(function)
    stays = [folder for k, folder in enumerate(way) if k == 0 or folder != way[k - 1]]
    folders = len(set(stays))
    print(f"{kind}: {len(stays)} stays in {folders} folders, {len(stays) - folders} returns, {len(seen)} functions")
    print(" ".join(stays))


if __name__ == "__main__":
    main()
