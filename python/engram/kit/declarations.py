"""What a task declares in ``Task.build``: props, draws, memory, infos, state fields and phases."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from engram._args import values
from engram.errors import BadStateError, InvalidArgumentError
from engram.kit.columns import ENGINE_NAMES, INFO_NAMES, Column
from engram.kit.constants import IntegerRange, RealRange, constants_of
from engram.kit.props import Prop
from engram.kit.scene import Props

_DECLARED_BY = {
    "draw": "draw_...",
    "memory": "remember",
    "info": "add_info",
    "words": "add_subtasks",
}
_DTYPES = ("bool", "int32", "float32", "float64", "uint64")


@dataclasses.dataclass
class Declared:
    """All that a task has declared, as ``Task.describe`` lists it."""

    props: list[Prop] = dataclasses.field(default_factory=list)
    draws: list[dict[str, Any]] = dataclasses.field(default_factory=list)
    memory: list[dict[str, Any]] = dataclasses.field(default_factory=list)
    infos: list[dict[str, Any]] = dataclasses.field(default_factory=list)
    state_fields: list[dict[str, Any]] = dataclasses.field(default_factory=list)
    phases: list[tuple[str, str | int | None]] = dataclasses.field(default_factory=list)
    words: dict[str, Any] = dataclasses.field(default_factory=dict)
    # Attribute: name in the engine's table, look.
    columns: dict[str, tuple[str, Column]] = dataclasses.field(default_factory=dict)


class Declarations:
    """Base of ``Task`` with what ``build`` calls."""

    _declared: Declared

    # --- scene ---

    def add_prop(self, prop: Prop) -> int:
        """Adds a prop to the scene and returns its index.

        A prop is hidden until ``place`` puts it on the table.
        """
        self._check_building("add_prop")
        if not isinstance(prop, Prop):
            raise InvalidArgumentError(f"prop: {prop!r} given; one of engram.kit, such as kit.Cube")
        prop.definition()  # its mistakes come out here
        if not prop.name or prop.name in [one.name for one in self._declared.props]:
            raise InvalidArgumentError(f"prop: name {prop.name!r} given; each needs its own")
        self._declared.props.append(prop)
        return len(self._declared.props) - 1

    def add_props(self, props: Iterable[Prop]) -> Props:
        """Adds several props and returns them as a group.

        Methods take a group, one of its props (``self.cubes[2]``) or another one in every
        environment (``self.cubes[self.target]``).
        """
        numbers = [self.add_prop(prop) for prop in props]
        if not numbers:
            raise InvalidArgumentError("props: none given; at least one needed")
        return Props(numbers[0], len(numbers))

    # --- draws ---

    def draw_integer(
        self,
        name: str,
        low: int,
        high: int,
        *,
        width: int = 1,
        text: str,
        names: Sequence[str] = (),
    ) -> None:
        """Declares whole numbers from low to high: (n,), or (n, width), int32.

        `names`, one for each number, stand for {name} in the instruction and in subtasks.
        """
        fields = _bounds(values.integer("low", low), values.integer("high", high))
        fields |= _names(names, high - low + 1)
        self._add_draw("integer", name, text, "", fields, _shape(width))

    def draw_real(
        self, name: str, low: float, high: float, *, width: int = 1, unit: str = "", text: str
    ) -> None:
        """Declares uniform numbers from low to high: (n,), or (n, width), float64."""
        fields = _bounds(values.real("low", low), values.real("high", high))
        self._add_draw("real", name, text, unit, fields, _shape(width))

    def draw_range(self, name: str, constant: str, *, width: int = 1, text: str = "") -> None:
        """Declares numbers out of a constant, an IntegerRange, Steps or RealRange, by its name."""
        declared = constants_of(type(self)).get(constant)
        if not isinstance(declared, (IntegerRange, RealRange)):
            raise InvalidArgumentError(
                f"constant: {constant!r} given; the name of an IntegerRange, Steps or RealRange "
                f"of {type(self).__name__} needed"
            )
        kind = "integer" if isinstance(declared, IntegerRange) else "real"
        fields = {**_bounds(*getattr(self, constant)), "constant": constant}
        text = text or declared.text
        self._add_draw(kind, name, text, declared.unit, fields, _shape(width))

    def draw_order(self, name: str, count: int, *, text: str, names: Sequence[str] = ()) -> None:
        """Declares the numbers 0, ..., count - 1 in a random order: (n, count) int32.

        For `names` see ``draw_integer``.
        """
        count = values.integer("count", count, 1)
        fields = {"count": count, **_names(names, count)}
        self._add_draw("order", name, text, "", fields, (count,))

    def draw_choice(
        self, name: str, count: int, of: int, *, text: str, names: Sequence[str] = ()
    ) -> None:
        """Declares count different numbers of 0, ..., of - 1 in random order: (n, count) int32.

        For `names` see ``draw_integer``.
        """
        of = values.integer("of", of, 1)
        count = values.integer("count", count, 1, of)
        fields = {"count": count, "of": of, **_names(names, of)}
        self._add_draw("choice", name, text, "", fields, (count,))

    def draw_places(
        self,
        name: str,
        count: int,
        low: Sequence[float],
        high: Sequence[float],
        *,
        least_distance: float,
        text: str,
    ) -> None:
        """Declares points of a rectangle, far enough apart: (n, count, 2) float64, m.

        Args:
            name: Of the draw and the attribute.
            count: Points.
            low: Least x and y, m.
            high: Greatest x and y, m.
            least_distance: Between any two of the points, m.
            text: What they are.
        """
        count = values.integer("count", count, 1)
        corners = [_pair("low", low), _pair("high", high)]
        for pair in zip(*corners):
            _bounds(*pair)
        fields = {
            "count": count,
            "low": corners[0],
            "high": corners[1],
            "least_distance": values.real("least_distance", least_distance),
        }
        self._add_draw("places", name, text, "m", fields, (count, 2))

    def _add_draw(
        self,
        kind: str,
        name: str,
        text: str,
        unit: str,
        fields: dict[str, Any],
        shape: tuple[int, ...],
    ) -> None:
        self._add_column(name, "draw", Column(shape))
        listed = {"name": name, "kind": kind, "text": values.text("text", text), **fields}
        if kind in ("integer", "real"):
            listed["width"] = math.prod(shape)
        self._declared.draws.append({**listed, "unit": values.text("unit", unit)})

    # --- memory and infos ---

    def remember(
        self,
        name: str,
        dtype: Any = int,
        *,
        width: int | tuple[int, ...] = 1,
        low: int | None = None,
        high: int | None = None,
        unit: str = "",
        text: str = "",
    ) -> None:
        """Declares a column for what an episode has to keep: zero at reset, part of snapshots.

        It becomes the attribute `name`: ``(n,)``, or ``(n, *width)``. What differs between
        environments or steps has to be in such columns; other attributes cannot change.

        Args:
            name: Of the attribute.
            dtype: bool, int (32 bits), float, or np.float32 or np.uint64.
            width: Values per environment, or their shape.
            low: Least value of a whole number that serves as an index; snapshots with others are
                refused.
            high: Greatest such value.
            unit: Of the values.
            text: What it is.
        """
        column, listed = self._written_column(name, "memory", dtype, width, unit, text)
        limits = {key: one for key, one in (("low", low), ("high", high)) if one is not None}
        if limits and (len(limits) == 1 or listed["dtype"] not in ("int32", "bool")):
            raise InvalidArgumentError(
                f"{name}: low={low}, high={high} given; both, of whole numbers, allowed"
            )
        listed.update({key: values.integer(key, one) for key, one in limits.items()})
        self._add_column(name, "memory", column)
        self._declared.memory.append(listed)

    def add_info(
        self,
        name: str,
        dtype: Any = float,
        *,
        width: int | tuple[int, ...] = 1,
        unit: str = "",
        text: str = "",
        privileged: bool = False,
    ) -> None:
        """Declares a field of infos: an attribute that methods write, zero at reset.

        Args:
            name: Of the field and the attribute.
            dtype: See ``remember``; a float is np.float32 here.
            width: Values per environment, or their shape.
            unit: Of the values.
            text: What it is.
            privileged: It reveals what has to be remembered: policies do not get it.
        """
        dtype = np.float32 if dtype is float else dtype
        if name in INFO_NAMES:
            raise InvalidArgumentError(f"name: {name!r} given, an info that engram has itself")
        column, listed = self._written_column(name, "info", dtype, width, unit, text)
        listed["privileged"] = values.boolean("privileged", privileged)
        self._add_column(name, "info", column)
        self._declared.infos.append(listed)

    def _written_column(
        self, name: str, kind: str, dtype: Any, width: int | tuple[int, ...], unit: str, text: str
    ) -> tuple[Column, dict[str, Any]]:
        known = _dtype(f"dtype of {kind} {name!r}", dtype)
        column = Column(_shape(width), writable=True, dtype=np.bool_ if known == "bool" else None)
        listed = {
            "name": name,
            "dtype": known,
            "width": column.width,
            "unit": values.text("unit", unit),
            "text": values.text("text", text),
        }
        return column, listed

    # --- state and phases ---

    def add_state(self, name: str, width: int = 1, *, unit: str = "", text: str) -> None:
        """Declares a field of state observations; ``observe`` returns its values."""
        self._check_building("add_state")
        values.text("name", name)
        if name in [one["name"] for one in self._declared.state_fields]:
            raise InvalidArgumentError(f"name: state field {name!r} given twice")
        width = values.integer("width", width, 1)
        field = {"name": name, "width": width, "unit": values.text("unit", unit)}
        self._declared.state_fields.append({**field, "text": values.text("text", text)})

    def add_phases(self, *phases: tuple[str, str | int] | str) -> None:
        """Declares phases that follow one another, such as ("cue", "cue_steps"), "act".

        ``in_phase``, ``begins`` and ``start_of`` tell them apart. When a phase "cue" is over,
        nothing shows the answer any more (``cue_end``); with ``frozen_cue`` actions are zero until
        the last phase begins (``freeze_steps``).

        Args:
            *phases: A name, and a length in control steps: the name of a draw, or a number. The
                last one has a name only and lasts until the end.
        """
        self._check_building("add_phases")
        if self._declared.phases or len(phases) < 2:
            raise InvalidArgumentError("phases: two or more, all in one call, needed")
        for i, phase in enumerate(phases):
            self._declared.phases.append(self._phase(phase, last=i == len(phases) - 1))

    def _phase(self, phase: Any, *, last: bool) -> tuple[str, str | int | None]:
        if last and isinstance(phase, str):
            return phase, None
        if last or not (isinstance(phase, tuple) and len(phase) == 2):
            raise InvalidArgumentError(
                f"phases: {phase!r} given; (name, length) needed, of the last one the name"
            )
        name, length = values.text("phases", phase[0]), phase[1]
        if not isinstance(length, str):
            return name, values.integer(f"length of phase {name!r}", length, 1)
        draws = self._declared.draws
        drawn = [one["name"] for one in draws if one["kind"] == "integer" and one["width"] == 1]
        if length not in drawn:
            raise InvalidArgumentError(
                f"length of phase {name!r}: {length!r} given; a draw of whole numbers needed, "
                f"declared before: {', '.join(drawn) or 'none yet'}"
            )
        return name, length

    # --- words ---

    def add_subtasks(self, *subtasks: str, memory: str = "", unknown: str = "right") -> None:
        """Declares the plan of an episode in words, for ``words()`` and labels of data sets.

        In all texts {name} stands for a draw's value, or its name (``draw_integer``). Declares
        three columns, which methods write: ``subtask`` (n,) int32 is the one that is to be done
        now; ``shown`` (n,) bool, whether the cue has been shown, so that words may name what is
        hidden; ``meant`` (n,) int32, the prop that the subtask is about, -1 at reset: none.

        Args:
            *subtasks: In order, such as "wait", "touch the {color} cube".
            memory: What has to be remembered once it has been shown, such as "the {color} cube".
            unknown: Stands for the hidden draw until then.
        """
        if self._declared.words or not subtasks:
            raise InvalidArgumentError("subtasks: one or more, all in one call, needed")
        self._declared.words = {
            "subtasks": [values.text("subtasks", one) for one in subtasks],
            "memory": values.text("memory", memory),
            "unknown": values.text("unknown", unknown),
        }
        for name, dtype in (("subtask", None), ("shown", np.bool_), ("meant", None)):
            self._add_column(name, "words", Column(writable=True, dtype=dtype), name)

    # --- checks ---

    def _add_column(self, name: Any, kind: str, column: Column, engine: str = "") -> None:
        """`engine`: the column's name there; empty: the kind and the name."""
        self._check_building(_DECLARED_BY[kind])
        values.text("name", name)
        if not name.isidentifier() or name.startswith("_"):
            raise InvalidArgumentError(f"name: {name!r} given; a Python name without _ first")
        if name in ENGINE_NAMES:
            raise InvalidArgumentError(f"name: {name!r} given, which is a column of the engine")
        if name in self._declared.columns:
            raise InvalidArgumentError(f"name: {name!r} given, which is declared already")
        if name in self.__dict__ or hasattr(type(self), name):
            raise InvalidArgumentError(
                f"name: {name!r} given, which is another attribute of {type(self).__name__}"
            )
        self._declared.columns[name] = (engine or f"{kind}:{name}", column)

    def _check_building(self, what: str) -> None:
        if "_sealed" in self.__dict__:
            raise BadStateError(f"{what}: called outside of build(), which declares everything")


