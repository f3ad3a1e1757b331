"""Props for scenes of tasks: what ``Task.add_prop`` takes.

Lengths are metres and half sizes, as in MuJoCo. Colours are names of ``COLORS`` or three or four
numbers from 0 to 1: linear red, green, blue and, if given, opacity. `object` is the kind of the
prop in objects observations, such as "object", "ball", "place" or "part" (none of its own); None:
the usual one.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engram._args import values
from engram.errors import InvalidArgumentError
from engram.kit.meshes import MOST_POINTS, read_points

Color = str | Sequence[float]
Body = Literal["dynamic", "kinematic", "visual"]
# "dynamic": moved by physics. "kinematic": moved by the task alone, pushes and is never pushed.
# "visual": moved by the task, collides with nothing.
_BODIES = ("dynamic", "kinematic", "visual")

# The benchmark's nine colours in their order, red, green, blue and opacity.
COLORS: Mapping[str, tuple[float, float, float, float]] = {
    "red": (1, 0, 0, 1),
    "green": (0, 1, 0, 1),
    "blue": (0, 0, 1, 1),
    "yellow": (1, 1, 0, 1),
    "magenta": (1, 0, 1, 1),
    "cyan": (0, 1, 1, 1),
    "maroon": (128 / 255, 0, 0, 1),
    "olive": (1, 128 / 255, 0, 1),
    "teal": (0, 128 / 255, 128 / 255, 1),
}


def rgba(name: str, color: Any) -> list[float]:
    """A colour as four numbers."""
    if isinstance(color, str):
        if color not in COLORS:
            near = values.nearest(color, COLORS)
            hint = f"did you mean {near!r}?" if near else f"allowed: {', '.join(COLORS)}"
            raise InvalidArgumentError(f"{name}: {color!r} given; {hint}")
        return list(COLORS[color])
    numbers = _numbers(name, color)
    if len(numbers) not in (3, 4) or not all(0 <= one <= 1 for one in numbers):
        raise InvalidArgumentError(
            f"{name}: {color!r} given; a name, or 3 or 4 numbers from 0 to 1 allowed"
        )
    return [*numbers, 1.0][:4]


@dataclasses.dataclass(frozen=True)
class Prop:
    """Base of all props."""

    name: str

    # Orientation of a prop that stands upright: (w, x, y, z).
    upright: ClassVar[tuple[float, float, float, float]] = (1, 0, 0, 0)
    _height: ClassVar[float | None] = None

    @property
    def resting_height(self) -> float | None:
        """Height (m) of the origin of a prop that stands on the table; None if poses need one."""
        return self._height

    def definition(self) -> dict[str, Any]:
        """The prop as ``Task.describe`` lists it."""
        found: dict[str, Any] = {"kind": self._kind()}
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if value is not None:
                found[field.name] = _checked(f"{self.name}.{field.name}", field.name, value)
        return found

    @classmethod
    def _kind(cls) -> str:
        """LampBody is lamp_body."""
        letters = [f"_{c.lower()}" if c.isupper() else c for c in cls.__name__]
        return "".join(letters).lstrip("_")


_LYING_AXIS = (0.7071067811865476, 0.0, 0.7071067811865476, 0.0)  # x of the body upwards
_QUARTER_TURN = (0.7071067811865476, 0.0, 0.0, 0.7071067811865476)  # x of the body along y


# --- solids ---


@dataclasses.dataclass(frozen=True)
class Cube(Prop):
    """A solid cube of 1000 kg/m^3."""

    half_size: float = 0.02
    color: Color = "red"
    object: str | None = None

    @property
    def resting_height(self) -> float:
        return self.half_size


@dataclasses.dataclass(frozen=True)
class Box(Prop):
    """A box; half_size is (x, y, z); density in kg/m^3."""

    half_size: Sequence[float] = (0.02, 0.02, 0.02)
    color: Color = "red"
    body: Body = "dynamic"
    density: float = 1000.0
    friction: float = 0.3
    object: str | None = None

    @property
    def resting_height(self) -> float:
        return self.half_size[2]


@dataclasses.dataclass(frozen=True)
class Sphere(Prop):
    """A sphere; density in kg/m^3."""

    radius: float = 0.02
    color: Color = "red"
    body: Body = "dynamic"
    density: float = 1000.0
    friction: float = 0.3
    object: str | None = None

    @property
    def resting_height(self) -> float:
        return self.radius


@dataclasses.dataclass(frozen=True)
class Cylinder(Prop):
    """An upright cylinder; density in kg/m^3."""

    radius: float = 0.02
    half_height: float = 0.02
    color: Color = "red"
    body: Body = "dynamic"
    density: float = 1000.0
    friction: float = 0.3
    object: str | None = None

    @property
    def resting_height(self) -> float:
        return self.half_height


@dataclasses.dataclass(frozen=True)
class Mesh(Prop):
    """The convex hull of a mesh; density in kg/m^3.

    Its origin and axes are those of the file. Corners that stand out by less than a ten-thousandth
    of its size are left out; if there are more than 64, the 64 remain that stand out most. Several
    meshes in ``Parts`` make a body that is not convex.

    Args:
        file: An OBJ or STL file; give this or vertices.
        vertices: Points (n, 3).
        scale: Of the file's or the array's numbers, to metres: 0.001 for millimetres.
    """

    file: str | os.PathLike[str] | None = None
    vertices: ArrayLike | None = None
    scale: float = 1.0
    color: Color = "red"
    body: Body = "dynamic"
    density: float = 1000.0
    friction: float = 0.3
    object: str | None = None

    def __post_init__(self) -> None:
        points = _mesh_points(self.name, self.file, self.vertices, self.scale)
        object.__setattr__(self, "vertices", tuple(map(tuple, points.tolist())))

    @property
    def resting_height(self) -> float:
        points: Any = self.vertices
        return -min(z for _, _, z in points)

    def definition(self) -> dict[str, Any]:
        shown = {"kind": "mesh"}
        for field in ("name", "vertices", "color", "body", "density", "friction", "object"):
            if getattr(self, field) is not None:
                shown[field] = _checked(f"{self.name}.{field}", field, getattr(self, field))
        return shown


@dataclasses.dataclass(frozen=True)
class Shape(Prop):
    """One of the benchmark's nine shapes, from "cube" to "crescent"; scale as of a cube."""

    shape: str = "cube"
    color: Color = "blue"
    scale: float = 0.02
    object: str | None = None


