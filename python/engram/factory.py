"""``engram.make`` and ``engram.make_vec``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, overload

from engram._args.keywords import check_batch, check_single

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from typing_extensions import Unpack

    from engram.envs.env import Env
    from engram.envs.vector_env import VectorEnv
    from engram.typing import (
        AnyBatchOptions,
        BatchOptions,
        EnvOptions,
        ObjectsDict,
        ObsMode,
        RgbDepthObservation,
        RgbDepthSegmentationObservation,
        RgbObservation,
        RgbSegmentationObservation,
        Row,
        RowMode,
        StateDict,
    )
    from engram.wrappers.base import Wrapper


@overload
def make(id: str, *, obs_mode: RowMode = ..., **options: Unpack[EnvOptions]) -> Env[Row]: ...
@overload
def make(
    id: str, *, obs_mode: Literal["rgb"], **options: Unpack[EnvOptions]
) -> Env[RgbObservation]: ...
@overload
def make(
    id: str, *, obs_mode: Literal["rgb+depth"], **options: Unpack[EnvOptions]
) -> Env[RgbDepthObservation]: ...
@overload
def make(
    id: str, *, obs_mode: Literal["rgb+segmentation"], **options: Unpack[EnvOptions]
) -> Env[RgbSegmentationObservation]: ...
@overload
def make(
    id: str, *, obs_mode: Literal["rgb+depth+segmentation"], **options: Unpack[EnvOptions]
) -> Env[RgbDepthSegmentationObservation]: ...
@overload
def make(
    id: str, *, obs_mode: Literal["state_dict"], **options: Unpack[EnvOptions]
) -> Env[StateDict]: ...
@overload
def make(
    id: str, *, obs_mode: Literal["objects_dict"], **options: Unpack[EnvOptions]
) -> Env[ObjectsDict]: ...
@overload
def make(id: str, *, obs_mode: ObsMode, **options: Unpack[EnvOptions]) -> Env[Any]: ...
def make(id: str, **options: Any) -> Env[Any]:
    """One environment; see ``Env``."""
    from engram.envs.env import Env

    check_single("make", options)
    return Env(id, **options)


@overload
def make_vec(
    id: str, num_envs: int = ..., *, obs_mode: RowMode = ..., **options: Unpack[BatchOptions]
) -> VectorEnv[Row]: ...
@overload
def make_vec(
    id: str, num_envs: int = ..., *, obs_mode: Literal["rgb"], **options: Unpack[BatchOptions]
) -> VectorEnv[RgbObservation]: ...
@overload
def make_vec(
    id: str,
    num_envs: int = ...,
    *,
    obs_mode: Literal["rgb+depth"],
    **options: Unpack[BatchOptions],
) -> VectorEnv[RgbDepthObservation]: ...
@overload
def make_vec(
    id: str,
    num_envs: int = ...,
    *,
    obs_mode: Literal["rgb+segmentation"],
    **options: Unpack[BatchOptions],
) -> VectorEnv[RgbSegmentationObservation]: ...
@overload
def make_vec(
    id: str,
    num_envs: int = ...,
    *,
    obs_mode: Literal["rgb+depth+segmentation"],
    **options: Unpack[BatchOptions],
) -> VectorEnv[RgbDepthSegmentationObservation]: ...
@overload
def make_vec(
    id: str,
    num_envs: int = ...,
    *,
    obs_mode: Literal["state_dict"],
    **options: Unpack[BatchOptions],
) -> VectorEnv[StateDict]: ...
@overload
def make_vec(
    id: str,
    num_envs: int = ...,
    *,
    obs_mode: Literal["objects_dict"],
    **options: Unpack[BatchOptions],
) -> VectorEnv[ObjectsDict]: ...
@overload
def make_vec(
    id: str, num_envs: int = ..., *, obs_mode: ObsMode, **options: Unpack[BatchOptions]
) -> VectorEnv[Any]: ...
@overload
def make_vec(
    id: str,
    num_envs: int = ...,
    *,
    preset: Literal["train"],
    obs_mode: ObsMode = ...,
    **options: Unpack[BatchOptions],
) -> Wrapper: ...
@overload
def make_vec(
    id: Sequence[str] | Mapping[str, Any], num_envs: int = ..., **options: Unpack[AnyBatchOptions]
) -> VectorEnv[Any]: ...
def make_vec(
    id: Any, num_envs: int = 1, *, preset: Literal["train"] | None = None, **options: Any
) -> Any:
    """A batch of environments of one task or several; see ``VectorEnv``.

    With ``preset="train"`` it is wrapped for training by ``engram.wrappers.train``, with the
    defaults of that function, and episodes end at success unless ``terminate_on_success`` is given.
    """
    from engram.envs.vector_env import VectorEnv

    check_batch("make_vec", options)
    if preset is None:
        return VectorEnv(id, num_envs, **options)
    from engram.wrappers.preset import wrapped

    return wrapped(preset, lambda defaults: VectorEnv(id, num_envs, **{**defaults, **options}))
