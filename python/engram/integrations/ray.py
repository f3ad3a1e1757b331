"""engram on a cluster of Ray: batches in actors, and evaluations by many of them."""

from __future__ import annotations

import shutil
import tempfile
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import ray

import engram
from engram._args.values import integer
from engram.errors import InvalidArgumentError, UnavailableError

JOURNAL = "episodes.journal"
# Options of engram.evaluate that mean one process, or that this module sets.
OWN_PROCESS = ("resume", "seed_file", "progress", "shard")


@ray.remote
class BatchActor:
    """A batch in a process of its own, on a machine of the cluster.

    Its arrays are copied once, into Ray's object store; ``ray.get`` on the same machine shows them
    there, read-only. Actions of ``ray.put`` are read there, too::

        actor = BatchActor.options(num_cpus=8).remote(id, 256, seed=(run, 3), threads=8)
        obs, info = ray.get(actor.reset.remote())
        obs, reward, terminated, truncated, info = ray.get(actor.step.remote(actions))

    Args:
        id: Task, such as "RememberColor3-VLA-v0".
        num_envs: Number of environments.
        **options: Those of ``engram.make_vec``, except copy. Actors with different pairs
            ``seed=(base, worker)`` play different episodes.
    """

    def __init__(self, id: str, num_envs: int = 1, **options: Any) -> None:
        if "copy" in options:
            raise InvalidArgumentError("copy: given; results of actors are always copies")
        self._id = id
        self._batch: Any = engram.make_vec(id, num_envs, copy=False, **options)

    def reset(self, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, Any]:
        """Starts new episodes: observations and infos."""
        return self._batch.reset(seed=seed, options=options)

    def step(self, actions: np.ndarray) -> tuple[Any, Any, Any, Any, Any]:
        """Steps all environments: observations, rewards, terminated, truncated, infos."""
        return self._batch.step(actions)

    def act(self, policy: Any = "oracle") -> np.ndarray:
        """Actions of one of engram's own policies."""
        return self._batch.act(policy)

    def snapshot(self) -> bytes:
        """All environments, for ``restore`` of any actor or batch of that task and size."""
        return self._batch.save()

    def restore(self, data: bytes) -> tuple[Any, Any]:
        """Goes on from a snapshot: observations and infos."""
        return self._batch.restore(data)

    def evaluate(self, policy: Any, **options: Any) -> dict[str, Any]:
        """``engram.evaluate`` in the actor's task; the batch does not change."""
        return engram.evaluate(policy, self._id, **options)

    def seed(self) -> int:
        """The batch's seed, which was drawn if none was given."""
        return self._batch.seed


def evaluate(
    policy: Callable[[dict[str, Any]], Any] | type | str | None = None,
    ids: Any = None,
    *,
    num_actors: int,
    num_cpus: int = 1,
    num_gpus: float = 0,
    retries: int = 3,
    output: Any = None,
    **options: Any,
) -> dict[str, Any]:
    """``engram.evaluate`` by actors, each of which plays a shard; the result has its bytes.

    Args:
        policy: As for ``engram.evaluate``; each actor has a copy. Or a class, which each actor
            makes an object of, without arguments.
        ids: Tasks, unless the options have a suite.
        num_actors: Number of actors, which is that of shards.
        num_cpus: Cores of an actor; the default of ``threads``.
        num_gpus: Accelerators of an actor, for the policy.
        retries: How often an actor that has died is started again. Where it finds its folder, it
            plays what is missing.
        output: Results go to ``<output>/<split>/<date_time>/``. After an interruption, the same
            call plays what is missing of the shards, which are in this folder until all are
            finished. Machines need not share it.
        **options: Those of ``engram.evaluate``, except resume, seed_file, progress and shard.

    Raises:
        UnavailableError: An actor has died too often.
    """
    count = integer("num_actors", num_actors, 1)
    for name in OWN_PROCESS:
        if name in options:
            raise InvalidArgumentError(f"{name}: given; an evaluation by actors has none")
    options.setdefault("threads", num_cpus)
    keep = output is not None
    folder = Path(output if keep else Path(tempfile.gettempdir(), f"engram-{uuid.uuid4().hex}"))
    folder = folder.absolute()
    actor_class: Any = _ShardActor
    actor_options = {
        "num_cpus": num_cpus,
        "num_gpus": num_gpus,
        "max_restarts": retries,
        "max_task_retries": retries,
    }
    shared = ray.put(policy)
    actors = [actor_class.options(**actor_options).remote() for _ in range(count)]
    shards = [folder / f"shard-{number}-of-{count}" for number in range(1, count + 1)]
    try:
        plays = {
            actor.play.remote(shared, str(folder), f"{number}/{count}", ids, options, keep): (
                actor,
                shard,
            )
            for number, (actor, shard) in enumerate(zip(actors, shards), 1)
        }
        while plays:
            (done,), _ = ray.wait(list(plays), num_returns=1)
            actor, shard = plays.pop(done)
            _keep_journal(shard, ray.get(done))
            ray.kill(actor)  # its cores are free for those that wait
        result = engram.merge(folder, folder)
        for shard in shards:
            shutil.rmtree(shard)
        return result
    except ray.exceptions.RayActorError as error:
        again = f"; the same call with output={output!r} goes on" if keep else ""
        raise UnavailableError(
            f"an actor has died {retries + 1} times, {retries} retries allowed{again}"
        ) from error
    finally:
        for actor in actors:
            ray.kill(actor)
        if not keep:
            shutil.rmtree(folder, ignore_errors=True)


@ray.remote
class _ShardActor:
    """A process that plays a shard."""

    def play(
        self, policy: Any, folder: str, shard: str, ids: Any, options: dict[str, Any], keep: bool
    ) -> bytes:
        """Plays what is missing of the shard, and returns its journal. keep: leaves it there."""
        act = policy() if isinstance(policy, type) else policy
        played = engram.evaluate(act, ids, output=folder, shard=shard, **options)
        journal = Path(played["out"], JOURNAL).read_bytes()
        if not keep:
            shutil.rmtree(played["out"])
        return journal


def _keep_journal(shard: Path, journal: bytes) -> None:
    """Writes the journal of a shard that another machine has played."""
    file = shard / JOURNAL
    if not file.exists():
        shard.mkdir(parents=True, exist_ok=True)
        file.write_bytes(journal)
