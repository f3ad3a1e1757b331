"""In which phase of its task an episode is, picture by picture, for plots.

Descriptions tell phases in words, and lengths are drawn anew in every episode. What can be seen of
the scene, and what infos say, tells where one phase ends and the next begins.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from engram.play.setting import Setting

_STILL = 1e-4  # of positions, in half metres
_NONE = -1  # no phase
_PAUSE = 3  # steps without a motion after which a shuffle is over


class PhaseTrack:
    """Follows an episode; `track` has the number of a phase per picture, None if unknown."""

    def __init__(self, setting: Setting, description: Any) -> None:
        self.track: list[int | None] = []
        self._setting = setting
        names = tuple(phase["name"] for phase in description["phases"])
        outputs = {output["name"] for output in description["outputs"]}
        rules = _RULES.get(names)
        self._rule = None
        if rules is not None and rules[0] <= outputs:
            self._rule = rules[1]
        self._scene = _Scene(setting) if self._rule is None and names in _SEEN else None
        self._follow = _SEEN.get(names)
        self._phase = 0
        self._known = len(names) == 1 or self._rule is not None or self._scene is not None

    def begin(self, info: Mapping[str, Any]) -> None:
        """Takes in the first picture's infos."""
        if self._scene is not None:
            self._scene.begin(self._setting)
        self._add(info)

    def step(self, info: Mapping[str, Any], action: Any) -> None:
        """Takes in a step: its action, and the infos after it."""
        if self._scene is not None:
            self._scene.step(action)
        self._add(info)

    def close(self) -> None:
        if self._scene is not None:
            self._scene.close()

    def _add(self, info: Mapping[str, Any]) -> None:
        if self._rule is not None:
            self._phase = self._rule(info, self._phase)
        elif self._scene is not None and self._follow is not None:
            self._phase = self._follow(self._scene, self._phase)
        self.track.append(self._phase if self._known and self._phase != _NONE else None)


class _Scene:
    """The same episode once more, observed as objects."""

    def __init__(self, setting: Setting) -> None:
        self._env = setting.batch(obs_mode="objects_dict")
        fields = self._env.description["state_fields"]
        names = next(f["names"] for f in fields if f["name"] == "object_0_kind")
        self._kinds = [names.index(kind) for kind in ("object", "ball")]
        self._cup = names.index("cup")
        self.still = 0  # steps in which no cup has moved

    def begin(self, setting: Setting) -> None:
        self._observation, _ = setting.reset(self._env)
        self._cups = self._places()

    def step(self, action: Any) -> None:
        self._observation, *_ = self._env.step(action)
        cups = self._places()
        same = cups.shape == self._cups.shape
        moved = not same or np.abs(cups - self._cups).max(initial=0) > _STILL
        self.still = 0 if moved else self.still + 1
        self._cups = cups

    @property
    def shown(self) -> bool:
        """Whether anything but furniture can be seen: what to remember, or what to act on."""
        objects = self._observation["objects"]
        seen = objects["seen"][0, :, 0] > 0
        return bool((seen & (objects["kind"][0][:, self._kinds] > 0).any(1)).any())

    def _places(self) -> Any:
        objects = self._observation["objects"]
        cups = objects["position"][0][objects["kind"][0][:, self._cup] > 0]
        return np.sort(cups.reshape(-1, 3), axis=0)

    def close(self) -> None:
        self._env.close()


# --- what can be seen ---


def _cue_gap_action(scene: _Scene, phase: int) -> int:
    return max(phase, 0 if scene.shown and not phase else 1 if not scene.shown else 2)


def _cue_action(scene: _Scene, phase: int) -> int:
    return 1 if phase or not scene.shown else 0


def _cue_shuffle_action(scene: _Scene, phase: int) -> int:
    if phase == 0:
        return 0 if scene.shown else 1
    return 2 if phase == 2 or scene.still >= _PAUSE else 1


_SEEN: dict[tuple[str, ...], Callable[[_Scene, int], int]] = {
    ("cue", "empty", "manipulation"): _cue_gap_action,
    ("cue", "empty", "action"): _cue_gap_action,
    ("cue", "manipulation"): _cue_action,
    ("cue", "shuffle", "manipulation"): _cue_shuffle_action,
}


# --- what infos say ---


def _is(info: Mapping[str, Any], name: str) -> bool:
    return bool(info[name][0])


def _traced(info: Mapping[str, Any], _phase: int) -> int:
    return 2 if _is(info, "action_mask") else 1 if _is(info, "demo_mask") else 0


def _blinked(info: Mapping[str, Any], phase: int) -> int:
    return 1 if phase or _is(info, "phase_ready") else 0


def _tested(info: Mapping[str, Any], _phase: int) -> int:
    return int(info["action_stage"][0])


def _there_and_back(info: Mapping[str, Any], _phase: int) -> int:
    return 1 if _is(info, "goal_reached_status") else 0


def _gathered(info: Mapping[str, Any], _phase: int) -> int:
    return 1 if _is(info, "flash_active") else 2 if _is(info, "all_on_disc") else 0


def _timed(info: Mapping[str, Any], phase: int) -> int:
    if _is(info, "past_window"):
        return _NONE
    return 2 if _is(info, "in_window") else 1 if phase or _is(info, "signal_on") else 0


_Rule = tuple[set[str], Callable[[Mapping[str, Any], int], int]]
_RULES: dict[tuple[str, ...], _Rule] = {
    ("pre-demo", "demo", "action"): ({"action_mask", "demo_mask"}, _traced),
    ("cue", "action"): ({"phase_ready"}, _blinked),
    ("insert", "return", "confirm"): ({"action_stage"}, _tested),
    ("there", "back"): ({"goal_reached_status"}, _there_and_back),
    ("wait", "count", "window"): ({"signal_on", "in_window", "past_window"}, _timed),
    ("move", "flash", "press"): ({"flash_active", "all_on_disc"}, _gathered),
}
