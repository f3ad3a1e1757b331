"""Tasks in Python on the engine: they behave as built-in ones."""

from __future__ import annotations

import inspect
import sys
import textwrap
from contextlib import closing
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import engram
from engram import kit

EXAMPLES = Path(__file__).parents[2] / "examples" / "own_tasks"
BUILT_IN = "RememberColor9-VLA-v0"
OWN = "MyRememberColor9-v0"
BUTTON = "RememberButton3-v0"
IDS = (OWN, "RememberColorSequence3-v0", "KeepTrack4-v0", BUTTON, "InterceptFastCover-v0")
PLACES = [(x, y) for x in (-0.15, -0.05, 0.05) for y in (-0.15, 0, 0.15)]


@pytest.fixture(scope="module", autouse=True)
def examples():
    ids = [id for file in sorted(EXAMPLES.glob("*.py")) for id in kit.load_file(file)]
    assert set(ids) == set(IDS)


def made(id=OWN, num_envs=8, **options):
    options.setdefault("autoreset_mode", "DISABLED")
    options.setdefault("threads", 2)
    return closing(engram.make_vec(id, num_envs, **options))


def played(id, steps, policy="oracle", seed=3, noise=0.0, **options):
    """Observations, rewards and successes of an episode."""
    rng = np.random.default_rng(5)
    record = []
    with made(id, after_end="hold", **options) as env:
        observation, _ = env.reset(seed=seed)
        record.append(observation.copy())
        for _ in range(steps):
            actions = env.act(policy)
            actions += rng.normal(0, noise, actions.shape).astype(np.float32)
            observation, reward, _, _, info = env.step(actions)
            record += [observation.copy(), reward.copy(), info["success"].copy()]
    return record


def assert_equal(first, second):
    assert len(first) == len(second)
    for one, other in zip(first, second):
        np.testing.assert_array_equal(one, other)


# --- the same task twice ---


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_remember_color_is_like_the_built_in_one(noise):
    pins = {"positions": np.ravel(PLACES), "robot_noise": np.zeros(7)}
    rng = np.random.default_rng(1)
    for target in range(9):
        pins.update(target=target, cue_steps=1 + target % 5, empty_steps=1 + target % 3)
        with made(num_envs=4, pins=pins) as own, made(BUILT_IN, 4, pins=pins) as built_in:
            own.reset(seed=0)
            built_in.reset(seed=0)
            successes = 0
            for _ in range(25):
                actions = built_in.act("oracle")
                actions += rng.normal(0, noise, actions.shape).astype(np.float32)
                first, second = own.step(actions), built_in.step(actions)
                np.testing.assert_allclose(first[1], second[1], rtol=0, atol=1e-6)
                for name in ("success", "answered", "first_answer", "first_answer_correct"):
                    np.testing.assert_array_equal(first[4][name], second[4][name], err_msg=name)
                successes += int(first[4]["success"].sum())
            assert noise > 0 or successes > 0


# --- determinism ---


@pytest.mark.parametrize("id", IDS)
def test_threads_slots_and_batches_do_not_matter(id):
    whole = played(id, 20, num_envs=6, threads=1)
    assert_equal(whole, played(id, 20, num_envs=6, threads=2))
    seeds = list(range(3, 9))
    part = played(id, 20, num_envs=2, seed=seeds[2:4])
    assert_equal([one[2:4] for one in whole], part)


@pytest.mark.parametrize("id", IDS)
def test_snapshots_continue_episodes(id):
    with made(id, 4, after_end="hold") as env:
        env.reset(seed=2)
        for _ in range(12):
            env.step(env.act("oracle"))
        saved = env.save()
        first = [[part.copy() for part in env.step(env.act("oracle"))[:4]] for _ in range(8)]
        env.restore(saved)
        second = [[part.copy() for part in env.step(env.act("oracle"))[:4]] for _ in range(8)]
    for one, other in zip(first, second):
        assert_equal(one, other)


@pytest.mark.parametrize("mode", ["SAME_STEP", "NEXT_STEP"])
def test_environments_are_reset_by_themselves(mode):
    with made(num_envs=4, autoreset_mode=mode) as env:
        env.reset(seed=0)
        ends = 0
        for _ in range(60):
            *_, truncated, _ = env.step(env.act("oracle"))
            ends += int(truncated.sum())
        assert ends == 8


# --- policies ---


