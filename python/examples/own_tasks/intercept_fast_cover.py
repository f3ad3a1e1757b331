"""InterceptFastCover: a ball rolls fast under a cover; meet it where it comes out.

As InterceptFast, but for most of its way the ball is under a cover. When it comes out there is
little time left, so that the hand has to be on its way already: lane and speed have to be
remembered from the moment before the ball vanished.

    python -m engram eval intercept_fast_cover.py:InterceptFastCover-v0 --policy oracle
"""

from __future__ import annotations

import numpy as np

import engram
from engram import kit

BALL_RADIUS = 0.02  # m
GOAL_RADIUS = 0.1
COVER_HALF_SIZE = (0.22, 0.3, 0.03)
COVER_POS = (-0.18, -0.28, 0.03)
ROLLING = 5 / 7  # of the launch's speed is left once the ball rolls
STEP = 0.05  # s
HOVER, GRIP = 0.068, 0.022  # m: heights of the hand that runs along, and that grips
BASE_X, FARTHEST = -0.615, 0.76  # m: the robot's base, and how far the hand goes from there
GAIN = 0.625  # servo() asks for 1.6 times the way to its goal


class InterceptFastCover(engram.Task):
    VELOCITY_RANGE = kit.RealRange(
        0.75, 1.0, low=0.3, high=1.2, unit="m/s", text="speed of the ball's launch, in y"
    )

    memory_type = "Spatial"
    success_reward = 30.0
    hidden = "velocity_y"
    table_ends = True

    def build(self):
        self.ball = self.add_prop(kit.Ball("ball", radius=BALL_RADIUS))
        self.goal_disc = self.add_prop(kit.TargetDisc("goal", radius=GOAL_RADIUS, color="red"))
        self.cover = self.add_prop(
            kit.Box("cover", half_size=COVER_HALF_SIZE, color=(0.4, 0.4, 0.4), body="visual",
                    object="part")
        )  # fmt: skip
        self.draw_real("ball_x", -0.35, -0.05, unit="m", text="where the ball starts")
        self.draw_real("ball_y", -0.9, -0.65, unit="m", text="where the ball starts")
        self.draw_real("velocity_x", 0, 0.05, unit="m/s", text="of the ball's launch")
        self.draw_range("velocity_y", "VELOCITY_RANGE")
        self.draw_real("goal_y", 0.1, 0.2, unit="m", text="where the target lies")
        self.remember("reached", bool, text="the hand was once behind the ball")
        self.remember("caught", bool, text="the hand held the ball")
        self.add_state("ball_pos", 3, unit="m", text="the ball")
        self.add_state("ball_velocity", 3, unit="m/s", text="of the ball")
        self.add_state("goal_pos", 3, unit="m", text="centre of the target")

    phases = (("manipulation", "always"),)

    @property
    def ball_pos(self):
        return self.pos_of(self.ball)

    @property
    def goal(self):
        return self.pos_of(self.goal_disc)

    def reset(self):
        zero = np.zeros(self.n)
        start = np.stack([self.ball_x, self.ball_y, zero + 2 * BALL_RADIUS], axis=1)
        velocity = np.stack([self.velocity_x, self.velocity_y, zero], axis=1)
        self.place(self.ball, start, awake=True, velocity=velocity)
        self.place(self.goal_disc, np.stack([self.ball_x + 0.2, self.goal_y], axis=1))
        self.place(self.cover, COVER_POS)
        self.cue_end[:] = self.horizon

    def is_covered(self):
        inside = np.abs(self.ball_pos - COVER_POS) < COVER_HALF_SIZE
        return inside[:, 0] & inside[:, 1]

    def advance(self):
        self.covered[:] = self.is_covered() << self.ball

    def evaluate(self):
        away = kit.distance(self.ball_pos[:, :2], self.goal[:, :2])
        self.success[:] = away < GOAL_RADIUS

    def reward(self):
        from_goal = self.ball_pos - self.goal
        behind = (BALL_RADIUS + 0.05) * from_goal / kit.length(from_goal)[:, None]
        hit_distance = self.tcp_distance(self.ball_pos + behind)
        self.reached |= hit_distance < 0.04
        place = 1 - kit.tanh(kit.length(from_goal[:, :2]))
        shaped = np.where(self.reached, 5 * place, 2 * (1 - kit.tanh(2 * hit_distance)))
        return np.where(self.success, 30, shaped)

    def observe(self):
        return {
            "ball_pos": self.ball_pos,
            "ball_velocity": self.prop_qvel[:, self.ball, :3],
            "goal_pos": self.goal,
        }

    # --- scripts ---

    def oracle(self):
        self.catch_and_carry(self.ball_pos, self.prop_qvel[:, self.ball, :2])

    def blind(self):
        """Runs along with a ball of a guessed speed while the real one is covered."""
        low, high = self.VELOCITY_RANGE
        speed = ROLLING * (low + (high - low) * self.uniforms(1)[:, 0])
        time = STEP * self.elapsed
        zero = np.zeros(self.n)
        velocity = np.stack([zero, speed], axis=1)
        guessed = np.stack([self.ball_x, self.ball_y + speed * time, zero + BALL_RADIUS], axis=1)
        self.catch_and_carry(guessed, velocity)

    def sweep(self):
        """Waits behind the cover until the ball comes out."""
        self.servo((COVER_POS[0], 0.15, HOVER), gripper=kit.GRIPPER_OPEN)
        seen = ~self.is_covered() & (self.ball_pos[:, 1] > COVER_POS[1])
        self.catch_and_carry(self.ball_pos, self.prop_qvel[:, self.ball, :2], where=seen)

    def catch_and_carry(self, ball, velocity, where=True):
        holds = self.is_grasping(self.ball)
        where = np.broadcast_to(where, self.n)
        self.catch(ball, velocity, where & ~holds)
        at_goal = kit.distance(self.ball_pos[:, :2], self.goal[:, :2]) < 0.07
        carried = self.goal * (1, 1, 0) + (0, 0, BALL_RADIUS + 0.005)
        self.servo(carried, gripper=-1, where=holds & ~at_goal)
        self.rest(gripper=-1, where=holds & at_goal)

    def catch(self, ball, velocity, where):
        """Runs along above the ball, comes down over it and closes the fingers."""
        tcp = self.tcp_pos
        error = ball[:, :2] - tcp[:, :2]
        command = (STEP * velocity + 0.45 * error) / 0.38
        meeting = self.meeting_y(ball, velocity)
        far = -error[:, 1] > 0.03 + 2.5 * STEP * velocity[:, 1]
        ahead = np.maximum(command[:, 1], (meeting - tcp[:, 1]) / 0.38)
        command[:, 1] = np.where(far, ahead, command[:, 1])

        above = (np.abs(error[:, 1]) < 0.016) & (np.abs(error[:, 0]) < 0.008)
        around = above & (np.abs(error[:, 1]) < 0.014) & (tcp[:, 2] < GRIP + 0.012)
        low = (tcp[:, 2] < 0.05) & (np.abs(error[:, 1]) < 0.03)
        height = np.where(above | low, GRIP, HOVER)
        goal = np.column_stack([tcp[:, :2] + GAIN * command, height])
        gripper = np.where(around, -1, kit.GRIPPER_OPEN)
        self.servo(goal, gripper=gripper, where=where)

    def meeting_y(self, ball, velocity):
        """Where the hand can first be above the ball (n,), m."""
        steps = np.arange(1, 61)
        point = ball[:, None, :2] + STEP * steps[:, None] * velocity[:, None]
        reach = kit.length(point - (BASE_X, 0))
        way = kit.length(point - self.tcp_pos[:, None, :2])
        possible = (reach <= FARTHEST) & (way / 0.033 + 2 <= steps)
        first = np.where(possible.any(axis=1), possible.argmax(axis=1), len(steps) - 1)
        return point[self.rows, first, 1]


INSTRUCTION = (
    "Watch the ball until it vanishes under the cover, meet it where it comes out and bring it to "
    "the target."
)
engram.register_task(InterceptFastCover, "InterceptFastCover-v0", 60, INSTRUCTION, oracle_floor=0.8)
