"""engram.compare and engram.report, and their figures against statsmodels and scipy."""

import io
import json
import math

import numpy as np
import pandas
import pytest
from scipy import stats
from statsmodels.stats import contingency_tables, multitest, proportion

import engram
from engram._io import documents

ID = "RememberColor3-VLA-v0"
SEED = 4242424242


def task(id, successes, **changes):
    """The document of a task that nobody has played."""
    count = len(successes)
    document = {
        "env_id": id,
        "split": "Short",
        "memory_type": "Object",
        "start_seed": SEED,
        "n_episodes": count,
        "successes": [bool(success) for success in successes],
        "returns": [0.5] * count,
        "sr": sum(map(bool, successes)) / count,
        "mean_return": 0.5,
        "obs_mode": "rgb",
        "model": {"name": "mine", "config": {}},
        "episode_lengths": [10] * count,
        "episode_seeds": [SEED + i for i in range(count)],
        "version": engram.__version__,
        "rules": "reference",
        "chance": 0.25,
        "first_answer_correct": None,
        "memory_score": None,
    }
    return json.loads(documents.to_text(document | changes))


def results(*tasks):
    return {"summary": {}, "tasks": list(tasks)}


def pair(table):
    """Successes of A and B with these numbers of both, only A, only B and neither."""
    a = np.repeat([1, 1, 0, 0], table)
    b = np.repeat([1, 0, 1, 0], table)
    return a, b


@pytest.fixture(scope="module")
def tables():
    random = np.random.default_rng(0)
    shares = random.dirichlet([0.6] * 4, size=1000)
    sizes = random.integers(1, 300, size=1000)
    drawn = np.array([random.multinomial(n, share) for n, share in zip(sizes, shares)])
    drawn[:8] = [
        [50, 0, 0, 0], [0, 50, 0, 0], [0, 0, 50, 0], [0, 0, 0, 50],
        [0, 25, 25, 0], [25, 0, 0, 25], [1, 0, 0, 0], [0, 1, 0, 0],
    ]  # fmt: skip
    return drawn


@pytest.fixture(scope="module")
def comparison(tables):
    """One comparison of a thousand tasks."""
    pairs = [pair(table) for table in tables]
    a = results(*(task(f"Table{i:04}", a) for i, (a, _) in enumerate(pairs)))
    b = results(*(task(f"Table{i:04}", b) for i, (_, b) in enumerate(pairs)))
    return engram.compare(a, b)


def test_counts(tables, comparison):
    for table, row in zip(tables, comparison["tasks"], strict=True):
        assert [row[key] for key in ("both", "only_a", "only_b", "neither")] == table.tolist()
        assert row["pairs"] == sum(table)
        assert row["difference"] == pytest.approx((table[1] - table[2]) / sum(table))


def test_p_values_are_those_of_statsmodels_and_scipy(tables, comparison):
    for (both, only_a, only_b, neither), row in zip(tables, comparison["tasks"]):
        expected = contingency_tables.mcnemar([[both, only_a], [only_b, neither]], exact=True)
        # Where nothing differs, statsmodels has 0 / 0.
        if only_a + only_b > 0:
            assert row["p_value"] == pytest.approx(expected.pvalue, rel=1e-10)
            exact = stats.binomtest(int(only_a), int(only_a + only_b)).pvalue
            assert row["p_value"] == pytest.approx(exact, rel=1e-10)
        else:
            assert row["p_value"] == 1
    total = comparison["total"]
    exact = stats.binomtest(total["only_a"], total["only_a"] + total["only_b"]).pvalue
    assert total["p_value"] == pytest.approx(exact, rel=1e-10)


def test_corrected_p_values_are_those_of_statsmodels(comparison):
    plain = [row["p_value"] for row in comparison["tasks"]]
    expected = multitest.multipletests(plain, method="holm")[1]
    assert [row["p_value_holm"] for row in comparison["tasks"]] == pytest.approx(expected)


