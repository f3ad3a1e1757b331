"""Ray, as released: batches in actors, and an evaluation of whose actors one is killed."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("ray")

import numpy as np
import ray
from conftest import TASK
from doc_blocks import groups

import engram
from engram.integrations.ray import BatchActor, evaluate

ENVS = 32
IDS = [TASK, "TakeItBack-VLA-v0"]
OPTIONS = {"episodes": 6, "obs": "state", "num_envs": 3}


def start_ray(tries: int = 5) -> None:
    """A cluster of four actors of one core each, on any machine.

    Ray's node gives its agent 15 s to start, and then ends: on busy machines that takes tries.
    """
    os.environ.update({"RAY_raylet_start_wait_time_s": "60"})
    for left in reversed(range(tries)):
        try:
            ray.init(num_cpus=4, include_dashboard=False, log_to_driver=False)
            return
        except Exception:
            ray.shutdown()
            if left == 0:
                raise


@pytest.fixture(scope="module", autouse=True)
def cluster():
    start_ray()
    this = sys.modules[__name__]
    ray.cloudpickle.register_pickle_by_value(this)  # actors cannot import it
    yield
    ray.shutdown()
    ray.cloudpickle.unregister_pickle_by_value(this)


class Wave:
    """A policy whose answers depend on the episode alone; it counts its calls."""

    def __init__(self, folder: Path | None = None, fatal_call: int = 0) -> None:
        """folder: of a file per process; fatal_call: that call of the first process is its last."""
        self.folder, self.fatal_call, self.calls = folder, fatal_call, 0

    def __call__(self, observation: dict[str, Any]) -> np.ndarray:
        self.calls += 1
        if self.folder is not None:
            self.folder.joinpath(str(os.getpid())).touch()
            if self.calls == self.fatal_call:
                self._die_once()
        angle = observation["step"][:, None] * 0.3 + np.arange(7) + observation["state"][:, :1]
        return np.sin(angle).astype(np.float32)

    def _die_once(self) -> None:
        try:
            self.folder.joinpath("killed").touch(exist_ok=False)
        except FileExistsError:
            return
        os.kill(os.getpid(), signal.SIGKILL)


def files_below(folder: Path) -> dict[str, bytes]:
    """Files of the one run in the folder, but for those with times."""
    (run,) = folder.glob("*/*")
    return {
        str(file.relative_to(run)): file.read_bytes()
        for file in run.rglob("*")
        if file.is_file() and file.name not in ("timing.json", "report.html")
    }


def test_an_evaluation_by_four_actors_one_of_them_killed(tmp_path):
    one = engram.evaluate(Wave(), IDS, output=tmp_path / "one", **OPTIONS)
    noted = tmp_path / "noted"
    noted.mkdir()
    # The first process to come so far has finished episodes, and others under way.
    policy = Wave(noted, fatal_call=60)
    many = evaluate(policy, IDS, num_actors=4, output=tmp_path / "many", **OPTIONS)
    assert many == one
    assert len(list(noted.iterdir())) == 1 + 5  # four actors, and one that took a place
    assert files_below(tmp_path / "many") == files_below(tmp_path / "one")
    assert not list((tmp_path / "many").glob("shard-*"))


def test_machines_need_no_common_folder():
    one = engram.evaluate(Wave(), TASK, **OPTIONS)
    assert evaluate(Wave, TASK, num_actors=2, **OPTIONS) == one  # a class: each makes its own


def test_actors_that_die_too_often_are_an_error(tmp_path):
    class Fatal(Wave):
        def _die_once(self) -> None:
            os.kill(os.getpid(), signal.SIGKILL)

    fatal = Fatal(tmp_path, fatal_call=1)
    with pytest.raises(engram.UnavailableError, match="1 times, 0 retries allowed; the same call"):
        evaluate(fatal, TASK, num_actors=1, retries=0, output=tmp_path / "out", **OPTIONS)
    assert evaluate(Wave(), TASK, num_actors=1, output=tmp_path / "out", **OPTIONS)["tasks"]


def test_errors_of_a_policy_come_out():
    def wrong(observation):
        raise KeyError("lost")

    with pytest.raises(KeyError, match="lost"):
        evaluate(wrong, TASK, num_actors=1, **OPTIONS)
    with pytest.raises(engram.InvalidArgumentError, match="resume: given"):
        evaluate(wrong, TASK, num_actors=2, resume="folder")
    with pytest.raises(engram.InvalidArgumentError, match="num_actors: 0 given"):
        evaluate(wrong, TASK, num_actors=0)


@pytest.fixture(scope="module")
def actors():
    made = [BatchActor.remote(TASK, ENVS, seed=(7, worker), threads=1) for worker in range(4)]
    yield made
    for actor in made:
        ray.kill(actor)


def test_four_actors_of_thirty_two_play_128_episodes(actors):
    rows = [obs for obs, _ in ray.get([actor.reset.remote() for actor in actors])]
    assert len(np.unique(np.concatenate(rows), axis=0)) == 128


def test_an_actor_steps_the_batch(actors):
    actor = actors[2]
    batch = engram.make_vec(TASK, ENVS, seed=(7, 2), threads=1)
    assert ray.get(actor.seed.remote()) == batch.seed
    ray.get(actor.reset.remote(seed=5))
    batch.reset(seed=5)
    actions = np.zeros((ENVS, 7), np.float32)
    kept = ray.put(actions)
    for _ in range(3):
        assert_equal(ray.get(actor.step.remote(kept)), batch.step(actions))
    snapshot = ray.get(actor.snapshot.remote())
    assert snapshot == batch.save()
    oracle = ray.get(actor.act.remote())
    np.testing.assert_array_equal(oracle, batch.act("oracle"))
    after = ray.get(actor.step.remote(oracle))
    ray.get(actors[3].restore.remote(snapshot))
    assert_equal(ray.get(actors[3].step.remote(oracle)), after)
    result = ray.get(actor.evaluate.remote(Wave(), **OPTIONS))
    assert result == engram.evaluate(Wave(), TASK, **OPTIONS)
    assert ray.get(actor.snapshot.remote()) == ray.get(actors[3].snapshot.remote())


def test_the_block_of_its_page_runs(tmp_path, monkeypatch):
    monkeypatch.setenv("RAY_ADDRESS", ray.get_runtime_context().gcs_address)
    blocks = [b for group in groups() for b in group if b.elsewhere == "engram.integrations.ray"]
    assert len(blocks) == 1
    assert blocks[0].run(tmp_path).splitlines()[-1] == "0.0"


def assert_equal(first: Any, second: Any) -> None:
    for one, other in zip(first[:4], second[:4], strict=True):
        np.testing.assert_array_equal(one, other)


def test_images_are_read_where_ray_keeps_them():
    actor = BatchActor.remote(TASK, 4, obs_mode="rgb", seed=1, threads=1)
    obs, _ = ray.get(actor.reset.remote())
    rgb = obs["rgb"]
    assert rgb.shape == (4, 128, 128, 6)
    assert not rgb.flags.owndata  # Ray's memory, shared between processes
    assert not rgb.flags.writeable
    before = rgb.copy()
    ray.get(actor.step.remote(np.ones((4, 7), np.float32)))
    np.testing.assert_array_equal(rgb, before)
    ray.kill(actor)
