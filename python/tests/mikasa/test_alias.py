"""engram.mikasa.alias: modules of the original's names, what they refuse, what they never hide."""

from __future__ import annotations

import ast
import json
import subprocess
import sys

import pytest

pytest.importorskip("torch")

from released import run

from engram.mikasa import classes
from engram.mikasa.__main__ import main
from engram.mikasa._original_names import PACKAGES, SOURCES

ALIAS = "import engram.mikasa.alias"
RUNNER = ("-m", "engram.mikasa")


# Forks for each line of standard input, [program, folder, environment], and runs the program there.
WARM = """
import json, os, sys
import torch  # takes seconds; it imports none of the modules that are tested

for line in sys.stdin:
    program, folder, environment = json.loads(line)
    child = os.fork()
    if child == 0:
        os.chdir(folder)
        os.environ.update(environment)
        printed = os.open("printed.txt", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(printed, 1)
        os.dup2(printed, 2)
        exec(program, {"__name__": "__main__"})
        sys.stdout.flush()
        os._exit(0)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


@pytest.fixture(scope="module")
def warm():
    """A Python that has imported torch, and forks for each program."""
    command = [sys.executable, "-c", WARM]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        yield process
        process.stdin.close()


@pytest.fixture
def outcomes(warm, tmp_path):
    """Runs lines after one another in a process; texts of their errors, "" for none."""

    def run_lines(*lines, before=ALIAS, **environment):
        program = f"""
import json, warnings
{before}
texts = []
for line in {lines!r}:
    try:
        exec(line, globals())
        texts.append("")
    except Exception as error:
        texts.append(f"{{type(error).__name__}}: {{error}}")
print(json.dumps(texts))
"""
        print(json.dumps([program, str(tmp_path), environment]), file=warm.stdin, flush=True)
        code = warm.stdout.readline().strip()
        printed = (tmp_path / "printed.txt").read_text()
        assert code == "0", printed
        return json.loads(printed.splitlines()[-1])

    return run_lines


def package(folder, name, text="real = True\n"):
    """An installed package: its folder's parent."""
    (folder / name).mkdir(parents=True)
    (folder / name / "__init__.py").write_text(text)
    return folder


# --- names ---


@pytest.mark.parametrize(
    ("half", "made"), [("vla", classes.CLASSES), ("rl", classes.RL_CLASSES)], ids=["vla", "rl"]
)
def test_modules_of_families_are_those_of_the_wheel(wheel, half, made):
    beginning = f"mikasa_robo_suite/{half}/memory_envs/"
    files = {
        path: wheel.read(path)
        for path in wheel.namelist()
        if path.startswith(beginning) and not path.endswith("__init__.py")
    }
    modules = {path.removesuffix(".py").replace("/", "."): text for path, text in files.items()}
    own = {name for name in SOURCES if name.startswith(beginning.replace("/", "."))}
    assert own == set(modules)
    for module, text in modules.items():
        tree = ast.parse(text).body
        defined = {node.name for node in tree if isinstance(node, ast.ClassDef)}
        registered = {
            node.name for node in tree if isinstance(node, ast.ClassDef) and node.decorator_list
        }
        offered = set(SOURCES[module].names) & set(made)
        assert offered == defined & set(made), module
        assert registered, module
        assert registered <= offered, module


def test_every_offered_name_can_be_imported(outcomes):
    lines = [f"import {module}" for module in SOURCES]
    lines += [f"from {module} import *; from {module} import {', '.join(source.offered())}"
              for module, source in SOURCES.items() if source.offered()]  # fmt: skip
    assert set(outcomes(*lines)) == {""}


def test_names_are_those_of_engram(outcomes):
    lines = (
        "import engram.mikasa as m, engram.mikasa.rl, mikasa_robo_suite, mani_skill.utils",
        "from mikasa_robo_suite import memory_envs",
        "assert memory_envs.RememberColor3VLAEnv is m.RememberColor3VLAEnv",
        "assert memory_envs.ShellGameTouchEnv is m.rl.ShellGameTouchEnv",
        "from mikasa_robo_suite.rl.memory_envs.shell_game_push import ShellGamePushEnv",
        "assert ShellGamePushEnv is m.rl.ShellGamePushEnv",
        "from mikasa_robo_suite.vla.memory_envs.remember_color_vla import RememberColor3VLAEnv",
        "assert RememberColor3VLAEnv is m.RememberColor3VLAEnv",
        "from mani_skill.utils import common, gym_utils",
        "assert common.flatten_state_dict is m.flatten_state_dict",
        "assert 'common' in dir(mani_skill.utils) and 'sapien' not in dir(mani_skill.utils)",
    )
    assert set(outcomes(*lines)) == {""}


