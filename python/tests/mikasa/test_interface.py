"""Every name that scripts use of the original: each is tried, and docs/mikasa.md has it.

One table for each part of the surface: keywords, infos, wrappers, attributes, classes, scripts.
"""

from __future__ import annotations

import inspect
from pathlib import Path

import pytest

pytest.importorskip("torch")

import torch
from expected import INFOS, SHARED
from helpers import made
from test_keywords import IGNORED, REFUSED, SERVED

import engram
import engram.mikasa as mikasa
from engram.mikasa import apply_wrappers, benchmarking, memory_envs, ppo_memtasks, wrappers

PAGE = (Path(__file__).parents[3] / "docs" / "mikasa.md").read_text()

KEYWORDS = [
    "num_envs",
    "obs_mode",
    "control_mode",
    "reward_mode",
    "render_mode",
    "sim_backend",
    "render_backend",
    "reconfiguration_freq",
    "max_episode_steps",
    "robot_uids",
    "robot_init_qpos_noise",
    "angle_threshold",
    "blink_color",
    "sensor_configs",
    "human_render_camera_configs",
    "shader_dir",
    "enable_shadow",
    "viewer_camera_configs",
    "sim_config",
    "parallel_in_single_scene",
    "enhanced_determinism",
]

# Names of wrappers, with what they take beside the environment.
WRAPPERS = {
    "StateOnlyTensorToDictWrapper": "",
    "ConvertJointsToEEFXyzRpyGripperWrapper": "qpos_dim gripper_finger_dims",
    "ConvertJointsToQposGripperWidthWrapper": "",
    "CurriculumPhaseNoopActionWrapper": "",
    "CurriculumPhaseNoopActionWrapperPdJointPos": "",
    "InitialZeroActionWrapper": "n_initial_steps",
    "CameraShutdownWrapper": "n_initial_steps",
    "RenderStepInfoWrapper": "",
    "RenderRewardInfoWrapper": "",
    "DebugRewardWrapper": "",
    "ShellGameRenderCupInfoWrapper": "",
    "RememberColorInfoWrapper": "",
    "RememberShapeInfoWrapper": "",
    "RememberShapeAndColorInfoWrapper": "",
    "MemoryCapacityInfoWrapper": "",
    "RotateRenderAngleInfoWrapper": "",
    "RenderPressProgressInfoWrapper": "",
    "RenderWorkingBatteriesInfoWrapper": "",
    "RenderTimedTransferInfoWrapper": "",
    "RenderTraceShapeDebugWrapper": "minimap_size minimap_top",
}

