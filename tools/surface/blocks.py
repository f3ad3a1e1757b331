"""Blocks of generated lines in files that are otherwise written by hand."""

import re

BLOCK = re.compile(
    r"^( *)(\S+) begin generated: (\w+).*?\n(.*?)^ *\S+ end generated", re.MULTILINE | re.DOTALL
)


def rewritten(file, text, blocks):
    """The file's text with new lines in its blocks.

    blocks: by the name behind "begin generated:", functions from the indentation to lines. A name
    that is a compiled pattern takes the place of its first match instead: docstrings have no marks.
    """
    left = {name: lines for name, lines in blocks.items() if isinstance(name, str)}

    def replace(match):
        indent, _, name, _ = match.groups()
        if name not in left:
            raise SystemExit(f"{file}: block {name} given, none of the table's")
        new = "".join(line.rstrip() + "\n" for line in left.pop(name)(indent))
        begin, end = match.start(4) - match.start(), match.end(4) - match.start()
        return match[0][:begin] + new + match[0][end:]

    text = BLOCK.sub(replace, text)
    if left:
        raise SystemExit(f"{file}: no block named {', '.join(left)}")
    for pattern, lines in blocks.items():
        if isinstance(pattern, re.Pattern):
            text, found = pattern.subn("\n".join(lines("")).replace("\\", r"\\"), text, count=1)
            if not found:
                raise SystemExit(f"{file}: no text like {pattern.pattern}")
    return text


def squeezed(text):
    """The text without what clang-format adds: white space, and breaks in texts between quotes."""
    return re.sub(r'\s+|"\s*"', "", text)