def test_what_a_program_changes_counts(outcomes):
    lines = (
        "from unittest import mock",
        "from mikasa_robo_suite.vla import benchmarking",
        "import engram.mikasa.benchmarking as own",
        "before = own.make_benchmark_env",
        "benchmarking.make_benchmark_env = 'mine'",
        "assert own.make_benchmark_env == benchmarking.make_benchmark_env == 'mine'",
        "benchmarking.make_benchmark_env = before",
        "with mock.patch('mikasa_robo_suite.vla.benchmarking.START_SEED', 7): "
        "assert own.START_SEED == 7",
        "assert own.START_SEED == benchmarking.START_SEED == 4242424242",
        "import baselines",
        "baselines.mine = 1",
        "assert baselines.mine == 1",
        "del baselines.mine, benchmarking.CONTROL_MODE",
        "assert not hasattr(own, 'CONTROL_MODE') and not hasattr(baselines, 'mine')",
    )
    assert set(outcomes(*lines)) == {""}


# Lines that are refused, and words of the sentence.
REFUSED = {
    "import mani_skill.agents": [
        "mani_skill.agents: engram.mikasa", "robots are engram's own",
        "of mani_skill it has envs, utils, vector",
    ],
    "from mani_skill.utils.wrappers import FlattenRGBDObservationWrapper": [
        "mani_skill.utils.wrappers.FlattenRGBDObservationWrapper",
        "it has FlattenActionSpaceWrapper, RecordEpisode, flatten, record",
    ],
    "import mikasa_robo_suite.vla.utils.motion_planning.motion_planning_remember_long": [
        "`engram collect` writes",
    ],
    "from mikasa_robo_suite.vla.memory_envs import RememberColour3VLAEnv": [
        "names, BaseEnv to ", "Did you mean RememberColor3VLAEnv?",
    ],
    "import baselines.deepq": ["of baselines it has ppo"],
    "import mani_skill.utils; mani_skill.utils.sapien_utils": [
        "AttributeError: mani_skill.utils.sapien_utils", "it has common, gym_utils",
    ],
    "import mani_skill; mani_skill.__file__": ["AttributeError", "has no __file__"],
}  # fmt: skip


def test_other_names_are_refused_with_those_that_there_are(outcomes):
    for text, (line, words) in zip(outcomes(*REFUSED), REFUSED.items()):
        assert text.startswith("AttributeError" if ";" in line else "ModuleNotFoundError")
        assert all(word in text for word in words), text
        assert len(text) < 1000


# --- installed packages ---


def test_an_installed_package_is_not_hidden(tmp_path, outcomes):
    for name in ("mikasa_robo_suite", "baselines", "mani_skill"):
        place = str(package(tmp_path / f"site of {name}", name))
        lines = (
            f"import sys; sys.path.append({place!r})",
            ALIAS,
            f"import {name}",
            f"assert {name}.real",
        )
        before, refused, *after = outcomes(*lines, before="")
        assert (before, after) == ("", ["", ""])
        assert refused.startswith("BadStateError: engram.mikasa.alias would hide")
        assert f"{name} ({place}/{name}/__init__.py)" in refused
        assert "--force" in refused


def test_an_imported_package_stays(tmp_path, outcomes):
    package(tmp_path, "mani_skill")
    before = "import mani_skill, os; os.environ['ENGRAM_MIKASA_FORCE'] = '1'"
    texts = outcomes(ALIAS, "import mani_skill; assert mani_skill.real", before=before)
    assert "is imported already; import engram.mikasa.alias before it" in texts[0]
    assert texts[1] == ""


def test_a_package_that_is_found_later_is_not_hidden(tmp_path, outcomes):
    place = str(package(tmp_path / "site", "mani_skill"))
    lines = (
        f"import sys; sys.path.insert(0, {place!r})",
        "import mani_skill",
        "import mikasa_robo_suite.vla.benchmarking",
    )
    texts = outcomes(*lines)
    assert texts[1].startswith("ImportError: engram.mikasa.alias would hide mani_skill (")
    assert texts[::2] == ["", ""]


def test_a_folder_without_init_is_no_package(tmp_path, outcomes):
    (tmp_path / "baselines").mkdir()
    assert outcomes("from baselines.ppo import ppo_memtasks") == [""]


