"""Fuzzing of the codecs of policy servers: mutated and invented messages, by number.

    python python/tests/servers/fuzz_codecs.py [COUNT [FIRST]]

Case n is the same on every machine. Whatever comes, it is a value within the limits, or refused in
a short sentence; neither takes long.
"""

from __future__ import annotations

import collections
import random
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from engram.servers import codecs

SECONDS = 2.0  # that one case may take
SOUND = {
    "actions": np.arange(14, dtype=np.float32).reshape(2, 7) / 100,
    "more": [np.arange(7.0), {"text": "x" * 30}, 1.5, None, True, -(2**40)],
    "npy": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
}
CODECS: dict[str, tuple[Callable[[Any], bytes], Callable[[bytes], Any]]] = {
    "openpi": (codecs.pack_openpi, codecs.unpack),
    "vla-eval": (codecs.pack_vla_eval, codecs.unpack),
    "gr00t": (codecs.pack_gr00t, codecs.unpack_gr00t),
    "json": (codecs.pack_json, codecs.unpack_json),
}
_MSGPACK = [bytes([head]) for head in (0x80, 0x91, 0xC0, 0xC1, 0xD7, 0xFF)]
_MSGPACK += [
    b"\xdd\xff\xff\xff\xff",
    b"\xdf\x00\x10\x00\x00",
    b"\xdb\x7f\xff\xff\xff",
    b"\xc6\0\0\0\x01x",
]
_JSON = [
    b"[",
    b"]",
    b"{",
    b"}",
    b",",
    b'"',
    b":",
    b"\\u0000",
    b"\\ud800",
    b"NaN",
    b"1e999",
    b"\xff",
    b"-",
]


def message(rng: random.Random, good: bytes, name: str) -> bytes:
    """A sound message with damage, or pieces of the codec's grammar."""
    pieces = _JSON if name == "json" else _MSGPACK
    if rng.random() < 0.3:
        count = rng.choice((3, 30, 300, 3000))
        return b"".join(rng.choices(pieces, k=rng.choice((1, 2, len(pieces))))) * count
    bad = bytearray(good)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(bad))
        kind = rng.randrange(4)
        if kind == 0:
            bad[at] = rng.choice((0, 0x7F, 0xFF, 0xC0, 0xDF, rng.randrange(256)))
        elif kind == 1:
            bad[at:at] = rng.choice(pieces) * rng.choice((1, 1, 50))
        elif kind == 2:
            del bad[at : at + rng.randint(1, 8)]
        else:
            end = min(len(bad), at + rng.randint(1, 40))
            bad[at:end] = bad[at:end] * rng.choice((2, 20))
        if not bad:
            break
    return bytes(bad)


def problem(number: int, name: str) -> tuple[str, str | None]:
    """Reads a case; returns what came of it, and what does not hold."""
    pack, read = CODECS[name]
    data = message(random.Random(f"{name}{number}"), pack(SOUND), name)
    begin = time.process_time()
    outcome, found = "read", None
    try:
        read(data)
    except codecs.CodecError as error:
        outcome = "refused"
        if not 0 < len(str(error)) < 300:
            found = f"a sentence of {len(str(error))} characters"
    except Exception as error:
        outcome, found = "raised", f"{type(error).__name__}: {str(error)[:200]}"
    if time.process_time() - begin > SECONDS:
        found = f"{time.process_time() - begin:.1f} s"
    return outcome, found


def play(first: int, count: int) -> tuple[collections.Counter, list[str]]:
    """Plays cases of each codec; returns how many were read and refused, and what does not hold."""
    counts: collections.Counter = collections.Counter()
    findings = []
    for name in CODECS:
        for number in range(first, first + count):
            outcome, found = problem(number, name)
            counts[outcome] += 1
            if found:
                findings.append(f"{name} {number}: {found}")
    return counts, findings


def main() -> int:
    """The command."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    counts, findings = play(first, count)
    print(*findings, sep="\n")
    print(f"codecs: {count} cases of each, {dict(counts)}, {len(findings)} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
