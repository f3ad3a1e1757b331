#!/usr/bin/env python3
"""Measures the structure of the sources and prints a table: structure.py [--root DIR] [--list].

    units, includes, floors   a unit is a .h with the .cc of the same name; a floor is the longest
                              chain of includes below a unit
    circles                   units, or Python modules, that import one another in a loop; imports
                              inside functions and under TYPE_CHECKING count
    words                     standard terms that the code implements and that nobody could search
                              for, and names that were given up for a standard term
    comments                  comment blocks that open with a relative clause ("What ...")

--list names the findings. Nothing is run or imported.
"""

import argparse
import ast
import re
import subprocess
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

# Names that were replaced by standard terms, as words of code: (files, pattern).
FORMER_NAMES = {
    "PairSieve": ("cpp", r"\bPairSieve\b|\bsieve\b"),
    "Waker": ("cpp", r"\bWaker\b|\bwake_what_is_near\b|\bput_to_sleep\b"),
    "foresee": ("cpp", r"\bforesee\w*|\bforesight\b"),
    "push_out": ("cpp", r"\bis_engulfed\b|\bpush_out\b|\bway_out\b|\bway_in\b"),
    "JointLaw": ("cpp", r"\bJointLaw\b|\bRobotLaw\b|\bDriveLaw\b"),
    "aim, driven": (
        "core/(robot|physics)",
        r"\baim\b|\bdriven\b|\bbrake\b|\bresist\b|\bcouple\b|\bgive\b",
    ),
    "arms": ("core/(robot|physics)", r"\barms\b|\barm\["),
    "root()": ("core/(robot|math|physics)", r"\broot\("),
    "lesser": ("cpp", r"\blesser\b|\bgreater\(|\bmagnitude\("),
    "moved_far": ("cpp", r"\bmoved_far\b"),
    "kSeen, kRoom": ("core/(robot|physics|sim)", r"\bkSeen\b|\bkRoom\b|\bkAim\b"),
    "follow_arm": ("cpp", r"\bfollow_arm\b|\bplace_links\b"),
    "power()": ("core/(robot|physics)", r"\bpower\("),
    "Loader": ("cpp", r"\bLoader\b|\bharvest\b"),
    "look_around": ("cpp", r"\blook_around\b|\blooked_"),
    "room()": ("core", r"\broom\(\)|\bway\("),
    "glide": ("cpp", r"\bglid(e|er|ers|ing)\w*"),
    "mover": ("cpp", r"\b\w*[mM]overs?\b"),
    "describe_rows": ("cpp", r"\bdescribe_rows\b|\brefer_rows\b"),
    "Zone, Course": ("core", r"\bZone\b|\bCourse\b"),
    "compose_dynamics": ("cpp", r"\bcompose_dynamics\b|\bcomposed_step\b"),
    "move_evenly": ("cpp", r"\bmove_evenly\b"),
    "Workbench": ("cpp", r"\b\w*Workbench\b|\b(Scene|Step)Bench\b"),
    "make_sparing_data": ("cpp", r"\bmake_sparing_data\b|\bsmall_casts\b"),
    "shared_lock()": ("cpp", r"(?<!std::)\bshared_lock\("),
    "draws(), drawn(), draw()": ("core", r"\b(draws|drawn|draw)\(\)"),
    "OptionChoice": ("core", r"\bOptionChoice\b"),
    "tell, told": ("cpp|python/engram", r"\b\w*_tell\b|\b_?on_demand\b|\b_told\b|\bOnDemand\b"),
    "Changes": ("tasks", r"\bChanges\b|\bStretch\b|\bHaste\b"),
    "RenderCamera::kA": ("mjcf", r"\bRenderCamera\b|\bkA, kB\b"),
    "ObjectLook": ("cpp", r"\bObjectLook\b|\blooks\(\)|\blook_of\b"),
    "Eight": ("render", r"\bkEight\b|\bEight\b|\bEightsKernel\b|\bThree\b"),
    "leads, joined_run": ("protocol|apps", r"\bleads\(|\bjoined_run\b|\brun_joined\b"),
    "House, Wall, Film": (
        "python/engram/play",
        r"\bHouse\b|\bSetting\b|\bWall\b|\bFilm\b|\b_TOLD\b|\bkeeping\b",
    ),
    "liking, Eye": (
        "python/examples",
        r"\bLIKES\b|\bliking\b|\bSight\b|\bEye\b|\bRecollection\b|\bset_pace\b|\bsuccess_of\b",
    ),
}

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


