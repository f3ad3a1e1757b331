"""State of an environment as MuJoCo has it."""

from __future__ import annotations

import dataclasses

import numpy as np


@dataclasses.dataclass(frozen=True)
class MujocoState:
    """What MuJoCo's mjData says of an environment, as read-only copies in float64.

    Names and units are MuJoCo's: m, rad, s, quaternions (w, x, y, z). Kinematic props are mocap
    bodies. Hidden props are high above the scene.

    Attributes:
        time: Seconds since the episode began.
        qpos: (nq) the robot's nine joints, then position and quaternion of each free prop.
        qvel: (nv) velocities, six of each free prop.
        act: (na) activations; there are none.
        ctrl: (nu) targets of the drives in the last step.
        xpos: (nbody, 3) positions of the bodies in the world.
        xquat: (nbody, 4) their orientations.
        mocap_pos: (nmocap, 3) positions of mocap bodies.
        mocap_quat: (nmocap, 4) their orientations.
        body_names: Of the rows of xpos and xquat.
        joint_names: Of the joints, in the order of qpos.
    """

    time: float
    qpos: np.ndarray
    qvel: np.ndarray
    act: np.ndarray
    ctrl: np.ndarray
    xpos: np.ndarray
    xquat: np.ndarray
    mocap_pos: np.ndarray
    mocap_quat: np.ndarray
    body_names: tuple[str, ...]
    joint_names: tuple[str, ...]

    def __post_init__(self) -> None:
        """Makes the arrays read-only."""
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
