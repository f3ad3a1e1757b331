"""Queries of a batch beside its observations: robot, cameras, drawn values, images."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from engram import _core
from engram._args import options, values
from engram.envs.mujoco_state import MujocoState
from engram.errors import InvalidArgumentError

if TYPE_CHECKING:
    from engram.typing import Camera, TaskDescription

CAMERA_MATRICES = ("extrinsic_cv", "cam2world_gl", "intrinsic_cv")


class QueryMixin:
    """Queries of ``VectorEnv``, which provides these attributes."""

    _batch: _core.Batch
    _arguments: dict[str, Any]
    _render: tuple[str, int, int]  # camera, width, height
    description: TaskDescription
    num_envs: int

    # begin generated: queries (tools/surface, from api/surface.toml)
    def words(self) -> list[dict[str, Any]]:
        """The running episodes in words, for teachers and annotated data; not for policies.

        Returns:
            A dictionary per environment: "plan", the subtasks; "subtask", the index of the present
            one; "subtasks_done"; "memory", what has been shown and has to be remembered; "object",
            the name of what is meant, or None; and "paraphrases" of the instruction, which alone
            are not privileged.

        Raises:
            BadStateError: Nothing was reset.
        """
        return [json.loads(self._batch.words(i)) for i in range(self.num_envs)]

    def robot_state(self) -> dict[str, np.ndarray]:
        """The robot, in every observation mode, as new float32 arrays.

        Returns:
            "qpos", (N, 9) in rad and m, arm joints and fingers; "qvel", (N, 9) in rad/s and m/s;
            "tcp_pose", (N, 7), position in m and quaternion (w, x, y, z), in the world.

        Raises:
            BadStateError: Nothing was reset.
        """
        return dict(zip(("qpos", "qvel", "tcp_pose"), self._batch.robot_state()))

    # end generated

    def camera_params(
        self, size: int | tuple[int, int] | None = None
    ) -> dict[str, dict[str, np.ndarray]]:
        """The cameras of rgb observations as matrices, by name, as new float32 arrays.

        Args:
            size: Size of the images in pixels: a side or (width, height); default:
                ``image_size`` of the constructor.

        Returns:
            For each camera "extrinsic_cv", (N, 3, 4) from the world to the camera (x right, y
            down, z forward); "cam2world_gl", (N, 4, 4) from the camera (x right, y up, z backward)
            to the world; "intrinsic_cv", (N, 3, 3) in pixels, where pixel (0, 0) covers 0 to 1.
            hand_camera moves with the arm.

        Raises:
            BadStateError: Nothing was reset.
        """
        given = self._arguments
        width, height = options.size_pair(given["image_size"] if size is None else size)
        return {
            camera: dict(zip(CAMERA_MATRICES, self._batch.camera_params(camera, width, height)))
            for camera in given["cameras"] or options.SENSORS
        }

    def drawn(self) -> dict[str, np.ndarray]:
        """Values drawn for the episodes, such as the lengths of their phases, as new arrays.

        For analysis, and for scripts that read them in the original benchmark: they include
        quantities that are hidden from policies. ``description["drawn"]`` explains them.

        Returns:
            Arrays by name, (N,) or (N, width), int64, or float32 where values are no whole numbers.

        Raises:
            BadStateError: Nothing was reset.
            InvalidArgumentError: The batch has several tasks.
        """
        if "tasks" in self.description:
            raise InvalidArgumentError(
                "drawn: this batch has several tasks, which draw different values; "
                "a batch of one task needed"
            )
        row: Any = self._batch.drawn()
        result: dict[str, np.ndarray] = {}
        at = 0
        for field in self.description["drawn"]:
            width = field["width"]
            part = row[:, at] if width == 1 else row[:, at : at + width]
            result[field["name"]] = part.astype(np.int64 if field["integer"] else np.float32)
            at += width
        return result

    def mujoco(self, index: int = 0) -> MujocoState:
        """MuJoCo's state of an environment as it is now, for code that is written for MuJoCo.

        Args:
            index: Index of the environment.

        Raises:
            InvalidArgumentError: The physics is not "mujoco", or there is no such environment.
            BadStateError: Nothing was reset.
        """
        return MujocoState(**self._batch.mujoco(values.integer("index", index)))

    def ask(self, index: int = 0) -> None:
        """Lets an environment's episode wait for an answer by name (docs/choices.md).

        From now on ``act("blind")`` does in this environment what the oracle does before it needs
        the answer, and then carries out what :meth:`answer` names. To be called after each reset.

        Raises:
            Error: The task has no list of answers, or nothing was reset.
        """
        self._batch.ask(values.integer("index", index))

    def question(self, index: int = 0) -> dict[str, Any]:
        """The question of an environment's episode.

        Returns:
            "due", true if the hand cannot go on without an answer; "question"; "choices", in an
            order that means nothing; "least" and "most" of an answer; and "repeats", true if one
            may be named twice.
        """
        question: dict[str, Any] = json.loads(self._batch.question(values.integer("index", index)))
        return question

    def answer(self, choices: Sequence[int], index: int = 0) -> None:
        """Answers the question that is due.

        Args:
            choices: Indices of the question's choices, in order.
            index: Index of the environment.

        Raises:
            BadStateError: No question is due.
        """
        numbers = [values.integer("choices", choice) for choice in choices]
        self._batch.answer(values.integer("index", index), numbers)

    def frame(
        self,
        index: int = 0,
        camera: Camera | None = None,
        size: int | tuple[int, int] | None = None,
    ) -> np.ndarray:
        """One environment as it is now, uint8 (height, width, 3), row 0 on top.

        Args:
            index: Index of the environment.
            camera: One of those in docs/robot.md; default: ``render_camera`` of the constructor.
            size: Side in pixels or (width, height), 1 to 4096; default: ``render_size``.
        """
        name, width, height = self._render
        if size is not None:
            width, height = options.size_pair(size)
        if camera is not None:
            name = values.text("camera", camera)
        image: Any = self._batch.render(values.integer("index", index), name, width, height)
        return image
