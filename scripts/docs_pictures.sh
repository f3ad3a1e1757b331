#!/usr/bin/env bash
# Draws the sheets of docs/tasks again, or those that are named: docs_pictures.sh [NAME...].
# ENGRAM names the command, default build/release/engram.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

engram=${ENGRAM:-build/release/engram}
wanted=" $* "

# sheet NAME ID ARGS...: docs/pictures/tasks/NAME.png, an episode of ID that the oracle plays.
sheet() {
  local name=$1
  shift
  if [ "$wanted" = "  " ] || [[ $wanted == *" $name "* ]]; then
    "$engram" record "$@" --out "docs/pictures/tasks/$name.png"
  fi
}

table=(--camera base --size 195)               # what policies see, larger
human=(--camera render --size 190 --overlays)  # the view for people

mkdir -p docs/pictures/tasks
sheet remember RememberShapeAndColor3x3-VLA-v0 "${table[@]}" --seed 3 --pin cue_steps=3 --pin empty_steps=3 --pin target=2 --at 0,4,6,9,12,25
sheet find_imposter FindImposterColor5-VLA-v0 "${table[@]}" --seed 2 --pin cue_steps=3 --pin empty_steps=3 --at 0,6,25
sheet shell_game ShellGameShuffleTouch-VLA-v0 "${human[@]}" --seed 3 --pin cue_steps=3 --pin shuffle_steps=24 --pin num_swaps=3 --pin swap_pairs=0,2,1,0 --pin cup_with_ball_number=0 --at 0,3,7,15,23,50
sheet shell_game_lamp ShellGameColorLampTouch-VLA-v0 "${human[@]}" --seed 3 --pin cue_steps=3 --at 0,3,20
sheet colors SeqOfColors3-VLA-v0 "${table[@]}" --seed 1 --pin cue_step_duration=3 --pin empty_steps=3 --at 0,3,6,12,22,32,42,54,60
sheet blink_count BlinkCountButtonPressEasy-VLA-v0 "${human[@]}" --seed 1 --pin target_blinks=2 --at 0,10,17,32,40,48
sheet intercept InterceptMedium-VLA-v0 "${human[@]}" --seed 1 --at 0,10,20,24,30,40
sheet intercept_grab InterceptGrabMedium-VLA-v0 "${human[@]}" --seed 1 --at 0,16,30
sheet rotate RotateStrictPos-VLA-v0 "${human[@]}" --seed 1 --at 0,18,36,48,60,80
sheet take_it_back TakeItBack-VLA-v0 "${human[@]}" --seed 1 --at 0,13,17,21,25,29
sheet trace_shape TraceShapeHard-VLA-v0 "${human[@]}" --seed 5 --pin shape=2 --pin pre_demo_steps=4 --at 10,40,66,80,99,109
sheet trace_shape_seq TraceShapeSeqHard-VLA-v0 "${human[@]}" --seed 5 --pin sequence_length=2 --pin shapes=1,2,0,0,0 --pin pre_demo_steps=3 --at 35,100,155,175,196,221
sheet timed_transfer TimedTransferEasy-VLA-v0 "${human[@]}" --seed 0 --at 0,2,17,60,97,99
sheet gather_and_recall GatherAndRecall3-VLA-v0 "${human[@]}" --seed 0 --pin flash_trigger_count=2 --pin flash_color=1 --at 0,54,123,150,192,212
sheet batteries_checker BatteriesCheckerHard-3-VLA-v0 "${human[@]}" --seed 0 --pin working=1 --at 0,30,155,174,187,201
sheet cameras GatherAndRecall3-VLA-v0 --camera all --size 256 --seed 0 --at 30

# Examples of tasks in Python, for which the package has to be installed.
export ENGRAM_PYTHON=${ENGRAM_PYTHON:-$PWD/build/python-env/bin/python}
examples=python/examples/own_tasks
sheet remember_color_sequence "$examples/remember_color_sequence.py:RememberColorSequence3-v0" "${human[@]}" --seed 3 --pin show_steps=4 --pin empty_steps=3 --pin sequence=0,3,4 --pin asked=1 --at 0,4,8,13,18,40
sheet intercept_fast_cover "$examples/intercept_fast_cover.py:InterceptFastCover-v0" "${human[@]}" --seed 1 --at 0,5,12,20,28,36
sheet keep_track "$examples/keep_track.py:KeepTrack4-v0" "${human[@]}" --seed 5 --at 0,5,10,15,250,270