@dataclasses.dataclass(frozen=True)
class Ball(Prop):
    """A solid ball that rolls without resistance."""

    radius: float = 0.02
    color: Color = "red"
    object: str | None = None

    @property
    def resting_height(self) -> float:
        return self.radius


@dataclasses.dataclass(frozen=True)
class Geom:
    """One part of a ``Parts`` prop, posed in its frame.

    `size` is MuJoCo's: half sizes; radius; radius and half length along z. A mesh has `vertices`
    (n, 3) instead, or a `file`, as ``Mesh`` has, in metres.
    """

    type: Literal["box", "sphere", "capsule", "cylinder", "ellipsoid", "mesh"]
    size: Sequence[float] | None = None
    pos: Sequence[float] = (0, 0, 0)
    quat: Sequence[float] = (1, 0, 0, 0)  # w, x, y, z
    color: Color = "red"
    collides: bool = True
    visible: bool = True
    emission: float = 0.0
    vertices: ArrayLike | None = None
    file: str | os.PathLike[str] | None = None


@dataclasses.dataclass(frozen=True)
class Parts(Prop):
    """A body of several geoms; density in kg/m^3."""

    geoms: Sequence[Geom] = ()
    body: Body = "dynamic"
    density: float = 1000.0
    friction: float = 0.3
    object: str | None = None


# --- furniture of the benchmark ---


@dataclasses.dataclass(frozen=True)
class TargetDisc(Prop):
    """A target painted on the table: rings, the outer one in `color`."""

    radius: float = 0.05
    color: Color = (0.5, 0.5, 0.5)
    object: str | None = None

    @property
    def resting_height(self) -> float:
        return 0.001  # m: it lies on the table


@dataclasses.dataclass(frozen=True)
class Disc(Prop):
    """A flat disc, moved by the task alone, on which cubes can rest."""

    radius: float = 0.05
    half_height: float = 0.005
    color: Color = (0.5, 0.5, 0.5)
    object: str | None = None

    upright: ClassVar = _LYING_AXIS

    @property
    def resting_height(self) -> float:
        return self.half_height


@dataclasses.dataclass(frozen=True)
class Mug(Prop):
    """The mug of the shell games."""

    object: str | None = None
    _height: ClassVar = 0.0529462


@dataclasses.dataclass(frozen=True)
class Peg(Prop):
    """A bar along x, in the colours of its halves towards -x and +x."""

    half_length: float = 0.1
    half_width: float = 0.02
    colors: tuple[Color, Color] = ("red", "blue")
    object: str | None = None

    @property
    def resting_height(self) -> float:
        return self.half_width


@dataclasses.dataclass(frozen=True)
class Battery(Prop):
    """A battery, which a socket tests."""

    object: str | None = None

    upright: ClassVar = _LYING_AXIS
    _height: ClassVar = 0.030


@dataclasses.dataclass(frozen=True)
class BatteryTray(Prop):
    """A tray with slots, each at (x, y) in its frame."""

    slots: Sequence[Sequence[float]] = ()
    object: str | None = None

    upright: ClassVar = _QUARTER_TURN
    _height: ClassVar = 0.015


