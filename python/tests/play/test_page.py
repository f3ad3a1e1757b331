"""Page in a real browser: episodes chosen, played, saved and reviewed by keyboard alone."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest
from browser_page import screenshot, until
from play_server import SECONDS, Server, serving

from engram.play.episode_spec import EpisodeSpec

TASK = "RememberColor3-VLA-v0"
SEED = 12
# Directions of the keys over the table, as in page/input.js.
AWAY, RIGHT = np.array([-0.63, -0.77]), np.array([-0.77, 0.63])


def tab_to(page: Any, wanted: str, back: bool = False) -> None:
    """Presses Tab until an element that matches has the focus."""
    for _ in range(300):
        found = page.evaluate("wanted => document.activeElement.matches(wanted)", wanted)
        if found:
            return
        page.keyboard.press("Shift+Tab" if back else "Tab")
    raise AssertionError(f"{wanted} cannot be reached by keyboard")


def keys_for(action: np.ndarray) -> list[str]:
    """The keys whose motion is closest to the oracle's action."""
    right, away = action[:2] @ RIGHT, action[:2] @ AWAY
    motions = {"d": right, "a": -right, "w": away, "s": -away, "r": action[2], "f": -action[2]}
    return [key for key, motion in motions.items() if motion > 0.15]


def test_an_episode_is_chosen_played_and_saved_by_keyboard_alone(opened, server: Server):
    page = opened()
    sent: list[dict[str, Any]] = []
    # The socket is older than this listener: the page records its messages itself.
    page.evaluate(
        "() => { const send = WebSocket.prototype.send; globalThis.sent = [];"
        "WebSocket.prototype.send = function (text) { sent.push(text); send.call(this, text); }; }"
    )
    tab_to(page, "input[name=words]")
    page.keyboard.type(f"{TASK[:14]}")
    until(page, "document.querySelectorAll('.card').length < 5")
    tab_to(page, f"button[aria-label='Play {TASK}']")
    page.keyboard.press("Enter")
    until(page, "document.activeElement.id === 'stage'")
    tab_to(page, "#seed")
    page.keyboard.type(str(SEED))
    tab_to(page, "#again", back=True)
    page.keyboard.press("Enter")
    until(page, "document.activeElement.id === 'stage'")
    until(page, "engramPlay.play.last === 0")

    mirror = EpisodeSpec(TASK, SEED).make_batch(terminate_on_success=True)
    mirror.reset(seed=SEED)
    page.keyboard.press("Space")  # closes the gripper
    held: set[str] = set()
    ended = False
    steps = 0
    while not ended:
        wanted = set(keys_for(mirror.act("oracle")[0]))
        for key in held - wanted:
            page.keyboard.up(key)
        for key in wanted - held:
            page.keyboard.down(key)
        held = wanted
        page.keyboard.press(".")
        steps += 1
        until(page, f"engramPlay.play.last === {steps}")
        sent = [json.loads(text) for text in page.evaluate("sent")]
        action = np.array([m["a"] for m in sent if m["do"] == "step"][-1], np.float32)
        _, _, terminated, truncated, info = mirror.step(action[None])
        ended = bool(terminated[0] or truncated[0])
    assert info["success"][0]
    mirror.close()
    page.wait_for_selector("#after:not([hidden])")
    assert "Success" in page.inner_text("#result")
    assert "first answer was right" in page.inner_text("#result")
    assert "1 of 1" in page.inner_text("#score")
    screenshot(page, "played")

    tab_to(page, "#save")
    page.keyboard.press("Enter")
    until(page, "document.getElementById('result').textContent.includes('Saved:')")
    assert (server.out / "data_npz" / TASK / "train_data_0.npz").is_file()
    command = [sys.executable, "-m", "engram.datasets", "replay", "--json", str(server.out)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)[0]["equal"]

    tab_to(page, "#review")
    page.keyboard.press("Enter")
    page.wait_for_selector("#playback-human[data-frame='0']")
    tab_to(page, "#playback-scrub")
    page.keyboard.press("End")
    page.wait_for_selector(f"#playback-human[data-frame='{steps}']")
    for _ in range(3):
        page.keyboard.press("ArrowLeft")
    page.wait_for_selector(f"#playback-human[data-frame='{steps - 3}']")
    assert f"step {steps - 3} of {steps}" in page.inner_text("#playback-status")
    assert page.locator("#plots svg[role=img]").count() == 4
    screenshot(page, "reviewed")


