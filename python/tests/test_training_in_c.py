"""The preset for training of the C API: bit for bit the Python wrappers."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path

import numpy as np
import pytest
from conftest import ENDING_TASK, TASK
from wrapped_batches import N, make, modes

from engram import _core, kit, wrappers
from engram.envs.compat import GYMNASIUM_1

ROOT = Path(__file__).resolve().parents[2]
HEADERS = ROOT / "api/engram"
TYPES = {
    "int32_t": ctypes.c_int32,
    "uint64_t": ctypes.c_uint64,
    "size_t": ctypes.c_size_t,
    "double": ctypes.c_double,
}
C = ctypes.CDLL(_core.__file__)
C.engram_last_error.restype = ctypes.c_char_p
ARRAYS = ("observation", "final_observation", "reward", "action_low", "action_high")
for name in ARRAYS:
    function = getattr(C, f"engram_training_{name}")
    function.restype, function.argtypes = ctypes.POINTER(ctypes.c_float), [ctypes.c_void_p]
AUTO_RESETS = {"NEXT_STEP": 0, "SAME_STEP": 1, "DISABLED": 2}
OBS_MODES = {"state": 1, "objects": 4, "rgb+state": 9, "rgb+objects": 13}


def structure(header: str, name: str) -> type[ctypes.Structure]:
    """A struct of the C API, from its header."""
    text = re.sub(r"/\*.*?\*/", "", (HEADERS / header).read_text(), flags=re.DOTALL)
    body = re.search(rf"typedef struct {name} {{(.*?)}}", text, re.DOTALL)[1]
    fields = [
        (field, ctypes.c_void_p if "*" in kind else TYPES[kind])
        for kind, field in re.findall(r"^ +(\S.*?) ?(\w+); *$", body, re.MULTILINE)
    ]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


Options = structure("engram_options_c.h", "engram_options")
Share = structure("engram_options_c.h", "engram_task_share")
TrainingOptions = structure("engram_training_c.h", "engram_training_options")


class Training:
    """The preset of C, of a batch like ``wrapped_batches.make``'s: N environments of all ids."""

    def __init__(self, *ids: str, mode: str, obs_mode: str, **own: float) -> None:
        options, training = Options(), TrainingOptions()
        C.engram_options_init(ctypes.byref(options))
        options.num_envs, options.threads, options.seed = N, 1, 3
        options.terminate_on_success = 1
        options.auto_reset, options.obs_mode = AUTO_RESETS[mode], OBS_MODES[obs_mode]
        C.engram_training_options_init(ctypes.byref(training))
        for name, value in own.items():
            setattr(training, name, value)
        self.env, self.handle = ctypes.c_void_p(), ctypes.c_void_p()
        texts = [ctypes.create_string_buffer(id.encode()) for id in ids]
        shares = (Share * len(ids))()
        for share, text in zip(shares, texts):
            share.id, share.num_envs = ctypes.addressof(text), N // len(ids)
        if len(ids) == 1:
            self.call(C.engram_make, ids[0].encode(), ctypes.byref(options), ctypes.byref(self.env))
        else:
            batch = (shares, len(ids), ctypes.byref(options), ctypes.byref(self.env))
            self.call(C.engram_make_group, *batch)
        made = (self.env, ctypes.byref(training), ctypes.byref(self.handle))
        self.call(C.engram_training_make, *made)

    def __del__(self) -> None:
        C.engram_training_close(self.handle)
        C.engram_close(self.env)

    def call(self, function, *arguments) -> None:
        assert function(*arguments) == 0, C.engram_last_error()

    def reset(self) -> None:
        self.call(C.engram_training_reset, self.handle, None)

    def step(self, actions: np.ndarray) -> None:
        values = np.ascontiguousarray(actions, np.float32)
        pointer = values.ctypes.data_as(ctypes.c_void_p)
        count = ctypes.c_size_t(values.size)
        self.call(C.engram_training_step, self.handle, pointer, count)

    def array(self, name: str, *shape: int) -> np.ndarray:
        values = getattr(C, f"engram_training_{name}")(self.handle)
        return np.ctypeslib.as_array(values, shape).copy()

    @property
    def rows(self) -> tuple[int, int]:
        return N, C.engram_training_observation_dim(self.handle)


def actions_of(env, policy: str, rng: np.random.Generator) -> np.ndarray:
    """Noise that reaches the limits, or the oracle with a little of it."""
    if policy == "oracle":
        return np.float32(env.act("oracle") + rng.normal(0, 0.05, env.action_space.shape))
    return rng.normal(0, 2, env.action_space.shape).astype(np.float32)


