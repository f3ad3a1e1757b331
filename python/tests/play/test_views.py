"""Views of the page: how much fits, what they explain, and that they agree on the task."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

import pytest
from browser_page import screenshot, until
from play_server import SECONDS, Server

LONG = "RememberColor3-Long-VLA-v0"
TASK = "RememberColor3-VLA-v0"
PHONE = {
    "viewport": {"width": 390, "height": 844},
    "is_mobile": True,
    "has_touch": True,
    "device_scale_factor": 2,
}
WIDE = {"viewport": {"width": 1440, "height": 900}}


def boxes(page: Any, selector: str) -> list[dict[str, float]]:
    """Places of elements on the page."""
    return page.evaluate(
        "wanted => [...document.querySelectorAll(wanted)].map(one => {"
        " const b = one.getBoundingClientRect();"
        " return { x: b.x, y: b.y + scrollY, right: b.right, bottom: b.bottom + scrollY,"
        " width: b.width, height: b.height }; })",
        selector,
    )


def choose(page: Any, id: str, button: str = "Play") -> None:
    """Chooses a variant in its family's card, and presses a button of the card."""
    page.click("a[href='#choose']")
    page.fill("input[name=words]", id)
    page.click(f"button[aria-label='{button} {id}']")


# --- choosing ---


def test_the_choice_is_short_uses_the_width_and_has_even_rows(opened):
    page = opened(**WIDE)
    page.wait_for_selector(".card img[src]")
    assert page.evaluate("document.documentElement.scrollHeight") < 4500
    cards = boxes(page, ".card")
    assert max(card["right"] for card in cards) > 1440 - 40
    for y in {card["y"] for card in cards}:
        assert len({round(card["height"]) for card in cards if card["y"] == y}) == 1
    for row in boxes(page, ".card .buttons"):
        (card,) = [
            c for c in cards if c["x"] < row["x"] < c["right"] and c["y"] < row["y"] < c["bottom"]
        ]
        assert card["bottom"] - row["bottom"] < 20
    screenshot(page, "choose_wide")


def test_the_choice_on_a_phone_is_one_column(opened):
    page = opened(**PHONE)
    page.wait_for_selector(".card img[src]")
    assert page.evaluate("document.documentElement.scrollHeight") < 8000
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert all(card["width"] > 350 for card in boxes(page, ".card"))
    screenshot(page, "choose_phone")


def test_all_tasks_can_be_chosen_and_ids_break_between_words(opened, server: Server):
    page = opened(**WIDE)
    ids = {task["id"] for task in server.get("tasks.json")}
    offered = page.evaluate(
        "[...document.querySelectorAll('.card select')]"
        ".flatMap(select => [...select.options].map(option => option.value))"
    )
    assert sorted(offered) == sorted(ids)
    families = [card.get_attribute("aria-label") for card in page.locator(".card").all()]
    assert len(families) == len(set(families)) < 40
    page.set_viewport_size({"width": 700, "height": 900})
    broken = page.evaluate(
        "[...document.querySelectorAll('.card .id')].filter(id => [...id.childNodes].some(part =>"
        " { const range = document.createRange(); range.selectNodeContents(part);"
        " return part.nodeType === 3 && range.getClientRects().length > 1; }))"
        ".map(id => id.textContent)"
    )
    assert broken == []


def test_variants_of_the_rl_half_are_told_apart_and_come_last(opened):
    page = opened(**WIDE)
    words = page.evaluate(
        "[...document.querySelectorAll('.card[aria-label=\"Remember Color\"] option')]"
        ".map(option => [option.value, option.textContent])"
    )
    rl = [text for id, text in words if "-VLA-" not in id]
    assert rl == ["RL 3", "RL 5", "RL 9"]
    assert [text for _, text in words][-3:] == rl
    assert len({text for _, text in words}) == len(words)
    assert page.locator("section[aria-label='Your own tasks']").count() == 0


def test_own_tasks_have_a_heading_of_their_own(opened, server: Server):
    page = opened(**WIDE)
    id = TASK

    def tasks(route: Any) -> None:
        listed = server.get("tasks.json")
        route.fulfill(json=[{**task, "own": task["id"] == id} for task in listed])

    page.route("**/tasks.json", tasks)
    page.reload()
    page.wait_for_selector("section[aria-label='Your own tasks'] .card")
    own = page.locator("section[aria-label='Your own tasks'] .card")
    assert own.count() == 1
    assert "your own" in own.inner_text()
    assert page.locator("#families section").first.get_attribute("aria-label") == "Your own tasks"