def test_keys_move_the_tool_while_time_runs(opened):
    page = opened()
    page.fill("input[name=words]", "TakeItBack")
    page.click("button[aria-label='Play TakeItBack-VLA-v0']")
    until(page, "document.activeElement.id === 'stage'")
    before = page.evaluate("document.getElementById('human').toDataURL()")
    page.select_option("#speed", "1")
    page.focus("#stage")
    page.keyboard.press("Enter")
    page.keyboard.down("d")
    until(page, "engramPlay.play.last >= 10")
    page.keyboard.up("d")
    page.keyboard.press("Enter")
    until(page, "document.getElementById('run').textContent === 'Go on'")
    assert page.evaluate("document.getElementById('human').toDataURL()") != before
    assert page.evaluate("engramPlay.play.latencies.length") > 0
    # The mouse: a drag is an action too.
    last = page.evaluate("engramPlay.play.last")
    page.select_option("#speed", "turns")
    page.click("#run")
    box = page.locator("#stage").bounding_box()
    page.mouse.move(box["x"] + 200, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 260, box["y"] + 180, steps=4)
    until(page, f"engramPlay.play.last >= {last + 3}")
    page.mouse.up()


def test_an_answer_is_named_by_keyboard_and_carried_out(opened):
    page = opened()
    page.fill("input[name=words]", TASK[:14])
    page.click(f"button[aria-label='Play {TASK}']")
    until(page, "document.activeElement.id === 'stage'")
    assert page.is_enabled("#choices")
    page.select_option("#speed", "1")
    page.check("#choices")
    until(page, "document.activeElement.id === 'stage'")
    page.keyboard.press("Enter")
    page.wait_for_selector("#question:not([hidden])")
    until(page, "document.activeElement.parentElement.id === 'answers'")
    assert page.inner_text("#question-text") == "Which object is to be touched?"
    assert sorted(page.locator("#answers button").all_inner_texts()) == [
        "the blue cube", "the green cube", "the red cube",
    ]  # fmt: skip
    assert not page.is_visible("#compose")
    assert page.is_disabled("#step")
    screenshot(page, "question")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.wait_for_selector("#after:not([hidden])")
    assert not page.is_visible("#question")
    assert "first answer was" in page.inner_text("#result")


def test_several_answers_are_named_in_order_and_taken_back(opened):
    page = opened()
    page.fill("input[name=words]", "ChainOfColors")
    page.click("button[aria-label='Play ChainOfColors3-VLA-v0']")
    until(page, "document.activeElement.id === 'stage'")
    page.select_option("#speed", "1")
    page.check("#choices")
    until(page, "document.activeElement.id === 'stage'")
    page.keyboard.press("Enter")
    page.wait_for_selector("#question:not([hidden])")
    answers = page.locator("#answers button")
    names = answers.all_inner_texts()
    answers.nth(2).click()
    answers.nth(0).click()
    assert page.inner_text("#named") == f"{names[2]}, then {names[0]}"
    assert answers.nth(2).is_disabled()
    assert page.is_disabled("#answer")
    page.click("#take-back")
    assert page.inner_text("#named") == names[2]
    answers.nth(1).click()
    answers.nth(3).click()
    assert answers.nth(0).is_disabled()
    screenshot(page, "several answers")
    page.click("#answer")
    page.wait_for_selector("#question", state="hidden")


