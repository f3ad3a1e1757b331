"""``Task``: the class of which users derive tasks of their own."""

from __future__ import annotations

import json
import types
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engram._args import values
from engram.errors import BadStateError, InvalidArgumentError
from engram.kit.buttons import Buttons
from engram.kit.columns import ENGINE_NAMES, Column, Rows, engine_columns
from engram.kit.constants import changed_values, constants_of
from engram.kit.declarations import Declarations, Declared
from engram.kit.motion import Motion
from engram.kit.phases import Phases
from engram.kit.scene import HIDDEN_HEIGHT, Scene

# In the order of the engine's numbers.
METHODS = (
    "reset", "before_physics", "advance", "evaluate", "reward", "observe", "oracle", "blind",
    "sweep",
)  # fmt: skip
_OPTIONAL = ("before_physics", "oracle", "blind", "sweep")
_TERMINATIONS = ("never", "success", "success_or_failed")
# Attributes of the base class alone.
_OWN = frozenset({
    "_calls", "_current", "_declared", "_resting_height", "_reward", "_sealed", "_spare",
    "_starts", "_state", "_upright", "_whole",
})  # fmt: skip


class Task(Declarations, Scene, Buttons, Motion, Phases):
    """Base class of tasks that are written in Python.

    Class attributes declare constants (``kit.Integer``, ...) and facts; ``build`` declares scene,
    draws and memory; the other methods work on many environments at once::

        class TouchRed(engram.Task):
            success_reward = 3.0

            def build(self):
                self.cube = self.add_prop(kit.Cube("cube", color="red"))
                self.draw_places("spot", 1, (-0.1, -0.2), (0.1, 0.2), least_distance=0,
                                 text="where the cube is")

            def reset(self):
                self.place(self.cube, self.spot[:, 0])

            def evaluate(self):
                near = self.tcp_distance(self.pos_of(self.cube)) < 0.05
                self.success[:] = near & self.robot_is_static()

            def reward(self):
                away = self.tcp_distance(self.pos_of(self.cube))
                return np.where(self.success, 3.0, 1 - kit.tanh(10 * away))

            def oracle(self):
                self.touch(self.pos_of(self.cube) + (0, 0, 0.03))

        engram.register_task(TouchRed, "TouchRed-v0", 30, "Touch the red cube.")

    **Arrays.** While a method runs, all columns are attributes: NumPy arrays with one row for each
    of the ``n`` environments concerned: all of the batch, or some. Methods write in
    place (``self.success[:] = ...``) or through helpers (``place``, ``hide``, ``give_answer``).
    Those of draws and of the engine's measurements are read-only. What differs between
    environments or steps has to be in columns (``remember``): then resets, snapshots and any
    number of environments work. Other attributes cannot change after ``build``.

    ==================== ============= ======== =============================================
    attribute            shape         type     what
    ==================== ============= ======== =============================================
    n                                  int      environments
    rows                 (n,)          int64    0, ..., n - 1, for indices
    elapsed              (n,)          int32    control steps since the episode began
    seed, episode        (n,)          uint64   of the episode
    qpos, qvel           (n, 9)        float64  seven joints, two fingers; rad, m, and per s
    tcp_pos              (n, 3)        float64  m
    tcp_quat             (n, 4)        float64  w, x, y, z
    action               (n, D)        float32  of this step, as the robot got it
    previous_action      (n, D)        float32  of the step before; zeros at first
    finger_force         (n, P, 2, 3)  float64  of a prop on each finger, N
    prop_pos             (n, P, 3)     float64  m; may be written
    prop_quat            (n, P, 4)     float64  w, x, y, z; may be written
    prop_qvel            (n, P, 6)     float64  m/s in the world, rad/s in the body; may be written
    prop_status          (n, P)        uint8    0 hidden, 1 at rest, 2 moving; may be written
    prop_rgba            (n, P, 4)     float32  colour, if its opacity is not 0; may be written
    prop_emission        (n, P)        float32  emitted light; may be written
    moved                (n, P)        uint8    set 1 where a pose was written; helpers do
    covered              (n,)          uint64   bits of props that something stands over
    success, failed      (n,)          bool     written by ``evaluate``
    oracle_info          (n,), (n, K)  int32    written by ``evaluate``, if oracle_dim > 0
    cue_end              (n,)          int32    written by ``reset``: from this step on nothing
                                                shows the answer
    freeze_steps         (n,)          int32    written by ``reset``: actions before it are zeros
    answered             (n,)          bool     ``give_answer`` writes it and the two below,
    first_answer         (n,)          int32    if ``answer`` is not empty
    first_answer_correct (n,)          bool
    choice               (n, K)        int32    numbers in ``choices`` that a caller has named,
                                                -1: none; ``guess_choice`` reads it
    actions              (n, 7)        float32  written by ``oracle``, ``blind`` and ``sweep``
    ==================== ============= ======== =============================================

    **Order.** An episode begins with reset, advance (elapsed is 0), evaluate, observe. A step
    calls before_physics, moves robot and props, then calls advance, evaluate, observe, reward.

    Attributes:
        id: The registered id.
        horizon: Control steps of an episode.
    """

    # --- facts, to be set by the class or in build ---

    memory_type: str = "Object"
    termination: str = "never"  # or "success", "success_or_failed"
    success_reward: float = 1.0  # of a step with success; normalised rewards are divided by it
    frozen_cue: bool = False  # actions are zeros before freeze_steps
    candidates: int = 1  # equally likely answers
    guess_rate: float = 0.0  # success rate of guessing; 0: 1 / candidates
    answer: str = ""  # what the robot's answer is; empty: there is no such moment
    answer_rate: float = 0.0  # rate of right first answers of guessing; 0: 1 / candidates
    hidden: str = ""  # the draw that has to be remembered
    question: str = ""  # what a caller is asked who names an answer (docs/choices.md)
    choices: Sequence[str] = ()  # the texts of answers; () and "": there is no list
    choice_count: int = 1  # of them that an answer consists of, all different
    oracle_dim: int = 0  # width of oracle_info
    phases: Sequence[tuple[str, str]] = ()  # names and conditions; add_phases writes them
    table_ends: bool = False  # props fall off the table's edges
    time_to_act: int = 1  # control steps that the last of add_phases needs

    id: str
    horizon: int
    seed: NDArray[np.uint64]
    covered: NDArray[np.uint64]
    qpos: NDArray[np.float64]
    failed: NDArray[np.bool_]
    oracle_info: NDArray[np.int32]

    # --- to be written by users ---

    def build(self) -> None:
        """Declares scene, draws, memory, infos, state fields; sets facts. Called once."""

    def reset(self) -> None:
        """Begins episodes. Draws are sampled, memory and infos are zero, props are hidden."""

    def before_physics(self) -> None:
        """Moves kinematic props before a step; elapsed is still that of the step before."""

    def advance(self) -> None:
        """Brings the scene to the phase of elapsed: places, hides and paints props."""

    def evaluate(self) -> None:
        """Writes success, and failed, infos and answers, from the state; moves no prop."""
        raise self._missing("evaluate")

    def reward(self) -> NDArray[Any]:
        """The dense reward of this step: (n,)."""
        raise self._missing("reward")

    def observe(self) -> Mapping[str, Any]:
        """The values of state fields by name: (n,), or (n, width)."""
        return {}

    def oracle(self) -> NDArray[Any] | None:
        """Actions of a script that knows what is hidden: writes ``actions`` or returns them."""
        raise self._missing("oracle")

    def blind(self) -> NDArray[Any] | None:
        """Actions of a script that guesses what is hidden (``guess``)."""
        raise self._missing("blind")

    def sweep(self) -> NDArray[Any] | None:
        """Actions of a script without memory that tries everything (``tour``)."""
        raise self._missing("sweep")

    def _missing(self, name: str) -> BadStateError:
        return BadStateError(f"{type(self).__name__} has no method {name}()")

    # --- classes and instances ---

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        for name in vars(cls):
            if name in ENGINE_NAMES:
                raise InvalidArgumentError(
                    f"class {cls.__name__}: {name} is a column of the engine; another name"
                )
            if name in ("__init__", "__setattr__", "__getattr__"):
                raise InvalidArgumentError(
                    f"class {cls.__name__}: {name} given; build() declares what a task has"
                )
            if name in METHODS or name == "build" or name.startswith("__"):
                continue
            if callable(getattr(Task, name, None)):
                raise InvalidArgumentError(
                    f"class {cls.__name__}: {name} is a method of engram.Task; another name"
                )

    def __init__(self, id: str, horizon: int, constants: Mapping[str, Any]) -> None:
        """The engine makes instances; ``engram.register_task`` makes one to check the class."""
        held = self.__dict__
        held.update(id=id, horizon=horizon, _declared=Declared())
        held.update(changed_values(type(self), constants))
        build: Callable[[], Any] = self.build
        if build() is not None:
            raise InvalidArgumentError("build: returned a value; declarations are calls")
        self._find_starts()
        self._declare_caps()
        props = self._declared.props
        held["_upright"] = np.array([one.upright for one in props]).reshape(len(props), 4)
        heights = [one.resting_height for one in props]
        held["_resting_height"] = np.array([np.nan if h is None else h for h in heights], float)
        for name, value in held.items():
            if name not in _OWN:
                held[name] = _frozen(value)
        held["_sealed"] = True

    def __setattr__(self, name: str, value: Any) -> None:
        held = self.__dict__
        if "_sealed" not in held:
            self._check_attribute(name)
            held[name] = value
        elif held.get(name) is not value:  # self.count += 1 sets what it changed in place
            raise self._refusal(name)

    def _check_attribute(self, name: str) -> None:
        cls = type(self).__name__
        if name in _OWN:
            raise InvalidArgumentError(f"self.{name} = ...: {name} belongs to engram.Task")
        if name in self._declared.columns or name in ENGINE_NAMES:
            raise InvalidArgumentError(f"self.{name} = ...: {name} is a column; another name")
        if name in constants_of(type(self)):
            raise InvalidArgumentError(
                f"self.{name} = ...: {name} is a constant of {cls}, for users to change"
            )
        if callable(getattr(type(self), name, None)):
            raise InvalidArgumentError(f"self.{name} = ...: {name} is a method of {cls}")

    def _refusal(self, name: str) -> BadStateError:
        if name in self._declared.columns or name in ENGINE_NAMES:
            return BadStateError(
                f"self.{name} = ... would replace the array; self.{name}[:] = ... writes into it"
            )
        return BadStateError(
            f"self.{name} = ... after build(): attributes are the same for all environments and "
            f'steps; self.remember("{name}", ...) in build() declares a column, which is kept '
            "for every environment"
        )

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...
    else:

        def __getattr__(self, name):
            declared = self.__dict__.get("_declared")
            if declared is not None and (name in declared.columns or name in ENGINE_NAMES):
                raise BadStateError(
                    f"self.{name}: arrays exist only while the engine calls methods"
                )
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    # --- for the engine ---

    def describe(self) -> str:
        """The task as JSON: facts, scene, draws, columns."""
        declared = self._declared
        return json.dumps(
            {
                **self._facts(),
                "phases": self._conditions() or [list(phase) for phase in self.phases],
                "props": [prop.definition() for prop in declared.props],
                "draws": declared.draws,
                "memory": declared.memory,
                "infos": declared.infos,
                "state_fields": declared.state_fields,
                "methods": [name for name in _OPTIONAL if self._has(name)],
                **({"words": declared.words} if declared.words else {}),
                **({"choices": self._choices()} if self.choices or self.question else {}),
            }
        )

    def bind(self, all: Mapping[str, NDArray[Any]], some: Mapping[str, NDArray[Any]]) -> None:  # noqa: A002
        """Takes the columns of a batch and the spare rows for parts of it."""
        declared = self._declared
        width = sum(field["width"] for field in declared.state_fields)
        engine = engine_columns(
            len(declared.props),
            all["action"].shape[1],
            self.oracle_dim,
            bool(self.answer),
            self.choice_count if self.choices else 0,
        )
        columns = {name: (name, column) for name, column in engine.items()}
        columns.update(declared.columns)
        columns["_reward"] = ("reward", Column(writable=True))
        if width:
            columns["_state"] = ("state", Column((width,), writable=True))
        whole = Rows(all, columns)
        self.__dict__.update(
            _whole=whole.first(whole.count),
            _spare=Rows(some, columns),
            _current=None,
            _calls=[self._caller(name) for name in METHODS],
        )

    def call(self, method: int, rows: int, of_all: bool) -> None:
        """One method for the whole batch, or for the first `rows` of the spare rows."""
        held = self.__dict__
        current = -1 if of_all else rows
        if held["_current"] != current:
            held.update(held["_whole"] if of_all else held["_spare"].first(rows))
            held["_current"] = current
        held["_calls"][method]()

    def _caller(self, name: str) -> Callable[[], None]:
        own = {"reward": self._call_reward, "observe": self._call_observe}
        if name in own:
            return own[name]
        method = getattr(self, name)
        if name in ("oracle", "blind", "sweep"):
            return lambda: self._call_script(name, method)
        return lambda: self._call_plain(name, method)

    def _call_plain(self, name: str, method: Callable[[], Any]) -> None:
        if name == "reset":
            self.prop_pos[:] = (0.0, 0.0, HIDDEN_HEIGHT)
            self.prop_quat[:] = (1.0, 0.0, 0.0, 0.0)
            self._reset_phases()
            if self._declared.words:
                self.meant[:] = -1
        if method() is not None:
            raise InvalidArgumentError(f"{name}: returned a value; it writes into columns")
        if name == "advance":
            self._sink_caps()

    def _call_reward(self) -> None:
        _store("reward", self._reward, self.reward())

    def _call_script(self, name: str, method: Callable[[], Any]) -> None:
        self.actions[:] = 0
        returned = method()
        if returned is not None and returned is not self.actions:
            _store(name, self.actions, returned)

    def _call_observe(self) -> None:
        given = dict(self.observe())
        begin = 0
        for field in self._declared.state_fields:
            name, width = field["name"], field["width"]
            if name not in given:
                raise InvalidArgumentError(f"observe: state field {name!r} missing")
            out = self._state[:, begin : begin + width]
            _store(f"observe: {name}", out[:, 0] if width == 1 else out, given.pop(name))
            begin += width
        if given:
            raise InvalidArgumentError(
                f"observe: {', '.join(given)} given; build() declares no such state field"
            )

    def _has(self, name: str) -> bool:
        return getattr(type(self), name) is not getattr(Task, name)

    def _choices(self) -> dict[str, Any]:
        items = [values.text("choices", one) for one in self.choices]
        if len(items) < 2 or not self.question:
            raise InvalidArgumentError(
                f"choices: {items} given with question {self.question!r}; two or more, and a "
                "question, needed"
            )
        count = values.integer("choice_count", self.choice_count, 1, len(items))
        return {
            "question": values.text("question", self.question),
            "items": items,
            "count": count,
        }

    def _facts(self) -> dict[str, Any]:
        facts = {
            "candidates": values.integer("candidates", self.candidates, 1),
            "guess_rate": _rate("guess_rate", self.guess_rate),
            "answer": values.text("answer", self.answer),
            "answer_rate": _rate("answer_rate", self.answer_rate),
            "termination": values.text("termination", self.termination),
            "frozen_cue": values.boolean("frozen_cue", self.frozen_cue),
            "success_reward": values.real("success_reward", self.success_reward),
            "oracle_dim": values.integer("oracle_dim", self.oracle_dim, 0),
            "hidden": values.text("hidden", self.hidden),
            "table_ends": values.boolean("table_ends", self.table_ends),
        }
        if self.termination not in _TERMINATIONS:
            raise InvalidArgumentError(
                f"termination: {self.termination!r} given; allowed: {', '.join(_TERMINATIONS)}"
            )
        if not self.success_reward > 0:
            raise InvalidArgumentError(
                f"success_reward: {self.success_reward} given; more than 0 allowed"
            )
        if self.hidden and self.hidden not in [one["name"] for one in self._declared.draws]:
            raise InvalidArgumentError(f"hidden: {self.hidden!r} given, which is no draw")
        return facts


def _rate(name: str, value: Any) -> float:
    number = values.real(name, value)
    if not 0 <= number <= 1:
        raise InvalidArgumentError(f"{name}: {value} given; allowed: 0 to 1")
    return number


def _store(name: str, out: NDArray[Any], value: Any) -> None:
    """Copies what a method returned, whose shape must be that of the column."""
    given = np.asarray(value)
    if given.dtype.kind not in "biuf":
        raise InvalidArgumentError(f"{name}: {value!r} returned; an array of numbers needed")
    if given.shape != out.shape and (given.shape[:1], given.size) != (out.shape[:1], out.size):
        raise InvalidArgumentError(
            f"{name}: an array of shape {given.shape} returned; {out.shape} needed"
        )
    out[:] = given.reshape(out.shape)


def _frozen(value: Any) -> Any:
    """What build made, so that nothing can change it later."""
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, list):
        return tuple(_frozen(one) for one in value)
    elif isinstance(value, dict):
        return types.MappingProxyType({key: _frozen(one) for key, one in value.items()})
    elif isinstance(value, set):
        return frozenset(value)
    return value
