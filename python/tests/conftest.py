"""Shared fixtures and helpers."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from browser_page import browser, opened  # noqa: F401 (fixtures)
from demonstrations import demonstrations, folder  # noqa: F401 (fixtures)
from released import wheel  # noqa: F401 (a fixture)

import engram

if TYPE_CHECKING:
    from play_server import Server

TASK = "RememberColor3-VLA-v0"  # 25 steps; never ends before
ENDING_TASK = "ShellGameTouch-VLA-v0"  # ends at success

CLIENTS = (
    "gymnasium", "numpy", "torch", "jax", "stable-baselines3", "sb3-contrib", "torchrl", "skrl",
    "vla-eval", "lerobot", "tensorflow-datasets", "pyarrow", "av", "tianshou", "ray", "popgym",
)  # fmt: skip


def pytest_report_header() -> str:
    """Versions of the installed clients."""
    found = {d.metadata["Name"].replace("_", "-"): d.version for d in _distributions()}
    return "clients: " + ", ".join(f"{name} {found[name]}" for name in CLIENTS if name in found)


def _distributions() -> Any:
    return (d for d in importlib.metadata.distributions() if d.metadata["Name"])


def pytest_addoption(parser: pytest.Parser) -> None:
    """--may-skip: reasons for which a complete run may skip tests."""
    parser.addoption(
        "--may-skip",
        metavar="WORDS",
        help="fail if a test is skipped for a reason without these words; 'nothing' forbids all",
    )


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fails a run with other skipped tests."""
    words = session.config.getoption("--may-skip")
    reporter: Any = session.config.pluginmanager.get_plugin("terminalreporter")
    if words is None or reporter is None:
        return
    reasons = {report.longrepr[2] for report in reporter.stats.get("skipped", [])}
    wrong = sorted(reason for reason in reasons if words not in reason)
    if wrong:
        session.exitstatus = session.exitstatus or pytest.ExitCode.TESTS_FAILED
        reporter.write_line(f"\nskipped, but may not be: {'; '.join(wrong)}", red=True)


def registered_ids() -> list[str]:
    """The ids of tests/data/registry.csv."""
    table = Path(__file__).parents[2] / "tests" / "data" / "registry.csv"
    return [line.split(";")[0] for line in table.read_text().splitlines()[1:]]


@pytest.fixture
def make():
    """engram.make_vec with few threads; closes what it made."""
    made: list[engram.VectorEnv] = []

    def make_vec(id: str = TASK, num_envs: int = 4, **options: Any) -> engram.VectorEnv:
        options.setdefault("threads", 2)
        env = engram.make_vec(id, num_envs, **options)
        made.append(env)
        return env

    yield make_vec
    for env in made:
        env.close()


def assert_same(first: Any, second: Any, where: str = "") -> None:
    """Nested dicts of arrays and scalars are equal, values and types."""
    if isinstance(first, dict):
        assert isinstance(second, dict), where
        assert list(first) == list(second), where
        for key in first:
            assert_same(first[key], second[key], f"{where}.{key}")
    elif not isinstance(first, np.ndarray):
        assert first == second, where
    else:
        assert first.dtype == second.dtype, where
        assert first.shape == second.shape, where
        np.testing.assert_array_equal(first, second, err_msg=where)


def noisy_oracle(env: engram.VectorEnv, rng: np.random.Generator) -> np.ndarray:
    """The oracle with noise in the rotations, so that environments differ but still succeed."""
    actions = env.act("oracle")
    actions[:, 3:6] += rng.normal(0, 0.02, (env.num_envs, 3)).astype(np.float32)
    return actions


@pytest.fixture(scope="module")
def server(tmp_path_factory) -> Iterator[Server]:
    """`engram play`, one for all tests of a file; tabs come and go."""
    from play_server import serving  # needs libraries that not all environments have

    with serving(tmp_path_factory.mktemp("play") / "played") as running:
        yield running