def test_force_hides_with_a_warning_and_uninstall_undoes_it(tmp_path, outcomes):
    package(tmp_path, "mani_skill")
    before = f"""
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    {ALIAS}
"""
    lines = (
        "assert ['hides mani_skill (' in str(w.message) for w in caught] == [True]",
        "import mani_skill; assert not hasattr(mani_skill, 'real')",
        "engram.mikasa.alias.uninstall()",
        "import mani_skill; assert mani_skill.real",
        "import mikasa_robo_suite",
        "del __import__('sys').modules['mani_skill']",
        ALIAS,
        "import mikasa_robo_suite",
    )
    texts = outcomes(*lines, before=before, ENGRAM_MIKASA_FORCE="1")
    assert texts[4] == "ModuleNotFoundError: No module named 'mikasa_robo_suite'"
    assert set(texts[:4] + texts[5:]) == {""}


def test_ids_that_another_package_registered(outcomes):
    before = """
import gymnasium as gym
gym.register("TakeItBack-VLA-v0", entry_point="mani_skill.utils.registration:make")
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    import engram.mikasa
said = [str(w.message) for w in caught if w.category is RuntimeWarning]
"""
    lines = (
        "assert len(said) == 1, said",
        "assert '1 ids, such as TakeItBack-VLA-v0, were registered by mani_skill' in said[0]",
        "gym.make('TakeItBack-VLA-v0').close()",
    )
    assert outcomes(*lines, before=before) == ["", "", ""]


# --- the command ---

PROGRAM = """
import multiprocessing, os, subprocess, sys

import beside
import mani_skill.utils.common as common


def where(_):
    import mikasa_robo_suite
    return mikasa_robo_suite.__spec__.origin


if __name__ == "__main__":
    child = "import mikasa_robo_suite.vla.benchmarking as b; print(b.START_SEED)"
    child = subprocess.run(
        [sys.executable, "-c", child], cwd=os.path.dirname(__file__), capture_output=True, text=True
    )
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        print(sys.argv[1:], beside.text, child.stdout.split(), pool.map(where, [0]), child.stderr)
    sys.exit(7)
"""


def test_a_program(tmp_path):
    folder = tmp_path / "programs"
    folder.mkdir()
    (folder / "program.py").write_text(PROGRAM)
    (folder / "beside.py").write_text("text = 'beside'\n")
    package(tmp_path, "mani_skill")  # in the current folder, which programs do not import from
    for words in (["programs/program.py"], ["--force", "--", "programs/program.py"]):
        done = run(*RUNNER, *words, "--help", "-m", "x", folder=tmp_path, code=7)
        assert done.stdout.split("\n")[0] == (
            "['--help', '-m', 'x'] beside ['4242424242'] ['engram.mikasa'] "
        )
    done = run(*RUNNER, "-m", "program", "y", folder=folder, code=7)
    assert done.stdout.startswith("['y'] beside")


def test_a_program_beside_an_installed_package(tmp_path):
    package(tmp_path, "mikasa_robo_suite")
    (tmp_path / "program.py").write_text(
        "import engram.mikasa.alias, mikasa_robo_suite as m\nprint(m.__spec__.origin)"
    )
    done = run(*RUNNER, "program.py", folder=tmp_path, code=1)
    assert done.stderr.startswith("engram.mikasa: engram.mikasa.alias would hide mikasa_robo_suite")
    assert done.stderr.count("\n") == 1
    done = run(*RUNNER, "--force", "program.py", folder=tmp_path)
    assert done.stdout == "engram.mikasa\n"
    assert done.stderr.count("UserWarning: engram.mikasa.alias hides mikasa_robo_suite (") == 1


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["--help"], 0, "Runs a Python program that was written for MIKASA-Robo-VLA, unedited"),
        ([], 2, "a PROGRAM, or -m MODULE, is needed"),
        (["-m"], 2, "a PROGRAM, or -m MODULE, is needed"),
        (["none.py"], 2, "PROGRAM: 'none.py' given, a file needed"),
        (["--forced", "none.py"], 2, "unrecognized arguments: --forced"),
        (["-m", "baselines.ppo.ppo_memtasks"], 2, "run the original's file by its path"),
    ],
)
def test_the_command_line(capsys, words, code, text):
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == code
    assert text in " ".join("".join(capsys.readouterr()).split())
    assert not any(name in sys.modules for name in PACKAGES)