def test_tasks_without_a_list_of_answers_offer_none(opened):
    page = opened()
    page.fill("input[name=words]", "InterceptMedium")
    page.click("button[aria-label='Play InterceptMedium-VLA-v0']")
    until(page, "document.activeElement.id === 'stage'")
    assert page.is_disabled("#choices")
    assert page.get_attribute("#by-name", "title") == "This task has no list of answers"


def test_the_command_may_begin_with_choices(browser, tmp_path):
    with serving(tmp_path / "out", "--choices") as server:
        page = browser.new_page()
        page.goto(server.link)
        page.wait_for_selector("body[data-ready]")
        page.click(f"button[aria-label='Play {TASK}']")
        until(page, "document.activeElement.id === 'stage'")
        assert page.is_checked("#choices")
        page.close()


# Simulated gamepad.
GAMEPAD = """
globalThis.pad = { axes: [0, 0, 0, 0], buttons: [...Array(16)].map(() => ({ pressed: false })) };
navigator.getGamepads = () => [null, globalThis.pad];
"""


def test_a_gamepad_moves_the_tool(opened):
    page = opened(script=GAMEPAD)
    page.fill("input[name=words]", "TakeItBack")
    page.click("button[aria-label='Play TakeItBack-VLA-v0']")
    until(page, "document.activeElement.id === 'stage'")
    until(page, "engramPlay.play.last === 0")
    page.evaluate(
        "() => { const send = WebSocket.prototype.send; globalThis.sent = [];"
        "WebSocket.prototype.send = function (text) { sent.push(text); send.call(this, text); }; }"
    )

    def action(axes: list[float]) -> np.ndarray:
        """The action that the page sends for these positions of the sticks."""
        page.evaluate("axes => { sent.length = 0; pad.axes = axes; }", axes)
        until(page, "sent.some((text) => text.includes('act'))")
        sent = [json.loads(text) for text in page.evaluate("sent")]
        return np.array([m["a"] for m in sent if m["do"] == "act"][-1])

    right = action([1.0, 0, 0, 0])
    assert right[:2] @ RIGHT > 0.5
    assert abs(right[:2] @ AWAY) < 0.01
    away = action([0, -1.0, 0, 0])
    assert away[:2] @ AWAY > 0.5
    turned_up = action([0, 0, 0.5, -1.0])
    assert turned_up[2] > 0.5
    assert turned_up[5] != 0
    still = action([0.02, 0, 0, 0])  # worn sticks do not return to the centre
    assert not still[:6].any()

    def press(button: int) -> None:
        page.evaluate("button => { pad.buttons[button].pressed = true; }", button)
        time.sleep(0.1)
        page.evaluate("button => { pad.buttons[button].pressed = false; }", button)

    page.evaluate("sent.length = 0")
    press(0)
    until(page, "sent.some((text) => text.includes('act'))")
    gripper = [json.loads(text) for text in page.evaluate("sent")][-1]["a"][6]
    assert gripper == -still[6]
    press(9)
    until(page, "engramPlay.play.last >= 5")
    press(9)
    until(page, "document.getElementById('run').textContent === 'Go on'")
    press(1)
    until(page, "engramPlay.play.last === 0")


def test_a_grid_of_sixteen(opened):
    page = opened()
    page.click("a[href='#grid']")
    page.select_option("#grid-task", "ShellGameTouch-VLA-v0")
    page.wait_for_selector("#grid-values details")
    page.click("#grid-form button[type=submit]")
    until(page, "engramPlay.grid.frames > 5")
    until(page, "document.getElementById('grid-status').textContent.includes('16 of 16')")
    screenshot(page, "grid")


def test_policies_and_their_curves(opened):
    page = opened()
    page.fill("input[name=words]", "GatherAndRecall3")
    page.click("button[aria-label='Watch GatherAndRecall3-VLA-v0']")
    page.wait_for_selector("#playback-human[data-frame='0']")
    # The result is told when it is seen.
    assert "Success" not in page.inner_text("#playback-result")
    page.click("#playback-tell")
    assert "Success" in page.inner_text("#playback-result")
    page.locator("#playback-scrub").fill("60")
    page.wait_for_selector("#playback-human[data-frame='60']")
    page.select_option("#playback-speed", "4")
    page.click("#playback-run")
    until(page, "Number(document.getElementById('playback-human').dataset.frame) > 80")
    screenshot(page, "watched")


