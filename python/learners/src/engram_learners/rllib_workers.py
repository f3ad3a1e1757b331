"""engram in the workers of Ray RLlib: PPO with RLlib's own LSTM, from objects.

    pip install "ray[rllib]" torch
    python -m engram_learners.rllib_workers --workers 2

Every worker steps one batch, whose episodes no other worker and no run of another seed plays. The
script shows the connection; RLlib's LSTM needs many more iterations to learn a task.
"""

import argparse
import sys
import time

import engram
from engram.integrations.rllib import RllibVecEnv

try:
    import ray
    from ray.rllib.algorithms.ppo import PPOConfig
    from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
except ImportError as error:
    sys.exit(f'rllib_workers.py: {error.name} is missing: pip install "ray[rllib]" torch')


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--id", default="RememberColor3-VLA-v0")
    add("--seed", type=int, default=1)
    add("--workers", type=int, default=2, help="processes that sample")
    add("--envs", type=int, default=32, help="environments of each")
    add("--episodes", type=int, default=128, help="per iteration, of all workers")
    add("--iterations", type=int, default=5)
    return parser.parse_args()


def note_success(episode, metrics_logger, **_):
    metrics_logger.log_value("success_once", float(episode.get_infos(-1)["success_once"]))


def configuration(args):
    horizon = engram.describe(args.id)["horizon"]
    # Copies, because RLlib keeps the arrays.
    options = {"id": args.id, "obs_mode": "objects", "threads": 1, "copy": True}
    return (
        PPOConfig()
        .environment(RllibVecEnv, env_config=options)
        .env_runners(
            num_env_runners=args.workers,
            num_envs_per_env_runner=args.envs,
            gym_env_vectorize_mode="vector_entry_point",
        )
        .rl_module(
            model_config=DefaultModelConfig(
                fcnet_hiddens=[64], use_lstm=True, lstm_cell_size=64, max_seq_len=horizon
            )
        )
        .training(
            train_batch_size_per_learner=args.episodes * horizon,
            minibatch_size=args.episodes * horizon // 4,
            num_epochs=4,
            lr=1e-3,
            gamma=0.9,
        )
        .callbacks(on_episode_end=note_success)
        .debugging(seed=engram.worker_seed(args.seed, 0) % 2**31)
    )


def main():
    args = arguments()
    ray.init(num_cpus=args.workers + 1, include_dashboard=False, log_to_driver=False)
    algorithm = configuration(args).build_algo()
    for iteration in range(1, args.iterations + 1):
        begun = time.monotonic()
        played = algorithm.train()["env_runners"]
        seconds = time.monotonic() - begun
        steps = int(played["num_env_steps_sampled"])
        print(
            f"{iteration}: {steps} env steps, {steps / seconds:.0f} per second, "
            f"return {played['episode_return_mean']:.2f}, success {played['success_once']:.2f}",
            flush=True,
        )
    algorithm.stop()
    ray.shutdown()


if __name__ == "__main__":
    main()
