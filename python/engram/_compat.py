"""What differs between Gymnasium 0.29 and 1.x, in one place."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Any, TypeVar

import gymnasium

# What an environment observes, and what vector environments derive from: 0.29's is not generic.
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

if GYMNASIUM_1 and hasattr(gymnasium.vector, "AutoresetMode"):
    AutoresetMode = gymnasium.vector.AutoresetMode
else:

    class AutoresetMode(enum.Enum):  # type: ignore[no-redef]
        """When an environment whose episode has ended is reset; as Gymnasium 1.1 defines it."""

        NEXT_STEP = "NextStep"
        SAME_STEP = "SameStep"
        DISABLED = "Disabled"


# The default of the installed Gymnasium's vector environments.
DEFAULT_AUTORESET = AutoresetMode.NEXT_STEP if GYMNASIUM_1 else AutoresetMode.SAME_STEP