def test_pins_and_constants_can_be_watched(opened):
    page = opened()
    page.click("a[href='#watch']")
    page.wait_for_selector("#watch-values details")
    page.select_option("#watch-task", "RememberColor9-VLA-v0")
    page.wait_for_selector("#watch-values-pins-cue_steps", state="attached")
    for summary in page.locator("#watch-values summary").all():
        summary.click()
    page.fill("#watch-values-pins-cue_steps", "4")
    page.fill("#watch-values-constants-COLORS", "4")
    page.fill("#watch-values-constants-CUE_PHASE_STEPS", "40, 50")
    page.click("#watch-form button[type=submit]")
    page.wait_for_selector("#notice:not([hidden])")
    assert "no time to act" in page.inner_text("#notice")
    assert page.is_visible("#watch-empty")
    assert page.is_hidden("#playback")
    page.fill("#watch-values-constants-CUE_PHASE_STEPS", "4, 5")
    page.click("#watch-form button[type=submit]")
    page.wait_for_selector("#playback-human[data-frame='0']")
    screenshot(page, "watched_with_pins")
    for frame, phase in ((3, "cue"), (4, "empty")):
        page.locator("#playback-scrub").fill(str(frame))
        until(
            page,
            f"document.getElementById('playback-status').textContent.includes('phase {phase}')",
        )


def test_a_second_tab_is_notified(opened, browser, server: Server):
    first = opened()
    second = browser.new_page()
    second.goto(server.link)
    second.wait_for_selector("#connection:not([hidden])")
    assert "another tab" in second.inner_text("#connection")
    second.click("#connection button")
    second.wait_for_selector("body[data-ready]")
    until(first, "document.getElementById('connection').textContent.includes('taken over')")
    second.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_fits_phones_and_every_control_has_a_name(opened, scheme):
    page = opened(
        viewport={"width": 360, "height": 740},
        color_scheme=scheme,
        is_mobile=True,
        has_touch=True,
        device_scale_factor=2,
    )
    page.wait_for_selector(".card img[src]")
    screenshot(page, f"choose_{scheme}")
    page.fill("input[name=words]", TASK)
    page.tap(f"button[aria-label='Play {TASK}']")
    until(page, "engramPlay.play.last === 0")
    screenshot(page, f"play_{scheme}")
    for view in ("play", "watch", "grid", "choose"):
        page.evaluate("view => { location.hash = view; }", view)
        page.wait_for_selector(f"#{view}:not([hidden])")
        assert page.evaluate("document.documentElement.scrollWidth") <= 360
        nameless = page.evaluate(
            "() => [...document.querySelectorAll('button, input, select, canvas, summary, a')]"
            ".filter(e => e.offsetParent && !(e.ariaLabel || e.getAttribute('aria-label')"
            " || e.labels?.length || e.textContent.trim())).map(e => e.outerHTML)"
        )
        assert nameless == []
    background, ink = page.evaluate(
        "() => [getComputedStyle(document.body).backgroundColor,"
        " getComputedStyle(document.body).color]"
    )
    light = [sum(map(int, c.strip("rgb()").split(","))) for c in (background, ink)]
    assert (light[0] > light[1]) == (scheme == "light")


def test_the_page_ends_its_server(browser, tmp_path):
    with serving(tmp_path / "out", stay=False) as server:
        page = browser.new_page()
        page.goto(server.link)
        page.wait_for_selector("body[data-ready]")
        page.reload()
        page.wait_for_selector("body[data-ready]")
        assert page.is_hidden("#connection")
        assert server.process.poll() is None
        page.close()
        assert server.process.wait(SECONDS) == 0
