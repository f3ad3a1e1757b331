"""Runs the tasks of a file for another program, over a socket on standard input.

The file is loaded once. Each instance of a task runs in a process of its own, forked off this one,
and works on rows of columns in memory that both programs share. A message is its length (four
bytes, the lowest first), then that many bytes.
"""

from __future__ import annotations

import ctypes
import json
import mmap
import os
import signal
import socket
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from engram.errors import Error
from engram.kit.files import environment_files, load_file

if TYPE_CHECKING:
    from engram.kit.task import Task

_LENGTH_BYTES = 4
_PR_SET_DUMPABLE = 4


class _Connection:
    def __init__(self, end: socket.socket) -> None:
        self.end = end

    def send(self, message: bytes) -> None:
        self.end.sendall(len(message).to_bytes(_LENGTH_BYTES, "little") + message)

    def send_json(self, document: dict[str, Any]) -> None:
        self.send(json.dumps(document).encode())

    def receive(self) -> tuple[bytes, int | None] | None:
        """A message, and the descriptor beside it; None at the end."""
        length, descriptors, _, _ = socket.recv_fds(self.end, _LENGTH_BYTES, 1)
        while length and len(length) < _LENGTH_BYTES:
            length += self.end.recv(_LENGTH_BYTES - len(length))
        if not length:
            return None
        size = int.from_bytes(length, "little")
        message = bytearray()
        while len(message) < size:
            piece = self.end.recv(size - len(message))
            if not piece:
                return None
            message += piece
        return bytes(message), descriptors[0] if descriptors else None


def serve(file: str) -> None:
    """Loads the file and makes instances until the other program has closed the connection.

    Neither this process nor its forks can be read by others of the same user, such as policies.
    """
    connection = _Connection(socket.socket(fileno=0))
    if ctypes.CDLL(None).prctl(_PR_SET_DUMPABLE, 0, 0, 0, 0) != 0:
        connection.send_json({"error": "memory cannot be kept from other processes"})
        return
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for instances
    from engram.kit.registration import definitions

    try:
        ids = environment_files.get(Path(file).resolve()) or load_file(file)
    except BaseException as error:
        connection.send_json({"error": _reason(error)})
        return
    connection.send_json({"definitions": [json.loads(definitions[id][0]) for id in ids]})
    while (received := connection.receive()) is not None:
        message, descriptor = received
        assert descriptor is not None
        if os.fork() == 0:
            connection.end.close()
            asked_for = json.loads(message)
            factory = definitions[asked_for["id"]][1]
            _run_instance(_Connection(socket.socket(fileno=descriptor)), factory, asked_for)
            os._exit(0)
        os.close(descriptor)


def _run_instance(connection: _Connection, factory: Any, asked_for: dict[str, Any]) -> None:
    """One instance, until the other program has closed the connection."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    try:
        task = factory(asked_for["id"], json.dumps(asked_for["constants"]))
        connection.send_json({"description": json.loads(task.describe())})
    except BaseException as error:
        connection.send_json({"error": _reason(error)})
        return
    while (received := connection.receive()) is not None:
        message, descriptor = received
        try:
            if message.startswith(b"call "):
                method, rows = message[5:].split()
                task.call(int(method), int(rows), False)
                connection.send(b"")
            else:
                assert descriptor is not None
                _bind(task, json.loads(message)["bind"], descriptor)
                connection.send_json({})
        except BaseException as error:
            connection.send_json({"error": _reason(error)})


def _bind(task: Task, about: dict[str, Any], descriptor: int) -> None:
    memory = mmap.mmap(descriptor, 0)
    os.close(descriptor)
    rows = {}
    for array in about["arrays"]:
        shape = (about["num_envs"], array["width"])
        values: Any = np.ndarray(shape, array["dtype"], memory, array["offset"])
        values.flags.writeable = array["is_written"]
        rows[array["name"]] = values
    task.bind(rows, rows)


def _reason(error: BaseException) -> str:
    """Type and text of an exception; the traceback of the user's code goes to standard error."""
    if not isinstance(error, Error):
        traceback.print_exception(error, file=sys.stderr)
    return f"{type(error).__name__}: {error}"
