"""Types for checkers and editors: keywords, observations, descriptions.

from engram.typing import RgbObservation

env: engram.VectorEnv[RgbObservation] = engram.make_vec(id, 256, obs_mode="rgb")
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from gymnasium.vector import AutoresetMode

__all__ = [
    "ActionSpace",
    "BatchOptions",
    "Choices",
    "Constant",
    "Draw",
    "Drawn",
    "EnvOptions",
    "Field",
    "ObjectsDict",
    "Observation",
    "Option",
    "Output",
    "Phase",
    "Prop",
    "Quantity",
    "RgbObservation",
    "Row",
    "RowMode",
    "StateDict",
    "TaskDescription",
    "TaskSummary",
]

# begin generated: types (tools/surface, from api/surface.toml)
ObsMode = Literal[
    "none",
    "state",
    "state_dict",
    "rgb",
    "objects",
    "objects_dict",
    "rgb+depth",
    "rgb+segmentation",
    "rgb+depth+segmentation",
    "rgb+state",
    "rgb+depth+state",
    "rgb+segmentation+state",
    "rgb+depth+segmentation+state",
    "rgb+objects",
    "rgb+depth+objects",
    "rgb+segmentation+objects",
    "rgb+depth+segmentation+objects",
]
RewardMode = Literal["none", "sparse", "dense", "normalized_dense"]
AfterEnd = Literal["hold", "continue", "refuse"]
Policy = Literal["zero", "random", "oracle", "blind", "sweep"]
Rules = Literal["reference", "original"]
Physics = Literal["engram", "mujoco"]
ControlMode = Literal[
    "pd_joint_delta_pos",
    "pd_joint_pos",
    "pd_ee_delta_pos",
    "pd_ee_delta_pose",
    "pd_ee_pose",
    "pd_joint_target_delta_pos",
    "pd_ee_target_delta_pos",
    "pd_ee_target_delta_pose",
    "pd_joint_vel",
    "pd_joint_pos_vel",
    "pd_joint_delta_pos_vel",
]
Renderer = Literal["cpu", "egl"]
Camera = Literal["base_camera", "hand_camera", "render_camera"]
AutoresetName = Literal[
    "NEXT_STEP",
    "SAME_STEP",
    "DISABLED",
    "NextStep",
    "SameStep",
    "Disabled",
    "next-step",
    "same-step",
    "off",
]
RenderMode = Literal["rgb_array", "human"]


class EnvOptions(TypedDict, total=False):
    """Keywords of environments, single or in batches, but for obs_mode."""

    seed: int | tuple[int, int] | None
    threads: int
    reward_mode: RewardMode
    control_mode: ControlMode | None
    pins: Mapping[str, float | Sequence[float]] | None
    task_options: Mapping[str, float] | None
    constants: Mapping[str, Any] | None
    render_mode: RenderMode | None
    render_size: int | tuple[int, int]
    render_camera: Camera
    image_size: int | tuple[int, int]
    cameras: Sequence[Camera] | None
    renderer: Renderer
    shadows: bool
    antialias: bool
    terminate_on_success: bool | None
    rotation_sign: int
    freeze_cue: bool
    robot_init_qpos_noise: float
    substeps: int
    sleep: bool
    chunk: int
    lanes: int
    language_in_info: bool
    max_episode_steps: int | None
    observe_time: bool
    rules: Rules
    render_shadows: bool
    joint_proprio: bool
    terminate_on_failure: bool
    after_end: AfterEnd
    perturb: Mapping[str, float] | None
    physics: Physics
    privileged: bool


class BatchOptions(EnvOptions, total=False):
    """Keywords of batches too, but for obs_mode."""

    autoreset_mode: AutoresetMode | AutoresetName | None
    copy: bool
    out: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None


# end generated


class AnyBatchOptions(BatchOptions, total=False):
    """Keywords of batches."""

    obs_mode: ObsMode


# --- observations: of one environment, or with a first dimension for all of a batch ---

Row = NDArray[np.float32]  # (state_dim,): obs_mode "state", "objects" or "none"
RowMode = Literal["state", "objects", "none"]


class _Rgb(TypedDict):
    rgb: NDArray[np.uint8]  # (height, width, 3 per camera)
    proprio: Row  # (7,)


class RgbObservation(_Rgb, total=False):
    """Observation in obs_mode "rgb"."""

    task_cue: Row  # (1,), Rotate families only


class RgbDepthObservation(RgbObservation):
    """Observation in obs_mode "rgb+depth"."""

    depth: NDArray[np.int16]  # (height, width, cameras) mm along the camera's axis; 0: nothing


class RgbSegmentationObservation(RgbObservation):
    """Observation in obs_mode "rgb+segmentation"."""

    segmentation: NDArray[np.int16]  # (height, width, cameras) index into segmentation_names


class RgbDepthSegmentationObservation(RgbDepthObservation):
    """Observation in obs_mode "rgb+depth+segmentation"."""

    segmentation: NDArray[np.int16]  # (height, width, cameras) index into segmentation_names


class StateDict(TypedDict):
    """Observation in obs_mode "state_dict"."""

    agent: dict[str, Row]
    extra: dict[str, Row]


class ObjectsDict(TypedDict):
    """Observation in obs_mode "objects_dict"."""

    agent: dict[str, Row]
    objects: dict[str, Row]  # (tokens, width) each


Observation = Row | RgbObservation | StateDict | ObjectsDict

# --- descriptions ---


class TaskSummary(TypedDict):
    """Entry of ``engram.list()``."""

    id: str
    family: str
    split: str  # "short", "medium", "long", "extended", "rl"
    memory_type: str
    horizon: int  # control steps
    canonical: bool
    instruction: str
    action_dim: int
    state_dim: int
    candidates: int  # answers that a guess chooses from


class Quantity(TypedDict):
    """Name, unit and description."""

    name: str
    unit: str
    description: str


class Draw(Quantity):
    """Random variable of an episode; ``pins`` fix it."""

    width: int
    integer: bool
    low: float
    high: float


class Drawn(Quantity):
    """Value that ``drawn`` returns."""

    width: int
    integer: bool


class Option(Quantity):
    """One of ``task_options``."""

    default: float
    original: float
    value: float
    integer: bool
    low: float
    high: float


class _Constant(Quantity):
    value: Any
    kind: str
    low: float | None
    high: float | None


class Constant(_Constant, total=False):
    """One of ``constants``."""

    names: list[str]


class _Field(Quantity):
    offset: int
    width: int


class Field(_Field, total=False):
    """A part of a row: of the state, of objects or of proprio."""

    low: float  # of objects
    high: float
    names: list[str]  # of its values, where just one of them is 1


class Output(Quantity):
    """Output of a step, in observations or infos."""

    dtype: str
    width: int
    privileged: bool  # reveals the hidden quantity, or the robot's distance to it


class ActionSpace(TypedDict):
    """Actions of a control mode."""

    dim: int
    low: list[float | None]
    high: list[float | None]
    normalized: bool


class Phase(TypedDict):
    """Part of an episode, and its condition."""

    name: str
    when: str


class Prop(TypedDict):
    """Object on the table."""

    name: str
    motion: str
    mass: float
    bounding_radius: float


class Choices(TypedDict):
    """Answers that a policy may name (docs/choices.md)."""

    question: str
    choices: list[str] | None  # None: they are of an episode
    least: int
    most: int
    repeats: bool
    questions: int
    chance: float


class TaskDescription(TaskSummary):
    """Result of ``engram.describe(id)``."""

    chance: float
    answer: str | None
    answer_chance: float | None
    ceilings: dict[str, dict[str, float | None]]  # of oracle, sweep and blind
    termination: str
    frozen_cue: bool
    control_mode: str
    action_spaces: dict[str, ActionSpace]
    draws: list[Draw]
    drawn: list[Drawn]
    hidden: str  # the draw that an agent has to remember; "": none
    rules: str
    options: list[Option]
    changeable: list[Constant]
    changed: dict[str, Any]
    paraphrases: list[str]  # other wordings of the instruction
    warnings: list[str]  # of constants that have no effect under these rules
    choices: Choices | None
    phases: list[Phase]
    state_fields: list[Field]
    proprio: list[Field]
    segmentation_names: list[str]  # by value, of obs_modes with segmentation; else empty
    task_cue_dim: int
    oracle_dim: int
    outputs: list[Output]
    success_reward: float
    reward_terms: list[str]
    props: list[Prop]
    constants: dict[str, Any]
