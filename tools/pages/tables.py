"""Fills the tables of facts in docs/ from `engram list --json` and `engram info ID --json`.

A page marks where a table goes, each mark on a line of its own:

    <!-- table: KIND FAMILY... -->
    <!-- end -->

This replaces the text between the marks. KIND is one of ids, phases, draws, constants, state,
info, rewards, options, rules. FAMILY is a family of tasks, such as RememberColor; several share a
table. `table: rules`, without a family, has those of all. Tables leave out what all tasks have.

In cells where ids differ, a value follows the part of the id that distinguishes them: for
RememberColor, `3` means RememberColor3-VLA-v0 and RememberColor3-Long-VLA-v0 alike, `3-Long` the
latter only. A value without a name is that of the ids without Long.
"""

import argparse
import functools
import json
import os
import pathlib
import re
import subprocess
import sys

from pages.cells import Ids, code, in_reading_order, number, table, text_of

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DOCS = ROOT / "docs"
BEGIN = re.compile(r"<!-- table: (\w+)((?: \w+)*) -->")
END = "<!-- end -->"
COMMON_DRAWS = {"robot_noise"}
COMMON_STATE = {"qpos", "qvel", "tcp_pose"}
COMMON_INFO = {"answered", "first_answer", "first_answer_correct"}  # of all tasks with an answer


class TableError(Exception):
    """Error that the user has to fix; its text goes to standard error."""


class Engram:
    """The command: asks for every task once."""

    def __init__(self, command):
        self.command = command
        self.infos = {}
        self.entries = self.ask("list", "--json")
        self.families = {}
        for entry in self.entries:
            self.families.setdefault(entry["family"], []).append(entry["id"])
        for ids in self.families.values():
            ids.sort(key=in_reading_order)

    def ask(self, *arguments):
        call = [self.command, *arguments]
        try:
            done = subprocess.run(call, capture_output=True, text=True, check=True)
        except OSError as error:
            raise TableError(
                f"{self.command}: {error.strerror}; --engram FILE names the command"
            ) from error
        except subprocess.CalledProcessError as error:
            raise TableError(f"{' '.join(map(str, call))}: {error.stderr.strip()}") from error
        return json.loads(done.stdout)

    def info(self, task_id):
        if task_id not in self.infos:
            self.infos[task_id] = self.ask("info", task_id, "--json")
        return self.infos[task_id]

    @functools.cached_property
    def common_outputs(self):
        """Names of outputs that every task has."""
        one_of_each = [self.info(ids[0])["outputs"] for ids in self.families.values()]
        names = [{output["name"] for output in outputs} for outputs in one_of_each]
        return set.intersection(*names) | COMMON_INFO


# --- kinds of tables ---


def ids_table(ids):
    columns = {
        "id": [code(info["id"]) for info in ids.infos],
        "split": [info["split"] for info in ids.infos],
        "horizon": [number(info["horizon"]) for info in ids.infos],
        "candidates": [number(info["candidates"]) for info in ids.infos],
        "chance": [f"{info['chance']:.3g}" for info in ids.infos],
        "ends early at": [info["termination"] for info in ids.infos],
        "cue frozen": [text_of(info["frozen_cue"]) for info in ids.infos],
        "state width": [number(info["state_dim"]) for info in ids.infos],
    }
    same = {head: cells[0] for head, cells in columns.items() if len(set(cells)) == 1}
    if len(ids.infos) == 1:
        same = {}
    kept = {head: cells for head, cells in columns.items() if head not in same}
    text = table(list(kept), list(zip(*kept.values())))
    if same:
        text += "\nThe same for all: " + ", ".join(f"{head} {same[head]}" for head in same) + ".\n"
    return text + "\nInstruction:" + instructions_of(ids)