@dataclasses.dataclass(frozen=True)
class BatterySocket(Prop):
    """The socket that tests batteries."""

    object: str | None = None

    upright: ClassVar = _QUARTER_TURN
    _height: ClassVar = 0.015


@dataclasses.dataclass(frozen=True)
class ButtonBase(Prop):
    """The base of a button."""

    object: str | None = None
    _height: ClassVar = 0.015


@dataclasses.dataclass(frozen=True)
class ButtonCap(Prop):
    """The cap of a button: it sinks ahead of the tool by at most `travel`, see ``Task.pressed``."""

    travel: float = 0.01
    object: str | None = None

    upright: ClassVar = _LYING_AXIS
    _height: ClassVar = 0.044


@dataclasses.dataclass(frozen=True)
class LampBody(Prop):
    """The stand of a lamp; its origin is the middle of its underside."""

    object: str | None = None
    _height: ClassVar = 0.0


@dataclasses.dataclass(frozen=True)
class LampBulb(Prop):
    """The bulb of a lamp, in the stand's frame; ``Task.paint`` lights it."""

    object: str | None = None
    _height: ClassVar = 0.0


# --- checks ---

_POSITIVE = {"half_height", "radius", "scale", "half_length", "half_width", "travel", "density"}


def _checked(where: str, field: str, value: Any) -> Any:
    """A field of a prop as JSON has it."""
    if field == "color":
        return rgba(where, value)
    if field == "colors":
        return [rgba(where, one) for one in value]
    if field == "geoms":
        return [_geom(f"{where}[{i}]", one) for i, one in enumerate(value)]
    if field == "body":
        if value not in _BODIES:
            raise InvalidArgumentError(f"{where}: {value!r} given; allowed: {', '.join(_BODIES)}")
        return value
    if field == "slots":
        return [_numbers(where, one) for one in value]
    if field == "vertices":
        return value
    if field in ("collides", "visible"):
        return values.boolean(where, value)
    if isinstance(value, str) and field in ("name", "shape", "object", "type"):
        return values.text(where, value)
    if isinstance(value, (list, tuple, np.ndarray)):
        return _numbers(where, value)
    number = values.real(where, value)
    if field in _POSITIVE and not number > 0:
        raise InvalidArgumentError(f"{where}: {value!r} given; more than 0 allowed")
    return number


def _geom(where: str, geom: Any) -> dict[str, Any]:
    if not isinstance(geom, Geom):
        raise InvalidArgumentError(f"{where}: {geom!r} given, a kit.Geom needed")
    given = {field.name: getattr(geom, field.name) for field in dataclasses.fields(geom)}
    file, vertices = given.pop("file"), given.pop("vertices")
    if geom.type == "mesh":
        if given.pop("size") is not None:
            raise InvalidArgumentError(f"{where}.size: given; a mesh has vertices or a file")
        given["vertices"] = _mesh_points(where, file, vertices, 1.0).tolist()
    elif file is not None or vertices is not None:
        raise InvalidArgumentError(f"{where}: type {geom.type!r} has a size, no vertices or file")
    elif geom.size is None:
        raise InvalidArgumentError(f"{where}.size: missing")
    found = {key: _checked(f"{where}.{key}", key, value) for key, value in given.items()}
    if "size" in found:
        found["size"] = [*found["size"], 0.0, 0.0][:3]
    return found


def _mesh_points(name: str, file: Any, vertices: Any, scale: Any) -> NDArray[np.float64]:
    """Points of a mesh in metres (n, 3)."""
    if (file is None) == (vertices is None):
        given = "neither" if file is None else "both"
        raise InvalidArgumentError(f"{name}: {given} given; a file or vertices needed")
    factor = values.real(f"{name}.scale", scale)
    if not factor > 0:
        raise InvalidArgumentError(f"{name}.scale: {scale!r} given; more than 0 allowed")
    if file is not None:
        points = read_points(values.path(f"{name}.file", file))
    else:
        try:
            points = np.asarray(vertices, np.float64)
        except (TypeError, ValueError):
            raise InvalidArgumentError(f"{name}.vertices: numbers of shape (n, 3) needed") from None
    if points.ndim != 2 or points.shape[1] != 3:
        raise InvalidArgumentError(f"{name}.vertices: shape {points.shape} given; (n, 3) needed")
    if not 4 <= len(points) <= MOST_POINTS:
        raise InvalidArgumentError(
            f"{name}: {len(points)} points given; 4 to {MOST_POINTS} allowed"
        )
    if not np.isfinite(points).all():
        raise InvalidArgumentError(f"{name}.vertices: finite numbers needed")
    return points * factor


def _numbers(name: str, value: Any) -> list[float]:
    try:
        return [values.real(name, one) for one in value]
    except TypeError:
        raise InvalidArgumentError(f"{name}: {value!r} given, numbers needed") from None
