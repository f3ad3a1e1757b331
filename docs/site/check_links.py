"""Checks a built site: no link inside it is dead, and no page loads anything from other hosts.

check_links.py FOLDER
"""

import re
import sys
from functools import cache
from pathlib import Path
from urllib.parse import unquote, urlsplit

from bs4 import BeautifulSoup

LOADED = {"img": "src", "script": "src", "link": "href", "iframe": "src", "video": "src"}
NO_LOAD = {"canonical", "index", "search", "next", "prev"}  # links of the head that only name


@cache
def page(file):
    return BeautifulSoup(file.read_text(), "html.parser")


@cache
def anchors(file):
    return {tag["id"] for tag in page(file).find_all(id=True)}


def dead(file, address):
    """Error of an address on a page, or None."""
    parts = urlsplit(address)
    if parts.scheme or parts.netloc:
        return None  # out of this site
    target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
    if not target.is_file():
        return "no such file"
    anchor = unquote(parts.fragment)
    if anchor and target.suffix == ".html" and anchor not in anchors(target):
        return "no such anchor"
    return None


def problems(folder):
    for file in sorted(folder.rglob("*.html")):
        for tag in page(file).find_all(["a", *LOADED]):
            address = tag.get(LOADED.get(tag.name, "href"))
            if address and (trouble := dead(file, address)):
                yield f"{file.relative_to(folder)}: {address}: {trouble}"
            names_only = tag.name == "a" or NO_LOAD & set(tag.get("rel", []))
            if address and not names_only and re.match(r"(https?:)?//", address):
                yield f"{file.relative_to(folder)}: loads {address}"
    for file in sorted(folder.rglob("*.css")):
        for address in re.findall(r"url\([\"']?((?:https?:)?//[^)\"']*)", file.read_text()):
            yield f"{file.relative_to(folder)}: loads {address}"


def main():
    folder = Path(sys.argv[1]).resolve()
    found = list(problems(folder))
    if found or not (folder / "index.html").is_file():
        sys.exit("\n".join(found) or f"{folder}: no index.html")


if __name__ == "__main__":
    main()