def instructions_of(ids):
    """The instructions; those that differ in one number are written once, with N for it."""
    texts = [f"“{info['instruction']}”" for info in ids.infos]
    numbers = [re.findall(r"\d+", text) for text in texts]
    templates = [re.sub(r"\d+", "N", text) for text in texts]
    if len(set(texts)) > len(set(templates)) == 1 == len(numbers[0]):
        values = ids.groups([found[0] for found in numbers])
        return f" {templates[0]} N is " + ", ".join(f"{n} ({tag})" for tag, n in values) + ".\n"
    groups = ids.groups(texts)
    if len(groups) == 1:
        return f" {groups[0][1]}\n"
    return "\n\n" + "".join(f"* {label}: {text}\n" for label, text in groups)


def phases_table(ids):
    rows = ids.rows([info["phases"] for info in ids.infos], lambda phase: phase["when"])
    return table(["phase", "when"], rows)


def span(draw):
    low, high = number(draw["low"]), number(draw["high"])
    return low if low == high else f"{low} to {high}"


def others(items, common):
    return [item for item in items if item["name"] not in common]


def width_of(item):
    return number(item["width"]) if item["width"] != 1 else ""


def draws_table(ids):
    rows = ids.rows(
        [others(info["draws"], COMMON_DRAWS) for info in ids.infos],
        width_of,
        span,
        lambda draw: draw["unit"] or ("integer" if draw["integer"] else ""),
        lambda draw: draw["description"],
    )
    return table(["draw", "width", "range", "unit", "what"], rows)


def constants_table(ids):
    lists = [
        [{"name": name, "value": value} for name, value in info["constants"].items()]
        for info in ids.infos
    ]
    rows = ids.rows(lists, lambda constant: text_of(constant["value"]))
    return table(["constant", "value"], rows)


def merge_numbered(fields):
    """Fields alike but for a number in their names, counted from 0, become one: goal_<i>_pose."""
    merged = {}
    for field in fields:
        name, *number_found = re.split(r"(\d+)", field["name"], maxsplit=1)
        if number_found:
            name += "<i>" + number_found[1]
        alike = (name, field["width"], field["unit"], field["description"])
        if number_found and number_found[0] == str(len(merged.get(alike, []))):
            merged.setdefault(alike, []).append(field)
        else:
            merged[field["name"]] = [field]
    for key, group in merged.items():
        first = group[0]
        width = number(first["width"])
        if len(group) > 1:
            width = f"{len(group)} x {width}"
            if group[1]["offset"] != first["offset"] + first["width"]:
                width += f", {group[1]['offset'] - first['offset']} apart"
        name = key if isinstance(key, str) else key[0]
        yield dict(first, name=name, width=width)


def state_table(ids):
    rows = ids.rows(
        [list(merge_numbered(others(info["state_fields"], COMMON_STATE))) for info in ids.infos],
        lambda field: number(field["offset"]),
        lambda field: field["width"],
        lambda field: field["unit"],
        lambda field: field["description"],
    )
    return table(["field", "from", "width", "unit", "what"], rows)


def info_table(ids, common):
    rows = ids.rows(
        [others(info["outputs"], common) for info in ids.infos],
        lambda output: f"{width_of(output)} {output['dtype']}, {output['unit']}".strip(" ,"),
        lambda output: output["description"],
    )
    return table(["info", "type", "what"], rows)


def rewards_table(ids):
    groups = ids.groups(
        [
            (number(info["success_reward"]), ", ".join(map(code, info["reward_terms"])))
            for info in ids.infos
        ]
    )
    if len(groups) == 1:
        worth, terms = groups[0][1]
        return f"Success is worth {worth}. Terms of `reward_dict`, in this order: {terms}.\n"
    rows = [[label, worth, terms] for label, (worth, terms) in groups]
    return table(["ids", "success is worth", "terms of `reward_dict`, in this order"], rows)


def options_table(ids):
    rows = ids.rows(
        [info["options"] for info in ids.infos],
        lambda option: number(option["default"]),
        lambda option: (
            number(option["original"]) if option["original"] != option["default"] else ""
        ),
        span,
        lambda option: option["unit"],
        lambda option: option["description"],
    )
    return (
        table(["option", "default", "original", "range", "unit", "what"], rows)
        if rows
        else "No options.\n"
    )


