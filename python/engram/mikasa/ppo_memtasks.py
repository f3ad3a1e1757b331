"""Parts of the original's PPO baseline: flat observations, networks, a buffer.

The networks have the original's layers under the original's names, so that its checkpoints load.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np

from engram.mikasa._base_wrappers import ObservationWrapper, source
from engram.mikasa._observing import Wanted, joined
from engram.mikasa._torch import torch
from engram.mikasa.common import flatten_state_dict
from engram.mikasa.wrappers import NOTHING

__all__ = [
    "Agent",
    "AgentStateOnly",
    "Args",
    "DictArray",
    "FlattenRGBDObservationWrapper",
    "Logger",
    "NatureCNN",
    "layer_init",
]

nn = torch.nn
Normal = torch.distributions.Normal

_PRIVATE = ("oracle_info", "task_cue")
# Features of observations that are no images.
_WIDTHS = {"oracle_info": 64, "task_cue": 64, "joints": 128, "proprio": 128}


class FlattenRGBDObservationWrapper(ObservationWrapper):
    """Flat observations: {state}, or {rgb, joints, ...}; resets the environment once, unseeded.

    Args:
        env: Within StateOnlyTensorToDictWrapper.
        rgb: Images of all cameras, channels one after the other.
        depth: Depth, as further channels.
        state: All that is no image; without images, the row of obs_mode "state".
        oracle: The answer, too.
        joints: With images: tool pose 7, joint positions 9, velocities 9.
        joints_name: Name of these; None: "joints" in the RL half, as in its data and first release,
            and "proprio" in the VLA half.
    """

    _needs = Wanted.NO_MATRICES

    def __init__(
        self,
        env: gym.Env[Any, Any],
        rgb: bool = True,
        depth: bool = True,
        state: bool = True,
        oracle: bool = False,
        joints: bool = False,
        joints_name: str | None = None,
    ) -> None:
        super().__init__(env)
        base_env: Any = env.unwrapped
        self.base_env = base_env
        self.include_rgb = rgb
        self.include_depth = depth
        self.include_state = state
        self.include_oracle = oracle
        self.include_joints = joints
        self.joints_name = joints_name or ("joints" if base_env._rl else "proprio")
        self._source = source(env, self._needs) if rgb or depth else None
        # True if ConvertJointsToEEFXyzRpyGripperWrapper makes the observations of policies from it.
        flags = rgb and joints and not (depth or state or oracle)
        self._of_policies = flags and self.joints_name == "proprio"
        observation, _ = self.reset()
        self._update_space(observation)

    def observation(self, observation: Mapping[str, Any]) -> dict[str, torch.Tensor]:
        """The flat observation."""
        if self._source is not None and self._source.wanted is Wanted.POLICY:
            return dict(observation)
        private = {name: observation[name] for name in _PRIVATE if name in observation}
        if not self.include_oracle:
            private.pop("oracle_info", None)
        private = {name: value for name, value in private.items() if _is_present(value)}
        if not (self.include_rgb or self.include_depth):
            return {**{k: v for k, v in observation.items() if k not in _PRIVATE}, **private}
        result: dict[str, torch.Tensor] = private
        state: dict[str, Any] = {k: observation[k] for k in ("agent", "extra") if k in observation}
        if self.include_joints:
            tool_first: dict[str, Any] = {k: state[k] for k in ("extra", "agent") if k in state}
            result[self.joints_name] = flatten_state_dict(tool_first, use_torch=True)
        if self.include_state:
            result["state"] = flatten_state_dict(state, use_torch=True)
        kinds = [k for k, on in (("rgb", self.include_rgb), ("depth", self.include_depth)) if on]
        images = [camera[kind] for camera in observation["sensor_data"].values() for kind in kinds]
        result["rgbd" if len(kinds) == 2 else kinds[0]] = joined(images)
        return result


def _is_present(value: torch.Tensor) -> bool:
    return not (value.is_floating_point() and (value.numpy() == np.float32(NOTHING)).any())


def layer_init(layer: Any, std: float = np.sqrt(2), bias_const: float = 0.0) -> Any:
    """Orthogonal weights of this gain, and a constant bias."""
    nn.init.orthogonal_(layer.weight, std)
    nn.init.constant_(layer.bias, bias_const)
    return layer


class NatureCNN(nn.Module):
    """Features of flat observations: images through convolutions, the rest through a layer each.

    Args:
        sample_obs: An observation.
    """

    def __init__(self, sample_obs: Mapping[str, torch.Tensor]) -> None:
        super().__init__()
        parts: dict[str, Any] = {}
        self.out_features = 0
        if "rgb" in sample_obs:
            image = sample_obs["rgb"]
            cnn = nn.Sequential(
                nn.Conv2d(image.shape[-1], 32, kernel_size=8, stride=4),
                nn.ReLU(),
                nn.Conv2d(32, 64, kernel_size=4, stride=2),
                nn.ReLU(),
                nn.Conv2d(64, 64, kernel_size=3, stride=1),
                nn.ReLU(),
                nn.Flatten(),
            )
            with torch.no_grad():
                width = cnn(image[:1].float().permute(0, 3, 1, 2).cpu()).shape[1]
            parts["rgb"] = nn.Sequential(cnn, nn.Sequential(nn.Linear(width, 256), nn.ReLU()))
            self.out_features += 256
        for key, features in _WIDTHS.items():
            if key in sample_obs:
                layer = nn.Linear(sample_obs[key].shape[-1], features)
                parts[key] = nn.Sequential(layer, nn.ReLU())
                self.out_features += features
        if "state" in sample_obs:
            parts["state"] = nn.Linear(sample_obs["state"].shape[-1], 256)
            self.out_features += 256
        # Order of the concatenated features.
        order = [key for key in sample_obs if key in parts and key not in ("rgb", "state")]
        first, last = [k for k in ("rgb",) if k in parts], [k for k in ("state",) if k in parts]
        self.extractors = nn.ModuleDict({key: parts[key] for key in (*first, *order, *last)})

    def forward(self, observations: Mapping[str, torch.Tensor]) -> torch.Tensor:
        """(B, out_features)."""
        encoded = []
        for key, extractor in self.extractors.items():
            value = observations[key].float()
            if key == "rgb":
                value = value.permute(0, 3, 1, 2) / 255
            encoded.append(extractor(value))
        return torch.cat(encoded, dim=1)


class _ActorCritic(nn.Module):
    """A Gaussian policy and a value, of features."""

    critic: Any
    actor_mean: Any
    actor_logstd: Any

    def get_features(self, x: Any) -> torch.Tensor:
        """Features of observations."""
        raise NotImplementedError

    def get_value(self, x: Any) -> torch.Tensor:
        """Values (B, 1)."""
        value: torch.Tensor = self.critic(self.get_features(x))
        return value

    def get_action(self, x: Any, deterministic: bool = False) -> torch.Tensor:
        """Actions (B, D): drawn, or the means."""
        mean: torch.Tensor = self.actor_mean(self.get_features(x))
        return mean if deterministic else self._distribution(mean).sample()

    def get_action_and_value(
        self, x: Any, action: torch.Tensor | None = None
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]:
        """Actions, their log probabilities, entropies, values."""
        features = self.get_features(x)
        distribution = self._distribution(self.actor_mean(features))
        if action is None:
            action = distribution.sample()
        return (
            action,
            distribution.log_prob(action).sum(1),
            distribution.entropy().sum(1),
            self.critic(features),
        )

    def _distribution(self, mean: torch.Tensor) -> Any:
        return Normal(mean, self.actor_logstd.expand_as(mean).exp())


def _log_std(actions: int) -> Any:
    return nn.Parameter(torch.full((1, actions), -0.5))


class Agent(_ActorCritic):
    """Policy of observations with images.

    Args:
        envs: Whose actions it gives.
        sample_obs: An observation.
    """

    def __init__(self, envs: Any, sample_obs: Mapping[str, torch.Tensor]) -> None:
        super().__init__()
        self.feature_net = NatureCNN(sample_obs=sample_obs)
        width = self.feature_net.out_features
        actions = int(np.prod(envs.unwrapped.single_action_space.shape))

        def head(out: int, std: float) -> Any:
            hidden = layer_init(nn.Linear(width, 512))
            return nn.Sequential(
                hidden, nn.ReLU(inplace=True), layer_init(nn.Linear(512, out), std)
            )

        self.critic = head(1, np.sqrt(2))
        self.actor_mean = head(actions, 0.01 * np.sqrt(2))
        self.actor_logstd = _log_std(actions)

    def get_features(self, x: Any) -> torch.Tensor:
        """Features of observations."""
        features: torch.Tensor = self.feature_net(x)
        return features


class AgentStateOnly(_ActorCritic):
    """Policy of state observations: all entries, in the order of the space, through three layers.

    Args:
        envs: Whose single_observation_space and single_action_space it fits.
    """

    def __init__(self, envs: Any) -> None:
        super().__init__()
        space = envs.single_observation_space
        self.list_of_obs_keys = list(space.keys())
        width = sum(int(np.prod(space[key].shape)) for key in self.list_of_obs_keys)
        actions = int(np.prod(envs.single_action_space.shape))

        def body(out: int, std: float) -> Any:
            layers: list[Any] = []
            for size in (width, 256, 256):
                layers += [layer_init(nn.Linear(size, 256)), nn.Tanh()]
            return nn.Sequential(*layers, layer_init(nn.Linear(256, out), std))

        self.critic = body(1, np.sqrt(2))
        self.actor_mean = body(actions, 0.01 * np.sqrt(2))
        self.actor_logstd = _log_std(actions)

    def get_features(self, x: Any) -> torch.Tensor:
        """All entries beside each other."""
        return torch.cat([x[key] for key in self.list_of_obs_keys], dim=-1)

    add_task_cue_to_state = get_features


class Logger:
    """Writes scalars to TensorBoard's writer, and optionally to Weights & Biases.

    Args:
        log_wandb: Whether wandb.log is called, too.
        tensorboard: A SummaryWriter, or what has its add_scalar and close.
    """

    def __init__(self, log_wandb: bool = False, tensorboard: Any = None) -> None:
        self.writer = tensorboard
        self.log_wandb = log_wandb

    def add_scalar(self, tag: str, scalar_value: Any, step: int) -> None:
        """Writes one."""
        if self.log_wandb:
            import wandb

            wandb.log({tag: scalar_value}, step=step)
        self.writer.add_scalar(tag, scalar_value, step)

    def close(self) -> None:
        """Ends the writer."""
        self.writer.close()


class DictArray:
    """Tensors by name that share their first dimensions: a buffer of dict observations.

    Args:
        buffer_shape: The first dimensions.
        element_space: Dict space of an element.
        data_dict: Tensors to take over instead.
        device: Where new tensors are.
    """

    def __init__(
        self,
        buffer_shape: tuple[int, ...],
        element_space: Any,
        data_dict: dict[str, Any] | None = None,
        device: Any = None,
    ) -> None:
        self.buffer_shape = buffer_shape
        self.data: dict[str, Any] = data_dict or {
            key: DictArray(buffer_shape, space, device=device)
            if isinstance(space, gym.spaces.Dict)
            else torch.zeros(buffer_shape + space.shape, device=device)
            for key, space in element_space.items()
        }

    def keys(self) -> Any:
        """The names."""
        return self.data.keys()

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, str):
            return self.data[index]
        return {key: value[index] for key, value in self.data.items()}

    def __setitem__(self, index: Any, value: Any) -> None:
        if isinstance(index, str):
            self.data[index] = value
            return
        for key, part in value.items():
            self.data[key][index] = part

    @property
    def shape(self) -> tuple[int, ...]:
        """The first dimensions."""
        return self.buffer_shape

    def reshape(self, shape: tuple[int, ...]) -> DictArray:
        """A copy with other first dimensions."""
        kept = len(self.buffer_shape)
        data = {
            key: value.reshape(shape)
            if isinstance(value, DictArray)
            else value.reshape(shape + value.shape[kept:])
            for key, value in self.data.items()
        }
        first = next(iter(data.values()))
        return DictArray(tuple(first.shape[: len(shape)]), None, data_dict=data)


@dataclass
class Args:
    """Settings of the original's PPO script, with its defaults."""

    exp_name: str | None = None
    seed: int = 123
    torch_deterministic: bool = True
    cuda: bool = True
    track: bool = False
    wandb_project_name: str = "ManiSkill-MemoryBench"
    wandb_entity: str | None = None
    capture_video: bool = True
    save_model: bool = True
    evaluate: bool = False
    checkpoint: str | None = None
    render_mode: str = "all"
    env_id: str = "ShellGamePush-v1"
    include_state: bool = False
    total_timesteps: int = 50_000_000
    learning_rate: float = 3e-4
    num_envs: int = 1024
    num_eval_envs: int = 16
    partial_reset: bool = False
    eval_partial_reset: bool = False
    num_steps: int = 90
    num_eval_steps: int = 270
    reconfiguration_freq: int | None = None
    eval_reconfiguration_freq: int | None = 1
    anneal_lr: bool = False
    gamma: float = 0.99
    gae_lambda: float = 0.95
    num_minibatches: int = 32
    update_epochs: int = 4
    norm_adv: bool = True
    clip_coef: float = 0.2
    clip_vloss: bool = False
    ent_coef: float = 0.0
    vf_coef: float = 0.5
    max_grad_norm: float = 0.5
    target_kl: float = 0.2
    reward_scale: float = 1.0
    eval_freq: int = 25
    save_train_video_freq: int | None = None
    finite_horizon_gae: bool = True
    batch_size: int = 0
    minibatch_size: int = 0
    num_iterations: int = 0
    include_oracle: bool = False
    noop_steps: int = 1
    include_rgb: bool = False
    include_joints: bool = False
    reward_mode: str = "normalized_dense"