# Attributes and methods of the environment itself, by the task that is asked. "refused": what the
# error says.
COLOR, SHAPES = "RememberColor3-VLA-v0", "RememberShapeAndColor3x2-VLA-v0"
BUNCH, TIMED, TRACE = "BunchOfColors3-VLA-v0", "TimedTransferEasy-VLA-v0", "TraceShapeEasy-VLA-v0"
SEQUENCE, BLINK = "TraceShapeSeqEasy-VLA-v0", "BlinkCountButtonPressEasy-VLA-v0"
BATTERIES, PICK = "BatteriesCheckerEasy-3-VLA-v0", "ShellGamePick-VLA-v0"
GATHER, SHUFFLE = "GatherAndRecall3-VLA-v0", "ShellGameShuffleTouch-VLA-v0"
ATTRIBUTES = {
    COLOR: "single_action_space single_observation_space action_space observation_space "
    "elapsed_steps device update_obs_space _init_raw_obs reset step render close task_cue "
    "oracle_info cue_steps_per_env empty_steps_per_env evaluate control_mode spec num_envs "
    "reconfiguration_freq obs_mode reward_mode control_freq sim_freq control_timestep color_dict "
    "agent.robot.get_qpos agent.robot.get_qvel agent.robot.pose.p agent.robot.pose.q "
    "agent.robot.pose.raw_pose agent.tcp.pose.p agent.tcp.pose.raw_pose agent.is_static "
    "agent.is_grasping get_obs get_info get_reward compute_dense_reward "
    "compute_normalized_dense_reward compute_sparse_reward get_state get_state_dict set_state "
    "set_state_dict LANGUAGE_INSTRUCTION GOAL_THRESH",
    SHAPES: "COLOR_PALETTE",
    BUNCH: "touched_cubes color_dict button_xy",
    BLINK: "target_blinks press_count raw_press_count cue_steps_per_env empty_steps_per_env",
    BATTERIES: "found_working_count target_working_count",
    TIMED: "signal_step window_start window_end DELAY_STEPS agent.is_grasping",
    TRACE: "waypoints checkpoints checkpoint_visited shape_type green_cube.pose.p "
    "cue_steps_per_env",
    SEQUENCE: "shape_sequence sequence_len active_shape_idx shape_closed waypoints checkpoints "
    "button_xy",
    GATHER: "disc.pose.p",
    SHUFFLE: "cue_steps_per_env empty_steps_per_env shuffle_steps_per_env",
    "RotateStrictPos-VLA-v0": "LANGUAGE_INSTRUCTION_TEMPLATE task_cue angle_threshold peg.pose.q",
    "TakeItBack-VLA-v0": "cube.pose.p",
}
REFUSED_ATTRIBUTES = {
    SEQUENCE: {"checkpoint_visited": "not which"},
    COLOR: {
        "cubes": "state and state_dict: .*goal_0_pose",
        "goal_site": "body",
        "initial_poses": "body",
    },
    "RememberShape3-VLA-v0": {"shape_actors": "body"},
    PICK: {"mug_left": "body", "mug_center": "body", "mug_right": "body", "red_ball": "body"},
    BATTERIES: {"batteries": "body", "tray_slot_positions": "body", "socket_slot_pos": "body"},
    BLINK: {"button_top_z": "body"},
    TIMED: {"blue_cube": "body"},
}
SHAPED = {
    (TRACE, "waypoints"): (2, 64, 2),
    (TRACE, "checkpoints"): (2, 12, 2),
    (TRACE, "checkpoint_visited"): (2, 12),
    (TRACE, "green_cube.pose.p"): (2, 3),
    (SEQUENCE, "waypoints"): (2, 5, 64, 2),
    (SEQUENCE, "checkpoints"): (2, 5, 12, 2),
    (SEQUENCE, "shape_closed"): (2, 5),
    (SEQUENCE, "button_xy"): (2, 2),
    (BUNCH, "touched_cubes"): (2, 9),
}

# Methods that a subclass may override, and refused ones.
OVERRIDES = [
    "evaluate",
    "step",
    "compute_dense_reward",
    "compute_normalized_dense_reward",
    "compute_sparse_reward",
]
REFUSED_OVERRIDES = [
    "_get_obs_extra",
    "_initialize_episode",
    "_load_scene",
    "_load_agent",
    "_after_reconfigure",
    "_before_simulation_step",
    "_default_sensor_configs",
    "_default_human_render_camera_configs",
    "_default_sim_config",
]

# Modules that scripts import from, after the change of imports, and what they import.
SCRIPTS = {
    mikasa: "ManiSkillVectorEnv RecordEpisode FlattenActionSpaceWrapper BaseEnv Pose register_env "
    "find_max_episode_steps_value flatten_state_dict gym_utils common AgentStateOnly Agent "
    "NatureCNN Args Logger DictArray FlattenRGBDObservationWrapper apply_mikasa_vla_wrappers "
    "MIKASA_VLA_ENV_IDS VLA_WRAPPER_CONFIGS VLAWrapperConfig env_id_to_dataset_name "
    "is_dataset_name memory_envs",
    ppo_memtasks: "AgentStateOnly Agent NatureCNN Args Logger DictArray "
    "FlattenRGBDObservationWrapper layer_init",
    apply_wrappers: "apply_mikasa_vla_wrappers MIKASA_VLA_ENV_IDS VLA_WRAPPER_CONFIGS "
    "VLAWrapperConfig SHELL_GAME_OVERLAYS INTERCEPT_OVERLAYS ROTATE_OVERLAYS "
    "COLOR_MEMORY_OVERLAYS SHAPE_MEMORY_OVERLAYS SHAPE_COLOR_MEMORY_OVERLAYS "
    "MEMORY_CAPACITY_OVERLAYS BATTERIES_CHECKER_OVERLAYS BLINK_COUNT_OVERLAYS "
    "TRACE_SHAPE_OVERLAYS TIMED_TRANSFER_OVERLAYS STEP_REWARD_OVERLAYS",
    memory_envs: "register_env BaseEnv torch Pose",
    benchmarking: "START_SEED NUM_EPISODES_PER_TASK OBS_MODE CONTROL_MODE REWARD_MODE "
    "WRAPPER_CHAIN SUPPORTED_SPLITS BenchmarkTask BenchmarkConfig EpisodeResult ChunkPolicy "
    "load_benchmark_tasks select_benchmark_tasks make_benchmark_env run_episode evaluate_task "
    "evaluate_benchmark summarize_task_results write_benchmark_results make_run_dir "
    "RichBenchmarkUI default_task_csv_path benchmark_commit",
}
PARAMETERS = {
    mikasa.FlattenRGBDObservationWrapper: "env rgb depth state oracle joints",
    mikasa.ManiSkillVectorEnv: "env num_envs auto_reset ignore_terminations record_metrics",
    mikasa.register_env: "uid max_episode_steps override asset_download_ids",
    mikasa.apply_mikasa_vla_wrappers: "env include_overlays",
    mikasa.VLAWrapperConfig: "overlays curriculum_wrapper expected_control_mode",
    mikasa.flatten_state_dict: "state_dict use_torch device",
    mikasa.RecordEpisode: "env output_dir save_trajectory trajectory_name save_video info_on_video "
    "save_video_trigger max_steps_per_video video_fps source_type source_desc",
    benchmarking.BenchmarkTask: "env_id split memory_type max_episode_steps language_instruction "
    "data_source",
    benchmarking.BenchmarkConfig: "start_seed n_episodes obs_mode control_mode reward_mode "
    "sim_backend include_overlays save_videos",
    benchmarking.EpisodeResult: "success_once episode_return n_steps seed",
    benchmarking.run_episode: "env policy episode_seed collect_video",
}


