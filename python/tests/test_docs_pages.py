"""Python and shell of README.md and docs/ runs as it stands there."""

from __future__ import annotations

from pathlib import Path

import pytest
from doc_blocks import Block, groups, run_all

# Shell that is not run: how it begins, and why.
NOT_RUN = {
    "scripts/": "installs, builds or tests",
    "pip install": "installs",
    "build/release/cross_entropy": "a program of the C++ build",
    "engram=build/release/engram\n$engram eval --canonical": "takes long",
    "engram eval --canonical": "takes long",
    "engram eval --all": "takes long",
    "engram eval --split rl --policy blind": "takes long",
    "engram list --split rl": "takes long",
    "python -m engram_learners.scores": "takes long",
    "python -m engram_learners.zoo.scores": "takes long",
    "python python/examples/mikasa_ppo.py": "takes long",
    "engram eval RememberColor3-VLA-v0 --policy-server": "needs a server",
    "mpirun": "needs MPI",
    "openssl rand": "needs a policy, and a host that keeps a secret",
    "#!/bin/sh\n#SBATCH": "needs a cluster",
    "seq 7 | parallel": "needs GNU parallel, and machines",
    "lerobot-eval": "needs a policy",
    "engram collect TakeItBack-VLA-v0 --episodes 300": "takes long",
    "engram collect RememberColor3-VLA-v0 --episodes 300": "takes long",
    "sed -E": "needs a script of the original's",
    "engram info TouchSpot": "needs the task that the page adds",
    "cmake -S . -B build": "compiles; installed_package of ctest does the same",
    "engram eval my_tasks.py": "needs a file of the reader's",
    "engram check my_tasks.py": "needs a file of the reader's",
    "python -m engram_learners.distil --obs rgb --perturb": "takes long",
    "engram probe RememberColor3-VLA-v0 --policy-command": "needs a policy",
    "engram play": "does not end by itself",
    "python -m engram.mikasa": "runs programs of others",
    "python -m engram.datasets replay played": "needs played episodes",
}
PRINTED = {  # what a line of a block prints
    'print("success:"': "success: 1.0\n",
    'print(obs["rgb"].shape': "(64, 128, 128, 6) (64, 7)\n",
    "episodes succeeded": "1.0 of 256 episodes succeeded\n",
    "print(rewards.shape": "(25, 64) True\n",
}


def is_run(block: Block) -> bool:
    return block.language == "python" or not block.text.startswith(tuple(NOT_RUN))


@pytest.mark.parametrize(
    "group", [g for g in groups() if is_run(g[0]) and not g[0].elsewhere], ids=lambda g: str(g[0])
)
def test_its_blocks_run(group: list[Block], tmp_path: Path) -> None:
    here = [block for block in group if not block.elsewhere]
    assert all(is_run(block) for block in here)
    printed = run_all(here, tmp_path)
    for line, words in PRINTED.items():
        if any(line in block.text for block in here):
            assert words in printed


def test_there_are_blocks_of_both_kinds() -> None:
    run = [block for group in groups() for block in group if is_run(block)]
    assert sum(block.language == "python" for block in run) >= 25
    assert sum(block.language == "sh" for block in run) >= 7


@pytest.mark.parametrize("beginning", NOT_RUN)
def test_reasons_belong_to_a_block(beginning: str) -> None:
    assert any(g[0].language == "sh" and g[0].text.startswith(beginning) for g in groups())


@pytest.mark.parametrize("line", PRINTED)
def test_lines_that_print_belong_to_a_block(line: str) -> None:
    assert sum(line in block.text for group in groups() for block in group) == 1
