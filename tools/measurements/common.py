"""The engram command, and the files of docs/data."""

import csv
import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
DATA = ROOT / "docs" / "data"
PAGE = DATA / "README.md"


def run(words):
    """Standard output of a command; ends the program if it fails."""
    try:
        done = subprocess.run([str(w) for w in words], capture_output=True, text=True, check=False)
    except OSError as error:
        sys.exit(f"{words[0]}: {error.strerror}; --engram names the command")
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: {done.stderr.strip()}")
    return done.stdout


def run_json(words):
    return json.loads(run([*words, "--json"]))


def write_csv(name, head, rows):
    with (DATA / name).open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        writer.writerows(rows)
    print(f"docs/data/{name}: {len(rows)} rows")


def read_csv(name):
    """Rows of a file of docs/data, as mappings from column to text."""
    with (DATA / name).open(newline="") as file:
        return list(csv.DictReader(file))


def rate(value):
    return "" if value is None else f"{value:.3f}"


def between(text, begin, end, content):
    """The text with other lines between two marks."""
    pattern = re.compile(rf"({re.escape(begin)}\n).*?({re.escape(end)})", re.DOTALL)
    if not pattern.search(text):
        sys.exit(f"no '{begin}' with '{end}' behind it")
    return pattern.sub(lambda found: f"{found[1]}{content}\n{found[2]}", text, count=1)


def section(text, name, lines):
    """The page with other lines between <!-- NAME --> and <!-- end -->."""
    return between(text, f"<!-- {name} -->", "<!-- end -->", "\n".join(lines))


def write_section(name, lines):
    PAGE.write_text(section(PAGE.read_text(), name, lines))
