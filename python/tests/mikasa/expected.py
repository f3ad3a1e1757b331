"""Results of the original's environments, by family: keys, types and widths."""

from __future__ import annotations

from collections.abc import Iterator

SHARED = "elapsed_steps success language_instruction task_cue oracle_info reward_dict"

# b: bool (B); f: float32 (B); i: int64 (B); 3: float32 (B, 3); c: bool (B, checkpoints)
_TOUCH = "obj_to_goal_pos:3 is_obj_placed:b is_robot_static:b"
_MUG = f"{_TOUCH} mug_max_displacement:f is_mug_displacement_ok:b"
_BUTTON = "button_pressed:b button_pressable:b button_press_depth:f xy_dist_to_button:f"
_CAPACITY = (
    "obj_to_goal_pos:3 is_robot_static:b strong_cube_displacement:b max_cube_displacement_xy:f "
    + _BUTTON
)
_BATTERIES = (
    "action_mask:b cue_mask:b action_stage:i active_battery_idx:i socket_has_battery:b "
    "socket_battery_idx:i socket_has_working:b active_battery_count:i checked_count:i "
    "found_working_count:i target_working_count:i all_checked:b new_insert_event:b "
    "new_return_event:b new_confirm_event:b new_button_press_event:b button_press_depth:f "
    "obj_to_goal_pos:3"
)
INFOS = {
    "RememberColor": _TOUCH,
    "RememberShape": _TOUCH,
    "RememberShapeAndColor": _TOUCH,
    "FindImposterColor": _TOUCH,
    "FindImposterShape": _TOUCH,
    "FindImposterShapeAndColor": _TOUCH,
    "ShellGameColorLampTouch": _TOUCH,
    "ShellGameShuffleColorLampTouch": _TOUCH,
    "ShellGameTouch": _MUG,
    "ShellGameShuffleTouch": _MUG,
    "ShellGamePush": _TOUCH,
    "ShellGamePick": f"{_TOUCH} is_grasped:b",
    "BunchOfColors": _CAPACITY,
    "SeqOfColors": _CAPACITY,
    "ChainOfColors": _CAPACITY,
    "Intercept": "",
    "InterceptGrab": "is_ball_grasped:b is_robot_static:b",
    "RotateLenient": "relative_angle:f y_angle_error:f",
    "RotateStrict": "relative_angle:f y_angle_error:f x_pos_error:f y_pos_error:f",
    "TakeItBack": "goal_achieved:b goal_reached_status:b",
    "TraceShape": "action_mask:b demo_mask:b pre_demo_mask:b visit_fraction:f all_visited:b "
    "is_contour_closed:b start_checkpoint_dist:f checkpoint_visited:c obj_to_goal_pos:3",
    "TraceShapeSeq": "failed_submit:b submitted:b successful_submit_event:b action_mask:b "
    "demo_mask:b pre_demo_mask:b sequence_progress:f all_shapes_closed:b active_shape_idx:i "
    "active_shape_id:i active_visit_fraction:f active_all_visited:b is_active_contour_closed:b "
    f"start_checkpoint_dist:f {_BUTTON} submit_success_latched:b obj_to_goal_pos:3",
    "TimedTransfer": "failed:b too_early:b signal_on:b in_window:b before_window:b past_window:b "
    "cube_on_red:b cube_to_red_dist:f is_grasped:b obj_to_goal_pos:3",
    "GatherAndRecall": "failed:b n_on_disc:i all_on_disc:b flash_active:b flash_triggered:b "
    "flash_color:i pressed_button:i obj_to_goal_pos:3",
    "BlinkCountButtonPress": "failed:b submit_attempted:b submit_success:b action_mask:b "
    "phase_ready:b light_on:b press_count:i raw_press_count:i target_blinks:i "
    "new_raw_press_event:b new_press_event:b new_release_event:b new_confirm_press_event:b "
    "press_ready:b pending_press:b lift_target_z:f at_lift_target:b xy_dist_to_button:f "
    "press_depth:f xy_dist_to_confirm_button:f confirm_press_depth:f obj_to_goal_pos:3",
    "BatteriesCheckerEasy": _BATTERIES,
    "BatteriesCheckerHard": _BATTERIES,
}

