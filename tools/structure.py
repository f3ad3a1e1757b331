#!/usr/bin/env python3
"""Measures the structure of the sources and prints a table: structure.py [--root DIR] [--list].

    units, includes, floors   a unit is a .h with the .cc of the same name; a floor is the longest
                              chain of includes below a unit
    circles                   units, or Python modules, that import one another in a loop; imports
                              inside functions and under TYPE_CHECKING count
    lines by hand             without what lies between marks such as "begin generated" and
                              "end generated", or "begin rl: written by" and "end rl"
    relative, leaning         comment blocks that open with a relative clause ("How ..."), or that
                              lean on another comment ("The same", "As those", "Of")

--list names the findings. --commits A..B prints how many files a change touched, and by hand, for
an addition of one query or option; --naming WORD lists the files that name one. Nothing is run or
imported.
"""

import argparse
import ast
import re
import subprocess
from collections import Counter
from pathlib import Path

CPP = ("core", "mjcf", "tasks", "render", "media", "protocol", "api", "apps", "bench")
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]', re.MULTILINE)

# Terms that the simulator implements; each has to stand in core, render, tasks, protocol or apps.
STANDARD_TERMS = (
    "broad phase",
    "speculative contact",
    "contact manifold",
    "friction anchor",
    "penetration",
    "Gauss-Seidel",
    "CRBA",
    "RNEA",
    "forward kinematics",
    "workspace",
)

CODE = (
    ".h",
    ".cc",
    ".c",
    ".py",
    ".pyi",
    ".js",
    ".css",
    ".html",
    ".sh",
    ".cmake",
    ".yml",
    "CMakeLists.txt",
)
LEANING = re.compile(r"^(The same|As (those|that|the|in)|That of|Those of|Of)\b")
RELATIVE = re.compile(
    r"^(What|How|Where|Whether|Of|Which|As|From|Who|Whose|When|By what|To what|With what)\b"
)


