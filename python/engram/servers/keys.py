"""Presets of keys: under which names a server gets images, state and instruction."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from typing import Any

from engram.errors import InvalidArgumentError
from engram.servers.conventions import ACTIONS, LAYOUTS, known


@dataclasses.dataclass(frozen=True)
class Keys:
    """Names of what is sent; None: not sent.

    base, wrist: images of the two cameras.
    state: parts of the state, [start, stop) of its numbers by name.
    row: the numbers of ``obs="objects"`` or ``"state"``, if those are observed.
    prompt: the instruction.
    actions: parts of the answer, in the order of an action's numbers.
    layout, convention: names in conventions.py.
    size: height and width of images; None as they are.
    extra: sent as it is, such as {"unnorm_key": "bridge_orig"}.
    flat: GR00T N1.5's names "video.x", "state.x" and "action.x", without a batch and a reset.
    """

    base: str | None = "observation/image"
    wrist: str | None = "observation/wrist_image"
    state: Mapping[str, tuple[int, int]] = dataclasses.field(default_factory=dict)
    row: str | None = "observation/objects"
    prompt: str = "prompt"
    actions: tuple[str, ...] = ("actions",)
    layout: str = "tcp7"
    convention: str = "mikasa"
    size: tuple[int, int] | None = None
    extra: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    flat: bool = False

    @property
    def needs_joints(self) -> bool:
        return self.layout == "joints8"


_XYZ = ("x", "y", "z", "roll", "pitch", "yaw", "gripper")
_SLICES = {name: (i, i + 1) for i, name in enumerate(_XYZ)}
_224 = (224, 224)

_OPENPI = {
    "mikasa": Keys(state={"observation/state": (0, 7)}),
    "libero": Keys(
        state={"observation/state": (0, 8)}, layout="libero8", convention="libero", size=_224
    ),
    "droid": Keys(
        base="observation/exterior_image_1_left",
        wrist="observation/wrist_image_left",
        state={"observation/joint_position": (0, 7), "observation/gripper_position": (7, 8)},
        layout="joints8",
        size=_224,
    ),
}
_GR00T = {
    "mikasa": Keys("image", "wrist_image", {"state": (0, 7)}, "objects", "task", ("action",)),
    "libero": Keys(
        "image",
        "wrist_image",
        {**_SLICES, "gripper": (6, 8)},
        "objects",
        "annotation.human.action.task_description",
        _XYZ,
        "libero8",  # GR00T's client of LIBERO sends the rotation vector under these names
        "libero",
        (256, 256),
    ),
    "droid": Keys(
        "exterior_image_1_left",
        "wrist_image_left",
        {"joint_position": (0, 7), "gripper_position": (7, 8)},
        "objects",
        "annotation.language.language_instruction",
        ("joint_position", "gripper_position"),
        "joints8",
        size=(180, 320),
    ),
}
for _name in ("mikasa", "libero"):
    _GR00T["n1.5" if _name == "mikasa" else f"n1.5-{_name}"] = dataclasses.replace(
        _GR00T[_name], prompt="annotation.human.action.task_description", flat=True
    )
_OFT = Keys(
    "full_image",
    "wrist_image",
    {"state": (0, 8)},
    None,
    "instruction",
    layout="libero8",
    convention="libero",
    size=(256, 256),
)
_ACT = {
    "mikasa": Keys("image", "wrist_image", {"state": (0, 7)}, "objects", "instruction"),
    "openvla": Keys("image", None, {}, None, "instruction", convention="oxe", size=_224),
    "oft": _OFT,
    "libero": dataclasses.replace(_OFT, size=_224),
}
_VLA_EVAL = {
    "mikasa": Keys("base_camera", "hand_camera", {"state": (0, 7)}, "objects", "task_description"),
    "libero": Keys(
        "agentview",
        "wrist",
        {"states": (0, 8)},
        None,
        "task_description",
        layout="libero8",
        convention="libero",
        size=(256, 256),
    ),
}
PRESETS: dict[str, dict[str, Keys]] = {
    "openpi": _OPENPI,
    "gr00t": _GR00T,
    "act": _ACT,
    "vla-eval": _VLA_EVAL,
}


def keys_of(protocol: str, name: str) -> Keys:
    """A preset by name, or the keys of a JSON file."""
    presets = PRESETS[protocol]
    if name in presets:
        return presets[name]
    if not name.endswith(".json"):
        raise InvalidArgumentError(
            f"keys: {name!r} given; {', '.join(presets)} or a FILE.json allowed for {protocol}"
        )
    try:
        with open(name, encoding="utf-8") as file:
            given = json.load(file)
    except (OSError, ValueError) as error:
        raise InvalidArgumentError(f"keys: {name!r}: {error}") from None
    if not isinstance(given, dict):
        raise InvalidArgumentError(f"keys: {name!r}: {given!r:.60} given, an object needed")
    base = str(given.pop("preset", "mikasa"))
    if base not in presets:
        raise InvalidArgumentError(
            f"keys: {name!r}: preset {base!r} given, {', '.join(presets)} allowed for {protocol}"
        )
    values = {field: _checked(name, field, value) for field, value in given.items()}
    return dataclasses.replace(presets[base], **values)


def _checked(file: str, field: str, value: Any) -> Any:
    """A value of a file."""

    def need(what: str) -> InvalidArgumentError:
        return InvalidArgumentError(f"keys: {file!r}: {field}: {value!r:.60} given, {what} needed")

    def is_pair(item: Any) -> bool:
        return isinstance(item, list) and len(item) == 2 and all(type(i) is int for i in item)

    if field in ("base", "wrist", "row", "prompt"):
        if not (isinstance(value, str) or (value is None and field != "prompt")):
            raise need("a name")
        return value
    if field in ("layout", "convention"):
        return known(f"keys: {file!r}: {field}", value, LAYOUTS if field == "layout" else ACTIONS)
    if field == "state":
        if not isinstance(value, dict) or not all(map(is_pair, value.values())):
            raise need('{"name": [start, stop], ...}')
        return {name: tuple(pair) for name, pair in value.items()}
    if field == "actions":
        if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
            raise need("a list of names")
        return tuple(value)
    if field == "size":
        if value is not None and not (is_pair(value) and min(value) >= 8 and max(value) <= 4096):
            raise need("[height, width] or null")
        return None if value is None else tuple(value)
    if field == "flat":
        if type(value) is not bool:
            raise need("true or false")
        return value
    if field == "extra":
        if not isinstance(value, dict):
            raise need("an object")
        return value
    allowed = ", ".join(f.name for f in dataclasses.fields(Keys))
    raise InvalidArgumentError(f"keys: {file!r}: {field!r} given; preset, {allowed} allowed")