def assert_equal_episodes(env, training: Training, policy: str, steps: int) -> int:
    """Plays both side by side; returns how many episodes have ended."""
    rng = np.random.default_rng(5)
    ends = 0
    rows, _ = env.reset()
    training.reset()
    for _ in range(steps):
        np.testing.assert_array_equal(training.array("observation", *training.rows), rows)
        actions = actions_of(env, policy, rng)
        rows, reward, terminated, truncated, info = env.step(actions)
        training.step(actions)
        np.testing.assert_array_equal(training.array("reward", len(reward)), reward)
        ended = terminated | truncated
        ends += np.count_nonzero(ended)
        if ended.any() and "final_obs" in info:
            finals = training.array("final_observation", *training.rows)
            np.testing.assert_array_equal(finals[ended], np.stack(list(info["final_obs"][ended])))
    return ends


@modes
@pytest.mark.parametrize("obs_mode", ["state", "objects"])
@pytest.mark.parametrize("policy", ["random", "oracle"])
@pytest.mark.parametrize(
    "task",
    [
        "ShellGameTouch-VLA-v0",
        "RememberColor3-VLA-v0",
        "TakeItBack-VLA-v0",
        "InterceptSlow-VLA-v0",
        "FindImposterShape3-VLA-v0",
    ],
)
def test_episodes_are_those_of_the_wrappers(task, policy, obs_mode, mode):
    env = wrappers.train(make(task, mode, obs_mode=obs_mode, terminate_on_success=True))
    training = Training(task, mode=mode, obs_mode=obs_mode)
    ends = assert_equal_episodes(env, training, policy, 130)
    assert ends >= (N if mode == "DISABLED" else 2 * N)
    low, high = (training.array(f"action_{end}", 7) for end in ("low", "high"))
    np.testing.assert_array_equal(low, env.single_action_space.low)
    np.testing.assert_array_equal(high, env.single_action_space.high)


@pytest.mark.parametrize("rows", ["state", "objects"])
def test_rows_beside_pictures_are_scaled(rows):
    env = wrappers.train(make(TASK, obs_mode=f"rgb+{rows}", terminate_on_success=True))
    training = Training(TASK, mode="SAME_STEP", obs_mode=f"rgb+{rows}")
    seen, _ = env.reset()
    training.reset()
    for _ in range(3):
        np.testing.assert_array_equal(training.array("observation", *training.rows), seen[rows])
        actions = env.act("oracle")
        seen = env.step(actions)[0]
        training.step(actions)


@pytest.mark.parametrize(
    "options",
    [
        {"gamma": 0.9, "smoothing": 0.3, "still": 2.0, "bonus": 0.5},
        {"gamma": 1.0, "potential": 2.5, "scale_actions": 0, "time_left": 0},
        {"potential": 0.0, "bonus": 0.0, "scale_observations": 0},
    ],
)
@pytest.mark.parametrize("obs_mode", ["state", "objects"])
def test_options_are_those_of_the_wrappers(options, obs_mode):
    batch = make(TASK, obs_mode=obs_mode, terminate_on_success=True)
    training = Training(TASK, mode="SAME_STEP", obs_mode=obs_mode, **options)
    assert assert_equal_episodes(wrappers.train(batch, **options), training, "oracle", 80) >= N


@pytest.mark.skipif(not GYMNASIUM_1, reason="one mode shows it")
@pytest.mark.parametrize("obs_mode", ["state", "objects"])
def test_tasks_in_one_batch_are_those_of_the_wrappers(obs_mode):
    ids = [TASK, "InterceptSlow-VLA-v0", ENDING_TASK]
    batch = make(ids, obs_mode=obs_mode, terminate_on_success=True)
    training = Training(*ids, mode="SAME_STEP", obs_mode=obs_mode, still=1.0)
    env = wrappers.train(batch, still=1.0)
    assert assert_equal_episodes(env, training, "oracle", 70) >= N


def test_tasks_in_python_have_the_preset():
    """Their environments take other paths through the engine, in a group too."""
    (own,) = kit.load_file(ROOT / "python/examples/own_tasks/remember_button.py")
    for ids in ([own], [own, TASK]):
        batch = make(ids if len(ids) > 1 else own, terminate_on_success=True)
        training = Training(*ids, mode="SAME_STEP", obs_mode="state")
        assert assert_equal_episodes(wrappers.train(batch), training, "oracle", 70) > 0