def documented(name):
    return any(f"`{name}{end}" in PAGE or f".{name}{end}" in PAGE for end in ("`", "("))


def test_keywords():
    assert set(KEYWORDS) <= {*SERVED, *IGNORED, *REFUSED, "angle_threshold", "blink_color"}
    assert [name for name in KEYWORDS if not documented(name)] == []


def test_infos():
    assert set(INFOS) == {task["family"] for task in engram.list() if task["canonical"]} | {
        "ShellGamePick"
    }
    with made(BUNCH, num_envs=2) as env:
        assert set(env.reset(seed=1)[1]) >= {*SHARED.split(), "reconfigure"}


def test_wrappers():
    assert {name for name in wrappers.__all__ if "Wrapper" in name} == set(WRAPPERS)
    for name, takes in WRAPPERS.items():
        assert getattr(mikasa, name) is getattr(wrappers, name)
        signature = inspect.signature(getattr(wrappers, name))
        assert list(signature.parameters) == ["env", *takes.split()], name


def asked(env, path):
    value = env.unwrapped
    for name in path.split("."):
        value = getattr(value, name)
    return value


@pytest.mark.parametrize("id", ATTRIBUTES)
def test_attributes(id):
    with made(id, num_envs=2) as env:
        env.reset(seed=1)
        for path in ATTRIBUTES[id].split():
            value = asked(env, path)
            assert documented(path.split(".")[-1]) or documented(path) or path.isupper(), path
            if path == "task_cue" and id == COLOR:
                assert value is None
            elif (id, path) in SHAPED:
                assert tuple(value.shape) == SHAPED[id, path], path
            else:
                assert value is not None, path


@pytest.mark.parametrize("id", REFUSED_ATTRIBUTES)
def test_attributes_that_are_refused(id):
    with made(id, num_envs=2) as env:
        env.reset(seed=1)
        for name, expected in REFUSED_ATTRIBUTES[id].items():
            assert documented(name), name
            with pytest.raises(AttributeError, match=expected):
                getattr(env.unwrapped, name)


def test_attributes_of_states_are_refused_beside_pictures():
    for id, name in ((BUNCH, "touched_cubes"), (TRACE, "green_cube"), (SEQUENCE, "button_xy")):
        with (
            made(id, num_envs=1, obs_mode="rgb") as env,
            pytest.raises(AttributeError, match="state and state_dict"),
        ):
            getattr(env.unwrapped, name)


