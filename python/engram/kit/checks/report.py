"""Findings of a check, and their report as text and JSON."""

from __future__ import annotations

import dataclasses
from typing import Any, Literal

Verdict = Literal["ok", "note", "wrong"]


@dataclasses.dataclass(frozen=True)
class Finding:
    """One sentence about one task.

    Attributes:
        id: Task.
        check: Kind of check: "runs", "episodes", "snapshots", "draws", "constants", "scripts",
            "leaks", "speed", or "load".
        verdict: "wrong": to be changed; "note": worth knowing; "ok".
        sentence: What was found, and what to change.
        figures: Numbers behind it, by name.
    """

    id: str
    check: str
    verdict: Verdict
    sentence: str
    figures: dict[str, Any] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass
class Report:
    """What ``engram.kit.check`` has found."""

    findings: list[Finding] = dataclasses.field(default_factory=list)
    seconds: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return not self.wrong

    @property
    def wrong(self) -> list[Finding]:
        """What has to be changed."""
        return [one for one in self.findings if one.verdict == "wrong"]

    def document(self) -> dict[str, Any]:
        """The report as ``engram check --json`` prints it."""
        ids = dict.fromkeys(one.id for one in self.findings)
        tasks = []
        for id in ids:
            found = [one for one in self.findings if one.id == id]
            listed = [
                {key: value for key, value in dataclasses.asdict(one).items() if key != "id"}
                for one in found
            ]
            tasks.append({"id": id, "ok": all(one.verdict != "wrong" for one in found),
                          "findings": listed})  # fmt: skip
        return {"ok": self.ok, "seconds": round(self.seconds, 2), "tasks": tasks}

    def __str__(self) -> str:
        lines = []
        for id in dict.fromkeys(one.id for one in self.findings):
            lines.append(id)
            for one in self.findings:
                if one.id == id:
                    lines.append(f"  {one.verdict:<5}  {one.check}: {one.sentence}")
        count = len(self.wrong)
        wrong = "nothing wrong" if count == 0 else f"{count} wrong"
        return "\n".join([*lines, f"{wrong}, {self.seconds:.0f} s"])
