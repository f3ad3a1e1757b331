"""Frequencies of the hidden answers on the canonical seeds: random_draws.csv."""

import collections
import math

from measurements.common import write_csv

COLORS = 9  # of the families with coloured cubes
EPISODES = 50
COLUMNS = ["id", "hidden", "candidates", "episodes", "most_frequent", "limit", "chi2", "dof", "p"]


def tail(chi, freedom):
    """Probability of at least this chi-squared (Wilson and Hilferty's approximation)."""
    spread = 2 / (9 * freedom)
    return 0.5 * math.erfc(((chi / freedom) ** (1 / 3) - 1 + spread) / math.sqrt(2 * spread))


def limit(numbers, members, episodes):
    """Occurrences of the most frequent number that luck exceeds in one of a hundred tasks."""
    share = members / numbers
    above = 0.0
    for hits in range(episodes, -1, -1):
        above += math.comb(episodes, hits) * share**hits * (1 - share) ** (episodes - hits)
        if above * numbers > 0.01:
            return hits + 1
    return 0


def hidden_numbers(name, task, about):
    """How many numbers there are to choose from, and a list of those of every episode.

    None where answers are not equally likely, or too many for the episodes. Episodes of coloured
    cubes hide a set, others one number.
    """
    pairs = zip(task["first_answers"] or [], task["first_answers_correct"] or [])
    answers = [answer for answer, right in pairs if right]
    if "OfColors" in name:  # a digit per touch, 1 + the colour
        return COLORS, [[int(digit) for digit in str(answer)] for answer in answers]
    candidates = about["candidates"]
    equal = abs((about["answer_chance"] or 0) * candidates - 1) < 1e-9
    if not answers or not equal or not 2 <= candidates <= EPISODES:
        return None
    return candidates, [[answer] for answer in answers]


def chi_squared(numbers, episodes):
    """Chance of memberships; the usual one where an episode hides one number."""
    members = len(episodes[0])
    counts = collections.Counter(number for episode in episodes for number in episode)
    expected = len(episodes) * members / numbers
    squares = sum((count - expected) ** 2 for count in counts.values())
    squares += (numbers - len(counts)) * expected**2
    return squares / (expected * (1 - members / numbers)) * (numbers - 1) / numbers, counts


def write(canonical, info):
    rows = []
    for name, task in canonical.items():
        hidden = hidden_numbers(name, task, info[name])
        if hidden is None:
            continue
        numbers, episodes = hidden
        members = len(episodes[0])
        chi, counts = chi_squared(numbers, episodes)
        row = [name, members, numbers, len(episodes), max(counts.values())]
        row += [limit(numbers, members, len(episodes)), f"{chi:.2f}", numbers - 1]
        rows.append([*row, f"{tail(chi, numbers - 1):.3f}"])
    write_csv("random_draws.csv", COLUMNS, rows)
