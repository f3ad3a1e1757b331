#!/usr/bin/env python3
"""A policy for `engram eval --policy-command`: what a policy process has to do, in full.

    engram eval RememberColor3-VLA-v0 --policy-command "python3 python/examples/pipe_policy.py"

`engram record` takes it, too, and shows what it does.

Replace `act` with a model. Standard output belongs to the protocol (docs/evaluation.md): print to
standard error only. Needs nothing but Python 3; the arrays are memory views, which numpy.asarray
and torch.frombuffer take without a copy.
"""

import math
import struct
import sys

HELLO, TASK, REQUEST, CHUNKS, FAILED = 1, 2, 3, 4, 5
MAGIC, VERSION = 0x4D474E45, 1
RGB, STATE, OBJECTS = 1, 2, 3  # observations of a policy


def act(task, request):
    """A chunk of K actions for each episode that needs one: its shape and its numbers.

    This one moves as a function of observations and instruction: short, not good.
    """
    chunks = []
    for i in range(request["count"]):
        height = request["proprio"][i, 2]
        seen = 0
        if request["rgb"] is not None:
            seen = sum(request["rgb"][i, 64, x, 0] for x in range(0, 128, 8)) / (16 * 255)
        elif request["state"] is not None:
            values = [request["state"][i, j] for j in range(request["state"].shape[1])]
            seen = sum(min(abs(value), 1) for value in values) / len(values)
        angle = 6.28 * seen + len(request["instruction"][i])
        action = [0.3 * math.cos(angle), 0.3 * math.sin(angle), 0.1 - height, 0, 0, 0, 1]
        chunks.append(((4, 7), action * 4))
    return chunks


class Reader:
    """Takes values from the body of a message, one after another."""

    def __init__(self, body):
        self.body, self.at = memoryview(body), 0

    def take(self, size):
        self.at += size
        return self.body[self.at - size : self.at]

    def array(self, kind, *shape):  # kind: I uint32, i int32, f float32, B uint8
        part = self.take(math.prod(shape) * struct.calcsize(kind))
        return part.cast("B").cast(kind, shape) if part else part

    def number(self):
        return struct.unpack("<I", self.take(4))[0]

    def text(self):
        return bytes(self.take(self.number())).decode()


def read(size):
    data = sys.stdin.buffer.read(size)
    if len(data) < size:
        sys.exit(0)  # engram is done
    return data


def send(kind, body):
    sys.stdout.buffer.write(struct.pack("<II", kind, len(body)) + body)
    sys.stdout.buffer.flush()


def greet(message):
    names = [
        "magic",
        "version",
        "observes",
        "height",
        "width",
        "channels",
        "proprio",
        "action",
        "max_slots",
    ]
    hello = {name: message.number() for name in names}
    if (hello["magic"], hello["version"]) != (MAGIC, VERSION):
        sys.exit("pipe_policy: another version of the protocol")
    send(HELLO, struct.pack("<II", MAGIC, VERSION))
    return hello


def read_task(message):
    """Id, size of the state's row, and the seed of the policy's own random numbers."""
    task, state_dim = message.text(), message.number()
    policy_seed = struct.unpack("<Q", message.take(8))[0] if message.at < len(message.body) else 0
    return task, state_dim, policy_seed


def read_request(message, hello, state_dim, policy_seed):
    count = message.number()
    request = {"count": count, "policy_seed": policy_seed}
    for name in ("slot", "episode", "step"):
        request[name] = message.array("i", count)
    request["first"] = message.array("B", count)
    request["instruction"] = [message.text() for _ in range(count)]
    request["proprio"] = message.array("f", count, hello["proprio"])
    request["rgb"] = request["state"] = None
    if hello["observes"] == RGB:
        image = (hello["height"], hello["width"], hello["channels"])
        request["rgb"] = message.array("B", count, *image)
    elif hello["observes"] in (STATE, OBJECTS):
        request["state"] = message.array("f", count, state_dim)
    return request


def main():
    hello, task, state_dim, policy_seed = None, "", 0, 0
    while True:
        kind, size = struct.unpack("<II", read(8))
        message = Reader(read(size))
        if kind == HELLO:
            hello = greet(message)
        elif kind == TASK:
            task, state_dim, policy_seed = read_task(message)
        elif kind == REQUEST:
            request = read_request(message, hello, state_dim, policy_seed)
            answer = struct.pack("<I", request["count"])
            for shape, numbers in act(task, request):
                answer += struct.pack(f"<{1 + len(shape)}I", len(shape), *shape)
                answer += struct.pack(f"<{len(numbers)}f", *numbers)
            send(CHUNKS, answer)


if __name__ == "__main__":
    main()
