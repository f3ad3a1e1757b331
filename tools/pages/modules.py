"""Draws docs/pictures/modules.svg: the modules of the C++ code and the #include lines between them.

A module is a folder: one below core, render, protocol and tasks, and each of the other folders as a
whole. All families of tasks are one module. A module stands one layer above the highest module that
it includes. Arrows that follow from other arrows are left out.
"""

import argparse
import collections
import pathlib
import sys

from structure import CPP, INCLUDE

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PICTURE = ROOT / "docs" / "pictures" / "modules.svg"
SPLIT = (
    "core",
    "render",
    "protocol",
    "tasks",
)  # their folders are modules of their own

BOX_HEIGHT, LAYER_GAP, BOX_GAP, MARGIN = 44, 46, 14, 16  # pixels
CHARACTER = 8  # pixels: mean width in the font of names
COLORS = {
    "core": "#dbe9f6",
    "mjcf": "#e4ecd8",
    "tasks": "#e4ecd8",
    "render": "#f6e8d5",
    "media": "#f6e8d5",
    "protocol": "#ecdff0",
}
OTHER_COLOR = "#eeeeee"


def module_of(path):
    """Name of the module that holds a file, given relative to the root."""
    top, *rest = path.parts
    if top not in SPLIT or len(rest) < 2:
        return top
    if top == "tasks" and rest[0] != "common":
        return "tasks/<family>"
    return f"{top}/{rest[0]}"


def target_of(name):
    """Path from the root of a file that an #include line names, or None outside of the project."""
    for path in (pathlib.Path(name), pathlib.Path("api") / name):
        if path.parts[0] in CPP and (ROOT / path).is_file():
            return path
    return None


def read_modules():
    """Files by module, and #include lines by pair of modules."""
    files, includes = collections.Counter(), collections.Counter()
    for folder in CPP:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in (".h", ".cc", ".c"):
                continue
            module = module_of(path.relative_to(ROOT))
            files[module] += 1
            for name in INCLUDE.findall(path.read_text()):
                target = target_of(name)
                if target and module_of(target) != module:
                    includes[module, module_of(target)] += 1
    return files, includes


def layers_of(modules, below):
    """Layer of every module, 0 at the bottom."""
    layers, open_modules = {}, []

    def visit(module):
        if module in open_modules:
            cycle = [*open_modules[open_modules.index(module) :], module]
            sys.exit(f"modules include each other in a cycle: {' > '.join(cycle)}")
        if module not in layers:
            open_modules.append(module)
            layers[module] = max((visit(other) + 1 for other in sorted(below[module])), default=0)
            open_modules.pop()
        return layers[module]

    for module in sorted(modules):
        visit(module)
    return layers


def direct_arrows(below):
    """Pairs of modules without those that follow from a longer path (transitive reduction)."""

    def reaches(module, goal):
        return goal in below[module] or any(reaches(other, goal) for other in below[module])

    return [
        (module, other)
        for module in sorted(below)
        for other in sorted(below[module])
        if not any(reaches(between, other) for between in below[module] if between != other)
    ]


def ordered_rows(layers, arrows):
    """Modules by layer; in a layer, those stand left that are linked to the left ones below."""
    rows = []
    place = {}
    for layer in range(max(layers.values()) + 1):
        row = sorted(module for module in layers if layers[module] == layer)

        def pull(module):
            links = [place[other] for one, other in arrows if one == module]
            return sum(links) / len(links) if links else 0.5

        row.sort(key=lambda module: (pull(module), module))
        for i, module in enumerate(row):
            place[module] = (i + 0.5) / len(row)
        rows.append(row)
    return rows


def counted(number, noun):
    return f"{number} {noun}" + ("s" if number > 1 else "")


def label_of(module, files):
    return counted(files[module], "file")


def width_of(module, files):
    return round(max(len(module), len(label_of(module, files))) * CHARACTER) + 24


def escape(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def draw(files, includes):
    below = {module: set() for module in files}
    for module, other in includes:
        below[module].add(other)
    layers = layers_of(files, below)
    arrows = direct_arrows(below)
    rows = ordered_rows(layers, arrows)

    def row_width(row):
        return sum(width_of(module, files) + BOX_GAP for module in row) - BOX_GAP

    width = max(map(row_width, rows)) + 2 * MARGIN
    height = len(rows) * (BOX_HEIGHT + LAYER_GAP) - LAYER_GAP + 2 * MARGIN
    boxes = {}  # x, y, width
    for layer, row in enumerate(rows):
        x = (width - row_width(row)) / 2
        y = height - MARGIN - BOX_HEIGHT - layer * (BOX_HEIGHT + LAYER_GAP)
        for module in row:
            boxes[module] = (x, y, width_of(module, files))
            x += width_of(module, files) + BOX_GAP

    lines = [
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}" font-family="sans-serif" text-anchor="middle">'
        ),
        "<title>Modules of engram and the #include lines between them</title>",
        (
            '<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
            'markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8z" fill="#555"/></marker></defs>'
        ),
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    for module, other in arrows:
        x1, y1 = boxes[module][0] + boxes[module][2] / 2, boxes[module][1] + BOX_HEIGHT
        x2, y2 = boxes[other][0] + boxes[other][2] / 2, boxes[other][1]
        bend = LAYER_GAP * 0.6
        color = "#555" if layers[module] == layers[other] + 1 else "#aaa"
        lines.append(
            f'<path d="M{x1:g} {y1:g}C{x1:g} {y1 + bend:g} {x2:g} {y2 - bend:g} {x2:g} {y2:g}" '
            f'fill="none" stroke="{color}" stroke-width="1.2" marker-end="url(#head)">'
            f"<title>{escape(module)} includes {escape(other)}: "
            f"{counted(includes[module, other], 'line')}</title></path>"
        )
    for row in rows:
        for module in row:
            x, y, box_width = boxes[module]
            color = COLORS.get(module.split("/")[0], OTHER_COLOR)
            middle = x + box_width / 2
            lines += [
                (
                    f'<rect x="{x:g}" y="{y:g}" width="{box_width}" height="{BOX_HEIGHT}" rx="5" '
                    f'fill="{color}" stroke="#555"/>'
                ),
                (
                    f'<text x="{middle:g}" y="{y + 19:g}" font-size="13" font-weight="bold">'
                    f"{escape(module)}</text>"
                ),
                (
                    f'<text x="{middle:g}" y="{y + 35:g}" font-size="11" fill="#444">'
                    f"{label_of(module, files)}</text>"
                ),
            ]
    return "\n".join([*lines, "</svg>"]) + "\n"


def main(given, prog):
    parser = argparse.ArgumentParser(prog=prog, description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if it is stale")
    check = parser.parse_args(given).check
    picture = draw(*read_modules())
    if not check:
        PICTURE.write_text(picture)
    elif not PICTURE.is_file() or PICTURE.read_text() != picture:
        sys.exit(f"{PICTURE.relative_to(ROOT)} is stale; renew it with: tools/docs.py modules")
