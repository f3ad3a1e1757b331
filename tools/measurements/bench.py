"""All benchmarks of `engram bench`: bench/RESULTS.md."""

from measurements.common import ROOT, run_json
from measurements.common import run as output_of

PAGE = ROOT / "bench" / "RESULTS.md"
SUITES = (
    "overhead",
    "overhead --num-envs 1",
    "physics",
    "physics --policy oracle",
    "scaling",
    "memory",
    "objects",
    "reset",
    "create",
    "render",
)


def add_options(parser):
    parser.add_argument("--rounds", type=int, default=20, help="of each suite; default: 20")


def block(text):
    return ["```", text.rstrip(), "```"]


def budget_table(rows):
    """A line per task and observation, from rows budget.ID.OBS.PART."""
    whole, shares = {}, {}
    for row in rows:
        _, task, obs, part = row["name"].split(".")
        whole.setdefault((task, obs), row["baseline_value"])
        shares.setdefault((task, obs), {})[part] = row["ratio"]
    parts = list(next(iter(shares.values())))
    lines = ["| task | observation | us |" + "".join(f" {part} |" for part in parts)]
    lines.append("| --- | --- | ---: |" + " ---: |" * len(parts))
    for (task, obs), own in shares.items():
        cells = "".join(f" {100 * own[part]:.1f} |" for part in parts)
        lines.append(f"| {task} | {obs} | {whole[task, obs]:.4g} |{cells}")
    return lines


def run(options):
    rounds = ["--rounds", options.rounds]
    lines = [
        "# Results",
        "",
        f"Written by `tools/measure.py bench --rounds {options.rounds}`. Each suite runs",
        "interleaved with its baseline in one process; values are medians over the rounds, ratios",
        "are medians of the rounds' ratios.",
        "",
        *block(output_of([options.engram, "doctor"])),
    ]
    for suite in SUITES:
        table = output_of([options.engram, "bench", *suite.split(), *rounds])
        lines += ["", f"`engram bench {suite}`", "", *block(table)]
    for policy in ("random", "oracle"):
        words = [options.engram, "bench", "budget", "--policy", policy, *rounds]
        lines += [
            "",
            f"`engram bench budget --policy {policy}`: us per environment step and thread, and",
            "which percentage of it goes where. `outside` is everything but dynamics and render.",
            "",
            *budget_table(run_json(words)),
        ]
    PAGE.write_text("\n".join(lines) + "\n")
