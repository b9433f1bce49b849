#!/usr/bin/env python3
"""Measures comments, docstrings and Markdown: words of a sentence, and marks of dialect per 10,000 words, by folder.
  tools/prose.py --list PATH...    lists the sentences to mend: longer than 25 words, or with a mark
A mirror, not a gate: read your sentences aloud."""
import io, re, subprocess, sys, tokenize
LONG = 25
# "says what happened" asks a question; "what is not there" and "of what" are relative.
ASKS = r"(?:ask|know|see|say|show|decide|explain|describe|check|print|learn|depend|matter|test|define|report)\w* (?:on )?"
MARKS = {
    "what": rf"(?i)(?<!\w)(?!{ASKS}what)(?:\S+ (?:on )?)?\bwhat\b(?! to | kind| if | else| happen)(?= \w)",
    "tell": r"(?i)\b(?:tells?|told|telling)\b",
    "but for": r"(?i)\bbut for\b|\banew\b|\bnone of both\b",
    "is no": r"(?i)(?<!there )\b(?:is|are|was|were) no\b(?! longer| more| less)",
    "start": r"^(?:(?:Of|With|Beside)\b|To (?:the|an?|its|each|all|those|such)\b)",
    "chain": r"(?is)(?:\b(?:what|those|that|such|which)\b.*){3}",
}
LITERAL = re.compile(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\'')

def prose(path, text):
    """Yields (line, text, whether it begins a paragraph)."""
    kind, start = path.rsplit(".", 1)[-1], True
    if kind == "md":
        text = re.sub(r"^```.*?^```|^    .*?$|<!--.*?-->", lambda m: "\n" * m[0].count("\n"), text, flags=re.M | re.S)
    for t in tokenize.generate_tokens(io.StringIO(text).readline) if kind == "py" else ():
        if t.type == tokenize.COMMENT or (t.type == tokenize.STRING and start):
            for k, line in enumerate(t.string.split("\n")):
                yield t.start[0] + k, line.strip(" #:\"'"), bool(t.line[:t.start[1]].strip())
        if t.type not in (tokenize.NL, tokenize.COMMENT, tokenize.INDENT, tokenize.DEDENT):
            start = t.type == tokenize.NEWLINE
    mark = r"(?:^|\s)#(?!!)" if kind in ("sh", "txt", "cmake") else r"(?:^|\s)//[/!<]*|/\*"
    for n, line in enumerate(text.split("\n") if kind != "py" else (), 1):
        if kind == "md":
            for cell in line.split(" | "):  # rows, headings and items are paragraphs of their own
                yield n, re.sub(r"\]\([^)]*\)|[|>#*]", "", cell).strip(" -"), bool(re.match(r"\s*([|#>*-]|\d+\.) ?", line))
        else:
            parts = re.split(mark, line if re.match(rf"\s*(?:{mark})", line) else LITERAL.sub('""', line), maxsplit=1)
            comment = parts[1] if len(parts) > 1 else ""
            yield n, comment.strip(" */"), bool(parts[0].strip() or re.match(r" *(-|\d+\.) ", comment))

paragraph, totals = [], {}
for path in subprocess.check_output(["git", "ls-files", *(sys.argv[2:] or "*")], text=True).split("\n"):
    if not re.search(r"\.(?:[ch]pp|[ch]|inl|glsl|comp|vert|frag|in|py|sh|cmake|txt|md)$", path) or "corpus" in path:
        continue
    row = totals.setdefault("README, .md" if path.endswith(".md") else path.split("/")[0], [])
    for n, line, begins in [*prose(path, open(path, encoding="utf-8").read()), (0, "", True)]:
        if paragraph and (begins or not line or n > paragraph[-1][0] + 1):
            whole, at = "\n".join(text for _, text in paragraph), 0
            for part in re.split(r"(?:(?<=[.!?])|(?<=[.!?]\)))\s+(?=[\"'`(\[*]*[A-Z0-9`]|[\w, ()]+: )", whole):
                at = whole.index(part, at)
                found = [name for name, mark in MARKS.items() if re.search(mark, part) and part[-1:] != "?"]
                row.append((len(re.findall(r"[A-Za-z][\w'-]*", part)), found))
                if sys.argv[1:] and (row[-1][0] > LONG or found):
                    print(f"{path}:{paragraph[0][0] + whole.count(chr(10), 0, at)}: {row[-1][0]} {' '.join(found)}:", *part.split())
            paragraph = []
        paragraph += [(n, line)] if line else []
totals["total"] = sum(totals.values(), [])
for name, row in totals.items() if not sys.argv[1:] else ():
    count, whole = sum(n for n, _ in row) or 1, [n for n, _ in row if n > 2]  # shorter ones are names
    print(f"{name:14} {count:7} words, {sum(whole) / max(len(whole), 1):4.1f} a sentence", *(
        f"{mark} {1e4 * sum(mark in found for _, found in row) / count:.1f}" for mark in MARKS), sep="  ")
