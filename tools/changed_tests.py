#!/usr/bin/env python3
"""Prints the tests that a change can reach, one a line: changed_tests.py [REVISION].

What differs from REVISION is the change, with new files; default: where this branch left main.

    C++      tests whose file includes a changed unit (a .h with the .cc of the same name), directly
             or through other headers, and those in the folder that mirrors the unit's
    Python   tests that import a changed module, themselves or through other modules, and those in
             the folder that mirrors the module's
    others   tests that name the file (a table, an example), or whose helpers do

A line is "cpp FILE" or "python FILE". Changes of C++ choose no tests of Python, except those of the
binding, python/src, which choose all; "binding FILE" names them.
"""

import argparse
import ast
import functools
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
MODULE = re.compile(r"(engram|engram_learners)(\.\w+)*")
# Parts of the package that its other modules import on demand: tests that name them reach them.
ON_DEMAND = ("datasets", "integrations", "kit", "mikasa", "play", "servers")
CPP_TESTS, PYTHON_TESTS = "tests", "python/tests"
CONVENTIONS = "tests/conventions/"  # read all sources
BINDING = "python/src/"
CONFTEST = "conftest.py"
READERS = (  # tests of all files of a folder
    ("docs/", "python/tests/test_docs_pages.py"),
    ("README.md", "python/tests/test_docs_pages.py"),
    ("scripts/", "python/tests/test_tools.py"),
    ("tools/", "python/tests/test_tools.py"),
    ("changelog.d/", "python/tests/test_tools.py"),
)


def git(root, *arguments):
    words = ["git", "-C", root, *arguments]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.splitlines()


def changed_files(root, revision):
    if revision is None:
        (revision,) = git(root, "merge-base", "HEAD", "main")
    tracked = git(root, "diff", "--name-only", revision)
    return sorted({*tracked, *git(root, "ls-files", "--others", "--exclude-standard")})


