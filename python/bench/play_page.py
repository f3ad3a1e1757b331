#!/usr/bin/env python3
"""Measures `engram play` in a headless Chromium: from key to picture, pictures a second, memory.

    python3 python/bench/play_page.py                   # 60 s at the control rate
    python3 python/bench/play_page.py --seconds 3600    # the soak: memory over an hour

Keys are pressed and lifted by the browser's own input; a latency ends in the animation frame after
the first picture of a step that obeyed the key. Memory is that of the server, its USS where the
system tells it, once a minute or a tenth of the time. Prints one JSON document. Needs Debian's
chromium, and playwright, psutil, aiohttp and pillow from PyPI.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from typing import Any

import psutil
from playwright.sync_api import sync_playwright

TASK = "BatteriesCheckerHard-15-VLA-v0"  # the longest episodes: 4320 steps, 216 s
KEYS = "wdsarfjl"


def share(values: list[float], part: float) -> float:
    return round(sorted(values)[int(part * (len(values) - 1))], 1)


def begin(page: Any) -> None:
    page.focus("#stage")
    if page.inner_text("#run") == "New episode":
        page.keyboard.press("n")
        while page.inner_text("#run") != "Start":
            time.sleep(0.05)
    page.keyboard.press("Enter")


def _busy(processes: list[psutil.Process]) -> float:
    """Seconds of processor time."""
    return sum(sum(one.cpu_times()[:2]) for one in processes if one.is_running())


def measure(page: Any, server: psutil.Process, seconds: float) -> dict[str, Any]:
    latencies: list[float] = []
    gaps: list[float] = []
    memory: list[float] = []
    loads: list[float] = []
    frames = 0
    processes = {"server": [server], "browser": psutil.Process().children(recursive=True)}
    processes["browser"].remove(server)
    before = {name: _busy(them) for name, them in processes.items()}
    end = time.monotonic() + seconds
    due = 0.0
    every = min(60.0, seconds / 10)
    number = 0
    while time.monotonic() < end:
        if page.inner_text("#run") != "Pause":
            begin(page)
            page.evaluate("engramPlay.play.frames.length = 0")
        key = KEYS[number % len(KEYS)]
        number += 1
        page.keyboard.down(key)
        time.sleep(0.11 + 0.017 * (number % 7))  # at all moments of a control step
        page.keyboard.up(key)
        time.sleep(0.13 + 0.013 * (number % 5))
        if time.monotonic() >= due:
            due = time.monotonic() + every
            memory.append(round(server.memory_full_info().uss / 2**20, 1))
            loads.append(os.getloadavg()[0])
            sample = page.evaluate(
                "() => { const s = engramPlay.play; const t = s.frames.splice(0);"
                " if (t.length) s.frames.push(t[t.length - 1]);"
                " return [s.latencies.splice(0), t]; }"
            )
            latencies += sample[0]
            gaps += [b - a for a, b in zip(sample[1], sample[1][1:])]
            frames += max(0, len(sample[1]) - 1)
    return {
        "task": TASK,
        "seconds": seconds,
        "keys": len(latencies),
        "latency_median_ms": share(latencies, 0.5),
        "latency_95_ms": share(latencies, 0.95),
        "latency_worst_ms": share(latencies, 1),
        "pictures_per_second": round(1000 * frames / sum(gaps), 2),
        "gap_median_ms": share(gaps, 0.5),
        "gap_95_ms": share(gaps, 0.95),
        **{
            f"{name}_cores": round((_busy(them) - before[name]) / seconds, 3)
            for name, them in processes.items()
        },
        "memory_mb": memory,
        "load": [round(load, 1) for load in loads],
        "cores": os.cpu_count(),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60)
    seconds = parser.parse_args().seconds
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-m", "engram.play", "--no-open", "--out", out]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        link = process.stdout.readline().split()[-1]
        with sync_playwright() as starter:
            browser = starter.chromium.launch(
                executable_path=shutil.which("chromium"),
                args=["--no-sandbox"] if os.geteuid() == 0 else [],
            )
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.set_default_timeout(300_000)  # milliseconds; of busy machines
            page.goto(link)
            page.wait_for_selector("body[data-ready]")
            page.fill("input[name=words]", TASK)
            page.click(f"button[aria-label='Play {TASK}']")
            page.wait_for_selector("#stage:focus")
            page.wait_for_selector("#run:not([disabled])")
            page.select_option("#speed", "1")
            print(json.dumps(measure(page, psutil.Process(process.pid), seconds), indent=1))
            browser.close()
        process.wait(10)


if __name__ == "__main__":
    main()
