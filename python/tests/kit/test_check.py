"""`engram check`: sound tasks pass it, and planted mistakes are found or refused by name."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import engram
from engram import kit

EXAMPLES = Path(__file__).parents[2] / "examples" / "own_tasks"
SOUND = """
import random
import time

import numpy as np

import engram
from engram import kit

TOUCH = (0, 0, 0.037)
KEPT = {"steps": 0, "seen": []}


class Sound(engram.Task):
    COLORS = kit.Integer(3, low=2, high=4, text="cubes")
    CUE_PHASE_STEPS = kit.Steps(1, 3, text="how long the cue is shown")

    frozen_cue = True
    hidden = "target"
    answer = "the first cube that is touched"
    time_to_act = 15

    def build(self):
        self.candidates = self.COLORS
        self.kept = []
        colors = list(kit.COLORS)[: self.COLORS]
        self.cubes = self.add_props(kit.Cube(f"cube_{color}", color=color) for color in colors)
        self.draw_integer("target", 0, self.COLORS - 1, text="the cube to touch")
        self.draw_order("order", self.COLORS, text="where the cubes appear")
        self.draw_range("cue_steps", "CUE_PHASE_STEPS")
        self.remember("touches", text="steps beside the cube")
        self.add_info("nearby", bool, privileged=True, text="the tool is beside the cube")
        self.add_phases(("cue", "cue_steps"), ("empty", 2), "act")
        self.add_state("goal_pos", 3, unit="m", text="where the cube is")

    @property
    def goal(self):
        return self.pos_of(self.cubes[self.target])

    def reset(self):
        pass

    def spots(self):
        return np.array([(0, -0.18), (0, -0.06), (0, 0.06), (0, 0.18)])[self.order]

    def advance(self):
        self.place(self.cubes[self.target], (0, 0), where=self.begins("cue"))
        self.hide(self.cubes, where=self.begins("empty"))
        self.place(self.cubes, self.spots(), where=self.begins("act"))

    def evaluate(self):
        acts = self.in_phase("act")
        self.answer_by_touch(self.pos_of(self.cubes), self.target, 0.05, where=acts)
        self.nearby[:] = self.tcp_distance(self.goal) < 0.1
        self.touches += self.nearby

    def reward(self):
        near = 1 - kit.tanh(10 * self.tcp_distance(self.goal))
        return np.where(self.success, 1, 0.5 * near)

    def observe(self):
        return {"goal_pos": self.goal}

    def oracle(self):
        self.touch_cube(self.target)

    def blind(self):
        self.touch_cube(self.guess(self.COLORS))

    def touch_cube(self, key):
        self.rest()
        self.touch(self.pos_of(self.cubes[key]) + TOUCH, where=self.in_phase("act"))

    def sweep(self):
        self.rest()
        self.tour(self.pos_of(self.cubes) + TOUCH, where=self.in_phase("act"))


