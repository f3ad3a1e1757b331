"""Constants of a task: class attributes that users may change when they make an environment.

    class LampOrder(engram.Task):
        LAMPS = kit.Integer(3, low=2, high=5, text="lamps in a row")
        CUE_PHASE_STEPS = kit.Steps(1, 5, text="how long the cue is shown")

On an instance they are plain values: ``self.LAMPS`` is 3, ``self.CUE_PHASE_STEPS`` is (1, 5).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

from engram._args import values
from engram.errors import InvalidArgumentError

if TYPE_CHECKING:
    from typing_extensions import Self

Value = TypeVar("Value")

_MOST_STEPS = 100_000


class Constant(Generic[Value]):
    """Base of all constants: a default value and what it may be changed to."""

    kind = ""

    def __init__(self, value: Value, text: str, unit: str = "") -> None:
        self.value = value
        self.text = values.text("text", text)
        self.unit = values.text("unit", unit)

    @overload
    def __get__(self, task: None, owner: type) -> Self: ...
    @overload
    def __get__(self, task: object, owner: type) -> Value: ...
    def __get__(self, task: object, owner: type) -> Any:
        return self if task is None else self.value

    def definition(self, name: str) -> dict[str, Any]:
        """The constant as ``_core.register_task`` takes it."""
        return {
            "name": name,
            "kind": self.kind,
            "value": self.value,
            "unit": self.unit,
            "text": self.text,
        }

    def changed(self, value: Any) -> Value:
        """A value that the engine has checked, in the type that tasks see."""
        return type(self.value)(value)  # type: ignore[call-arg]


class Fixed(Constant[Any]):
    """A constant that is only published: a number, a text, or a list or dict of them."""

    kind = "fixed"

    def __init__(self, value: Any, text: str = "", unit: str = "") -> None:
        super().__init__(value, text, unit)

    def changed(self, _value: Any) -> Any:
        return self.value


class _Bounded(Constant[Value]):
    """A constant with bounds."""

    low: float
    high: float

    def definition(self, name: str) -> dict[str, Any]:
        return {**super().definition(name), "low": self.low, "high": self.high}


class Integer(_Bounded[int]):
    """A whole number from `low` to `high`."""

    kind = "integer"

    def __init__(self, value: int, *, low: int, high: int, text: str, unit: str = "") -> None:
        self.low, self.high = _bounds(values.integer, low, high)
        super().__init__(values.integer("value", value, low, high), text, unit)


class Real(_Bounded[float]):
    """A number from `low` to `high`."""

    kind = "real"

    def __init__(self, value: float, *, low: float, high: float, text: str, unit: str = "") -> None:
        self.low, self.high = _bounds(values.real, low, high)
        super().__init__(_within("value", values.real("value", value), low, high), text, unit)


class IntegerRange(_Bounded[tuple[int, int]]):
    """Whole numbers of which an episode draws one: from `least` to `greatest`, both included.

    Users may change both, within `low` and `high`. ``Task.draw_range`` draws.
    """

    kind = "integer_range"

    def __init__(
        self, least: int, greatest: int, *, low: int, high: int, text: str, unit: str = ""
    ) -> None:
        self.low, self.high = _bounds(values.integer, low, high)
        pair = _bounds(values.integer, least, greatest, ("least", "greatest"))
        for name, value in zip(("least", "greatest"), pair):
            values.integer(name, value, low, high)
        super().__init__(pair, text, unit)

    def definition(self, name: str) -> dict[str, Any]:
        return {**super().definition(name), "value": list(self.value)}

    def changed(self, value: Any) -> tuple[int, int]:
        return int(value[0]), int(value[1])


class Steps(IntegerRange):
    """The length of a phase: from `least` to `greatest` control steps (of 0.05 s)."""

    def __init__(
        self, least: int, greatest: int, *, text: str, low: int = 1, high: int = _MOST_STEPS
    ) -> None:
        super().__init__(least, greatest, low=low, high=high, text=text, unit="control steps")


class RealRange(_Bounded[tuple[float, float]]):
    """Numbers of which an episode draws one, uniformly from `least` to `greatest`."""

    kind = "real_range"

    def __init__(
        self,
        least: float,
        greatest: float,
        *,
        low: float,
        high: float,
        text: str,
        unit: str = "",
    ) -> None:
        self.low, self.high = _bounds(values.real, low, high)
        pair = _bounds(values.real, least, greatest, ("least", "greatest"))
        for name, value in zip(("least", "greatest"), pair):
            _within(name, value, low, high)
        super().__init__(pair, text, unit)

    def definition(self, name: str) -> dict[str, Any]:
        return {**super().definition(name), "value": list(self.value)}

    def changed(self, value: Any) -> tuple[float, float]:
        return float(value[0]), float(value[1])


class Name(Constant[str]):
    """One of several names."""

    kind = "name"

    def __init__(self, value: str, *, names: Sequence[str], text: str) -> None:
        self.names = [values.text("names", name) for name in names]
        super().__init__(values.text("value", value), text)
        if value not in self.names:
            raise InvalidArgumentError(f"value: {value!r} given; allowed: {', '.join(self.names)}")

    def definition(self, name: str) -> dict[str, Any]:
        return {**super().definition(name), "names": self.names}


def constants_of(cls: type) -> dict[str, Constant[Any]]:
    """The constants of a class, those of its bases first."""
    found: dict[str, Constant[Any]] = {}
    for base in reversed(cls.__mro__):
        for name, value in vars(base).items():
            if isinstance(value, Constant):
                found[name] = value
            else:
                found.pop(name, None)  # a subclass made it something else
    return found


def changed_values(cls: type, given: Mapping[str, Any]) -> dict[str, Any]:
    """The values of an instance, by name; `given` are those that differ from the class's."""
    declared = constants_of(cls)
    return {
        name: one.changed(given[name]) if name in given else one.value
        for name, one in declared.items()
    }


Number = TypeVar("Number", int, float)


def _bounds(
    kind: Any, low: Number, high: Number, names: tuple[str, str] = ("low", "high")
) -> tuple[Number, Number]:
    low, high = kind(names[0], low), kind(names[1], high)
    if low > high:
        raise InvalidArgumentError(f"{names[0]}: {low} given; at most {names[1]}, {high}, allowed")
    return low, high


def _within(name: str, value: float, low: float, high: float) -> float:
    if not low <= value <= high:
        raise InvalidArgumentError(f"{name}: {value} given; allowed: {low} to {high}")
    return value
