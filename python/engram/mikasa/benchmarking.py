"""The benchmark's protocol with a policy object: 50 seeded episodes per task, one at a time.

A policy has ``forward(obs)``, which returns an action (7,), or a chunk of them, (K, 7) or
(1, K, 7), that are used one per step; and, if it likes, ``chunk_size``. ``obs`` is what
``apply_mikasa_vla_wrappers`` makes, for one environment. The results are those of
``engram eval --rules original`` with the same policy.
"""

from __future__ import annotations

import contextlib
import csv
import json
import re
import subprocess
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from statistics import fmean
from typing import Any, Protocol

import gymnasium as gym
import numpy as np

from engram._args.methods import real_array
from engram._args.values import integer
from engram._io.files import open_folder, remove_leftovers, write_file
from engram.errors import BadStateError, InvalidArgumentError
from engram.mikasa import classes as _classes  # noqa: F401 (registers the ids)
from engram.mikasa._torch import torch
from engram.mikasa.apply_wrappers import apply_mikasa_vla_wrappers
from engram.mikasa.benchmark_ui import RichBenchmarkUI
from engram.tasks import list_tasks

__all__ = [
    "CONTROL_MODE",
    "NUM_EPISODES_PER_TASK",
    "OBS_MODE",
    "REWARD_MODE",
    "START_SEED",
    "SUPPORTED_SPLITS",
    "WRAPPER_CHAIN",
    "BenchmarkConfig",
    "BenchmarkTask",
    "ChunkPolicy",
    "EpisodeResult",
    "RichBenchmarkUI",
    "benchmark_commit",
    "default_task_csv_path",
    "evaluate_benchmark",
    "evaluate_task",
    "load_benchmark_tasks",
    "make_benchmark_env",
    "make_run_dir",
    "run_episode",
    "select_benchmark_tasks",
    "summarize_task_results",
    "write_benchmark_results",
]

START_SEED = 4242424242
NUM_EPISODES_PER_TASK = 50
OBS_MODE = "rgb"
CONTROL_MODE = "pd_ee_delta_pose"
REWARD_MODE = "normalized_dense"
WRAPPER_CHAIN = "apply_mikasa_vla_wrappers(include_overlays=False)"
SUPPORTED_SPLITS = ("short", "medium", "long", "all")
_ID = re.compile(r"[A-Za-z0-9._-]+-v[0-9]+")
_LONGEST_ID = 100
_VIDEO_RATE = 30  # images per second

JsonDict = dict[str, Any]


class ChunkPolicy(Protocol):
    """Policy interface of evaluations."""

    chunk_size: int

    def forward(self, obs: Mapping[str, Any]) -> Any:
        """One action or a chunk of them."""


@dataclass(frozen=True)
class BenchmarkTask:
    """A row of the benchmark's list."""

    env_id: str
    split: str
    memory_type: str
    max_episode_steps: int
    language_instruction: str
    data_source: str

    @classmethod
    def from_csv_row(cls, row: Mapping[str, str]) -> BenchmarkTask:
        """Makes a task from a row of a table with the original's columns."""
        return cls(
            env_id=_plain_id(row["Name"]),
            split=_split(row["Horizon Split"]),
            memory_type=row["Memory Type"],
            max_episode_steps=int(row["Max Length"]),
            language_instruction=row.get("language_instruction", ""),
            data_source=row.get("Data Source", ""),
        )


@dataclass(frozen=True)
class BenchmarkConfig:
    """Configuration of an evaluation.

    Attributes:
        sim_backend: See gym.make; engram computes on the CPU.
        include_overlays: True: images for people show the answer.
        save_videos: True: videos of all episodes, with overlays, beside the observations.
    """

    start_seed: int = START_SEED
    n_episodes: int = NUM_EPISODES_PER_TASK
    obs_mode: str = OBS_MODE
    control_mode: str = CONTROL_MODE
    reward_mode: str = REWARD_MODE
    sim_backend: str = "gpu"
    include_overlays: bool = False
    save_videos: bool = False

    def __post_init__(self) -> None:
        integer("n_episodes", self.n_episodes, 1)
        integer("start_seed", self.start_seed, 0, 2**64 - 1)


@dataclass(frozen=True)
class EpisodeResult:
    """Result of an episode."""

    success_once: bool
    episode_return: float
    n_steps: int
    seed: int


# --- tasks ---


