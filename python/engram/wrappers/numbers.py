"""Numbers of the preset for training."""

from __future__ import annotations

import math

# begin generated: numbers (tools/surface, from api/surface.toml)
# Shares of the largest motions that an action of 1 is: translation, rotation and gripper of
# pd_ee_delta_pose.
POSE_SCALE = (0.3, 0.3, 0.3, 0.1, 0.1, 0.1, 0.5)
# The share of any component of another control mode.
OTHER_SCALE = 0.3
# Unit of lengths in scaled observations, m.
LENGTH = 0.1
# Unit of angles, rad.
ANGLE = 0.5
# Unit of speeds, m/s.
SPEED = 0.5
# Unit of angular velocities, rad/s.
TURN_RATE = 1.0
# Unit of a finger's opening, m.
FINGER = 0.04
# Largest scaled value.
LIMIT = 10.0
# Rest pose of arm and fingers, rad and m.
REST = (0, 0, 0, -2 * math.pi / 3, 0, 2 * math.pi / 3, math.pi / 4, 0.04, 0.04)
# Position of the TCP there, m.
REST_TCP = (-0.0707, 0, 0.318)
# A coordinate of something hidden, m, and more.
HIDDEN = 500.0
# Distance from which on a distance counts in the potential, m: about that of the rest pose to the
# objects, so that the potential hardly jumps when they appear.
RANGE = 0.5
# end generated

# Terms of the task's reward in the potential, with their weights; those that tell when a first
# stage ends and a second one begins; and that of standing still, with where the arm has to.
# begin generated: terms
TERMS = {
    "tcp_to_obj_dist": 1.0,
    "tcp_to_hit_pose_dist": 1.0,
    "tcp_to_cube_dist": 1.0,
    "tcp_to_button_dist": 1.0,
    "tcp_push_dist": 1.0,
    "tcp_pull_dist": 1.0,
    "to_grip_dist": 1.0,
    "obj_to_goal_dist": 1.0,
    "place_in_goal_reward": 1.0,
    "place_back_reward": 3.0,
    "place_reward": 5.0,
    "keep_contact_reward": 1.0,
    "y_angle_reward": 5.0,
}
UNTIL = {
    "tcp_to_hit_pose_dist": "reached_status",
    "tcp_push_dist": "goal_reached_status",
    "place_in_goal_reward": "goal_reached_status",
}
SINCE = {
    "tcp_pull_dist": "goal_reached_status",
    "place_back_reward": "goal_reached_status",
    "keep_contact_reward": "goal_reached_status",
}
STILL = "static_reward"
THERE = ("reached", "is_obj_placed", 'info["is_obj_placed"]')
# end generated
