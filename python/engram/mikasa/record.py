"""Videos of a batch."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from engram._distribution import install_command
from engram._io.files import replacing
from engram.errors import InvalidArgumentError, UnavailableError
from engram.mikasa._base_wrappers import Wrapper
from engram.mikasa._torch import torch

__all__ = ["RecordEpisode", "write_video"]

_PYAV = 12  # the oldest version that writes them


def write_video(path: Path, frames: Sequence[Any], rate: float) -> None:
    """Writes images as an mp4; odd sides lose a pixel.

    Args:
        path: The file; its folder is made.
        frames: Of one shape (height, width, 3), uint8, or numbers from 0 to 1 or from 0 to 255.
        rate: Images per second.

    Raises:
        InvalidArgumentError: No images, or images of several sizes.
        UnavailableError: There is no PyAV, or an old one.
    """
    sizes = sorted({np.shape(frame) for frame in frames})
    if len(sizes) != 1 or len(sizes[0]) != 3 or sizes[0][2] != 3:
        raise InvalidArgumentError(
            f"frames: {sizes or 'none'} given; images of one shape (height, width, 3) needed"
        )
    _need_pyav(path.name)
    from engram._io.video import Stream

    path.parent.mkdir(parents=True, exist_ok=True)
    height, width = (side - side % 2 for side in sizes[0][:2])
    with replacing(path) as temporary:
        stream = Stream(str(temporary), "mp4", width, height, Fraction(rate).limit_denominator())
        for frame in frames:
            stream.send_rgb(np.ascontiguousarray(_as_bytes(frame)[:height, :width]))
        stream.finish()


def _as_bytes(image: Any) -> np.ndarray:
    array = np.asarray(image)
    if array.dtype == np.uint8:
        return array
    scale = 255 if np.nanmax(array, initial=0) <= 1 else 1
    return np.clip(array.astype(np.float32) * scale, 0, 255).astype(np.uint8)


def _need_pyav(name: str) -> None:
    try:
        import av
    except ImportError:
        raise UnavailableError(f"{name}: videos need PyAV: {install_command('video')}") from None
    if int(av.__version__.split(".")[0]) < _PYAV:
        raise UnavailableError(
            f"{name}: videos need PyAV {_PYAV} or newer, not {av.__version__}: "
            f"{install_command('video')}"
        )


def tiled(images: np.ndarray) -> np.ndarray:
    """A batch's images as one, in int(sqrt(B)) rows."""
    rows = int(math.sqrt(len(images)))
    columns = math.ceil(len(images) / rows)
    height, width = images.shape[1:3]
    sheet = np.zeros((rows * height, columns * width, 3), np.uint8)
    for i, image in enumerate(images):
        row, column = divmod(i, columns)
        sheet[row * height : (row + 1) * height, column * width : (column + 1) * width] = image
    return sheet


class RecordEpisode(Wrapper):
    """Records episodes: OUTPUT_DIR/0.mp4, 1.mp4, ...

    Args:
        env: The environment; its render mode is not None.
        output_dir: Folder of the videos.
        save_trajectory: False only: states of the original's simulator do not exist.
        trajectory_name: Has no effect.
        save_video: True: videos are recorded.
        info_on_video: False only: wrappers of this package write over images.
        save_video_trigger: Called with the number of steps so far; True records the step. None:
            always.
        max_steps_per_video: Steps of a video; None: until all environments are reset.
        video_fps: Images per second.
        source_type: Has no effect.
        source_desc: Has no effect.
        **_: Others of the original's that concern trajectories have no effect.
    """

    def __init__(
        self,
        env: Any,
        output_dir: str | Path,
        save_trajectory: bool = False,
        trajectory_name: str | None = None,
        save_video: bool = True,
        info_on_video: bool = False,
        save_video_trigger: Callable[[int], bool] | None = None,
        max_steps_per_video: int | None = None,
        video_fps: int = 30,
        source_type: str | None = None,
        source_desc: str | None = None,
        **_: Any,
    ) -> None:
        if save_trajectory:
            raise InvalidArgumentError(
                "save_trajectory: True given; trajectories hold states of the original's "
                "simulator; allowed: False (`engram collect` writes demonstrations)"
            )
        if info_on_video:
            raise InvalidArgumentError(
                "info_on_video: True given; allowed: False (RenderStepInfoWrapper and "
                "similar wrappers write over images)"
            )
        if save_video and env.render_mode is None:
            raise InvalidArgumentError(
                "env: its render_mode is None; videos need rgb_array, sensors or all"
            )
        super().__init__(env)
        self.output_dir = Path(output_dir)
        self.save_video = save_video
        self.save_video_trigger = save_video_trigger
        self.max_steps_per_video = max_steps_per_video
        self.video_fps = video_fps
        self.video_nums = 0
        self._steps = 0
        self._frames: list[np.ndarray] = []

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """See the wrapped environment; a video ends if all environments are reset."""
        indices = (kwargs.get("options") or {}).get("env_idx")
        everything = indices is None or len(indices) == self.unwrapped.num_envs  # type: ignore
        if everything and self.max_steps_per_video is None:
            self.flush_video()
        result = self.env.reset(**kwargs)
        if everything and self._records() and not self._frames:
            self._frames.append(self._image())
        return result

    def step(self, action: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """See the wrapped environment."""
        records = self._records()
        if records and not self._frames:
            self._frames.append(self._image())
        result = self.env.step(action)
        self._steps += 1
        if records:
            self._frames.append(self._image())
            if self.max_steps_per_video and len(self._frames) > self.max_steps_per_video:
                self.flush_video()
        elif self._frames:
            self.flush_video()
        return result

    def _records(self) -> bool:
        trigger = self.save_video_trigger
        return self.save_video and (trigger is None or bool(trigger(self._steps)))

    def _image(self) -> np.ndarray:
        images: Any = self.env.render()
        array = images.numpy() if isinstance(images, torch.Tensor) else np.asarray(images)
        return tiled(array)

    def flush_video(self, name: str | None = None, **_: Any) -> None:
        """Writes the current video, if it has more than its first image."""
        frames, self._frames = self._frames, []
        if len(frames) > 1:
            stem = name or str(self.video_nums)
            write_video(self.output_dir / f"{stem}.mp4", frames, self.video_fps)
            self.video_nums += 1

    def close(self) -> None:
        """Writes the last video and ends the environment."""
        self.flush_video()
        self.env.close()


class FlattenActionSpaceWrapper(Wrapper):
    """Does nothing: actions are flat."""