def _split(name: str) -> str:
    split = name.strip().lower()
    if split not in SUPPORTED_SPLITS:
        raise InvalidArgumentError(f"split: {name!r} given; allowed: {', '.join(SUPPORTED_SPLITS)}")
    return split


def _plain_id(env_id: Any) -> str:
    """The id, which names neither a module to import nor a path: tables come from others."""
    if not isinstance(env_id, str) or len(env_id) > _LONGEST_ID or not _ID.fullmatch(env_id):
        raise InvalidArgumentError(
            f"env_id: {str(env_id)[:_LONGEST_ID]!r} given; letters, digits and '-_.' that end in "
            f"-v and a number needed, at most {_LONGEST_ID}"
        )
    return env_id


def default_task_csv_path() -> Path | None:
    """None: without a table, tasks are those of engram's own list."""
    return None


def load_benchmark_tasks(csv_path: str | Path | None = None) -> list[BenchmarkTask]:
    """The benchmark's 90 tasks, or those of a table with the original's columns."""
    if csv_path is not None:
        with Path(csv_path).open(newline="", encoding="utf-8") as file:
            rows = csv.DictReader(file, delimiter=";")
            return [BenchmarkTask.from_csv_row(row) for row in rows]
    return [
        BenchmarkTask(
            env_id=task["id"],
            split=task["split"],
            memory_type=task["memory_type"],
            max_episode_steps=task["horizon"],
            language_instruction=task["instruction"],
            data_source="",
        )
        for task in list_tasks()
        if task["canonical"]
    ]


def select_benchmark_tasks(
    *,
    split: str | None = None,
    env_ids: Sequence[str] | None = None,
    csv_path: str | Path | None = None,
) -> list[BenchmarkTask]:
    """Tasks of a split ("all": every one), or by id; other ids are of the split "custom"."""
    if (split is None) == (env_ids is None):
        raise InvalidArgumentError(
            f"split: {split!r} and env_ids: {env_ids!r} given; one of them is needed"
        )
    tasks = load_benchmark_tasks(csv_path)
    if env_ids is not None:
        known = {task.env_id: task for task in tasks}
        return [
            known.get(id, BenchmarkTask(id, "custom", "Unknown", 0, "", "custom")) for id in env_ids
        ]
    chosen = _split(split or "")
    return [task for task in tasks if chosen in ("all", task.split)]


# --- episodes ---


def make_benchmark_env(env_id: str, config: BenchmarkConfig) -> Any:
    """The environment of a task in the protocol."""
    env = gym.make(
        _plain_id(env_id),
        num_envs=1,
        obs_mode=config.obs_mode,
        control_mode=config.control_mode,
        reward_mode=config.reward_mode,
        render_mode="rgb_array" if config.save_videos else "all",
        sim_backend=config.sim_backend,
    )
    overlays = config.include_overlays or config.save_videos
    return apply_mikasa_vla_wrappers(env, include_overlays=overlays)


def _actions(chunk: Any, shape: tuple[int, ...]) -> Iterable[torch.Tensor]:
    """The actions of an answer, each (1, D)."""
    if isinstance(chunk, torch.Tensor):
        given = chunk
        if given.is_complex() or given.dtype == torch.bool:
            raise InvalidArgumentError(f"forward returned {given.dtype}; real numbers needed")
    else:
        given = torch.as_tensor(real_array("forward's answer", chunk))
    if given.ndim == len(shape) + 2 and given.shape[0] == 1:
        given = given[0]
    elif tuple(given.shape) == shape:
        given = given[None]
    if given.ndim != len(shape) + 1 or tuple(given.shape[1:]) != shape or not len(given):
        raise InvalidArgumentError(
            f"forward returned shape {tuple(given.shape)}; allowed: {shape}, (K, *{shape}) and "
            f"(1, K, *{shape}) with K of 1 or more"
        )
    return torch.split(given.to(device="cpu", dtype=torch.float32), 1)


def run_episode(
    env: Any, policy: ChunkPolicy, episode_seed: int, *, collect_video: bool = False
) -> tuple[EpisodeResult, list[np.ndarray] | None]:
    """One episode: its result and, optionally, images before every step and after the last."""
    observation, _ = env.reset(seed=episode_seed)
    steps = getattr(env, "max_episode_steps", None)
    if steps is None:
        raise BadStateError("env: it has no max_episode_steps; apply_mikasa_vla_wrappers gives one")
    frames: list[np.ndarray] | None = [] if collect_video else None
    queue: deque[torch.Tensor] = deque()
    success, total, taken = False, 0.0, 0
    for _ in range(int(steps)):
        if frames is not None:
            frames.append(_frame(env, observation))
        if not queue:
            queue.extend(_actions(policy.forward(observation), env.action_space.shape))
        observation, reward, terminated, truncated, info = env.step(queue.popleft())
        taken += 1
        total += float(reward[0])
        success = success or bool(info["success"][0])
        if bool(terminated[0]) or bool(truncated[0]):
            if frames is not None:
                frames.append(_frame(env, observation))
            break
    return EpisodeResult(success, total, taken, episode_seed), frames