# Reward terms that are no floats, with the letters above.
_TARGET_TERMS = "is_robot_static:b reached:b success:b"
_TOUCH_TERMS = 'info["is_obj_placed"]:b is_mug_displacement_ok:b'
_LAMP_TERMS = "is_obj_placed:b"
_CAPACITY_TERMS = (
    "correct_touches:i correct_touches_in_order:i wrong_touches:i touched_cubes:i "
    "sequence_cubes_mask:i is_robot_static:b all_seq_touched:b no_extra_touched:b "
    "strong_cube_displacement:b"
)
_ROTATE_TERMS = "reached_status:b correct_angle:b agent_is_static:b success:b"
REWARD_TERMS = {
    **dict.fromkeys(
        [name for name in INFOS if name.startswith(("Remember", "FindImposter"))], _TARGET_TERMS
    ),
    "ShellGameTouch": _TOUCH_TERMS,
    "ShellGameShuffleTouch": _TOUCH_TERMS,
    "ShellGameColorLampTouch": _LAMP_TERMS,
    "ShellGameShuffleColorLampTouch": _LAMP_TERMS,
    "ShellGamePush": 'info["is_obj_placed"]:b is_robot_static:b reached_status:b',
    "ShellGamePick": 'info["is_obj_placed"]:b info["is_grasped"]:b reached_status:b',
    "BunchOfColors": _CAPACITY_TERMS,
    "SeqOfColors": _CAPACITY_TERMS,
    "ChainOfColors": _CAPACITY_TERMS,
    "Intercept": "reached_status:b",
    "InterceptGrab": "ball_in_gripper:b is_grasped_reward:b robot_static_reward:b success:b "
    "very_close_mask:b",
    "RotateLenient": _ROTATE_TERMS,
    "RotateStrict": f"{_ROTATE_TERMS} position_ok:b",
    "TakeItBack": "goal_achieved:b goal_reached_status:b reached_pull:b reached_push:b",
}

# Answers: type and second dimension (0: none; a text: a constant of the task).
_FLOATS = ("float32", 0)
_TRIPLE = ("float32", 3)
_LIST = ("uint8", "SEQUENCE_LENGTH")
ORACLES = {
    "RotateLenient": _FLOATS,
    "RotateStrict": _FLOATS,
    "TimedTransfer": _FLOATS,
    "Intercept": _TRIPLE,
    "InterceptGrab": _TRIPLE,
    "TakeItBack": _TRIPLE,
    "BunchOfColors": _LIST,
    "SeqOfColors": _LIST,
    "ChainOfColors": _LIST,
    "BatteriesCheckerEasy": ("uint8", "WORKING_BATTERY_COUNT"),
    "BatteriesCheckerHard": ("uint8", "WORKING_BATTERY_COUNT"),
    "TraceShapeSeq": ("int64", 5),
    "RememberShapeAndColor": ("uint8", 2),
    "FindImposterShapeAndColor": ("uint8", 2),
}
CUES = {
    "RotateLenient": ("float16", 0),
    "RotateStrict": ("float16", 0),
    "ShellGameColorLampTouch": ("uint8", 0),
    "ShellGameShuffleColorLampTouch": ("uint8", 0),
    "TraceShapeSeq": ("int64", 5),
}
# Families with both phase lengths, with that of the cue alone; all others have neither.
CUE_AND_EMPTY = [
    "RememberColor",
    "RememberShape",
    "RememberShapeAndColor",
    "FindImposterColor",
    "FindImposterShape",
    "FindImposterShapeAndColor",
    "BunchOfColors",
    "SeqOfColors",
    "ChainOfColors",
    "ShellGameShuffleTouch",
    "ShellGameShuffleColorLampTouch",
    "BlinkCountButtonPress",
]
CUE_ALONE = [
    "ShellGameTouch",
    "ShellGamePush",
    "ShellGamePick",
    "ShellGameColorLampTouch",
    "TraceShape",
    "TraceShapeSeq",
]


def term_types(family: str) -> Iterator[tuple[str, str]]:
    """Names of a family's reward terms that are no floats, each with the letter of its type."""
    for entry in REWARD_TERMS.get(family, "").split():
        name, kind = entry.split(":")
        yield name, kind


def own_infos(family: str) -> Iterator[tuple[str, str]]:
    """Names of a family's own infos, each with the letter of its type."""
    for entry in INFOS[family].split():
        name, kind = entry.split(":")
        yield name, kind
