"""A server of OpenEnv: agents are asked what an episode has shown, in words (docs/choices.md).

python -m engram.integrations.openenv ShellGameTouch-VLA-v0 --port 8000
"""

from __future__ import annotations

import argparse
import queue
import secrets
import threading
from collections.abc import Sequence
from typing import Any

import uvicorn
from openenv.core.env_server.http_server import create_fastapi_app
from openenv.core.env_server.interfaces import Environment
from openenv.core.env_server.types import Action, EnvironmentMetadata, Observation, State
from pydantic import Field

from engram import _core
from engram.errors import InvalidArgumentError
from engram.evaluation import evaluate
from engram.tasks import describe

__all__ = ["Answer", "ChoicesEnvironment", "Question", "main"]


class Answer(Action):  # type: ignore[misc]
    """What the agent names."""

    answer: list[str] = Field(description="Texts of the question's choices, in order")


class Question(Observation):  # type: ignore[misc]
    """A question, or the end of an episode; its reward is 1 after a success, else 0."""

    instruction: str = ""
    frames: list[str] = Field(default=[], description="What each step showed; equal ones left out")
    question: str = ""
    choices: list[str] = Field(default=[])
    least: int = Field(default=0, description="Texts of an answer, at least")
    most: int = Field(default=0, description="Texts of an answer, at most")
    repeats: bool = Field(default=False, description="Whether a text may be named twice")


class _AbandonedError(Exception):
    """The agent has begun another episode."""


class _Episode:
    """An evaluation of one episode, in a thread that waits for answers."""

    def __init__(self, id: str, seed: int, options: dict[str, Any]) -> None:
        self.questions: queue.Queue[Any] = queue.Queue()
        self.answers: queue.Queue[list[str] | None] = queue.Queue()
        self._run = {"ids": id, "seed": seed, "episodes": 1, "obs": "objects", **options}
        threading.Thread(target=self._play, daemon=True).start()

    def _play(self) -> None:
        try:
            self.questions.put(evaluate(choices=self._ask, threads=1, **self._run))
        except _AbandonedError:
            pass
        except Exception as error:
            self.questions.put(error)

    def _ask(self, question: dict[str, Any]) -> list[str]:
        self.questions.put(question)
        answer = self.answers.get()
        if answer is None:
            raise _AbandonedError
        return answer


class ChoicesEnvironment(Environment[Answer, Question, State]):  # type: ignore[misc]
    """Episodes of a task. Each step answers a question; a scripted hand carries the answer out.

    Args:
        id: Task with choices.
        **options: Others of ``engram.evaluate``, such as ``rules``, ``constants`` and ``perturb``.
    """

    SUPPORTS_CONCURRENT_SESSIONS = True

    def __init__(self, id: str, **options: Any) -> None:
        super().__init__()
        if describe(id)["choices"] is None:
            raise InvalidArgumentError(f"{id} given; a task with choices needed (docs/choices.md)")
        self._id, self._options = id, options
        self._episode: _Episode | None = None
        self._seen = Question(done=True)
        self._state = State()

    def reset(self, seed: int | None = None, episode_id: str | None = None, **_: Any) -> Question:
        """Begins the episode with that seed, or with one of the system."""
        self.close()
        seed = secrets.randbits(32) if seed is None else seed
        self._state = State(episode_id=episode_id or f"{self._id}-{seed}", seed=seed)
        self._episode = _Episode(self._id, seed, self._options)
        return self._next()

    def step(self, action: Answer, timeout_s: float | None = None, **_: Any) -> Question:
        """Answers the question. What is no answer to it changes nothing.

        Raises:
            InvalidArgumentError: No question is due, or the answer is not one of its choices.
        """
        if self._episode is None:
            raise InvalidArgumentError("answer given, and no question is due; reset first")
        self._check(action.answer)
        self._state.step_count += 1
        self._episode.answers.put(action.answer)
        return self._next()

    @property
    def state(self) -> State:
        """Episode, its seed, and number of answers so far."""
        return self._state

    def get_metadata(self) -> EnvironmentMetadata:
        """The task."""
        text = describe(self._id)["instruction"]
        return EnvironmentMetadata(name=self._id, description=text, version=_core.version())

    def close(self) -> None:
        """Ends the episode."""
        if self._episode is not None:
            self._episode.answers.put(None)
        self._episode = None

    def _check(self, answer: Sequence[str]) -> None:
        asked = self._seen
        fits = asked.least <= len(answer) <= asked.most and set(answer) <= set(asked.choices)
        if not fits or (not asked.repeats and len(set(answer)) < len(answer)):
            again = "which may repeat" if asked.repeats else "each once"
            raise InvalidArgumentError(
                f"answer: {list(answer)} given; {asked.least} to {asked.most} of "
                f"{asked.choices} needed, {again}"
            )

    def _next(self) -> Question:
        assert self._episode is not None
        asked = self._episode.questions.get()
        if isinstance(asked, Exception):
            self._episode = None
            raise asked
        if "tasks" in asked:
            self._episode = None
            (task,) = asked["tasks"]
            right = {"first_answer_correct": task["first_answer_correct"]}
            self._seen = Question(done=True, reward=task["sr"], metadata=right)
        else:
            frames = [f"step {step}: {text}" for step, text in zip(asked["steps"], asked["text"])]
            keys = ("instruction", "question", "choices", "least", "most", "repeats")
            self._seen = Question(frames=frames, **{key: asked[key] for key in keys})
        return self._seen


def main(arguments: Sequence[str] | None = None) -> None:
    """Serves a task until it is interrupted."""
    parser = argparse.ArgumentParser(prog="python -m engram.integrations.openenv")
    parser.add_argument("id", help="task with choices, such as ShellGameTouch-VLA-v0")
    parser.add_argument("--host", default="127.0.0.1", help="default: %(default)s")
    parser.add_argument("--port", type=int, default=8000, help="default: %(default)s")
    parser.add_argument(
        "--sessions", type=int, default=16, help="agents at a time; default: %(default)s"
    )
    given = parser.parse_args(arguments)
    ChoicesEnvironment(given.id)  # a task without choices is refused now
    app = create_fastapi_app(
        lambda: ChoicesEnvironment(given.id), Answer, Question, max_concurrent_envs=given.sessions
    )
    uvicorn.run(app, host=given.host, port=given.port, log_level="warning")


if __name__ == "__main__":
    main()
