"""Differences between Gymnasium 0.29 and 1.x, and the modes of automatic resets."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Any, TypeVar

import gymnasium

from engram.errors import InvalidArgumentError

# Type of observations, and base class of vector environments: 0.29's is not generic.
if TYPE_CHECKING:
    import numpy as np
    from typing_extensions import TypeVar as TypeVarWithDefault

    ObsT = TypeVarWithDefault("ObsT", default=Any)
    VectorBase = gymnasium.vector.VectorEnv[ObsT, np.ndarray, np.ndarray]
else:
    ObsT = TypeVar("ObsT")

    class _Base:
        """Indexed, it is Gymnasium's class itself: clients look for that among the bases."""

        def __getitem__(self, _: Any) -> type:
            return gymnasium.vector.VectorEnv

    VectorBase = _Base()


GYMNASIUM_1 = int(gymnasium.__version__.split(".", 1)[0]) >= 1

if TYPE_CHECKING:
    from gymnasium.vector import AutoresetMode as AutoresetMode
elif GYMNASIUM_1 and hasattr(gymnasium.vector, "AutoresetMode"):
    AutoresetMode = gymnasium.vector.AutoresetMode
else:

    class AutoresetMode(enum.Enum):
        """Moment at which ended episodes are followed by new ones, as Gymnasium 1.1 defines it."""

        NEXT_STEP = "NextStep"
        SAME_STEP = "SameStep"
        DISABLED = "Disabled"


# The default of the installed Gymnasium's vector environments.
DEFAULT_AUTORESET = AutoresetMode.NEXT_STEP if GYMNASIUM_1 else AutoresetMode.SAME_STEP

# Names in the C API.
AUTORESET_NAMES = {
    AutoresetMode.NEXT_STEP: "next-step",
    AutoresetMode.SAME_STEP: "same-step",
    AutoresetMode.DISABLED: "off",
}


def autoreset(value: Any) -> AutoresetMode:
    """The mode by member, or by name in Gymnasium's or the engram command's spelling."""
    if value is None:
        return DEFAULT_AUTORESET
    if isinstance(value, str):
        name = value.replace("-", "_").upper()
        names = {mode.value.upper(): mode for mode in AUTORESET_NAMES}
        names.update({mode.name: mode for mode in AUTORESET_NAMES}, OFF=AutoresetMode.DISABLED)
        if name in names:
            return names[name]
    elif isinstance(value, AutoresetMode):
        return value
    raise InvalidArgumentError(
        f"autoreset_mode: {value!r} given; allowed: "
        f"{', '.join(mode.name for mode in AUTORESET_NAMES)}"
    )