def test_it_begins_with_tasks_that_need_memory(opened, server: Server):
    page = opened()
    rates = {task["id"]: task for task in server.get("tasks.json")}
    first = [one.inner_text() for one in page.locator(".card .id").all()[:8]]
    assert len(first) == 8
    for id in first:
        assert rates[id]["oracle"] - rates[id]["sweep"] > 0.05


def test_the_rates_are_explained(opened):
    page = opened()
    legend = page.inner_text(".legend")
    for word in ("guessing", "chance", "without memory", "sweep", "oracle"):
        assert word in legend
    card = page.locator(".card").first.inner_text()
    assert all(word in card for word in ("guessing", "without memory", "oracle", "%"))


@pytest.mark.parametrize(("word", "other"), [("colour", "color"), ("COLOUR cup", "color cup")])
def test_other_spellings_find_the_same(opened, word, other):
    page = opened()
    page.fill("input[name=words]", other)
    found = page.inner_text("#count")
    assert not found.startswith("0 ")
    page.fill("input[name=words]", word)
    assert page.inner_text("#count") == found


def test_a_search_that_finds_nothing_says_so(opened):
    page = opened()
    page.fill("input[name=words]", "elephant")
    assert "0 of" in page.inner_text("#count")
    page.click("#clear")
    assert page.is_hidden("#no-task")
    assert page.locator(".card").count() > 20


def test_the_search_box_gives_examples_that_are_found(opened):
    page = opened()
    for word in page.get_attribute("input[name=words]", "placeholder").split(", "):
        page.fill("input[name=words]", word)
        assert not page.inner_text("#count").startswith("0 ")


# --- one task in all views ---


def test_all_views_show_the_chosen_task(opened):
    page = opened()
    choose(page, LONG)
    until(page, "engramPlay.play.last === 0")
    assert page.inner_text("#task-shown") == LONG
    for view in ("watch", "grid"):
        page.click(f"a[href='#{view}']")
        until(page, f"document.getElementById('{view}-task').value === '{LONG}'")
    page.click("a[href='#watch']")
    page.click("#watch-form button[type=submit]")
    page.wait_for_selector("#playback-human[data-frame='0']")
    assert LONG in page.inner_text("#playback-result")
    # Another task: what was watched is put away, and the header names the new one.
    page.select_option("#watch-task", "TakeItBack-VLA-v0")
    assert page.is_hidden("#playback")
    assert page.inner_text("#task-shown") == "TakeItBack-VLA-v0"
    page.click("a[href='#play']")
    until(page, "document.getElementById('instruction').textContent.includes('Push')")
    until(page, "!document.getElementById('run').disabled")


def test_after_watching_the_same_task_can_be_played(opened):
    page = opened()
    choose(page, TASK, "Watch")
    page.wait_for_selector("#playback-human[data-frame='0']")
    page.click("a[href='#play']")
    until(page, "document.getElementById('run').textContent === 'Start'")
    assert page.is_enabled("#run")
    assert page.is_hidden("#play-empty")
    page.click("#run")
    until(page, "engramPlay.play.last >= 3")
    # And back again: the same episode can be watched.
    page.click("a[href='#watch']")
    page.wait_for_selector("#playback:not([hidden])")
    page.locator("#playback-scrub").fill("3")
    page.wait_for_selector("#playback-human[data-frame='3']")
    page.click("a[href='#play']")
    until(page, "document.getElementById('run').textContent === 'Start'")


def test_a_paused_episode_goes_on_after_a_look_at_other_views(opened):
    page = opened()
    choose(page, LONG)
    until(page, "engramPlay.play.last === 0")
    for _ in range(3):
        page.click("#step")
    until(page, "engramPlay.play.last === 3")
    for view in ("grid", "watch", "choose", "play"):
        page.click(f"a[href='#{view}']")
    page.click("#step")
    until(page, "engramPlay.play.last === 4")
    assert page.is_hidden("#notice")


def test_without_a_task_the_views_say_what_to_do(opened):
    page = opened()
    page.click("a[href='#play']")
    assert "Choose one" in page.inner_text("#play-empty")
    for view in ("watch", "grid"):
        page.click(f"a[href='#{view}']")
        page.wait_for_selector(f"#{view}-empty")
        assert not [box for box in boxes(page, f"#{view} canvas") if box["height"] > 0]
        screenshot(page, f"empty_{view}")


# --- playing and watching ---


def test_the_result_of_a_watched_episode_is_told_at_its_end(opened):
    page = opened()
    choose(page, "ShellGameTouch-VLA-v0", "Watch")
    page.wait_for_selector("#playback-human[data-frame='0']")
    assert "uccess" not in page.inner_text("#playback-result")
    page.focus("#playback-scrub")
    page.keyboard.press("End")
    assert "Success" in page.inner_text("#playback-result")
    screenshot(page, "watched_to_the_end")


