"""Ray RLlib, as released: the example that plays engram's batches in its workers."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("ray")

EXAMPLE = Path(__file__).resolve().parents[3] / "learners/src/engram_learners/rllib_workers.py"


@pytest.mark.parametrize("workers", [1, 2])
def test_rllib_workers_play(workers):
    command = [sys.executable, EXAMPLE, "--iterations=2", "--envs=4", "--episodes=8"]
    done = subprocess.run(
        [*command, f"--workers={workers}"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "RAY_raylet_start_wait_time_s": "300"},  # for busy machines
    )
    assert done.returncode == 0, done.stderr[-3000:]
    played = [line.split()[:2] for line in done.stdout.splitlines() if "per second" in line]
    assert played == [["1:", "200"], ["2:", "200"]]