@pytest.mark.parametrize("method", OVERRIDES)
def test_methods_that_subclasses_override(method):
    called = []

    def own(self, *args, **kwargs):
        called.append(method)
        return getattr(mikasa.RememberColor3VLAEnv, method)(self, *args, **kwargs)

    cls = type(mikasa.BaseEnv)("Own", (mikasa.RememberColor3VLAEnv,), {method: own})
    id = f"RememberColor3-{method.replace('_', '')}-VLA-v0"
    mikasa.register_env(id, max_episode_steps=25)(cls)
    mode = method.removeprefix("compute_").removesuffix("_reward")
    keywords = {"reward_mode": mode} if method.startswith("compute") else {}
    with made(id, num_envs=2, **keywords) as env:
        env.reset(seed=1)
        env.step(torch.zeros(2, 7))
    assert called
    assert documented(method)


@pytest.mark.parametrize("method", REFUSED_OVERRIDES)
def test_methods_that_subclasses_may_not_override(method):
    cls = type(mikasa.BaseEnv)(
        "Own", (mikasa.RememberColor3VLAEnv,), {method: lambda self, *args: None}
    )
    with pytest.raises(engram.InvalidArgumentError, match=method):
        mikasa.register_env("RememberColor3-Refused-VLA-v0")(cls)
    assert documented(method)


def test_classes():
    for id, cls in mikasa.registration.REGISTERED.items():
        if not vars(cls).get("_generated") or cls._rl:
            continue
        stem = id.removesuffix("-VLA-v0").replace("-", "")
        name = f"{stem.replace('CheckerHard', 'Checker')}VLAEnv"
        assert getattr(memory_envs, name) is cls
        assert getattr(mikasa, name) is cls


def test_imports_of_scripts():
    for module, names in SCRIPTS.items():
        missing = [name for name in names.split() if not hasattr(module, name)]
        assert not missing, module.__name__
    for callable_, names in PARAMETERS.items():
        parameters = list(inspect.signature(callable_).parameters)
        assert [name for name in names.split() if name not in parameters] == [], callable_
    with made(COLOR, max_episode_steps=9) as env:
        assert mikasa.find_max_episode_steps_value(env) == 9
        assert mikasa.FlattenActionSpaceWrapper(env).action_space == env.action_space
    # The second is that of programs in joint space.
    defaults = {"include_overlays": True, "joint_proprio": False}
    assert mikasa.apply_mikasa_vla_wrappers.__kwdefaults__ == defaults
    assert (benchmarking.OBS_MODE, benchmarking.CONTROL_MODE) == ("rgb", "pd_ee_delta_pose")


def test_evaluation_has_no_side_effects_and_rewards_repeat():
    with made(BATTERIES, num_envs=2, reward_mode="dense") as env:
        env.reset(seed=1)
        observation, reward, *_, info = env.step(torch.full((2, 7), 0.2))
        base = env.unwrapped
        for _ in range(3):
            again = base.evaluate()
            assert set(again) == set(info) - {"elapsed_steps"}
            for name, value in again.items():
                if isinstance(value, torch.Tensor):
                    assert torch.equal(value, info[name]), name
        given = {"obs": observation, "action": torch.zeros(2, 7), "info": info}
        assert torch.equal(base.compute_dense_reward(**given), reward)
        expected = base._description["success_reward"]
        torch.testing.assert_close(base.compute_normalized_dense_reward(**given), reward / expected)
        assert torch.equal(base.compute_sparse_reward(**given), info["success"])


def test_states_of_a_batch_include_the_tasks_variables():
    with made(SEQUENCE, num_envs=2) as env:
        env.reset(seed=1)
        base = env.unwrapped
        state, drawn = base.get_state(), base.waypoints
        env.reset(seed=2)
        assert not torch.equal(base.waypoints, drawn)
        base.set_state(state)
        assert torch.equal(base.waypoints, drawn)
        base.set_state_dict(base.get_state_dict())
        assert torch.equal(base.get_state(), state)


def test_reward_terms_of_an_environment_that_has_none():
    """After a partial reset: NaN, False and 0 beside the terms of the others."""
    with made("ChainOfColors3-VLA-v0", num_envs=2, obs_mode="state") as env:
        env.reset(seed=0)
        for _ in range(3):
            env.step(env.action_space.sample())
        _, info = env.reset(options={"env_idx": torch.tensor([1])})
        terms = info["reward_dict"]
        assert terms["is_robot_static"].dtype == terms["all_seq_touched"].dtype == torch.bool
        assert terms["wrong_touches"].dtype == terms["sequence_cubes_mask"].dtype == torch.int64
        assert terms["sequence_cubes_mask"].tolist() == [3, 0]
        assert terms["reaching_reward"].isnan().tolist() == [False, True]
        assert not terms["all_seq_touched"].any()
