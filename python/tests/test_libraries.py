"""What messages, pages and scripts install: no distribution by a name of another project."""

from __future__ import annotations

import importlib.metadata
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

import engram
from engram._distribution import LIBRARIES, NAME, install_command

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().relative_to(ROOT).as_posix()
# An entry of the changelog with these words reports the old ones.
REPORT = "belongs to another project"

OURS = r"engram(?:[-_]sim)?"
INSTALLER = re.compile(
    r"\b(?:(?:pip3?|uv|pipx|poetry|pdm|conda|mamba)(?:[ \t]+[-\w./=]+)*?[ \t]+)"
    r"(?:install|download|wheel|add|inject|run)\b(?P<words>(?:\\\n|[^\n|;&`#])*)"
)
WITH_VALUE = ("--reinstall-package", "--no-binary", "--only-binary", "--find-links", "-f", "--with")
REQUIREMENT = re.compile(rf"{OURS}(?:\[[\w,\s-]*\])?(?:[=<>~!@].*)?", re.IGNORECASE)
ELSEWHERE = re.compile(  # in lists of requirements, and in prose
    rf"(?<![\w./-]){OURS}(?:\[(?:{'|'.join(LIBRARIES)}|all)\b|\s*(?:==|~=)\s*[\d*])", re.IGNORECASE
)


def by_name(text: str) -> Iterator[str]:
    """What in the text makes an installer look for this project on an index."""
    for command in INSTALLER.finditer(text):
        words = [word.strip("\"'\\(),.:") for word in command["words"].split()]
        if "--no-index" in words:
            continue
        for before, word in zip(["", *words], words):
            if before not in WITH_VALUE and REQUIREMENT.fullmatch(word):
                yield " ".join(command[0].split())
    yield from (found[0] for found in ELSEWHERE.finditer(text))


def files_of_the_repository() -> list[str]:
    """Those that git tracks; without git, all that nothing has built."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode == 0:
        return [name for name in listed.stdout.split("\0") if name]
    built = re.compile(r"build|build-.*|out|\.git|\.\w+_cache")
    tops = [top for top in ROOT.iterdir() if not built.fullmatch(top.name)]
    files = [file for top in tops for file in (top, *top.rglob("*")) if file.is_file()]
    return sorted(file.relative_to(ROOT).as_posix() for file in files)


def texts_of_the_repository() -> Iterator[tuple[str, str]]:
    """Names and texts of its text files."""
    for name in files_of_the_repository():
        try:
            yield name, (ROOT / name).read_text()
        except (UnicodeDecodeError, FileNotFoundError):
            continue  # pictures, arrays; files that are removed next


def without_reports(changelog: str) -> str:
    entries = re.split(r"^(?=\* |## )", changelog, flags=re.MULTILINE)
    return "".join(entry for entry in entries if REPORT not in " ".join(entry.split()))


def test_messages_name_the_libraries_of_the_extras():
    tomllib = pytest.importorskip("tomllib")  # Python 3.11
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    declared = {
        extra: tuple(re.match(r"[\w-]+", one)[0] for one in requirements)
        for extra, requirements in project["optional-dependencies"].items()
    }
    assert declared == LIBRARIES
    assert install_command("play") == "pip install aiohttp pillow"
    assert project["name"] == NAME


def test_the_distribution_has_its_own_name():
    if not [*importlib.metadata.distributions(name=NAME)]:
        pytest.skip("not installed by pip")
    assert importlib.metadata.version(NAME) == engram.__version__
    commands = importlib.metadata.distribution(NAME).entry_points
    assert ("engram", "engram.command:main") in {(one.name, one.value) for one in commands}


@pytest.mark.parametrize(
    "text",
    [
        'pip install "engram[play]"',
        "pip install engram",
        "pip install -q --upgrade engram-sim",
        "pip3 install --find-links build/dist 'engram[video]==0.6.0'",
        "python -m pip install engram_sim>=0.5",
        "pip download engram",
        "uv add engram",
        "uv pip install --python env engram",
        "pip --quiet install numpy \\\n  engram",
        r"print('pip install \"engram[play]\"; none')",
        "`pip install engram`.",
        "needs engram[datasets]",
        'dependencies = ["engram==0.6.0"]',
        "engram-sim ~= 0.5",
    ],
)
def test_the_search_finds_installations_by_name(text):
    assert [*by_name(text)]


@pytest.mark.parametrize(
    "text",
    [
        "pip install build/dist/engram_sim-*_x86_64.whl",
        'pip install "./engram_sim-0.6.0-cp310-abi3-manylinux_2_34_x86_64.whl[play]"',
        'pip install ".[video]"',
        "pip install aiohttp pillow  # for engram play",
        "pip install torch | engram",
        "pip install --no-index --find-links build/wheels engram-sim",
        "uv pip install --reinstall-package engram-sim build/wheels/engram_sim-*.whl",
        "pip uninstall engram",
        "apt install engram",
        "find_package(engram 0.6)",
        '"engram": "0.6.0"',
        'metadata["engram"]["rules"]',
    ],
)
def test_the_search_passes_over_others(text):
    assert [*by_name(text)] == []


def test_the_changelog_may_report_the_old_words():
    report = f"* That name {REPORT}:\n  `pip install engram`.\n"
    assert without_reports(f"{report}* Other.\n") == "* Other.\n"
    assert [*by_name(without_reports(f"{report}* Other: `pip install engram`.\n"))]


def test_nothing_tells_people_to_install_the_project_by_name():
    found = []
    for name, text in texts_of_the_repository():
        if name == HERE:
            continue
        shown = without_reports(text) if name == "CHANGELOG.md" else text
        found += [f"{name}: {words[:200]}" for words in by_name(shown)]
    assert found == []


def test_pages_name_the_files_of_this_version():
    files = {
        (name, file)
        for name, text in texts_of_the_repository()
        if name.endswith((".md", ".ipynb")) and name != "CHANGELOG.md"
        for file in re.findall(r"engram(?:_sim)?-[\w.]*\d[\w.-]*?\.(?:whl|tar\.gz)", text)
    }
    assert len(files) >= 3
    start = f"engram_sim-{engram.__version__}"
    wheel = f"{start}-cp310-abi3-manylinux_2_34_"
    for name, file in files:
        assert file.startswith(wheel) or file == f"{start}.tar.gz", name