engram.register_task(Sound, "Sound-v0", 24, "Touch the cube that was shown.")
"""


def after(method, line):
    """A line more at the beginning of a method."""
    head = f"    def {method}(self):\n"
    return head, head + "".join(f"        {one}\n" for one in line.splitlines())


WRONG = {
    # Randomness and state.
    "numpy_draws": (
        after("reset", "self.touches[:] = np.random.randint(5, size=self.n)"),
        ("self.tcp_distance(self.goal) < 0.1", "self.touches % 2"),
        "episodes", r"second of two runs in one process.*may be random.*np\.random\.randint",
    ),
    "random_module": (
        after("reward", "return np.full(self.n, random.random() * 0.5)"),
        "episodes", r"reward in step 1 .*random\.random",
    ),
    "time": (
        after("observe", "return {'goal_pos': self.goal + time.perf_counter()}"),
        "episodes", r"state field goal_pos .*time\.perf_counter",
    ),
    "module_global": (
        after("reward", "KEPT['steps'] += 1\nreturn np.full(self.n, 0.001 * (KEPT['steps'] % 97))"),
        "episodes", r"reward in step .*columns \(remember\(\)\), not in globals",
    ),
    "object_that_keeps": (
        ("self.kept = []", "self.kept = type('Kept', (), {'n': 0})()"),
        after("reward", "self.kept.n += 1\nreturn np.full(self.n, 0.001 * self.kept.n)"),
        "snapshots", r"saved in step .*reward differs .*columns \(remember\(\)\)",
    ),
    "hash": (
        after("reward", "return np.full(self.n, (hash('cube') % 1000) / 2000)"),
        "episodes", r"reward differs in a fresh process.*hash\(\).*line \d+: hash",
    ),
    "mixed_rows": (
        after("reward", "return np.full(self.n, 0.4 * self.tcp_pos[:, 0].mean())"),
        "episodes", r"reward .* differs in a batch of 1: a method mixes environments",
    ),
    # Leaks.
    "leak_by_colour": (
        after("advance", "self.paint(self.cubes[self.target], 'red', where=self.begins('act'))"),
        "leaks", r"tells draw 'target' .*'cube_\w+' has another colour \(paint\)",
    ),
    "leak_by_position": (
        ("self.spots(), where=self.begins", "self.spots() + 0.01 * self.target[:, None, None], "
         "where=self.begins"),
        "leaks", r"image of base_camera.* tells draw 'target' .* is at another place",
    ),
    "leak_by_emission": (
        after("advance", "self.paint(self.cubes[self.target], None, emission=0.5, "
              "where=self.begins('act'))"),
        "leaks", r"tells draw 'target' .*emits other light \(paint: emission\)",
    ),
    "cue_that_stays": (
        ('self.hide(self.cubes, where=self.begins("empty"))', "pass"),
        "leaks", r"step \d+ tells draw 'target' .*cue ends at step \d+.*is shown in one",
    ),
    "leak_by_info": (
        (", privileged=True", ""),
        ("self.nearby[:] = self.tcp_distance(self.goal) < 0.1", "self.nearby[:] = self.target > 0"),
        "leaks", r"info nearby in step \d+ tells draw 'target' .*privileged=True",
    ),
    "leak_by_object": (
        after("advance", "self.prop_quat[self.rows, self.cubes[self.target]] = (0.8, 0, 0, 0.6)\n"
              "self.moved[self.rows, self.cubes[self.target]] = 1"),
        "leaks", r"tells draw 'target' .*is turned otherwise",
    ),
    "leak_by_reward": (
        ("0.5 * near)", "0.4 * near + 0.02 * self.target)"),
        "leaks", r"reward in step \d+ tells draw 'target' .*before the last phase reward\(\)",
    ),
    # Rewards and success.
    "wrong_shape": (
        after("reward", "return np.zeros((self.n, 2))"),
        "runs", r"step 1 with oracle actions: .*reward: an array of shape \(8, 2\) returned; "
        r"\(8,\) needed.*reset\(\) works again",
    ),
    "wrong_dtype": (
        after("reward", "return np.full(self.n, 'much')"),
        "runs", r"reward: .* returned; an array of numbers needed",
    ),
    "nan_reward": (
        after("reward", "return np.where(self.elapsed == 7, np.nan, 0.1)"),
        "runs", r"step 7 of environment 0 .*: reward\(\) has given a value that is not finite",
    ),
    "great_reward": (
        ("np.where(self.success, 1, 0.5 * near)", "np.where(self.success, 3, near)"),
        "runs", r"normalized reward of 3\.000, more than 1",
    ),
    "reward_without_success": (
        ("0.5 * near)", "1.0 + near)"),
        "runs", r"a step without success has a normalized reward of 1\.",
    ),
    "exception_in_mid_episode": (
        after("advance", "if (self.elapsed == 9).any():\n    raise ZeroDivisionError('by nine')"),
        "runs", r"step 9 with oracle actions: advance\(\), line \d+ of \w+\.py: "
        r"ZeroDivisionError: by nine; step\(\) is refused then .*; reset\(\) works again",
    ),
    "exception_in_reset": (
        after("reset", "self.order[:, 9]"),
        "runs", r"reset: reset\(\), line \d+ of \w+\.py: IndexError: .*reset\(\) raises, too",
    ),
    "in_place_list": (
        after("advance", "self.kept.append(1)"),
        "runs", r"advance\(\), line \d+ of \w+\.py: AttributeError: 'tuple' object has no",
    ),
    "attribute_after_build": (
        after("advance", "self.count = 1"),
        "runs", r"self\.count = \.\.\. after build\(\).*self\.remember\(\"count\"",
    ),
    # Scripts.
    "success_at_the_start": (
        after("evaluate", "self.success[:] = True\nself.nearby[:] = True\nreturn"),
        "scripts", r"zero actions succeed in 64 of 64 episodes: evaluate\(\) finds success",
    ),
    "oracle_that_fails": (
        after("oracle", "self.rest()\nreturn"),
        "scripts", r"oracle\(\) succeeds in 0 of 64 episodes, oracle_floor is 0\.95",
    ),
    "blind_that_knows": (
        ("self.touch_cube(self.guess(self.COLORS))", "self.touch_cube(self.target)"),
        "scripts", r"blind\(\) has success in 64 of 64 .*blind\(\) knows what is hidden",
    ),
    "candidates": (
        ("self.candidates = self.COLORS", "self.candidates = 40"),
        "scripts", r"declared chance is 0\.025: .*or candidates or guess_rate is wrong",
    ),
    "horizon": (
        ("time_to_act = 15", "time_to_act = 1"),
        ('"Sound-v0", 24,', '"Sound-v0", 10,'),
        "scripts", r"oracle\(\) succeeds in .* with twice the time in 100% .*: the horizon, 10",
    ),
    "long_phases": (
        ("time_to_act = 15", "time_to_act = 1"),
        ("kit.Steps(1, 3,", "kit.Steps(1, 20,"),
        "draws", r"with the longest phases \(cue_steps 20\) oracle\(\) succeeds in 0 of",
    ),
    # Places.
    "prop_in_the_table": (
        ("self.place(self.cubes, self.spots(), where",
         "self.place(self.cubes, np.dstack([self.spots(), np.full((self.n, 3), 0.005)]), where"),
        ("(0, 0.18)])[self.order]", "(0, 0.18)])[self.order].astype(float)"),
        "runs", r"prop 'cube_red' overlaps the table by 15 mm in step \d+",
    ),
    "cap_in_the_table": (
        after("build", "self.cap = self.add_prop(kit.ButtonCap('cap'))"),
        after("reset", "self.place(self.cap, (0, 0.3, 0))"),
        "runs", r"prop 'cap' overlaps the table by 14 mm in step 0",
    ),
    "prop_under_another": (
        after("build", "self.ball = self.add_prop(kit.Box('spare', (0.01,) * 3, body='visual'))\n"
                       "self.lid = self.add_prop(kit.Box('lid', (0.05,) * 3, body='visual'))"),
        after("reset", "self.place(self.ball, (0, 0.3))\nself.place(self.lid, (0, 0.3))"),
        "runs", r"prop 'spare' is placed, but is in no picture of any episode",
    ),
    # Constants and draws.
    "constant_that_breaks": (
        ("low=2, high=4", "low=2, high=6"),
        "constants", r"with COLORS = 6 .*IndexError",
    ),
}  # fmt: skip

NOTES = {
    "prop_that_is_never_placed": (
        after("build", "self.add_prop(kit.Sphere('spare', radius=0.02))"),
        "runs", r"prop 'spare' is hidden in every step",
    ),
    "draw_without_use": (
        after("build", "self.draw_real('spare', 0, 1, text='nothing')"),
        "draws", r"draw 'spare' changes nothing",
    ),
    "no_scripts": (
        ("    def sweep(self):", "    def sweeping(self):"),
        "scripts", r"there is no sweep\(\)",
    ),
    "nothing_hidden": (
        ('    hidden = "target"\n', ""),
        "leaks", r"hidden names no draw, although there are candidates",
    ),
}  # fmt: skip

REFUSED = {
    "two_columns_of_a_name": (
        after("build", "self.remember('target', text='again')"),
        r"'target' given, which is declared already",
    ),
    "the_engines_name": (
        after("build", "self.remember('qpos', text='mine')"),
        r"'qpos' given, which is a column of the engine",
    ),
    "two_props_of_a_name": (
        after("build", "self.add_prop(kit.Cube('cube_red'))"),
        r"'cube_red' given; each needs its own",
    ),
    "instruction_as_an_info": (
        after("build", "self.add_info('language_instruction', text='tells')"),
        r"'language_instruction' given, an info that engram has itself",
    ),
    "no_reward": (
        ("    def reward(self):", "    def rewarding(self):"),
        r"load: line \d+ of \w+\.py: .*no method reward\(\)",
    ),
    "hidden_that_is_no_draw": (('hidden = "target"', 'hidden = "goal"'), r"'goal' given.*no draw"),
    "no_time": (("time_to_act = 15", "time_to_act = 22"), r"leave no time to act"),
    "syntax": (("    def build(self):", "    def build(self)"), r"SyntaxError"),
}


def planted(folder, changes):
    """A file with the sound task and some changes."""
    text = SOUND
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file = folder / f"planted_{time.monotonic_ns()}.py"
    file.write_text(text)
    return str(file)


def sentences(report, verdict, check=None):
    return [f"{one.check}: {one.sentence}" for one in report.findings
            if one.verdict == verdict and check in (None, one.check)]  # fmt: skip


def assert_says(report, verdict, check, words):
    found = sentences(report, verdict, check)
    assert any(re.search(words, one) for one in found), found or report.findings
    assert all(len(one) < 800 and "\n" not in one for one in found)


@pytest.mark.parametrize("name", WRONG)
def test_a_planted_mistake_is_found(name, tmp_path):
    *changes, check, words = WRONG[name]
    report = kit.check(planted(tmp_path, changes), fast=True, only=[check])
    assert not report.ok
    assert_says(report, "wrong", check, words)


@pytest.mark.long
@pytest.mark.parametrize("name", WRONG)
def test_a_planted_mistake_is_found_by_all_checks(name, tmp_path):
    *changes, _, _ = WRONG[name]
    assert not kit.check(planted(tmp_path, changes), fast=True).ok


@pytest.mark.parametrize("name", NOTES)
def test_what_is_odd_is_noted(name, tmp_path):
    *changes, check, words = NOTES[name]
    report = kit.check(planted(tmp_path, changes), fast=True, only=[check])
    assert report.ok
    assert_says(report, "note", check, words)


@pytest.mark.parametrize("name", REFUSED)
def test_other_mistakes_are_refused_when_the_file_is_loaded(name, tmp_path):
    *changes, words = REFUSED[name]
    report = kit.check(planted(tmp_path, changes))
    assert_says(report, "wrong", "load", words)


# --- what is sound ---


def test_a_sound_task_passes(tmp_path):
    report = kit.check(planted(tmp_path, []), fast=True)
    assert report.ok, str(report)
    assert [one.check for one in report.findings if one.verdict == "note"] == ["speed"]


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.py")), ids=lambda file: file.stem)
def test_examples_pass(file):
    report = kit.check(str(file), fast=True, only=["runs", "episodes", "snapshots", "leaks"])
    assert report.ok, str(report)


@pytest.mark.long
@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.py")), ids=lambda file: file.stem)
def test_examples_pass_all_checks(file):
    report = kit.check(str(file))
    assert report.ok, str(report)


@pytest.mark.parametrize(
    ("id", "hidden"),
    [
        ("RememberColor3-VLA-v0", "target"),
        ("ShellGameTouch-VLA-v0", "cup_with_ball_number"),
        ("TakeItBack-VLA-v0", ""),
        ("InterceptMedium-VLA-v0", ""),
    ],
)
def test_built_in_tasks_pass_and_tell_what_is_hidden(id, hidden):
    report = kit.check(id, fast=True)
    assert report.ok, str(report)
    assert engram.describe(id)["hidden"] == hidden
    found = next(one for one in report.findings if one.check == "leaks")
    assert (f"draw {hidden!r} alone" if hidden else "hidden names no draw") in found.sentence


# --- Ctrl-C, and the state of a batch ---


LOOP = after(
    "advance",
    "while (self.elapsed == 5).any():\n"
    "    if not KEPT['steps']: print('loops', flush=True)\n"
    "    KEPT['steps'] += 1",
)


def heed_ctrl_c():
    """Where these tests run in the background, a shell lets their processes ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def test_ctrl_c_ends_a_loop_and_the_command_reports_it(tmp_path):
    run = subprocess.Popen(
        [sys.executable, "-m", "engram.kit.checks", planted(tmp_path, [LOOP])],
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=heed_ctrl_c,
    )
    assert run.stdout.readline() == "loops\n"
    run.send_signal(signal.SIGINT)
    out, _ = run.communicate(timeout=60)
    assert run.returncode == 130
    assert re.search(r"runs: .*advance\(\), line \d+ of \w+\.py: interrupted by Ctrl-C", out)


