"""Blocks of docs/datasets.md that read data sets through LeRobot and TensorFlow."""

from __future__ import annotations

from pathlib import Path

import pytest
from doc_blocks import Block, groups, run_all

pytest.importorskip("lerobot")


def is_read(block: Block) -> bool:
    return block.elsewhere in ("lerobot", "tensorflow_datasets")


@pytest.mark.parametrize(
    "group", [g for g in groups() if any(is_read(block) for block in g)], ids=lambda g: str(g[0])
)
def test_its_readers_run(group: list[Block], tmp_path: Path) -> None:
    readers = [block for block in group if is_read(block)]
    assert {block.elsewhere for block in readers} == {"lerobot", "tensorflow_datasets"}
    run_all([group[0], *readers], tmp_path)
