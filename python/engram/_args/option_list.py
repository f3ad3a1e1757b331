"""Keywords of a batch, and the numbers of names in the extension."""

from __future__ import annotations

# begin generated: lists (tools/surface, from api/surface.toml)
OBS_MODE = {
    "none": 0,
    "state": 1,
    "state_dict": 2,
    "rgb": 3,
    "objects": 4,
    "objects_dict": 5,
    "rgb+depth": 6,
    "rgb+segmentation": 7,
    "rgb+depth+segmentation": 8,
    "rgb+state": 9,
    "rgb+depth+state": 10,
    "rgb+segmentation+state": 11,
    "rgb+depth+segmentation+state": 12,
    "rgb+objects": 13,
    "rgb+depth+objects": 14,
    "rgb+segmentation+objects": 15,
    "rgb+depth+segmentation+objects": 16,
}
REWARD_MODE = {"none": 0, "sparse": 1, "dense": 2, "normalized_dense": 3}
AUTO_RESET = {"next-step": 0, "same-step": 1, "off": 2}
AFTER_END = {"hold": 0, "continue": 1, "refuse": 2}
POLICY = {"zero": 0, "random": 1, "oracle": 2, "blind": 3, "sweep": 4}
RULES = {"reference": 0, "original": 1}
PHYSICS = {"engram": 0, "mujoco": 1}
CAMERAS = ("base_camera", "hand_camera", "render_camera")
IMAGE_SIDE = (1, 4096)  # pixels

# Conversion of each keyword: by type, or by the numbers of its names.
KINDS: dict[str, str | dict[str, int]] = {
    "num_envs": "int",
    "seed": "seed",
    "threads": "int",
    "chunk": "int",
    "obs_mode": OBS_MODE,
    "observe_time": "bool",
    "joint_proprio": "bool",
    "reward_mode": REWARD_MODE,
    "control_mode": "maybe_text",
    "rotation_sign": "int",
    "freeze_cue": "bool",
    "terminate_on_success": "maybe",
    "robot_init_qpos_noise": "real",
    "sleep": "bool",
    "lanes": "int",
    "substeps": "int",
    "rules": RULES,
    "renderer": "text",
    "shadows": "bool",
    "antialias": "bool",
    "render_shadows": "bool",
    "terminate_on_failure": "bool",
    "physics": PHYSICS,
}
# end generated

# Options of an evaluation: by keyword, name in the extension and conversion.
# begin generated: evaluation
EVALUATION: dict[str, tuple[str, str | dict[str, int]]] = {
    "episodes": ("episodes", "int"),
    "num_envs": ("num_envs", "int"),
    "threads": ("threads", "int"),
    "obs": ("obs_mode", OBS_MODE),
    "seed": ("seed", "seed_value"),
    "name": ("name", "text"),
    "renderer": ("renderer", "text"),
    "output": ("output", "path"),
    "resume": ("resume", "path"),
    "rules": ("rules", RULES),
    "tell_episodes": ("tell_episodes", "bool"),
    "seed_file": ("seed_file", "path"),
    "repeat": ("repeat", "int"),
    "policy_seed": ("policy_seed", "seed_value"),
    "latency": ("latency", "latency"),
    "control_mode": ("control_mode", "maybe_text"),
    "joint_proprio": ("joint_proprio", "bool"),
    "choices_stride": ("choices_stride", "int"),
    "physics": ("physics", PHYSICS),
    "shard": ("shard", "path"),
}
# end generated