INTERRUPTED = """
import _thread, sys, threading
import engram
from engram import kit

kit.load_file(sys.argv[1])
env = engram.make_vec("Sound-v0", 4, autoreset_mode="DISABLED")
env.reset(seed=0)
threading.Timer(1, _thread.interrupt_main).start()
try:
    for _ in range(10):
        if sys.argv[2] == "halves":
            env.step_async(env.act("oracle"))
            env.step_wait()
        else:
            env.step(env.act("oracle"))
except KeyboardInterrupt:
    print("interrupted")
try:
    env.step(env.act("zero"))
except engram.BadStateError as error:
    print(error)
env.reset(seed=0)
for _ in range(4):
    env.step(env.act("oracle"))
print("goes on")
"""


@pytest.mark.parametrize("way", ["whole", "halves"])
def test_a_batch_survives_ctrl_c(tmp_path, way):
    file = planted(tmp_path, [LOOP])
    words = [sys.executable, "-c", INTERRUPTED, file, way]
    run = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False,
                         preexec_fn=heed_ctrl_c)  # fmt: skip
    loops, *lines = run.stdout.splitlines()
    assert loops == "loops"
    assert lines[0] == "interrupted", run.stderr
    assert "reset" in lines[1]
    assert lines[2] == "goes on"


# --- the command ---


