"""All benchmarks of `engram bench`: speed.csv and speed_budget.csv."""

from measurements import common

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
COLUMNS = ["name", "value", "unit", "baseline", "baseline_value", "ratio"]


def add_options(parser):
    parser.add_argument("--rounds", type=int, default=20, help="of each suite; default: 20")


def rounded(value):
    """Four digits of a number, at least all before the point."""
    if not isinstance(value, float):
        return value
    return f"{value:.4g}" if abs(value) < 1000 else f"{value:.0f}"


def speed_rows(engram, rounds):
    for suite in SUITES:
        for row in common.run_json([engram, "bench", *suite.split(), *rounds]):
            yield [suite, *(rounded(row[column]) for column in COLUMNS)]


def budget_rows(policy, rows):
    """A row per task and observation, from rows budget.ID.OBS.PART; the first has the names."""
    whole, shares = {}, {}
    for row in rows:
        _, task, obs, part = row["name"].split(".")
        whole.setdefault((task, obs), row["baseline_value"])
        shares.setdefault((task, obs), {})[part] = row["ratio"]
    parts = list(next(iter(shares.values())))
    yield ["policy", "id", "obs", "us", *parts]
    for key, own in shares.items():
        yield [policy, *key, f"{whole[key]:.4g}", *(f"{100 * own[part]:.1f}" for part in parts)]


def run(options):
    rounds = ["--rounds", options.rounds]
    common.write_csv("speed.csv", ["suite", *COLUMNS], list(speed_rows(options.engram, rounds)))
    budget = []
    for policy in ("random", "oracle"):
        words = [options.engram, "bench", "budget", "--policy", policy, *rounds]
        head, *rows = budget_rows(policy, common.run_json(words))
        budget += rows
    common.write_csv("speed_budget.csv", head, budget)
    machine = common.run([options.engram, "doctor"]).rstrip()
    text = f"Medians over {options.rounds} rounds, on this machine:"
    common.write_section("speed", [text, "", "```", machine, "```"])