def public_methods(root: Path) -> int:
    """Public member functions of the engine's batch, constructors and operators left out."""
    for path, name in (("core/batch/batch.h", "Batch"), ("core/vector_env.h", "VectorEnv")):
        file = root / path
        if file.is_file():
            text = re.sub(r"//[^\n]*", "", read(file))
            body = text[re.search(rf"class {name} ?[^;{{]*{{", text).end() :]
            body = body[body.index("public:") : re.search(r"\bprivate:", body).start()]
            depth = 0
            outer = []
            for char in body:  # drops what nested braces hold: bodies and nested types
                depth -= char == "}"
                if depth == 0:
                    outer.append(char)
                depth += char == "{"
            declared = re.findall(r"\b(~?[A-Za-z_]\w*)\s*\(", "".join(outer))
            own = {name, "~" + name, "operator", "span", "function", "decltype"}
            return sum(1 for method in declared if method not in own)
    return 0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parent.parent)
    parser.add_argument("--list", action="store_true", help="names the findings, too")
    options = parser.parse_args()
    root = options.root
    rows: list[tuple[str, str, list[str]]] = []

    code = sources(root, (".h", ".cc"))
    in_code = [f for f in code if f.parts[0] in ("core", "render", "tasks", "protocol", "apps")]
    text = " ".join(read(root / f) for f in in_code)
    plain = re.sub(r"[\s/_]+", " ", text).lower()
    missing = [term for term in STANDARD_TERMS if term.lower() not in plain]
    rows.append(("standard terms with no use in code", f"{len(missing)}", missing))

    everything = code + sources(root, (".py", ".js", ".html"))
    left = []
    for name, (where, pattern) in FORMER_NAMES.items():
        folder = re.compile(
            "|".join(CPP) if where == "cpp" else where.replace("cpp", "|".join(CPP))
        )
        word = re.compile(pattern)
        hits = [
            str(f)
            for f in everything
            if folder.match(str(f)) and "tests" not in f.parts and word.search(read(root / f))
        ]
        if hits:
            left.append(f"{name}: {', '.join(hits[:6])}")
    rows.append((f"former names left, of {len(FORMER_NAMES)} rows", f"{len(left)}", left))

    units = cpp_units(root)
    loops = circles(units)
    rows.append(("circles of units, C++", f"{len(loops)}", [", ".join(c) for c in loops]))
    modules = python_modules(root)
    loops = circles(modules)
    rows.append(("circles of modules, Python", f"{len(loops)}", [", ".join(c) for c in loops]))

    core = {n: {o for o in below if o.startswith("core/")} for n, below in units.items()}
    core = {n: below for n, below in core.items() if n.startswith("core/")}
    size = f"{len(core)}, {sum(map(len, core.values()))}, {floors(core)}"
    rows.append(("core: units, includes, floors", size, []))
    rows.append(("public methods of the engine's batch", f"{public_methods(root)}", []))

    enums = []
    for file in code:
        if file.parts[0] == "tasks":
            for name in re.findall(r"^\s*enum (\w+)? ?(?:: [\w:]+ )?{ ?k", read(root / file), re.M):
                enums.append(f"{file}: {name or 'unnamed'}")
    rows.append(("plain enums of indices in tasks", f"{len(enums)}", enums))

    listed: dict[tuple[str, str], int] = {}
    for file in code:
        if (
            file.parts[0] == "tasks"
            and len(file.parts) > 2
            and file.parts[1] not in ("common", "parts")
        ):
            for name in re.findall(r'"([A-Z][A-Z0-9]*_[A-Z0-9_]+)"', read(root / file)):
                listed[file.parts[1], name] = listed.get((file.parts[1], name), 0) + 1
    mean = sum(listed.values()) / max(1, len(listed))
    worst = sorted(listed, key=lambda key: -listed[key])[:8]
    rows.append(
        (
            "times a family writes a constant's name: mean, most",
            f"{mean:.2f}, {max(listed.values(), default=0)}",
            [f"{family}: {name} {listed[family, name]}" for family, name in worst],
        )
    )

    level = {m.split(".")[1] for m in modules if m.count(".") >= 1}
    rows.append(("python/engram, first level: modules", f"{len(level)}", sorted(level)))

    blocks = comment_blocks(root, [f for f in code if f.parts[0] != "tests"])
    relative = [f"{f}:{n}: {t}" for f, n, t in blocks if RELATIVE.match(t)]
    share = 100 * len(relative) / len(blocks)
    rows.append(
        (
            "comment blocks that open with a relative clause",
            f"{len(relative)} of {len(blocks)} ({share:.1f} %)",
            relative,
        )
    )
    tested = {f.stem.removesuffix("_test") for f in sources(root, ("_test.cc",))}
    with_logic = [f for f in code if f.suffix == ".cc" and f.parts[0] in CPP]
    bare = [str(f) for f in with_logic if f.stem not in tested]
    rows.append(
        (
            "source files with a test of their own name",
            f"{len(with_logic) - len(bare)} of {len(with_logic)}",
            bare,
        )
    )
    long = [(len(read(root / f).splitlines()), str(f)) for f in everything]
    long = sorted((n, f) for n, f in long if n > 500)
    rows.append(("files over 500 lines", f"{len(long)}", [f"{n} {f}" for n, f in long]))

    print("| measure | value |\n| --- | --: |")
    for name, value, _ in rows:
        print(f"| {name} | {value} |")
    if options.list:
        for name, _, findings in rows:
            if findings:
                print(f"\n{name}:")
                for finding in findings:
                    print(f"  {finding}")


if __name__ == "__main__":
    main()