def rules_table(ids):
    """The options in which the original's code differs, by family."""
    rows = []
    for family in dict.fromkeys(ids.families):
        options = {}  # those of the family's ids: all have the same
        for info in ids.infos:
            if info["family"] == family:
                options |= {option["name"]: option for option in info["options"]}
        rows += [
            [
                code(family),
                code(option["name"]),
                number(option["default"]),
                number(option["original"]),
                option["description"],
            ]
            for option in options.values()
            if option["original"] != option["default"]
        ]
    merged = {}
    for family, *rest in rows:
        merged.setdefault(tuple(rest), []).append(family)
    rows = [[", ".join(families), *rest] for rest, families in merged.items()]
    return table(["families", "option", "reference", "original", "what"], rows)


KINDS = {
    "ids": ids_table,
    "phases": phases_table,
    "draws": draws_table,
    "constants": constants_table,
    "state": state_table,
    "info": info_table,
    "rewards": rewards_table,
    "options": options_table,
    "rules": rules_table,
}


def make_table(engram, kind, families):
    if kind == "rules" and not families:
        families = list(engram.families)
    if kind not in KINDS or not families or not set(families) <= set(engram.families):
        raise TableError(
            f"no table '{' '.join([kind, *families])}'; kinds: {', '.join(KINDS)}; "
            f"families: {', '.join(engram.families)}"
        )
    ids = Ids([engram.info(task_id) for family in families for task_id in engram.families[family]])
    further = [engram.common_outputs] if kind == "info" else []
    return KINDS[kind](ids, *further)


# --- pages ---


def renewed(engram, text):
    """The page's text with all its tables renewed, and the names of those that were stale."""
    out, stale = [], []
    lines = iter(text.splitlines(keepends=True))
    in_code = False
    for line in lines:
        out.append(line)
        in_code ^= line.startswith("```")
        mark = None if in_code else BEGIN.fullmatch(line.rstrip("\n"))
        if not mark:
            continue
        old = []
        for line in lines:
            if line.rstrip("\n") == END:
                break
            old.append(line)
        else:
            raise TableError(f"{mark[0]} has no {END}")
        new = "\n" + make_table(engram, mark[1], mark[2].split()) + "\n"
        if "".join(old) != new:
            stale.append(mark[1] + mark[2])
        out += [new, line]
    return "".join(out), stale


def main(given, prog):
    parser = argparse.ArgumentParser(
        prog=prog,
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--engram",
        metavar="FILE",
        default=ROOT / "build/release/engram",
        type=pathlib.Path,
        help="the command (default: build/release/engram)",
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="change nothing; fail, naming them, if tables are stale",
    )
    parser.add_argument(
        "pages", metavar="PAGE", nargs="*", type=pathlib.Path, help="default: all of docs/"
    )
    arguments = parser.parse_args(given)
    try:
        renew(arguments.engram, arguments.pages, arguments.check)
    except TableError as error:
        sys.exit(f"{prog}: {error}")


def renew(command, pages, check):
    """Renews the tables of pages, or fails if one is stale; no pages: all."""
    engram = Engram(command)
    stale_pages = 0
    for page in [page.resolve() for page in pages] or sorted(DOCS.rglob("*.md")):
        name = os.path.relpath(page, ROOT)
        try:
            text = page.read_text()
            new_text, stale = renewed(engram, text)
        except OSError as error:
            raise TableError(f"{name}: {error.strerror}") from error
        except TableError as error:
            raise TableError(f"{name}: {error}") from error
        if stale:
            stale_pages += 1
            print(f"{name}: {'stale' if check else 'renewed'}: {', '.join(stale)}")
            if not check:
                page.write_text(new_text)
    if check and stale_pages:
        raise TableError(
            f"renew with: tools/docs.py tables --engram {os.path.relpath(command, ROOT)}"
        )
