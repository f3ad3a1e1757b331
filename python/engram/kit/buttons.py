"""Buttons: caps that sink under the tool, and what counts as a press."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engram.errors import InvalidArgumentError
from engram.kit.columns import Column
from engram.kit.functions import length
from engram.kit.props import ButtonCap
from engram.kit.scene import AnyProps, Mask, Props

if TYPE_CHECKING:
    from engram.kit.declarations import Declared

# Lengths of the benchmark's buttons, m.
CAP_HALF_HEIGHT = 0.014
_REACH = 0.065  # of the tool from the cap's axis
_MARGIN = 0.03  # above the cap: the tool begins to press there
_POSED = 1  # in the column moved
# Columns of each cap: its height when the tool is away, and how far it has sunk, m.
_MEMORY = ("_cap_rest", "_cap_depth")


class Buttons:
    """Base of ``Task`` with what moves and reads caps."""

    n: int
    rows: NDArray[np.int64]
    tcp_pos: NDArray[np.float64]
    prop_pos: NDArray[np.float64]
    prop_status: NDArray[np.uint8]
    moved: NDArray[np.uint8]

    _declared: Declared
    _cap_rest: NDArray[np.float64]
    _cap_depth: NDArray[np.float64]

    def press_depth(self, caps: AnyProps) -> NDArray[np.float64]:
        """How far caps have sunk, m: (n,), of a group (n, k).

        The cap of a button sinks ahead of the tool, as in the benchmark: while the TCP is less than
        65 mm from its axis, by as much as the TCP is below a height of 30 mm above the
        released cap, and by at most its ``travel``.
        """
        columns = self._columns_of(caps)
        if isinstance(caps, np.ndarray):
            return self._cap_depth[self.rows, columns]
        return self._cap_depth[:, columns]

    def pressed(self, caps: AnyProps, share: float = 0.35) -> Mask:
        """Whether caps have sunk by that share of their travel: (n,), of a group (n, k)."""
        props = self._declared.props
        travels = np.array([getattr(prop, "travel", 0.0) for prop in props])
        index = caps.slice if isinstance(caps, Props) else caps
        depth = self.press_depth(caps)  # refuses what is no cap
        return depth >= share * travels[index]

    def _columns_of(self, caps: AnyProps) -> Any:
        """The numbers of caps among all of the scene."""
        props = self._declared.props
        kinds = np.array([isinstance(prop, ButtonCap) for prop in props])
        index = caps.slice if isinstance(caps, Props) else caps
        if not kinds[index].all():
            other = np.atleast_1d(np.arange(len(props))[index][~kinds[index]])[0]
            raise InvalidArgumentError(
                f"caps: prop {props[other].name!r} given; a kit.ButtonCap needed"
            )
        return (kinds.cumsum() - 1)[index]

    # --- for the engine ---

    def _declare_caps(self) -> None:
        """Columns of the scene's caps."""
        count = sum(isinstance(prop, ButtonCap) for prop in self._declared.props)
        if count == 0:
            return
        for name in _MEMORY:
            about = {"name": name, "dtype": "float64", "width": count, "unit": "m", "text": ""}
            self._declared.memory.append(about)
            self._declared.columns[name] = (f"memory:{name}", Column((count,), writable=True))

    def _sink_caps(self) -> None:
        """Brings caps to the height that the tool leaves them; after ``advance``."""
        if _MEMORY[0] not in self._declared.columns:
            return
        props = self._declared.props
        caps = [i for i, prop in enumerate(props) if isinstance(prop, ButtonCap)]
        travel = np.array([prop.travel for prop in props if isinstance(prop, ButtonCap)])
        pos = self.prop_pos[:, caps]
        rest, depth = self._cap_rest, self._cap_depth
        np.copyto(rest, pos[..., 2], where=pos[..., 2] != rest - depth)  # placed anew
        near = length(pos[..., :2] - self.tcp_pos[:, None, :2]) < _REACH
        near &= self.prop_status[:, caps] != 0
        sunk = rest + (CAP_HALF_HEIGHT + _MARGIN) - self.tcp_pos[:, 2:]
        depth[:] = np.where(near, np.clip(sunk, 0, travel), 0)
        rows, columns = (rest - depth != pos[..., 2]).nonzero()
        numbers = np.array(caps)[columns]
        self.prop_pos[rows, numbers, 2] = (rest - depth)[rows, columns]
        self.moved[rows, numbers] = _POSED
