r"""Evaluation of a trained policy by the benchmark's protocol, beside chance, sweep and oracle.

    python -m engram_learners.evaluate runs/color3/agent.pt
    python -m engram_learners.evaluate runs/color3/agent.pt --json
    python -m engram_learners.evaluate runs/ten/agent.pt           # each of its tasks
    python -m engram_learners.evaluate runs/short/agent.pt --id ShellGamePush-VLA-v0 \
        --instruction "Push that cup."

50 episodes with the benchmark's seeds. Chance is the rate of guessing; the sweep tries one answer
after the other without memory of the cue; the oracle uses privileged state.
"""

import argparse
import json
from pathlib import Path

import engram
from engram_learners.env_options import of_evaluation
from engram_learners.inference import load_runner
from engram_learners.training import perturbation

FIGURES = ("success_once", "first_answer_correct")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("agent", type=Path, help="agent.pt of a learner's --out")
    add("--id", help="another task than that of its training")
    add("--tasks", type=Path, help="file of tasks of your own, if it is one of those")
    add("--instruction", help="in place of the task's, for a policy that reads it")
    add("--wiped", action="store_true", help="the memory is reset, as serve.py --wiped does")
    add("--episodes", type=int, default=50)
    add("--perturb", nargs="+", default=[], type=perturbation, metavar="AXIS=LEVEL")
    add("--seed", type=int, default=4242424242, help="of the first episode")
    add("--json", action="store_true", help="in place of the table, a line of JSON for each task")
    add("--out", type=Path, help="folder for engram's own results")
    return parser.parse_args()


def evaluate(runner, task, episodes, seed, out=None, perturb=None):
    """Rates of a policy, and those of chance, sweep and oracle."""
    options = of_evaluation(runner.options)
    results = engram.evaluate(
        runner,
        task,
        obs=runner.obs,
        episodes=episodes,
        seed=seed,
        threads=1,
        num_envs=50,
        output=out,
        perturb=perturb,
        **options,
    )
    one, known = results["tasks"][0], engram.describe(task, **options)
    others = known["ceilings"] or {}  # measured for engram's own tasks, not for variants
    unknown = dict.fromkeys(FIGURES)
    return {
        "id": task,
        "obs": runner.obs,
        **({"wiped": True} if runner.forget else {}),
        **({"options": runner.options} if runner.options else {}),
        "episodes": episodes,
        "seed": seed,
        "policy": dict(zip(FIGURES, (one["sr"], one["first_answer_correct"]))),
        "chance": dict(zip(FIGURES, (known["chance"], known["answer_chance"]))),
        "sweep": others.get("sweep", unknown),
        "oracle": others.get("oracle", unknown),
    }


def table(figures):
    lines = ["{id} from {obs}, {episodes} episodes from seed {seed}".format(**figures)]
    lines.append(" " * 8 + "".join(f"{figure:>22}" for figure in FIGURES))
    for name in ("policy", "chance", "sweep", "oracle"):
        rates = (figures[name][figure] for figure in FIGURES)
        cells = ("-" if rate is None else f"{rate:.2f}" for rate in rates)
        lines.append(f"{name:8}" + "".join(f"{cell:>22}" for cell in cells))
    return "\n".join(lines)


def main():
    args = arguments()
    if args.tasks is not None:
        engram.load_tasks(args.tasks)
    runner = load_runner(args.agent, args.wiped)
    if args.instruction is not None:
        if not runner.reads:
            raise SystemExit("evaluate.py: --instruction: this policy reads none")
        runner.instruction = args.instruction
    tasks = args.id or runner.task
    for task in [tasks] if isinstance(tasks, str) else tasks:
        figures = evaluate(runner, task, args.episodes, args.seed, args.out, dict(args.perturb))
        print(json.dumps(figures) if args.json else table(figures), flush=True)


if __name__ == "__main__":
    main()
