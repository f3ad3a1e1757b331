"""Lines of C++ as clang-format lays them out."""

import textwrap

from table import WIDTH


def call(indent, head, arguments, tail=");"):
    """A call with as many arguments in a line as fit; head ends with "("."""
    line = indent + head + ", ".join(arguments) + tail
    if len(line) <= WIDTH:
        return [line]
    lines, aligned = [indent + head], " " * len(indent + head)
    for number, argument in enumerate(arguments):
        last = number == len(arguments) - 1
        word = argument + (tail if last else ",")
        begins = lines[-1] in (indent + head, aligned)
        if not begins and len(lines[-1]) + 1 + len(word) > WIDTH:
            lines.append(aligned)
            begins = True
        lines[-1] += word if begins else " " + word
    return lines


def text_lines(indent, text, tail=""):
    """A text as literals, one behind the other."""
    pieces = textwrap.wrap(text, WIDTH - len(indent) - 3 - len(tail), break_long_words=False)
    spaced = [piece + " " for piece in pieces[:-1]] + pieces[-1:]
    lines = [f'{indent}"{piece}"' for piece in spaced]
    lines[-1] += tail
    return lines
