"""Draws the sheets of docs/pictures/tasks, or those that are named, by `engram record`.

Custom tasks need an interpreter with the package: ENGRAM_PYTHON, default build/python-env's.
"""

import argparse
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FOLDER = ROOT / "docs" / "pictures" / "tasks"
EXAMPLES = "python/examples/own_tasks"
TABLE = "--camera base --size 195"  # the sensor images that policies see, enlarged
HUMAN = "--camera render --size 190 --overlays"  # the view for people

# Name of a sheet, and an episode that the oracle plays: id, view, seed and pins, steps.
SHEETS = {
    "remember": (
        f"RememberShapeAndColor3x3-VLA-v0 {TABLE} --seed 3 --pin cue_steps=3 --pin empty_steps=3 "
        "--pin target=2 --at 0,4,6,9,12,25"
    ),
    "find_imposter": (
        f"FindImposterColor5-VLA-v0 {TABLE} --seed 2 --pin cue_steps=3 --pin empty_steps=3 "
        "--at 0,6,25"
    ),
    "shell_game": (
        f"ShellGameShuffleTouch-VLA-v0 {HUMAN} --seed 3 --pin cue_steps=3 --pin shuffle_steps=24 "
        "--pin num_swaps=3 --pin swap_pairs=0,2,1,0 --pin cup_with_ball_number=0 "
        "--at 0,3,7,15,23,50"
    ),
    "shell_game_lamp": (
        f"ShellGameColorLampTouch-VLA-v0 {HUMAN} --seed 3 --pin cue_steps=3 --at 0,3,20"
    ),
    "colors": (
        f"SeqOfColors3-VLA-v0 {TABLE} --seed 1 --pin cue_step_duration=3 --pin empty_steps=3 "
        "--at 0,3,6,12,22,32,42,54,60"
    ),
    "blink_count": (
        f"BlinkCountButtonPressEasy-VLA-v0 {HUMAN} --seed 1 --pin target_blinks=2 "
        "--at 0,10,17,32,40,47"
    ),
    "intercept": f"InterceptMedium-VLA-v0 {HUMAN} --seed 1 --at 0,10,20,24,30,40",
    "intercept_grab": f"InterceptGrabMedium-VLA-v0 {HUMAN} --seed 1 --at 0,16,30",
    "rotate": f"RotateStrictPos-VLA-v0 {HUMAN} --seed 1 --at 0,18,36,48,60,80",
    "take_it_back": f"TakeItBack-VLA-v0 {HUMAN} --seed 1 --at 0,13,17,21,25,29",
    "trace_shape": (
        f"TraceShapeHard-VLA-v0 {HUMAN} --seed 5 --pin shape=2 --pin pre_demo_steps=4 "
        "--at 10,40,66,80,99,109"
    ),
    "trace_shape_seq": (
        f"TraceShapeSeqHard-VLA-v0 {HUMAN} --seed 5 --pin sequence_length=2 "
        "--pin shapes=1,2,0,0,0 --pin pre_demo_steps=3 --at 35,100,155,175,196,221"
    ),
    "timed_transfer": f"TimedTransferEasy-VLA-v0 {HUMAN} --seed 0 --at 0,2,17,60,97,98",
    "gather_and_recall": (
        f"GatherAndRecall3-VLA-v0 {HUMAN} --seed 0 --pin flash_trigger_count=2 "
        "--pin flash_color=1 --at 0,54,123,150,192,212"
    ),
    "batteries_checker": (
        f"BatteriesCheckerHard-3-VLA-v0 {HUMAN} --seed 0 --pin working=1 --at 0,30,155,174,187,201"
    ),
    "cameras": "GatherAndRecall3-VLA-v0 --camera all --size 256 --seed 0 --at 30",
    "remember_color_sequence": (
        f"{EXAMPLES}/remember_color_sequence.py:RememberColorSequence3-v0 {HUMAN} --seed 3 "
        "--pin show_steps=4 --pin empty_steps=3 --pin sequence=0,3,4 --pin asked=1 "
        "--at 0,4,8,13,18,40"
    ),
    "intercept_fast_cover": (
        f"{EXAMPLES}/intercept_fast_cover.py:InterceptFastCover-v0 {HUMAN} --seed 1 "
        "--at 0,5,12,20,28,36"
    ),
    "keep_track": (
        f"{EXAMPLES}/keep_track.py:KeepTrack4-v0 {HUMAN} --seed 5 --at 0,5,10,15,250,270"
    ),
}


def main(given, prog):
    parser = argparse.ArgumentParser(prog=prog, description=__doc__)
    parser.add_argument("--engram", metavar="FILE", default=str(ROOT / "build/release/engram"))
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"default: {', '.join(SHEETS)}")
    options = parser.parse_args(given)
    unknown = [name for name in options.names if name not in SHEETS]
    if unknown:
        parser.error(f"{', '.join(unknown)} given; allowed: {', '.join(SHEETS)}")
    python = str(ROOT / "build/python-env/bin/python")
    env = {"ENGRAM_PYTHON": python, **os.environ}
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in options.names or SHEETS:
        words = [options.engram, "record", *SHEETS[name].split()]
        out = ["--out", str(FOLDER / f"{name}.png")]
        subprocess.run([*words, *out], cwd=ROOT, env=env, check=True)