def _names(names: Sequence[str], count: int) -> dict[str, Any]:
    if not names:
        return {}
    given = [values.text("names", one) for one in names]
    if len(given) != count:
        raise InvalidArgumentError(
            f"names: {len(given)} given; {count}, one for each number, needed"
        )
    return {"names": given}


def _bounds(low: Any, high: Any) -> dict[str, Any]:
    if low > high:
        raise InvalidArgumentError(f"low: {low} given; at most high, {high}, allowed")
    return {"low": low, "high": high}


def _pair(name: str, value: Any) -> list[float]:
    numbers = [values.real(name, one) for one in value]
    if len(numbers) != 2:
        raise InvalidArgumentError(f"{name}: {value!r} given; x and y needed")
    return numbers


def _shape(width: Any) -> tuple[int, ...]:
    if isinstance(width, tuple):
        return tuple(values.integer("width", one, 1) for one in width)
    number = values.integer("width", width, 1)
    return () if number == 1 else (number,)


def _dtype(name: str, dtype: Any) -> str:
    try:
        known = "int32" if dtype is int else np.dtype(dtype).name
    except TypeError:
        known = ""
    if known not in _DTYPES:
        raise InvalidArgumentError(
            f"{name}: {dtype!r} given; allowed: bool, int, float, np.float32, np.uint64"
        )
    return known