def newcombe(both, only_a, only_b, neither):
    """Newcombe 1998, method 10, on the Wilson intervals of statsmodels."""
    n = both + only_a + only_b + neither
    rate_a, rate_b = (both + only_a) / n, (both + only_b) / n
    low_a, high_a = proportion.proportion_confint(both + only_a, n, method="wilson")
    low_b, high_b = proportion.proportion_confint(both + only_b, n, method="wilson")
    product = both * neither - only_a * only_b
    margins = (both + only_a) * (only_b + neither) * (both + only_b) * (only_a + neither)
    if product > 0:
        product = max(product - n / 2, 0)
    phi = product / math.sqrt(margins) if margins else 0

    def distance(x, y):
        return math.sqrt(max(x * x - 2 * phi * x * y + y * y, 0))

    difference = rate_a - rate_b
    return (
        difference - distance(rate_a - low_a, high_b - rate_b),
        difference + distance(high_a - rate_a, rate_b - low_b),
    )


def test_intervals_of_differences(tables, comparison):
    for table, row in zip(tables, comparison["tasks"]):
        assert row["difference_interval"] == pytest.approx(
            newcombe(*map(int, table)), rel=1e-9, abs=1e-12
        )


def test_intervals_of_differences_cover():
    """95 of 100 intervals contain the true difference."""
    random = np.random.default_rng(1)
    share = np.array([0.5, 0.2, 0.1, 0.2])
    drawn = random.multinomial(60, share, size=800)
    pairs = [pair(table) for table in drawn]
    rows = engram.compare(
        results(*(task(f"T{i:04}", a) for i, (a, _) in enumerate(pairs))),
        results(*(task(f"T{i:04}", b) for i, (_, b) in enumerate(pairs))),
    )["tasks"]
    inside = [low <= 0.1 <= high for low, high in (row["difference_interval"] for row in rows)]
    assert 0.93 <= np.mean(inside) <= 0.98


def test_wilson_intervals_are_those_of_statsmodels_and_scipy(tables):
    pairs = [pair(table) for table in tables]
    text = engram.report(results(*(task(f"T{i:04}", a) for i, (a, _) in enumerate(pairs))), "csv")
    rows = pandas.read_csv(io.StringIO(text))
    assert len(rows) == 1000
    for (a, _), low, high in zip(pairs, rows["sr_low"], rows["sr_high"]):
        expected = proportion.proportion_confint(a.sum(), len(a), method="wilson")
        assert (low, high) == pytest.approx(expected, abs=1e-12)
        exact = stats.binomtest(int(a.sum()), len(a)).proportion_ci(method="wilson")
        assert (low, high) == pytest.approx((exact.low, exact.high), abs=1e-12)


def test_detectable_differences_are_found_in_four_of_five_comparisons():
    random = np.random.default_rng(2)
    pairs, differing = 150, 0.3
    a, b = pair([70, 30, 15, 35])
    row = engram.compare(results(task(ID, a)), results(task(ID, b)))["total"]
    assert row["smallest_difference"] == pytest.approx(6 / pairs)
    d = row["detectable_difference"]
    drawn = random.multinomial(
        pairs, [1 - differing, (differing + d) / 2, (differing - d) / 2], size=4000
    )
    found = [stats.binomtest(int(a), int(a + b)).pvalue < 0.05 for _, a, b in drawn if a + b]
    # The exact test is somewhat weaker than the formula's.
    assert 0.72 <= np.mean(found) <= 0.86
    small = engram.compare(results(task(ID, [1] * 5)), results(task(ID, [0] * 5)))["total"]
    assert small["smallest_difference"] is None
    assert small["p_value"] == 0.0625