def read(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def sources(root: Path, suffixes: tuple[str, ...]) -> list[Path]:
    listed = subprocess.run(
        ["git", "-C", root, "ls-files", "--cached", "--others", "--exclude-standard"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split("\n")
    return [Path(f) for f in listed if f.endswith(suffixes) and (root / f).is_file()]


def cpp_units(root: Path) -> dict[str, set[str]]:
    """Unit -> units that it includes."""
    files = [f for f in sources(root, (".h", ".cc")) if f.parts[0] in CPP]
    known = {str(f.with_suffix("")) for f in files}
    units: dict[str, set[str]] = {name: set() for name in known}
    for file in files:
        unit = str(file.with_suffix(""))
        for name in INCLUDE.findall(read(root / file)):
            for candidate in (name, "api/" + name, f"{file.parent}/{name}"):
                other = candidate.removesuffix(".h")
                if other in known and other != unit:
                    units[unit].add(other)
    # The public header ends with its own implementation.
    units.get("api/engram/engram_impl", set()).discard("api/engram/engram")
    return units


def python_modules(root: Path) -> dict[str, set[str]]:
    """Module of python/engram -> modules that it imports; faces (__init__.py) count."""
    files = [f for f in sources(root, (".py",)) if f.is_relative_to("python/engram")]

    def dotted(file: Path) -> str:
        name = file.relative_to("python").with_suffix("")
        parts = name.parts[:-1] if name.name == "__init__" else name.parts
        return ".".join(parts)

    known = {dotted(f) for f in files}
    modules: dict[str, set[str]] = {name: set() for name in known}
    for file in files:
        module = dotted(file)
        for node in ast.walk(ast.parse(read(root / file))):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                base = node.module or ""
                if node.level:
                    here = module if file.name == "__init__.py" else module.rpartition(".")[0]
                    for _ in range(node.level - 1):
                        here = here.rpartition(".")[0]
                    base = f"{here}.{base}" if base else here
                names = [f"{base}.{alias.name}" for alias in node.names]
            else:
                continue
            for name in names:
                while name and name not in known:
                    name = name.rpartition(".")[0]
                if name and name != module and name != "engram":
                    modules[module].add(name)
    return modules


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Strongly connected components of more than one node (Tarjan's algorithm)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(graph[node]):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            at = stack.index(node)
            component = sorted(stack[at:])
            del stack[at:]
            if len(component) > 1:
                found.append(component)

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return sorted(found, key=len, reverse=True)


def floors(graph: dict[str, set[str]]) -> int:
    """Length of the longest chain; nodes of a circle count once each."""
    depth: dict[str, int] = {}

    def of(node: str, path: frozenset[str]) -> int:
        if node in depth:
            return depth[node]
        if node in path:
            return 0
        value = 1 + max((of(o, path | {node}) for o in graph[node]), default=0)
        depth[node] = value
        return value

    return max((of(node, frozenset()) for node in graph), default=0)


def comment_blocks(root: Path, files: list[Path]) -> list[tuple[Path, int, str]]:
    """File, line and first line of every block of // comments, those behind code left out."""
    blocks = []
    for file in files:
        before = False
        for number, line in enumerate(read(root / file).splitlines(), 1):
            text = line.strip()
            is_comment = text.startswith("//")
            if is_comment and not before:
                blocks.append((file, number, text.lstrip("/").strip()))
            before = is_comment
    return blocks


def batch_class(root: Path) -> str:
    """The definition of the engine's batch, without comments."""
    for path in ("core/batch/batch.h", "core/env/batch.h"):
        if (root / path).is_file():
            text = re.sub(r"//[^\n]*", "", read(root / path))
            body = text[re.search(r"^class Batch ?[^;{]*{", text, re.MULTILINE).end() :]
            return body[: body.index("\n};")]
    return ""


def public_methods(root: Path) -> list[str]:
    """Public member functions of the engine's batch, constructors and operators left out."""
    body = batch_class(root)
    body = body[body.index("public:") : re.search(r"\bprivate:", body).start()]
    depth = 0
    outer = []
    for char in body:  # drops what nested braces hold: bodies and nested types
        depth -= char == "}"
        if depth == 0:
            outer.append(char)
        depth += char == "{"
    declared = re.findall(r"\b(~?[A-Za-z_]\w*)\s*\(", "".join(outer))
    own = {"Batch", "~Batch", "operator", "span", "function", "decltype"}
    return [method for method in declared if method not in own]


def example_modules(root: Path) -> dict[str, int]:
    """Programs of python/examples, with the modules of that folder behind each, itself included.

    Other programs that it imports count as examples of their own.
    """
    files = {f for f in sources(root, (".py",)) if f.is_relative_to("python/examples")}
    programs = {file for file in files if "__main__" in read(root / file)}

    def imported(file: Path) -> set[Path]:
        names = set()
        for node in ast.walk(ast.parse(read(root / file))):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                base = node.module or ""
                names |= {base, *(f"{base}.{alias.name}" for alias in node.names)}
        paths = {file.parent / name.replace(".", "/") for name in names if name.strip(".")}
        return {p.with_suffix(".py") for p in paths} | {p / "__init__.py" for p in paths}

    def behind(file: Path, found: set[Path]) -> set[Path]:
        found.add(file)
        for other in imported(file) & files - found:
            behind(other, found)
        return found

    return {file.stem: len(behind(file, set()) - programs) + 1 for file in sorted(programs)}


def by_hand(lines: list[str]) -> list[str]:
    """Lines without those that tables generate."""
    kept = []
    generated = False
    for line in lines:
        if re.search(r"\bbegin (generated\b|\w+: written by )", line):
            generated = True
        elif generated and re.search(r"(//|#|\*) end \w+", line):
            generated = False
        elif not generated:
            kept.append(line)
    return kept


def is_test(file: Path) -> bool:
    return "tests" in file.parts


def product_and_tests(root: Path) -> tuple[int, int, int]:
    """Lines of code by hand of the product and of the tests, and lines that are generated."""
    product = tests = generated = 0
    folders = (*CPP, "python", "tests", "scripts", "tools", "cmake", ".github")
    for file in sources(root, CODE):
        if file.parts[0] in folders and "data" not in file.parts:
            lines = read(root / file).splitlines()
            own = len(by_hand(lines))
            generated += len(lines) - own
            if is_test(file):
                tests += own
            else:
                product += own
    return product, tests, generated


def touched(root: Path, commits: str) -> tuple[list[str], list[str]]:
    """Files that a range of commits changed, and those of them that it changed by hand."""

    def git(*words: str) -> str:
        command = ["git", "-C", str(root), *words]
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout

    before, _, after = commits.partition("..")
    files = git("diff", "--name-only", before, after).split()

    def own(commit: str, file: str) -> list[str]:
        return by_hand(git("show", f"{commit}:{file}").splitlines())

    return files, [file for file in files if own(before, file) != own(after, file)]


def naming(root: Path, word: str) -> list[str]:
    """Files of code whose lines by hand have a word; those of tests are left out."""
    pattern = re.compile(rf"\b{word}\b")
    files = [f for f in sources(root, (*CODE, ".toml")) if not is_test(f)]
    return [str(f) for f in files if any(map(pattern.search, by_hand(read(root / f).splitlines())))]


class Measures:
    """Rows of the table: name, value, findings."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.code = sources(root, (".h", ".cc"))
        self.units = cpp_units(root)
        self.modules = python_modules(root)
        self.rows: list[tuple[str, str, list[str]]] = []

    def add(self, name: str, value: object, findings: list[str] | None = None) -> None:
        self.rows.append((name, str(value), findings or []))

    def add_words(self) -> None:
        where = ("core", "render", "tasks", "protocol", "apps")
        text = " ".join(read(self.root / f) for f in self.code if f.parts[0] in where)
        plain = re.sub(r"[\s/_]+", " ", text).lower()
        missing = [term for term in STANDARD_TERMS if term.lower() not in plain]
        self.add("standard terms with no use in code", len(missing), missing)

    def add_graph(self) -> None:
        loops = circles(self.units)
        self.add("circles of units, C++", len(loops), [", ".join(c) for c in loops])
        loops = circles(self.modules)
        self.add("circles of modules, Python", len(loops), [", ".join(c) for c in loops])
        core = {n: {o for o in below if o.startswith("core/")} for n, below in self.units.items()}
        core = {n: below for n, below in core.items() if n.startswith("core/")}
        size = f"{len(core)}, {sum(map(len, core.values()))}, {floors(core)}"
        self.add("core: units, includes, floors", size)
        folders = Counter(str(Path(name).parent) for name in self.units if "/" in name)
        folders = Counter({f: n for f, n in folders.items() if f.startswith(("core", "protocol"))})
        fattest = [f"{n} {folder}" for folder, n in folders.most_common(8)]
        self.add("units of the fattest folder of core and protocol", max(folders.values()), fattest)
        level = {m.split(".")[1] for m in self.modules if m.count(".") >= 1}
        self.add("python/engram, first level: modules", len(level), sorted(level))

    def add_batch(self) -> None:
        methods = public_methods(self.root)
        self.add("public methods of Batch", len(methods), methods)
        friends = re.findall(r"friend (?:class|struct) (\w+)", batch_class(self.root))
        self.add("friends of Batch", len(friends), friends)

    def add_tasks(self) -> None:
        enums = []
        listed: Counter[tuple[str, str]] = Counter()
        for file in self.code:
            if file.parts[0] != "tasks":
                continue
            text = read(self.root / file)
            for name in re.findall(r"^\s*enum (\w+)? ?(?:: [\w:]+ )?{ ?k", text, re.MULTILINE):
                enums.append(f"{file}: {name or 'unnamed'}")
            if len(file.parts) > 2 and file.parts[1] not in ("common", "parts"):
                for name in re.findall(r'"([A-Z][A-Z0-9]*_[A-Z0-9_]+)"', text):
                    listed[file.parts[1], name] += 1
        self.add("plain enums of indices in tasks", len(enums), enums)
        mean = sum(listed.values()) / max(1, len(listed))
        worst = [f"{family}: {name} {n}" for (family, name), n in listed.most_common(8)]
        most = max(listed.values(), default=0)
        self.add(
            "times a family writes a constant's name: mean, most", f"{mean:.2f}, {most}", worst
        )

    def add_comments(self) -> None:
        blocks = comment_blocks(self.root, [f for f in self.code if f.parts[0] != "tests"])
        for name, pattern in (
            ("open with a relative clause", RELATIVE),
            ("lean on others", LEANING),
        ):
            found = [f"{f}:{n}: {t}" for f, n, t in blocks if pattern.match(t)]
            share = f"{len(found)} of {len(blocks)} ({100 * len(found) / len(blocks):.1f} %)"
            self.add(f"comment blocks that {name}", share, found)

    def add_size(self) -> None:
        product, tests, generated = product_and_tests(self.root)
        self.add("lines by hand: product, tests", f"{product:,}, {tests:,}")
        self.add("lines that are generated", f"{generated:,}")
        behind = Counter(example_modules(self.root))
        listed = [f"{n} {name}" for name, n in behind.most_common(8)]
        self.add("modules behind the largest example", max(behind.values(), default=0), listed)
        options = {word: len(naming(self.root, word)) for word in ("latency", "policy_seed")}
        counts = ", ".join(map(str, options.values()))
        self.add(f"files that name an option of evaluations: {', '.join(options)}", counts)
        pages = [read(self.root / f) for f in sources(self.root, (".md",))]
        self.add("pages, words", f"{len(pages)}, {sum(len(page.split()) for page in pages):,}")
        programs = [str(f) for f in sources(self.root, (".sh", ".py")) if is_program(self.root, f)]
        self.add("programs of scripts and tools", len(programs), programs)

    def add_tests(self) -> None:
        tested = {f.stem.removesuffix("_test") for f in sources(self.root, ("_test.cc",))}
        with_logic = [f for f in self.code if f.suffix == ".cc" and f.parts[0] in CPP]
        bare = [str(f) for f in with_logic if f.stem not in tested]
        value = f"{len(with_logic) - len(bare)} of {len(with_logic)}"
        self.add("source files with a test of their own name", value, bare)
        everything = self.code + sources(self.root, (".py", ".js", ".html"))
        long = [(len(read(self.root / f).splitlines()), str(f)) for f in everything]
        long = sorted((n, f) for n, f in long if n > 500)
        self.add("files over 500 lines", len(long), [f"{n} {f}" for n, f in long])


def is_program(root: Path, file: Path) -> bool:
    """A file of scripts or tools that is run, and no part of a package."""
    return file.parts[0] in ("scripts", "tools") and (
        file.name == "__main__.py" or read(root / file).startswith("#!")
    )


def measure(root: Path) -> list[tuple[str, str, list[str]]]:
    measures = Measures(root)
    for add in (
        measures.add_words,
        measures.add_graph,
        measures.add_batch,
        measures.add_tasks,
        measures.add_comments,
        measures.add_size,
        measures.add_tests,
    ):
        add()
    return measures.rows


def print_list(name: str, findings: list[str]) -> None:
    print(f"\n{name}:")
    for finding in findings:
        print(f"  {finding}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parent.parent)
    parser.add_argument("--list", action="store_true", help="names the findings, too")
    parser.add_argument("--commits", metavar="A..B", help="counts the files of this change")
    parser.add_argument("--naming", metavar="WORD", help="lists the files of code with a word")
    options = parser.parse_args()
    if options.naming:
        print_list(options.naming, naming(options.root, options.naming))
        return
    if options.commits:
        files, own = touched(options.root, options.commits)
        print(f"{len(files)} files, {len(own)} of them by hand")
        if options.list:
            print_list("by hand", own)
        return
    rows = measure(options.root)
    print("| measure | value |\n| --- | --: |")
    for name, value, _ in rows:
        print(f"| {name} | {value} |")
    for name, _, findings in rows:
        if options.list and findings:
            print_list(name, findings)


if __name__ == "__main__":
    main()
