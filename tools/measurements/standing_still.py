"""Dense returns of success and of standing still shortly before it, where success ends an episode.

Writes standing_still.csv. Needs an interpreter with the package.
"""

from measurements.common import write_csv

EPISODES = 20
EARLIER = (1, 8)  # steps before success in which the robot stops
COLUMNS = ["id", "success", "standing_still", "success_to_horizon"]
NEVER = 2**30


def add_options(parser):
    parser.add_argument("--ids", nargs="+", default=[], metavar="ID", help="default: all")


def play(task, stops=None, **options):
    """Returns (N,) of oracle episodes, and the steps of success; stops: when the robot stops."""
    import numpy as np

    import engram

    options = {"autoreset_mode": "DISABLED", "after_end": "hold", "threads": 1, **options}
    env = engram.make_vec(task, EPISODES, reward_mode="normalized_dense", **options)
    env.reset(seed=list(range(EPISODES)))
    total, first = np.zeros(EPISODES), np.full(EPISODES, NEVER)
    done, last = np.zeros(EPISODES, bool), np.zeros(EPISODES)
    for step in range(1, env.description["horizon"] + 1):
        actions = env.act("oracle")
        if stops is not None:
            still = step >= stops
            actions[still] = 0
            actions[still, -1] = last[still]  # the gripper stays as it was
        last = actions[:, -1].copy()
        _, reward, terminated, truncated, info = env.step(actions)
        total += np.where(done, 0, reward)
        first = np.where(info["success"].astype(bool), np.minimum(first, step), first)
        done |= terminated | truncated
    env.close()
    return total, first


def measure(task):
    import numpy as np

    success, first = play(task)
    solved = first < NEVER
    best = np.full(EPISODES, -np.inf)
    for earlier in EARLIER:
        still, again = play(task, stops=first - earlier)
        best = np.where(solved & (again == NEVER), np.maximum(best, still), best)
    held, _ = play(task, terminate_on_success=False)
    known = np.isfinite(best)
    means = (success[solved], best[known], held[solved])
    return [task, *(f"{values.mean():.1f}" if len(values) else "" for values in means)]


def run(options):
    import engram

    ids = [task["id"] for task in engram.list() if task["id"].endswith("-VLA-v0")]
    ending = [id for id in options.ids or ids if engram.describe(id)["termination"] != "never"]
    write_csv("standing_still.csv", COLUMNS, [measure(id) for id in ending])
