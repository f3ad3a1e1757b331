"""What messages and pages say about libraries that a plain installation lacks."""

import re
from pathlib import Path

import pytest

from engram.command.libraries import LIBRARIES, install_command

ROOT = Path(__file__).resolve().parents[2]
# Fetching this project by name: the name belongs to another project on the package index.
BY_NAME = re.compile(
    r"""pip\s+install\s[^|\n]*?(?<![\w/.-])engram(?:-sim)?(?![\w./-])|["'`]engram(?:-sim)?\[""",
    re.IGNORECASE,
)


def extras():
    tomllib = pytest.importorskip("tomllib")  # Python 3.11
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    return {
        extra: tuple(re.match(r"[\w-]+", one)[0] for one in requirements)
        for extra, requirements in project["optional-dependencies"].items()
    }


def test_messages_name_the_libraries_of_the_extras():
    declared = extras()
    assert {extra: declared[extra] for extra in LIBRARIES} == LIBRARIES
    assert install_command("play") == "pip install aiohttp pillow"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('pip install "engram[play]"', True),
        ("pip install engram", True),
        ("pip install -q --upgrade engram-sim", True),
        ("pip install build/dist/engram-*_x86_64.whl", False),
        ("pip install aiohttp pillow  # for engram play", True),
        ("pip install .", False),
    ],
)
def test_the_search_finds_installations_by_name(text, found):
    assert bool(BY_NAME.search(text)) == found


def test_nothing_tells_people_to_install_the_project_by_name():
    files = [ROOT / "README.md"]
    for folder in ("docs", "python", "apps", "media", "api"):
        files += sorted((ROOT / folder).rglob("*"))
    found = []
    for path in files:
        if path == Path(__file__).resolve() or not path.is_file():
            continue
        try:
            text = path.read_text()
        except UnicodeDecodeError:
            continue
        found += [f"{path.relative_to(ROOT)}: {hit[0]}" for hit in BY_NAME.finditer(text)]
    assert found == []
