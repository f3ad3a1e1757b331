"""Policy in a process of its own, queried over pipes (docs/evaluation.md has the protocol)."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import struct
import subprocess
import time
from typing import Any

import numpy as np
import numpy.typing as npt

from engram._io import pipe_messages as pipes
from engram.datasets.checks import printable
from engram.servers.limits import IDENTITY

_LARGEST = 64 << 20  # bytes of an answer
_LONGEST_FAILURE = 2000  # bytes of a reported failure that are read
_SLICE = 0.1  # seconds between looks at the deadline, which may be brought forward
_MOST_DIMENSIONS = 3
_SHUTDOWN_SECONDS = 2
_DIM = 7

Actions = npt.NDArray[np.float32]


class PolicyError(Exception):
    """The process ended, was too slow, sent an invalid answer or reported a failure."""


class PolicyProcess:
    """Acts in a batch; requests a chunk of actions when those of the last one are used up.

    Args:
        command: For /bin/sh.
        obs: Observation mode of the batches, "rgb", "objects" or "state".
        num_envs: Most environments of a batch.
        timeout: Seconds for every answer, its request included.

    The process is started, and greeted with the first request.
    """

    def __init__(self, command: str, obs: str, num_envs: int, timeout: float) -> None:
        self._timeout = timeout
        self._obs = obs
        self._queues: list[list[Actions]] = []
        self._steps = np.zeros(0, np.int32)
        self._episode = -1
        self._task = ""
        self._num_envs = num_envs
        self._deadline = 0.0
        self._busy = False  # an answer is waited for
        self._deadline_shortened = False
        self._greeted = False
        self._process = subprocess.Popen(
            command,
            shell=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            bufsize=0,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._input = self._process.stdin.fileno()
        self._output = self._process.stdout.fileno()
        for pipe in (self._input, self._output):
            os.set_blocking(pipe, False)

    def shorten_deadline(self, seconds: float) -> None:
        """Brings the deadline of the answer that is waited for forward; from any thread."""
        if self._busy:
            self._deadline_shortened = True
            self._deadline = min(self._deadline, time.monotonic() + seconds)

    def act(self, env: Any, first: bool) -> Actions:
        """The actions of all environments of a batch; `first`: its episodes have just begun."""
        if first:
            self._begin(env)
        views = env._views
        running = ~(views["terminated"] | views["truncated"])
        waiting = [i for i in range(env.num_envs) if running[i] and not self._queues[i]]
        if waiting:
            self._ask(env, waiting)
        actions = np.zeros((env.num_envs, _DIM), np.float32)
        for i in np.flatnonzero(running):
            actions[i] = self._queues[i].pop(0)
        self._steps[running] += 1
        return np.clip(actions, -1, 1)

    def close(self) -> None:
        """Ends the process and its children."""
        self._input = self._output = -1  # their numbers may be given to other files
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()
        end = time.monotonic() + _SHUTDOWN_SECONDS
        while self._exit() is None and time.monotonic() < end:
            time.sleep(0.01)
        # Until the process is waited for, no other group has its number.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    # --- requests ---

    def _begin(self, env: Any) -> None:
        self._queues = [[] for _ in range(env.num_envs)]
        self._steps = np.zeros(env.num_envs, np.int32)
        self._episode += 1

    def _ask(self, env: Any, waiting: list[int]) -> None:
        """One request and its answer, within the timeout."""
        self._deadline = time.monotonic() + self._timeout
        self._deadline_shortened = False
        self._busy = True
        try:
            if not self._greeted:
                self._greet()
                if not self._deadline_shortened:
                    self._deadline = time.monotonic() + self._timeout
            if env.task_id != self._task:
                self._task = env.task_id
                size = 0 if self._obs == "rgb" else env._batch.state_dim
                self._send(pipes.TASK, pipes.packed_text(env.task_id) + struct.pack("<I", size))
            self._request(env, waiting)
        finally:
            self._busy = False

    def _greet(self) -> None:
        image = (128, 128, 6) if self._obs == "rgb" else (0, 0, 0)
        fields = (pipes.OBSERVES[self._obs], *image, 7, _DIM, self._num_envs)
        self._send(pipes.HELLO, pipes.SIGNATURE + struct.pack("<7I", *fields))
        if self._receive(pipes.HELLO) != pipes.SIGNATURE:
            raise PolicyError("the process did not answer the greeting as a policy does")
        self._greeted = True

    def _request(self, env: Any, waiting: list[int]) -> None:
        count = len(waiting)
        views = env._views
        instructions = env.instructions
        row, source = ("rgb", "rgb") if self._obs == "rgb" else ("state", "observation")
        steps = self._steps[waiting]
        request = {
            "slot": np.array(waiting),
            "episode": np.full(count, self._episode),
            "step": steps,
            "first": steps == 0,
            "instruction": [instructions[i] for i in waiting],
            "proprio": views["proprio"][waiting],
            row: views[source][waiting],
        }
        self._send(pipes.REQUEST, pipes.packed_request(request))
        for i, chunk in zip(waiting, _chunks(self._receive(pipes.CHUNKS), count)):
            self._queues[i] = list(chunk)

    # --- pipes ---

    def _send(self, kind: int, body: bytes) -> None:
        rest = memoryview(pipes.packed(kind, body))
        while rest:
            self._wait(self._input, select.POLLOUT)
            try:
                rest = rest[os.write(self._input, rest) :]
            except BlockingIOError:
                continue
            except OSError:
                raise self._ended() from None

    def _receive(self, expected: int) -> bytes:
        kind, size = struct.unpack("<2I", self._read(8))
        if kind == pipes.IDENTITY and size <= IDENTITY:
            self._read(size)
            kind, size = struct.unpack("<2I", self._read(8))
        if kind == pipes.FAILED:  # the beginning is enough
            words = self._read(min(size, _LONGEST_FAILURE)).decode(errors="backslashreplace")
            raise PolicyError(f"the policy reported a failure: {printable(words)}")
        if kind != expected or size > _LARGEST:
            raise PolicyError(
                f"the policy answered with message {kind} of {size} bytes; {expected} of at most "
                f"{_LARGEST} needed"
            )
        return self._read(size)

    def _read(self, size: int) -> bytes:
        body = bytearray()
        while len(body) < size:
            self._wait(self._output, select.POLLIN)
            try:
                part = os.read(self._output, min(size - len(body), 1 << 20))
            except BlockingIOError:
                continue
            except OSError:
                part = b""
            if not part:
                raise self._ended()
            body += part
        return bytes(body)

    def _wait(self, pipe: int, event: int) -> None:
        """Waits until the pipe takes or gives something, no longer than the deadline."""
        poll = select.poll()
        poll.register(pipe, event)
        while True:
            # Before the pipe: one that takes or gives a byte now and then is late all the same.
            left = self._deadline - time.monotonic()
            if left <= 0:
                raise PolicyError(f"the policy did not answer within {self._timeout:g} s")
            ended = self._exit() is not None  # before the pipe, whose last bytes are still read
            if poll.poll(0 if ended else 1000 * min(left, _SLICE)):
                return
            if ended:
                raise self._ended()

    def _exit(self) -> Any:
        """How the process has ended; None while it runs. It stays for `wait`."""
        return os.waitid(os.P_PID, self._process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)

    def _ended(self) -> PolicyError:
        for _ in range(100):  # a pipe may close a moment before the process is gone
            found = self._exit()
            if found is not None:
                how = "with exit code" if found.si_code == os.CLD_EXITED else "by signal"
                return PolicyError(f"the policy's process has ended {how} {found.si_status}")
            time.sleep(0.01)
        return PolicyError("the policy's process has closed its standard input or output")


def _chunks(body: bytes, count: int) -> list[Actions]:
    """One array (K, 7) for each of `count` episodes."""
    reader = pipes.Reader(body)
    try:
        given = reader.number()
        if given != count:
            raise PolicyError(f"the policy answered for {given} episodes, {count} requested")
        chunks = [_chunk(reader) for _ in range(count)]
    except EOFError:
        raise PolicyError("the policy's answer ends too early") from None
    if not reader.at_end:
        raise PolicyError("the policy's answer is longer than its header says")
    return chunks


def _chunk(reader: pipes.Reader) -> Actions:
    dimensions = reader.number()
    if not 1 <= dimensions <= _MOST_DIMENSIONS:
        raise PolicyError(f"the policy's actions have {dimensions} dimensions, 1 to 3 needed")
    shape = tuple(reader.number() for _ in range(dimensions))
    if shape[-1] != _DIM or (dimensions == 3 and shape[0] != 1) or 0 in shape:
        raise PolicyError(
            f"the policy's actions are of shape {shape}; (7), (K, 7) or (1, K, 7) needed"
        )
    chunk = reader.array("<f4", *shape).reshape(-1, _DIM)
    if not np.isfinite(chunk).all():
        raise PolicyError("the policy's actions hold a number that is not finite")
    return chunk.astype(np.float32)
