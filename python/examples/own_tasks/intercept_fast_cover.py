"""InterceptFastCover: a ball rolls fast under a cover; stop it on the field where it comes out.

The field is short: a hand that starts when it sees the ball is late. Lane and speed have to be
remembered from the moment before the ball vanished. Over 400 new seeds the oracle succeeds in 100 %
of the episodes, a hand that waits at the cover's end in 24 %, and guesses of lane and speed in 1 %.

No draw is `hidden`: lane and speed follow from four draws, and the ball shows them again when it
comes out.

    python -m engram eval intercept_fast_cover.py:InterceptFastCover-v0 --policy oracle
"""

from __future__ import annotations

import numpy as np

import engram
from engram import kit

BALL_RADIUS = 0.02  # m
ENTRY, EXIT, END = -0.6, 0.1, 0.33  # m: y of the cover's ends, and of the field's
LANES, WIDTH = -0.16, 0.24  # m: x of the middle of all lanes, and how far they reach
STEP = 0.05  # s
ROLLING = 5 / 7  # of the launch's speed is left once the ball rolls
HOVER, GRIP = 0.068, 0.022  # m: heights of the hand that runs along, and that grips
BASE_X, FARTHEST = -0.615, 0.76  # m: the robot's base, and how far the hand goes from there
GAIN = 0.625  # servo() asks for 1.6 times the way to its goal


class InterceptFastCover(engram.Task):
    VELOCITY_RANGE = kit.RealRange(
        0.75, 1.0, low=0.65, high=1.2, unit="m/s", text="speed of the ball's launch, in y"
    )

    guess_rate = 0.013  # of blind(): 39 of 3000 episodes
    memory_type = "Spatial"
    termination = "success_or_failed"
    phases = (("manipulation", "always"),)
    table_ends = True

    def build(self):
        self.ball = self.add_prop(kit.Ball("ball", radius=BALL_RADIUS))
        self.cover = self.add_prop(self.area("cover", ENTRY, EXIT, 0.03, (0.4, 0.4, 0.4)))
        self.field = self.add_prop(self.area("field", EXIT, END, 0.0005, (0.8, 0.1, 0.1)))
        self.draw_real("ball_x", -0.35, -0.05, unit="m", text="where the ball starts")
        self.draw_real("ball_y", -0.9, -0.65, unit="m", text="where the ball starts")
        self.draw_real("velocity_x", 0, 0.05, unit="m/s", text="of the ball's launch")
        self.draw_range("velocity_y", "VELOCITY_RANGE")
        self.add_state("ball_pos", 3, unit="m", text="the ball")
        self.add_state("ball_velocity", 3, unit="m/s", text="of the ball")

    def area(self, name, begin, end, half_height, color):
        size = (WIDTH, (end - begin) / 2, half_height)
        return kit.Box(name, half_size=size, color=color, body="visual", object="part")

    @property
    def ball_pos(self):
        return self.pos_of(self.ball)

    @property
    def velocity(self):
        return self.prop_qvel[:, self.ball, :3]

    def reset(self):
        zero = np.zeros(self.n)
        start = np.stack([self.ball_x, self.ball_y, zero + 2 * BALL_RADIUS], axis=1)
        velocity = np.stack([self.velocity_x, self.velocity_y, zero], axis=1)
        self.place(self.ball, start, awake=True, velocity=velocity)
        self.place(self.cover, (LANES, (ENTRY + EXIT) / 2))
        self.place(self.field, (LANES, (EXIT + END) / 2))

    def is_covered(self):
        y = self.ball_pos[:, 1]
        return (y > ENTRY) & (y < EXIT)

    def advance(self):
        self.covered[:] = self.is_covered() << self.ball

    def evaluate(self):
        y = self.ball_pos[:, 1]
        stopped = kit.length(self.velocity[:, :2]) < 0.1
        self.success[:] = stopped & (y > EXIT) & (y < END)
        self.failed[:] = y >= END

    def reward(self):
        near = 1 - kit.tanh(5 * self.tcp_distance(self.ball_pos))
        return np.where(self.success, 1, 0.5 * near)

    def observe(self):
        return {"ball_pos": self.ball_pos, "ball_velocity": self.velocity}

    # --- scripts ---

    def oracle(self):
        self.catch(self.ball_pos, self.velocity[:, :2])

    def blind(self):
        """Runs along with a ball of a guessed lane and speed."""
        lane, speed = self.uniforms(2).T
        low, high = self.VELOCITY_RANGE
        speed = ROLLING * (low + (high - low) * speed)
        x = LANES + WIDTH * (2 * lane - 1)
        y = self.ball_y + speed * STEP * self.elapsed
        zero = np.zeros(self.n)
        ball = np.stack([x, y, zero + BALL_RADIUS], axis=1)
        self.catch(ball, np.stack([zero, speed], axis=1))

    def sweep(self):
        """Waits behind the cover until the ball comes out."""
        self.servo((LANES, EXIT + 0.05, HOVER), gripper=kit.GRIPPER_OPEN)
        self.catch(self.ball_pos, self.velocity[:, :2], where=self.ball_pos[:, 1] > EXIT)

    def catch(self, ball, velocity, where=True):
        """Runs along above the ball, comes down over it and closes the fingers."""
        tcp = self.tcp_pos
        error = ball[:, :2] - tcp[:, :2]
        command = (STEP * velocity + 0.45 * error) / 0.38
        far = -error[:, 1] > 0.03 + 2.5 * STEP * velocity[:, 1]
        ahead = np.maximum(command[:, 1], (self.meeting_y(ball, velocity) - tcp[:, 1]) / 0.38)
        command[:, 1] = np.where(far, ahead, command[:, 1])

        above = (np.abs(error[:, 1]) < 0.016) & (np.abs(error[:, 0]) < 0.008)
        around = above & (np.abs(error[:, 1]) < 0.014) & (tcp[:, 2] < GRIP + 0.012)
        low = (tcp[:, 2] < 0.05) & (np.abs(error[:, 1]) < 0.03)
        height = np.where(above | low, GRIP, HOVER)
        goal = np.column_stack([tcp[:, :2] + GAIN * command, height])
        gripper = np.where(around, -1, kit.GRIPPER_OPEN)
        holds = self.is_grasping(self.ball)
        self.servo(goal, gripper=gripper, where=~holds & where)
        self.rest(gripper=-1, where=holds)

    def meeting_y(self, ball, velocity):
        """Where the hand can first be above the ball, beyond the cover (n,), m."""
        steps = np.arange(1, 61)
        point = ball[:, None, :2] + STEP * steps[:, None] * velocity[:, None]
        reach = kit.length(point - (BASE_X, 0))
        way = kit.length(point - self.tcp_pos[:, None, :2])
        possible = (reach <= FARTHEST) & (way / 0.033 + 2 <= steps) & (point[..., 1] > EXIT - 0.05)
        first = np.where(possible.any(axis=1), possible.argmax(axis=1), len(steps) - 1)
        return point[self.rows, first, 1]


INSTRUCTION = (
    "Watch the ball until it vanishes under the cover, then stop it on the red field behind it."
)
engram.register_task(InterceptFastCover, "InterceptFastCover-v0", 60, INSTRUCTION, oracle_floor=0.8)