def rates(id, policy, episodes=200):
    with made(id, episodes, after_end="hold") as env:
        env.reset(seed=11)
        success = np.zeros(episodes, bool)
        for _ in range(env.description["horizon"]):
            *_, info = env.step(env.act(policy))
            success |= info["success"].astype(bool)
        return success.mean()


@pytest.mark.parametrize("id", IDS)
def test_oracles_solve_and_zero_does_not(id):
    assert rates(id, "oracle") >= (0.8 if "Intercept" in id else 0.95)
    assert rates(id, "zero") <= 0.02


@pytest.mark.parametrize("id", IDS[:4])
def test_guesses_are_at_chance(id):
    chance = 1 / engram.describe(id)["candidates"]
    assert rates(id, "blind") == pytest.approx(chance, abs=0.1)


# --- ways to make them ---


def test_gymnasium_makes_them():
    env = gymnasium.make(f"engram/{OWN}")
    assert env.spec.max_episode_steps == 25
    env.reset(seed=0)
    _, _, _, truncated, info = env.step(env.action_space.sample())
    assert not truncated
    assert "success" in info
    assert env.unwrapped.language_instruction.startswith("Observe the cube")
    env.close()
    assert OWN in [task["id"] for task in engram.list()]


def test_constants_and_variants():
    with made(constants={"COLORS": 3, "CUE_PHASE_STEPS": (2, 2), "max_episode_steps": 40}) as env:
        assert env.description["candidates"] == 3
        assert env.description["horizon"] == 40
    with pytest.raises(engram.InvalidArgumentError, match="no time to act"):
        engram.make_vec(OWN, 1, constants={"CUE_PHASE_STEPS": (1, 30)})
    with pytest.raises(engram.Error, match="did you mean 'COLORS'"):
        engram.make_vec(OWN, 1, constants={"COLOURS": 3})
    engram.register("MyRememberColor4-v0", base=OWN, constants={"COLORS": 4})
    assert engram.describe("MyRememberColor4-v0")["candidates"] == 4


def test_evaluation_and_strict_mode():
    result = engram.evaluate(
        lambda seen: np.zeros((len(seen["episode"]), 7), np.float32), OWN, episodes=4, obs="state"
    )
    assert not any(result["tasks"][0]["successes"])
    with made(task_options={"strict": 1}, num_envs=32, after_end="hold") as env:
        env.reset(seed=0)
        failed = np.zeros(32, bool)
        for _ in range(25):
            *_, info = env.step(env.act("blind"))
            failed |= info["failed"].astype(bool)
        assert failed.mean() > 0.5


def test_pictures_and_objects():
    with made(num_envs=2, obs_mode="rgb") as env:
        observation, _ = env.reset(seed=0)
        assert observation["rgb"].any()
    with made(num_envs=2, obs_mode="objects") as env:
        env.reset(seed=0)


# --- buttons and choices ---


def test_caps_sink_under_the_tool_and_rise_again():
    with made(BUTTON, num_envs=6, pins={"target": [1]}, after_end="hold") as env:
        env.reset(seed=0)
        fields = [one["name"] for one in env.description["state_fields"]]
        depth = env.description["state_fields"][fields.index("depth")]["offset"]
        sunk = []
        for _ in range(40):
            observation, *_, info = env.step(env.act("oracle"))
            sunk.append(observation[:, depth : depth + 3].copy())
            if info["success"].all():
                break
        assert info["success"].all()
        sunk = np.array(sunk)
        assert not sunk[0].any()
        assert (sunk[-1][:, 1] >= 0.35 * 0.014).all()
        assert sunk.max() <= np.float32(0.014)
        assert not sunk[:, :, [0, 2]].any()


def test_a_list_of_answers_asks_for_one():
    assert engram.describe(BUTTON)["choices"]["choices"][0] == "the left button"
    for right in (True, False):
        with made(BUTTON, num_envs=4, pins={"target": [2]}, after_end="hold") as env:
            env.reset(seed=3)
            for i in range(4):
                env.ask(i)
            answered = np.zeros(4, bool)
            for step in range(60):
                for i in range(4):
                    question = env.question(i)
                    if question["due"] and not answered[i]:
                        assert question["question"] == "Which button is to be pressed?"
                        assert step >= 2
                        text = engram.describe(BUTTON)["choices"]["choices"][2 if right else i % 2]
                        env.answer([question["choices"].index(text)], i)
                        answered[i] = True
                *_, info = env.step(env.act("blind"))
            assert answered.all()
            assert info["answered"].all()
            assert (info["first_answer_correct"] == right).all()
            expected = np.full(4, 2) if right else np.arange(4) % 2
            np.testing.assert_array_equal(info["first_answer"], expected)


