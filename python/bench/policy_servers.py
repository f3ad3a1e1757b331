#!/usr/bin/env python3
"""Round trips of policies: over pipes, to servers, and over pipes to servers.

    python python/bench/policy_servers.py                 # a table of round trips
    python python/bench/policy_servers.py --rate 50 8     # the canonical tasks, one episode each,
                                                          # from a server with chunks of 8 in 50 ms

A round trip has two images of 224 x 224, state and instruction, and one chunk of 8 actions. The
server answers at once, in a process of its own.
"""

import argparse
import contextlib
import json
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from engram.servers import ServerPolicy

SIDE = 224
ROUNDS = 400
PROTOCOLS = ("openpi", "gr00t", "act")
POLICY = """
import time
import numpy as np

def load(file):
    delay, length = open(file).read().split()
    chunk = np.zeros((1, int(length), 7), np.float32)

    def act(observation):
        time.sleep(float(delay) / 1000)
        return chunk

    return act
"""
PIPE = """
import sys
import numpy as np
from engram.servers.bridge import serve_pipes
chunk = np.zeros((8, 7), np.float32)
sys.exit(serve_pipes(lambda dim: lambda seen: [chunk] * len(seen["first"])))
"""


@contextlib.contextmanager
def server(protocol, delay, length):
    """`engram serve` with a policy that waits; yields its URL."""
    with tempfile.TemporaryDirectory() as folder:
        code, settings = Path(folder, "waiting.py"), Path(folder, "settings")
        code.write_text(POLICY)
        settings.write_text(f"{delay} {length}")
        words = ["--policy", settings, "--loader", f"{code}:load", "--protocol", protocol]
        command = [sys.executable, "-m", "engram", "serve", "--port", "0", *words]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            try:
                yield process.stdout.readline().split()[-1]
            finally:
                process.terminate()


def observation():
    rng = np.random.default_rng(1)
    return {
        "env_id": "RememberColor3-VLA-v0",
        "worker": 0,
        "slot": np.zeros(1, np.int32),
        "episode": np.zeros(1, np.int32),
        "step": np.zeros(1, np.int32),
        "first": np.zeros(1, np.uint8),
        "instruction": ["touch the cube that was shown"],
        "proprio": np.zeros((1, 7), np.float32),
        "rgb": rng.integers(0, 256, (1, SIDE, SIDE, 6), np.uint8),
        "state": None,
    }


def median(ask):
    """Milliseconds: median and 95th percentile."""
    for _ in range(20):
        ask()
    times = []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        ask()
        times.append(1000 * (time.perf_counter() - begin))
    return np.percentile(times, (50, 95))


class Pipe:
    """The simulator's side of the pipe protocol, for one episode."""

    def __init__(self, command):
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
        )
        self.send(1, struct.pack("<9I", 0x4D474E45, 1, 1, SIDE, SIDE, 6, 7, 7, 1))
        self.receive()
        name = b"RememberColor3-VLA-v0"
        self.send(2, struct.pack("<I", len(name)) + name + struct.pack("<I", 0))

    def send(self, kind, body):
        rest = memoryview(struct.pack("<II", kind, len(body)) + body)
        while rest:
            rest = rest[self.process.stdin.write(rest) :]

    def receive(self):
        def read(size):
            data = b""
            while len(data) < size:
                data += self.process.stdout.read(size - len(data))
            return data

        kind, size = struct.unpack("<II", read(8))
        body = read(size)
        assert kind in (1, 4), body
        return body

    def ask(self, seen):
        text = seen["instruction"][0].encode()
        self.send(
            3,
            struct.pack("<4IB", 1, 0, 0, 0, 0)
            + struct.pack("<I", len(text))
            + text
            + seen["proprio"].tobytes()
            + seen["rgb"].tobytes(),
        )
        self.receive()

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def round_trips():
    seen = observation()
    pipe = Pipe([sys.executable, "-c", PIPE])
    yield "pipe", median(lambda: pipe.ask(seen))
    pipe.close()
    for protocol in PROTOCOLS:
        with server(protocol, 0, 8) as url:
            policy = ServerPolicy(url, image=SIDE)
            yield protocol, median(lambda: policy(seen))  # noqa: B023
            policy.close()
            bridge = [sys.executable, "-m", "engram.servers", "bridge", url]
            pipe = Pipe([*bridge, f"--server-image={SIDE}"])
            yield f"pipe and {protocol}", median(lambda: pipe.ask(seen))  # noqa: B023
            pipe.close()


def rate(delay, length, ids, episodes):
    """Episodes an hour of the command, and the share of the time in which the server works."""
    with server("openpi", delay, length) as url:
        words = ["eval", *(ids or ["--canonical"]), f"--episodes={episodes}", "--json"]
        words += ["--policy-server", url, f"--server-image={SIDE}"]
        command = [sys.executable, "-m", "engram", *words]
        begin = time.perf_counter()
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        seconds = time.perf_counter() - begin
    lengths = [n for task in json.loads(done.stdout)["tasks"] for n in task["episode_lengths"]]
    questions = sum(-(-n // length) for n in lengths)
    print(
        f"{len(lengths)} episodes, {sum(lengths)} steps, {questions} questions in {seconds:.1f} s: "
        f"{3600 * len(lengths) / seconds:.0f} episodes an hour; the server works "
        f"{100 * questions * delay / 1000 / seconds:.0f} % of the time"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rate", nargs=2, type=int, metavar=("MS", "ACTIONS"))
    parser.add_argument("--episodes", type=int, default=1, help="of each task")
    parser.add_argument("ids", nargs="*")
    args = parser.parse_args()
    if args.rate:
        rate(*args.rate, args.ids, args.episodes)
        return
    print("round trip with two images of 224 x 224, ms: median, 95 %")
    for name, (half, most) in round_trips():
        print(f"{name:18} {half:6.2f} {most:6.2f}")


if __name__ == "__main__":
    main()
