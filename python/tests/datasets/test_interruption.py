"""Ctrl-C in the commands of data sets."""

from __future__ import annotations

import concurrent.futures
import signal
import sys
import threading
import time
import weakref
from collections.abc import Iterator

import pytest

from engram.datasets.__main__ import _Interruption
from engram.datasets.work import ahead, in_order


class Deleted:
    pass


def test_a_ctrl_c_that_python_loses_is_noted_and_not_printed(capsys, monkeypatch):
    monkeypatch.setattr(sys, "unraisablehook", sys.__unraisablehook__)  # not pytest's
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with _Interruption() as interruption:
            watched = Deleted()
            reference = weakref.ref(watched, lambda _: signal.raise_signal(signal.SIGINT))
            del watched
    finally:
        signal.signal(signal.SIGINT, before)
    assert reference() is None
    assert interruption.noted
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1])
def test_signals_that_end_a_process_are_taken_as_a_ctrl_c(number):
    before = signal.signal(number, signal.SIG_DFL)  # nohup ignores SIGHUP
    try:
        with pytest.raises(KeyboardInterrupt), _Interruption() as interruption:
            signal.raise_signal(number)
        assert interruption.noted
        assert signal.getsignal(number) is signal.SIG_DFL
    finally:
        signal.signal(number, before)


class Slow:
    """A function that takes a while, and counts its calls."""

    def __init__(self) -> None:
        self.begun = self.ended = 0
        self._lock = threading.Lock()

    def __call__(self, item: int) -> int:
        with self._lock:
            self.begun += 1
        time.sleep(0.1)
        with self._lock:
            self.ended += 1
        return item


def interrupt_after_one(results: Iterator[int]) -> None:
    next(results)
    time.sleep(0.02)  # the next call begins
    raise KeyboardInterrupt


def running_after_interruption(slow: Slow) -> int:
    left = slow.begun - slow.ended
    begun = slow.begun
    time.sleep(0.2)
    assert slow.begun == begun
    return left


@pytest.mark.parametrize("interrupted", [1, 2])
def test_no_call_runs_after_a_ctrl_c_while_its_thread_starts(monkeypatch, interrupted):
    slow = Slow()
    starts = []
    real = threading.Thread.start

    def start(thread: threading.Thread) -> None:
        real(thread)
        starts.append(thread)
        if len(starts) == interrupted:
            time.sleep(0.02)  # the call begins
            raise KeyboardInterrupt

    monkeypatch.setattr(threading.Thread, "start", start)
    with pytest.raises(KeyboardInterrupt), in_order(slow, range(4), jobs=2) as results:
        list(results)
    assert running_after_interruption(slow) == 0
    assert slow.begun == interrupted


def test_no_call_runs_after_a_ctrl_c_between_two_results():
    slow = Slow()
    with pytest.raises(KeyboardInterrupt), in_order(slow, range(20), jobs=2) as results:
        interrupt_after_one(results)
    assert running_after_interruption(slow) == 0


def test_no_call_runs_after_a_second_ctrl_c_while_threads_are_joined(monkeypatch):
    slow = Slow()

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(concurrent.futures.ThreadPoolExecutor, "shutdown", interrupted)
    with pytest.raises(KeyboardInterrupt), in_order(slow, range(4), jobs=2) as results:
        interrupt_after_one(results)
    assert running_after_interruption(slow) == 0


def test_no_item_is_made_after_a_ctrl_c():
    slow = Slow()
    with pytest.raises(KeyboardInterrupt), ahead(map(slow, range(5))) as items:
        interrupt_after_one(items)
    assert running_after_interruption(slow) == 0
    assert slow.ended <= 2


def test_the_first_error_is_reported_and_no_call_runs_after_it():
    slow = Slow()

    def failing(item: int) -> int:
        if item == 1:
            raise ValueError(item)
        return slow(item)

    with pytest.raises(ValueError, match="1"), in_order(failing, range(20), jobs=3) as results:
        list(results)
    assert running_after_interruption(slow) == 0
    with in_order(slow, range(5), jobs=3) as results:
        assert list(results) == [0, 1, 2, 3, 4]