def test_answers_by_name_are_evaluated():
    result = engram.evaluate(choices=lambda question: 0, ids=BUTTON, episodes=30, obs="objects")
    assert result["tasks"][0]["sr"] == pytest.approx(1 / 3, abs=0.25)


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        ({"choices": ("one", "two")}, "a question, needed"),
        ({"question": "Which?", "choices": ("one",)}, "two or more"),
        ({"question": "Which?", "choices": ("one", "one")}, "'one' given twice"),
        ({"question": "Which?", "choices": ("one", "two"), "choice_count": 3}, "choice_count"),
        ({"question": "Which?", "choices": ("one", "two"), "blind": engram.Task.blind}, "blind"),
    ],
)
def test_lists_of_answers_that_cannot_be_are_refused(facts, message):
    with pytest.raises(engram.InvalidArgumentError, match=message):
        register(**{"blind": lambda t: t.rest(), **facts})


# --- mistakes ---


def register(**methods):
    methods = {
        "evaluate": lambda t: None,
        "reward": lambda t: np.zeros(t.n),
        "oracle": lambda t: t.rest(),
        **methods,
    }
    engram.register_task(type("Mistaken", (engram.Task,), methods), "Mistaken-v0", 10, "Do it.")


def test_exceptions_come_out_of_step_and_reset_with_their_traceback():
    def advance(self):
        if (self.elapsed == 3).any():
            raise ZeroDivisionError("in the third step")

    register(advance=advance)
    with made("Mistaken-v0", 2) as env:
        env.reset(seed=0)
        for _ in range(2):
            env.step(env.act("oracle"))
        with pytest.raises(ZeroDivisionError, match="third step") as raised:
            env.step(np.zeros((2, 7), np.float32))
        assert "advance" in [entry.name for entry in raised.traceback]
        with pytest.raises(engram.BadStateError):
            env.step(np.zeros((2, 7), np.float32))
        env.reset(seed=0)
        env.step(np.zeros((2, 7), np.float32))


def test_an_id_can_be_registered_again():
    register()
    assert engram.describe("Mistaken-v0")["family"] == "Mistaken"
    old = engram.make_vec("Mistaken-v0", 2)

    def build(self):
        self.candidates = 5

    register(build=build)
    assert engram.describe("Mistaken-v0")["candidates"] == 5
    old.reset(seed=0)
    assert old.description["candidates"] == 1
    old.close()


@pytest.mark.parametrize(
    ("register", "message"),
    [
        (lambda: engram.register_task(object, "X-v0", 3, ""), "cls: <class 'object'> given"),
        (lambda: engram.register_task(engram.Task, "X-v0", 3, ""), "derived from engram.Task"),
        (lambda: register(reward=engram.Task.reward), "Mistaken has no method reward"),
        (lambda: register(build=lambda t: t.remember("n")), "'n' given, which is a column"),
    ],
)
def test_what_cannot_be_registered_is_refused(register, message):
    with pytest.raises(engram.InvalidArgumentError, match=message):
        register()


def test_files_can_be_loaded_again(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    file = tmp_path / "spare_tasks.py"
    text = (EXAMPLES / "remember_color.py").read_text()
    file.write_text(text.replace(OWN, "Spare-v0"))
    assert kit.load_file(file) == ["Spare-v0"]
    assert sys.modules["spare_tasks"].__file__ == str(file)
    file.write_text(text.replace(OWN, "Spare-v0").replace("horizon=25", "horizon=30"))
    assert kit.load_file(str(file)) == ["Spare-v0"]
    assert engram.describe("Spare-v0")["horizon"] == 30


def test_the_example_of_the_class_works():
    """The code in the docstring of engram.Task."""
    text = inspect.getdoc(engram.Task)
    block = text[text.index("class TouchRed") - 4 : text.index("**Arrays.**")]
    code = textwrap.dedent(block)
    exec(code, {"engram": engram, "kit": kit, "np": np})
    assert rates("TouchRed-v0", "oracle") >= 0.95
    assert rates("TouchRed-v0", "zero") <= 0.1