def ready_to_play(opened: Any, task: str) -> Any:
    """A page with the first picture of the task, at speed 1."""
    page = opened()
    choose(page, task)
    until(page, "engramPlay.play.last === 0")
    page.select_option("#speed", "1")
    return page


def test_no_words_for_developers(opened):
    page = ready_to_play(opened, LONG)
    page.focus("#stage")
    page.keyboard.press("Enter")
    for _ in range(8):
        page.keyboard.press("d", delay=60)
    until(page, "engramPlay.play.latencies.length >= 5")
    text = page.inner_text("#play")
    assert " ms" not in text
    assert "key to picture" not in text


@pytest.mark.parametrize(
    "device",
    [PHONE, {**PHONE, "viewport": {"width": 844, "height": 390}}],
    ids=["upright", "across"],
)
def test_on_a_phone_picture_and_controls_are_on_one_screen(opened, device):
    page = opened(**device)
    choose(page, TASK)
    until(page, "engramPlay.play.last === 0")
    screenshot(page, f"play_phone_{device['viewport']['width']}")
    seen = boxes(page, "#stage, #run, #again, #pad button")
    assert len(seen) == 15
    assert max(box["bottom"] for box in seen) <= device["viewport"]["height"]
    assert max(box["right"] for box in seen) <= device["viewport"]["width"]
    assert min(box["height"] for box in seen) >= 36  # of a finger
    page.tap("#run")
    until(page, "engramPlay.play.last >= 2")


def test_on_a_phone_a_watched_episode_and_its_controls_are_on_one_screen(opened):
    page = opened(**PHONE)
    choose(page, TASK, "Watch")
    page.wait_for_selector("#playback-human[data-frame='0']")
    screenshot(page, "watch_phone")
    seen = boxes(page, "#playback-human, #playback-run, #playback-scrub")
    assert max(box["bottom"] for box in seen) <= 844


def test_one_lost_episode_gives_no_score(opened):
    page = ready_to_play(opened, TASK)
    page.click("#run")
    page.wait_for_selector("#after:not([hidden])", state="attached")
    until(page, "document.getElementById('score').textContent.includes('0 of 1 episode')")
    text = page.inner_text("#score")
    assert "-" not in text
    assert "more episodes until" in text


def ask_for_a_long_episode(page: Any) -> None:
    page.click("a[href='#watch']")
    page.select_option("#watch-task", TASK)
    page.wait_for_selector("#watch-values-constants-max_episode_steps", state="attached")
    for summary in page.locator("#watch-values summary").all():
        summary.click()
    page.fill("#watch-values-constants-max_episode_steps", "1000000")
    page.select_option("#watch-source", "zero")
    page.click("#watch-form button[type=submit]")
    until(page, "document.getElementById('watch-building').textContent.includes(' of 20000')")


def test_a_long_episode_tells_how_far_it_is(opened):
    page = opened()
    ask_for_a_long_episode(page)
    page.wait_for_selector("#playback-human[data-frame='0']")
    page.click("#playback-tell")
    assert "first 20000 of 1000000 steps" in page.inner_text("#playback-result")


def test_an_episode_that_takes_long_does_not_interrupt_another_view(opened):
    page = opened()
    choose(page, TASK)
    until(page, "engramPlay.play.last === 0")
    page.click("#step")
    until(page, "engramPlay.play.last === 1")
    ask_for_a_long_episode(page)
    page.click("a[href='#play']")
    page.click("#step")
    until(page, "engramPlay.play.last === 2")
    time.sleep(4)  # longer than it takes
    assert page.is_visible("#play")
    page.click("#step")
    until(page, "engramPlay.play.last === 3")
    page.click("a[href='#watch']")
    page.wait_for_selector("#playback-human[data-frame='0']")


# --- from the file that a browser is given ---


def test_the_page_opens_from_the_file(browser, server: Server, tmp_path, monkeypatch):
    from engram.play.browser import Browser

    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    addresses: list[str] = []
    monkeypatch.setattr("webbrowser.open", addresses.append)
    starter = Browser()
    starter.open(server.link)
    until_true(lambda: bool(addresses))
    page = browser.new_page()
    page.goto(addresses[0])
    page.wait_for_selector("body[data-ready]")
    assert page.url.startswith(server.link)
    page.close()
    starter.close()
    assert os.listdir(tmp_path) == []


def until_true(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + SECONDS
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)