def _frame(env: Any, observation: Mapping[str, Any]) -> np.ndarray:
    """The image for people, beside it the images of both cameras, one above the other."""
    from engram.mikasa import drawing

    general = np.asarray(env.render())[0]
    height, width = general.shape[0], general.shape[1] // 2
    if "rgb" not in observation:
        return general
    seen = observation["rgb"][0].numpy()
    sides = []
    for i, (label, rows) in enumerate((("top", height // 2), ("wrist", height - height // 2))):
        camera = seen[..., 3 * i : 3 * i + 3]
        down = np.arange(rows) * camera.shape[0] // rows
        across = np.arange(width) * camera.shape[1] // width
        image = np.ascontiguousarray(camera[down][:, across])
        drawing.put_text(image, label, (8, 22), 0.65)
        sides.append(image)
    return np.concatenate([general, np.concatenate(sides)], axis=1)


def _write_video(path: str | Path, frames: Sequence[Any], fps: float) -> None:
    """Writes an episode's images as an mp4; of none, nothing. Programs import it."""
    from engram.mikasa.record import write_video

    if len(frames) > 0:
        write_video(Path(path), frames, fps)


# --- results ---


def benchmark_commit() -> str | None:
    """The git commit of the folder that engram is in, if there is one."""
    command = ["git", "rev-parse", "HEAD"]
    folder = Path(__file__).resolve().parent
    try:
        done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return done.stdout.strip() or None


def evaluate_task(
    task: BenchmarkTask,
    policy: ChunkPolicy,
    config: BenchmarkConfig,
    *,
    model: Mapping[str, Any] | None = None,
    commit: str | None = None,
    video_dir: str | Path | None = None,
    episode_callback: Callable[[int, EpisodeResult], None] | None = None,
) -> JsonDict:
    """A task's result, as its JSON file has it."""
    chunk_size = integer("policy.chunk_size", getattr(policy, "chunk_size", 1), 1)
    env = make_benchmark_env(task.env_id, config)
    episodes: list[EpisodeResult] = []
    try:
        for i in range(config.n_episodes):
            seed = config.start_seed + i
            result, frames = run_episode(env, policy, seed, collect_video=video_dir is not None)
            episodes.append(result)
            if episode_callback is not None:
                episode_callback(i, result)
            if frames and video_dir is not None:
                _write_video(Path(video_dir) / f"episode_{i:04d}.mp4", frames, fps=_VIDEO_RATE)
    finally:
        env.close()
    successes = [episode.success_once for episode in episodes]
    returns = [episode.episode_return for episode in episodes]
    return {
        "env_id": task.env_id,
        "split": task.split.title(),
        "memory_type": task.memory_type,
        "start_seed": config.start_seed,
        "n_episodes": config.n_episodes,
        "successes": successes,
        "returns": returns,
        "sr": fmean(successes),
        "mean_return": fmean(returns),
        "benchmark_commit": commit,
        "control_mode": config.control_mode,
        "obs_mode": config.obs_mode,
        "wrapper_chain": WRAPPER_CHAIN,
        "action_chunk_size": chunk_size,
        "model": dict(model or {}),
        "episode_lengths": [episode.n_steps for episode in episodes],
        "episode_seeds": [episode.seed for episode in episodes],
    }


def summarize_task_results(task_results: Sequence[Mapping[str, Any]]) -> JsonDict:
    """The summary of several tasks' results."""
    if not task_results:
        raise InvalidArgumentError("task_results: none given; one or more are needed")
    splits = {str(result["split"]) for result in task_results}
    rates = {str(result["env_id"]): float(result["sr"]) for result in task_results}
    by_type: dict[str, list[float]] = {}
    for result in task_results:
        by_type.setdefault(str(result["memory_type"]), []).append(float(result["sr"]))
    return {
        "split": splits.pop() if len(splits) == 1 else "Custom",
        "sr_split": fmean(rates.values()),
        "sr_per_memory_type": {kind: fmean(by_type[kind]) for kind in sorted(by_type)},
        "tasks": list(rates),
        "per_task_sr": rates,
        "per_task_mean_return": {
            str(result["env_id"]): float(result["mean_return"]) for result in task_results
        },
    }


def make_run_dir(base_dir: str | Path) -> Path:
    """A new folder in this one, with date and time for a name."""
    Path(base_dir).mkdir(parents=True, exist_ok=True)
    while True:
        folder = Path(base_dir) / datetime.now().strftime("%Y-%m-%d_%H-%M-%S")
        with contextlib.suppress(FileExistsError):
            folder.mkdir()
            return folder
        time.sleep(0.1)  # another run began in this very second


def _write(folder: int, name: str, document: Mapping[str, Any]) -> None:
    write_file(folder, name, (json.dumps(document, indent=2) + "\n").encode())


def write_benchmark_results(
    output_dir: str | Path,
    task_results: Sequence[Mapping[str, Any]],
    summary: Mapping[str, Any],
) -> None:
    """Writes ENV_ID.json for each task, and summary.json: each complete, or not at all.

    Raises:
        InvalidArgumentError: An ``env_id`` is no id.
        OSError: A file cannot be written.
    """
    with open_folder(Path(output_dir)) as folder:
        _write_results(folder, task_results, summary)


def _video_folder(output_dir: Path, env_id: str) -> Path:
    """The folder of a task's videos, which is no link."""
    parts = ("videos", env_id)
    with open_folder(output_dir, *parts):
        return output_dir.joinpath(*parts)


def _write_results(
    folder: int, task_results: Sequence[Mapping[str, Any]], summary: Mapping[str, Any]
) -> None:
    names = [f"{_plain_id(result['env_id'])}.json" for result in task_results]
    for name, result in zip(names, task_results):
        _write(folder, name, result)
    _write(folder, "summary.json", summary)


def evaluate_benchmark(
    tasks: Sequence[BenchmarkTask],
    policy: ChunkPolicy,
    config: BenchmarkConfig | None = None,
    *,
    output_dir: str | Path | None = None,
    model: Mapping[str, Any] | None = None,
    progress: Callable[[str], None] | None = None,
    task_start_callback: Callable[[int, BenchmarkTask], None] | None = None,
    episode_callback: Callable[[int, EpisodeResult], None] | None = None,
    task_done_callback: Callable[[int, JsonDict], None] | None = None,
    initial_results: list[JsonDict] | None = None,
) -> tuple[list[JsonDict], JsonDict]:
    """Results of tasks and their summary; files are written after every task.

    Args:
        tasks: From ``select_benchmark_tasks``.
        policy: See the module.
        config: The configuration; None: that of the protocol.
        output_dir: Folder of the results, if there are to be files.
        model: Description of the policy in the results, {"name": ..., "config": ...} by convention.
        progress: Called with a line before every task.
        task_start_callback: Called with a task's number and the task.
        episode_callback: Called with an episode's number and its result.
        task_done_callback: Called with a task's number and its result.
        initial_results: Of an interrupted run; the summary includes them.

    Raises:
        InvalidArgumentError: No tasks, or one whose id is none.
        OSError: Another run writes to ``output_dir``.
    """
    if not tasks:
        raise InvalidArgumentError("tasks: none given; one or more are needed")
    for task in tasks:
        _plain_id(task.env_id)
    config = config or BenchmarkConfig()
    with contextlib.ExitStack() as stack:
        folder = None
        if output_dir is not None:
            folder = stack.enter_context(open_folder(Path(output_dir), lock=True))
            remove_leftovers(folder)
        commit = benchmark_commit()
        results = list(initial_results or [])
        for i, task in enumerate(tasks):
            if progress is not None:
                progress(f"[{i + 1}/{len(tasks)}] {task.env_id}  ({config.n_episodes} episodes)")
            if task_start_callback is not None:
                task_start_callback(i, task)
            videos = None
            if config.save_videos and output_dir is not None:
                videos = _video_folder(Path(output_dir), task.env_id)
            result = evaluate_task(
                task,
                policy,
                config,
                model=model,
                commit=commit,
                video_dir=videos,
                episode_callback=episode_callback,
            )
            results.append(result)
            if task_done_callback is not None:
                task_done_callback(i, result)
            if folder is not None:
                _write_results(folder, [result], summarize_task_results(results))
        return results, summarize_task_results(results)