def test_rounds_are_flipped_together():
    """With repeats, the test is that of all sign flips of seeds."""
    random = np.random.default_rng(3)
    rounds, seeds = 3, 9
    a, b = random.random((2, rounds, seeds)) < [[[0.8]], [[0.4]]]
    more = {"repeat": rounds, "policy_seed": 0, "episode_seeds": [SEED + i for i in range(9)] * 3}
    row = engram.compare(
        results(task(ID, a.ravel(), **more)), results(task(ID, b.ravel(), **more))
    )["total"]
    differences = a.sum(axis=0) - b.sum(axis=0)
    expected = stats.permutation_test(
        (differences,), np.sum, permutation_type="samples", n_resamples=np.inf
    )
    assert row["p_value"] == pytest.approx(expected.pvalue)
    assert row["test"] == "exact sign flips of seeds"
    assert row["pairs"] == 27


def test_what_does_not_pair_is_refused():
    one = results(task(ID, [1, 0]))
    other = results(task("TakeItBack-VLA-v0", [1, 0]))
    with pytest.raises(engram.InvalidArgumentError, match="no task in common"):
        engram.compare(one, other)
    older = results(task(ID, [1, 0], version="0.1.0"))
    with pytest.raises(engram.InvalidArgumentError, match="allow version"):
        engram.compare(one, older)
    assert engram.compare(one, older, allow=["version"])["total"]["p_value"] == 1
    with pytest.raises(engram.UnknownIdError, match=r"'colour'.*ids, seeds, version"):
        engram.compare(one, one, allow=["colour"])
    with pytest.raises(engram.InvalidArgumentError, match="a list of words needed"):
        engram.compare(one, one, allow="ids")
    edited = json.loads(json.dumps(one))
    edited["tasks"][0]["successes"] = [True, True]
    with pytest.raises(engram.InvalidArgumentError, match="checksum"):
        engram.compare(one, edited)
    with pytest.raises(engram.InvalidArgumentError, match="a path needed"):
        engram.compare(one, 3)
    with pytest.raises(engram.IoError, match="does not exist"):
        engram.report("nowhere")
    with pytest.raises(engram.UnknownIdError, match="md, latex, csv, episodes, vla-eval"):
        engram.report(one, format="word")


def test_an_evaluation_can_be_compared_and_tabulated(tmp_path):
    def still(observation):
        return np.zeros((len(observation["instruction"]), 7), np.float32)

    a = engram.evaluate(still, ID, episodes=3, obs="state", output=tmp_path)
    (folder,) = (tmp_path / "short").iterdir()
    same = engram.compare(a, folder)["total"]
    assert same["same_digests"] == dict.fromkeys(same["same_digests"], 3)
    assert engram.report(folder, "csv") == (folder / "summary.csv").read_text()
    episodes = pandas.read_csv(folder / "episodes.csv")
    assert episodes["success"].tolist() == a["tasks"][0]["successes"]
    assert episodes["seed"].tolist() == [SEED, SEED + 1, SEED + 2]
    assert episodes["return"].tolist() == a["tasks"][0]["returns"]
    frame = pandas.DataFrame(a["tasks"])
    assert frame["sr"].tolist() == [0.0]


def test_an_entry_of_the_leaderboard_fits_its_schema():
    """The required keys and types of vla-evaluation-harness's leaderboard.schema.json."""
    names = ["ShellGameTouch", "InterceptMedium", *(f"RememberColor{n}" for n in (3, 5, 9))]
    whole = results(*(task(f"{name}-VLA-v0", [1, 0] * 50) for name in names))
    entry = json.loads(engram.report(whole, "vla-eval"))
    allowed = {
        "model", "display_name", "name_in_paper", "benchmark", "overall_score", "suite_scores",
        "task_scores", "reported_paper", "reported_table", "curated_by", "notes", "date_added",
        "params", "model_paper", "weight_type",
    }  # fmt: skip
    assert set(entry) <= allowed
    required = {"model", "display_name", "benchmark", "weight_type", "curated_by", "date_added"}
    assert all(isinstance(entry[key], str) for key in required)
    assert entry["weight_type"] in ("shared", "finetuned")
    assert entry["overall_score"] == 50
    assert entry["task_scores"] == dict.fromkeys(names, 50.0)