class Tree:
    """Files of a checkout, and what each of them includes or imports."""

    def __init__(self, root):
        self.root = root
        self.files = set(git(root, "ls-files", "--cached", "--others", "--exclude-standard"))
        self.files = {name for name in self.files if (root / name).is_file()}
        self.cpp_tests = self._named(CPP_TESTS, "_test.cc")
        self.python_tests = sorted(
            name for name in self._named("python", ".py") if Path(name).name.startswith("test_")
        )

    def _named(self, folder, end):
        return sorted(n for n in self.files if n.startswith(f"{folder}/") and n.endswith(end))

    @functools.cache  # noqa: B019 (one tree a run)
    def text(self, name):
        return (self.root / name).read_text(errors="replace")

    def reach(self, name, edges):
        """Files that one leads to, itself included."""
        seen, todo = {name}, [name]
        while todo:
            for found in edges(todo.pop()) - seen:
                seen.add(found)
                todo.append(found)
        return seen

    # --- C++ ---

    @functools.cache  # noqa: B019
    def includes(self, name):
        folder = Path(name).parent
        found = set()
        for path in INCLUDE.findall(self.text(name)):
            places = (path, f"api/{path}", f"tests/{path}", (folder / path).as_posix())
            found |= self.files.intersection(places)
        return found

    def tests_of_unit(self, unit):
        """Tests that include a unit, named by its path without the ending, or mirror its folder."""
        folder = f"{CPP_TESTS}/{Path(unit).parent.as_posix()}"
        return {
            test
            for test in self.cpp_tests
            if Path(test).parent.as_posix() == folder
            or unit in {_unit(name) for name in self.reach(test, self.includes)}
        }

    # --- Python ---

    @functools.cache  # noqa: B019
    def module(self, dotted, folder):
        """File of a module, as a file of that folder imports it; None for others' modules."""
        path = dotted.replace(".", "/")
        above = [parent.as_posix() for parent in [folder, *folder.parents]]
        for place in (*above, "python", "python/learners/src", "python/tests/mikasa", "tools"):
            for name in (f"{place}/{path}.py", f"{place}/{path}/__init__.py"):
                if name in self.files:
                    return name
        return None

    @functools.cache  # noqa: B019
    def imports(self, name):
        """Files whose modules a file imports or, as a string or an attribute, names."""
        if Path(name).name == CONFTEST:  # all tests have it, and few need what it imports
            return set()
        folder = Path(name).parent
        dotted = set()
        for node in ast.walk(ast.parse(self.text(name))):
            dotted.update(_names(node, folder))
            if "tests/" in name:
                dotted.update(_words(node))
        parts = [one.split(".") for one in dotted]  # a module's packages are imported with it
        dotted = {".".join(one[:end]) for one in parts for end in range(1, len(one) + 1)}
        found = {self.module(one, folder) for one in dotted} - {None, name}
        return found if name in self.python_tests else {n for n in found if _is_followed(name, n)}

    def tests_of_module(self, name):
        """Tests that import a file of Python, and all below a conftest.py that is or imports it."""
        found = {test for test in self.python_tests if name in self.reach(test, self.imports)}
        for conftest in self._named("python", CONFTEST) if "/tests/" in name else ():
            folder = Path(conftest).parent
            nodes = ast.walk(ast.parse(self.text(conftest)))
            if name == conftest or name in {
                self.module(n, folder) for one in nodes for n in _names(one, folder)
            }:
                found |= {test for test in self.python_tests if folder in Path(test).parents}
        return found

    def tests_of_folder(self, name):
        """Tests in the folder that mirrors the file's, or the nearest above it that has some."""
        parts = Path(name).parts
        for end in range(len(parts) - 1, 2, -1):
            folder = Path(PYTHON_TESTS, *parts[2:end])
            found = {test for test in self.python_tests if Path(test).parent == folder}
            if found:
                return found
        return set()

    def tests_naming(self, name):
        path = Path(name)
        is_alone = sum(Path(other).name == path.name for other in self.files) == 1
        words = path.name if is_alone else f"{path.parent.name}/{path.name}"
        pattern = re.compile(rf"(?<![\w-]){re.escape(words)}\b")
        tests = [(test, self.includes) for test in self.cpp_tests]
        tests += [(test, self.imports) for test in self.python_tests]
        return {
            test
            for test, edges in tests
            if any(pattern.search(self.text(n)) for n in self.reach(test, edges) if "tests/" in n)
        }

    def tests_of(self, name):
        """Tests that a changed file reaches."""
        if name in self.cpp_tests or name in self.python_tests:
            return {name} & self.files
        if name.startswith(BINDING):
            return set(self.python_tests)
        if name.endswith((".cc", ".h", ".c")):
            return self.tests_of_unit(_unit(name))
        found = {test for place, test in READERS if name.startswith(place)}
        if name.startswith("python/engram/"):
            found |= self.tests_of_folder(name)
        else:
            found |= self.tests_naming(name)
        return found | (self.tests_of_module(name) if name.endswith(".py") else set())


def _unit(name):
    return name.rpartition(".")[0]


def _names(node, folder):
    """Dotted names of modules in a node of a syntax tree."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:  # of the package that holds the file
            parts = folder.parts[1 + ("learners" in folder.parts) * 2 :]
            base = ".".join([*parts[: len(parts) - node.level + 1], *filter(None, [base])])
        yield base
        yield from (f"{base}.{alias.name}" for alias in node.names)


def _words(node):
    """Modules that an attribute names (engram.kit.Task), or a string (of python -m engram)."""
    if isinstance(node, ast.Attribute) and MODULE.fullmatch(ast.unparse(node)):
        yield ast.unparse(node)
    if (
        isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and MODULE.fullmatch(node.value)
    ):
        yield from (node.value, f"{node.value}.__main__")


def _is_followed(name, other):
    """False for an import on demand."""
    parts = Path(other).parts
    if parts[:2] != ("python", "engram") or parts[2] not in ON_DEMAND:
        return True
    return Path(name).parts[:3] == parts[:3] or not name.startswith("python/engram/")


def chosen(root, revision=None):
    """Pairs: "cpp", "python" or "binding", and a file."""
    tree = Tree(root)
    changed = changed_files(root, revision)
    tests = set().union(*(tree.tests_of(name) for name in changed))
    if changed:
        tests |= {test for test in tree.cpp_tests if test.startswith(CONVENTIONS)}
    pairs = [("python" if test.endswith(".py") else "cpp", test) for test in sorted(tests)]
    return pairs + [("binding", name) for name in changed if name.startswith(BINDING)]


def main(given=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("revision", nargs="?", metavar="REVISION")
    for pair in chosen(ROOT, parser.parse_args(given).revision):
        print(*pair)


if __name__ == "__main__":
    main()
