"""Files of data sets with one byte more than readers take; they are sparse, and cost nothing."""

from __future__ import annotations

import io
import os
import struct
from pathlib import Path

import pytest

pytest.importorskip("pyarrow")

from engram.datasets import checks, collected, episodes, folders, source
from engram.datasets.checks import DatasetError
from engram.datasets.lerobot import reader, v21

READERS = {
    "metadata.json": (256 << 20, episodes._read),
    "engram.json": (256 << 20, source._read),
    v21.EPISODES: (1 << 30, lambda file: list(reader._listed(file.parent.parent))),
}


def sparse(file: Path, size: int) -> Path:
    file.parent.mkdir(exist_ok=True)
    file.touch()
    os.truncate(file, size)
    return file


@pytest.mark.parametrize("name", READERS)
def test_one_byte_more_than_a_document_may_have(tmp_path: Path, name: str) -> None:
    most, read = READERS[name]
    assert checks.regular_file(sparse(tmp_path / name, most), most)
    with pytest.raises(DatasetError, match=f"more than {most >> 20} MB"):
        read(sparse(tmp_path / name, most + 1))


def test_one_byte_more_than_a_list_of_files_may_have(tmp_path: Path) -> None:
    assert folders._LARGEST_LIST == 64 << 20
    file = sparse(tmp_path / folders.LIST, folders._LARGEST_LIST + 1)
    assert file.stat().st_size == (64 << 20) + 1
    assert not folders._listed(tmp_path)


def test_one_byte_more_than_a_block_of_a_stream_may_have() -> None:
    stream = collected.CollectedEpisodes("engram", "RememberColor3-VLA-v0", [], 1, None)
    stream._source = io.BytesIO(struct.pack("<Q", (1 << 32) + 1))
    with pytest.raises(DatasetError, match="ended too early"):
        stream._block()


def test_a_record_one_byte_longer_than_its_file(tmp_path: Path) -> None:
    tf_example = pytest.importorskip("engram.datasets.tf_example")
    length = struct.pack("<Q", 17)
    head = length + tf_example._masked_checksum(length)
    file = tmp_path / "records"
    file.write_bytes(head + bytes(4))  # 16 bytes
    with open(file, "rb") as records, pytest.raises(ValueError, match="longer than its file"):
        next(tf_example.read_records(records))
