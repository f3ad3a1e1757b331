"""A batch in the workers of Ray RLlib, with seeds that do not coincide."""

from __future__ import annotations

from typing import Any

from engram._args.values import worker_seed
from engram.envs.vector_env import VectorEnv
from engram.errors import InvalidArgumentError


class RllibVecEnv(VectorEnv[Any]):
    """engram's batch as the environment of RLlib's workers.

    ::

        PPOConfig()
        .environment(RllibVecEnv, env_config={"id": "RememberColor3-VLA-v0", "obs_mode": "objects"})
        .env_runners(gym_env_vectorize_mode="vector_entry_point", num_envs_per_env_runner=32)
        .debugging(seed=1)

    RLlib gives worker w the seed of its configuration plus w. Environment i of a batch has the
    batch's seed plus i, so that workers would share nearly all episodes: this class resets with
    ``engram.worker_seed(seed, 0)`` instead. Without a seed each worker draws one.

    Args:
        config: RLlib's ``env_config``: ``id`` and the options of ``engram.make_vec``, except seed;
            and ``num_envs``, from RLlib.
    """

    def __init__(self, config: dict[str, Any]) -> None:
        options = dict(config)
        if "seed" in options:
            raise InvalidArgumentError(
                "seed: given in env_config, which all workers share; "
                "AlgorithmConfig.debugging(seed=...) needed"
            )
        super().__init__(**options)

    def reset(self, *, seed: Any = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        """Starts new episodes: those of ``engram.worker_seed(seed, 0)``."""
        spread = seed if seed is None else worker_seed(seed, 0)
        return super().reset(seed=spread, options=options)