def command(*words):
    run = subprocess.run([sys.executable, "-m", "engram.kit.checks", *words], capture_output=True,
                         text=True, timeout=120, check=False)  # fmt: skip
    return run.returncode, run.stdout, run.stderr


def test_the_command_prints_sentences_and_json(tmp_path):
    file = planted(tmp_path, [after("reward", "return np.zeros((self.n, 2))")])
    code, out, _ = command(file, "--fast", "--only", "runs", "--json")
    document = json.loads(out)
    assert code == 1
    assert not document["ok"]
    [task] = document["tasks"]
    assert task["id"] == "Sound-v0"
    assert [one["verdict"] for one in task["findings"]] == ["wrong"]
    assert set(task["findings"][0]) == {"check", "verdict", "sentence", "figures"}

    code, out, _ = command(planted(tmp_path, []) + ":Sound-v0", "--fast", "--only", "runs")
    assert code == 0
    assert "nothing wrong" in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "required: FILE.py"),
        (("missing.py",), "missing.py: no such file"),
        (("Missing-v0",), "Missing-v0"),
        (("Missing-v0", "--episodes", "1"), "episodes"),
    ],
)
def test_wrong_usage_has_status_2(words, message):
    code, _, err = command(*words)
    assert code == 2
    assert message in err


def test_an_unknown_kind_of_check_is_refused():
    with pytest.raises(engram.InvalidArgumentError, match="only: 'all' given; allowed: runs"):
        kit.check("RememberColor3-VLA-v0", only=["all"])
