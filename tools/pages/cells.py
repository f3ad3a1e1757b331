"""Cells of the tables in docs/: texts of values, and labels of the ids that share one."""

import functools
import re

SUFFIX = "-VLA-v0"
KINDS = ("Long", "v0")  # endings of tags: long episodes, RL ids
RANKS = {"Easy": 0, "Slow": 0, "Medium": 1, "Hard": 2, "Fast": 2}


def in_reading_order(task_id):
    """Easy before hard, 3 before 12, short before long."""
    difficulty = next((rank for word, rank in RANKS.items() if word in task_id), 0)
    numbers = [int(number) for number in re.findall(r"\d+", task_id.removesuffix(SUFFIX))]
    return "-Long" in task_id, difficulty, numbers, task_id


def number(value):
    return str(value) if isinstance(value, int) else f"{value:.6g}"


def code(text):
    return f"`{text}`"


def text_of(value):
    """Text of a constant for a cell."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, float)):
        return number(value)
    if isinstance(value, list):
        return "[" + ", ".join(text_of(item) for item in value) + "]"
    if isinstance(value, dict):
        return "<br>".join(f"{key}: {words(item)}" for key, item in value.items())
    return str(value)


def words(value):
    """An entry of a mapping: a list with a name in front is the name, then the rest."""
    if isinstance(value, list) and value and isinstance(value[0], str):
        return " ".join(text_of(item) for item in value)
    return text_of(value)


def table(head, rows):
    """Columns that are empty in every row are left out."""
    kept = [i for i in range(len(head)) if any(row[i] for row in rows)]
    lines = [[head[i] for i in kept], ["---"] * len(kept)]
    lines += [[row[i].replace("|", r"\|") for i in kept] for row in rows]
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


class Ids:
    """Ids of one family or of several, with short labels for common and different values.

    A tag is the part of an id that distinguishes it in its family: 3, or 3-Long.
    """

    def __init__(self, infos):
        self.infos = infos
        self.names = [info["id"].removesuffix(SUFFIX) for info in infos]
        self.families = [info["family"] for info in infos]
        self.tags = [
            name.removeprefix(family).removeprefix("-") or name
            for name, family in zip(self.names, self.families)
        ]

    def groups(self, values, shorten=True):
        """Labels of the ids with the same value, and the value; no label: all, or all but Long."""
        by_tag = dict(zip(self.tags, values))
        by_family = dict(zip(self.families, values))
        whole_families = len(by_family) > 1 and self.spread(by_family, self.families) == values
        if not whole_families and self.spread(by_tag, self.tags) == values:
            tags, label = self.tags, functools.partial(label_of, tags=list(by_tag))
        else:
            tags, label = self.names, self.label_of_names
        groups = {}
        for tag, value in zip(tags, values):
            groups.setdefault(value, {})[tag] = True
        labels = {value: label(list(group)) for value, group in groups.items()}
        longest = max(labels, key=lambda value: labels[value].count(","))
        if shorten and len(by_family) > 1 and labels[longest].count(",") >= 2:
            several_long = "" in labels.values()  # the other ids have the value without a label
            labels.pop(longest)
            labels[longest] = "other `Long`" if several_long else "others"
        return [(label, value) for value, label in labels.items()]

    @staticmethod
    def spread(values, keys):
        return [values[key] for key in keys]

    def label_of_names(self, group):
        """Families of which all ids are in the group are called by the family's name."""
        if not label_of(group, self.names):
            return ""
        parts = []
        for family in dict.fromkeys(self.families):
            members = [name for name, other in zip(self.names, self.families) if other == family]
            mine = [name for name in group if name in members]
            if mine == members:
                parts.append(code(family))
            elif len(mine) == 1:
                parts.append(code(mine[0]))
            elif mine:
                kind = next((kind for kind in KINDS if mine == of_kind(kind, members)), None)
                labels = code(f"{family}*-{kind}") if kind else label_of(mine, members)
                parts.append(labels or ", ".join(map(code, mine)))
        return ", ".join(parts)

    def cell(self, values):
        """One text for a value per id."""
        groups = self.groups(values)
        if len(groups) == 1:
            return groups[0][1]
        groups = [(label, value) for label, value in groups if value]
        return "<br>".join(f"{label}: {value}" if label else value for label, value in groups)

    def rows(self, lists, *columns):
        """A row per name in `lists` (one list per id), a cell per function in `columns`."""
        names = merged_names(lists)
        found = [{item["name"]: item for item in items} for items in lists]
        rows = []
        for name in names:
            having = Ids([info for info, items in zip(self.infos, found) if name in items])
            items = [items[name] for items in found if name in items]
            presence = self.groups([name in items for items in found], shorten=False)
            label = next(label for label, present in presence if present)
            rows.append([code(name) + (f"<br>of {label}" if label else "")])
            rows[-1] += [having.cell([column(item) for item in items]) for column in columns]
        return rows


def merged_names(lists):
    """All names, in an order that agrees with each list."""
    names = []
    for items in lists:
        place = 0
        for item in items:
            if item["name"] in names:
                place = names.index(item["name"]) + 1
            else:
                names.insert(place, item["name"])
                place += 1
    return names


def of_kind(kind, tags):
    return [tag for tag in tags if tag.endswith(kind)]


def label_of(group, tags):
    """The shortest list of tags: X stands for X and X-Long, Long or v0 for all that are."""
    long = of_kind("Long", tags)
    if group == tags or (long and group == [tag for tag in tags if tag not in long]):
        return ""
    for kind in KINDS:
        if group == of_kind(kind, tags):
            return code(kind)
    if all(f"{tag}-Long" in group for tag in group if f"{tag}-Long" in tags):
        group = [
            tag
            for tag in group
            if not tag.endswith("-Long") or tag.removesuffix("-Long") not in group
        ]
    return ", ".join(map(code, group))
