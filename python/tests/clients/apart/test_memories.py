"""engram_learners.memories: each memory gives what its released implementation gives.

With the same weights, in sequences longer than a short episode. GRU and LSTM are torch's own.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import torch

LEARNERS = Path(__file__).parents[3] / "learners" / "src"
STEPS, ENVS, WIDTH = 100, 3, 16


@pytest.fixture(scope="module")
def ours() -> Iterator[SimpleNamespace]:
    sys.path.insert(0, str(LEARNERS))
    try:
        from engram_learners.memories import gtrxl, lru, make, mamba, mingru, scan, xlstm

        yield SimpleNamespace(
            gtrxl=gtrxl, lru=lru, make=make, mamba=mamba, mingru=mingru, scan=scan, xlstm=xlstm
        )
    finally:
        sys.path.remove(str(LEARNERS))


@pytest.fixture
def inputs() -> Any:
    torch.manual_seed(0)
    return torch.randn(STEPS, ENVS, WIDTH)


def copy(*pairs: tuple[Any, Any]) -> None:
    """Weights of the first of each pair into the second, of the same shape."""
    with torch.no_grad():
        for source, target in pairs:
            assert source.shape == target.shape
            target.copy_(source)


def shake(module: Any) -> Any:
    """Weights that are not those of the initialisation, so that none is zero."""
    with torch.no_grad():
        for weight in module.parameters():
            weight += 0.1 * torch.randn_like(weight)
    return module


@torch.no_grad()
def assert_same(memory: Any, inputs: Any, expected: Any) -> None:
    """As a whole sequence, in steps, and in two parts; expected: (ENVS, STEPS, WIDTH)."""
    expected = expected.detach().transpose(0, 1)
    assert expected.std() > 0.01
    same = {"rtol": 1e-5, "atol": 1e-5}
    torch.testing.assert_close(memory(inputs)[0], expected, **same)
    first, state = memory(inputs[:37])
    second, _ = memory(inputs[37:], state)
    torch.testing.assert_close(torch.cat([first, second]), expected, **same)
    steps, state = [], None
    for step in inputs:
        one, state = memory(step[None], state)
        steps.append(one)
    torch.testing.assert_close(torch.cat(steps), expected, **same)


def test_mingru(ours: SimpleNamespace, inputs: Any) -> None:
    from minGRU_pytorch.minGRU import minGRU

    theirs, memory = minGRU(WIDTH, expansion_factor=2.0), ours.mingru.MinGru(WIDTH, 2 * WIDTH)
    copy(
        (theirs.to_hidden_and_gate.weight, memory.candidate_and_gate.weight),
        (torch.zeros(2 * WIDTH), memory.gate_bias),  # theirs has none
        (theirs.to_out.weight, memory.output.weight),
    )
    assert_same(memory, inputs, theirs(inputs.transpose(0, 1)))


def test_mamba(ours: SimpleNamespace, inputs: Any) -> None:
    from mambapy.mamba import MambaBlock, MambaConfig

    theirs = shake(MambaBlock(MambaConfig(d_model=WIDTH, n_layers=1)))
    memory = ours.mamba.Mamba(WIDTH, 2 * WIDTH)
    copy(
        (theirs.in_proj.weight, memory.input.weight),
        (theirs.conv1d.weight[:, 0], memory.convolution.weight),
        (theirs.conv1d.bias, memory.convolution.bias),
        (theirs.x_proj.weight, memory.select.weight),
        (theirs.dt_proj.weight, memory.step.weight),
        (theirs.dt_proj.bias, memory.step.bias),
        (theirs.A_log, memory.log_rates),
        (theirs.D, memory.skip),
        (theirs.out_proj.weight, memory.output.weight),
    )
    assert_same(memory, inputs, theirs(inputs.transpose(0, 1)))


def test_xlstm(ours: SimpleNamespace, inputs: Any) -> None:
    from xlstm.blocks.mlstm.layer import mLSTMLayer, mLSTMLayerConfig

    config = mLSTMLayerConfig(embedding_dim=WIDTH, context_length=STEPS, proj_factor=2.0)
    theirs = mLSTMLayer(config)
    size = config._inner_embedding_dim
    theirs, memory = shake(theirs), ours.xlstm.Xlstm(WIDTH, size)
    cell = theirs.mlstm_cell
    copy(
        (theirs.proj_up.weight, memory.input.weight),
        (theirs.conv1d.conv.weight[:, 0], memory.convolution.weight),
        (theirs.conv1d.conv.bias, memory.convolution.bias),
        (theirs.q_proj.weight, memory.query.weight),
        (theirs.k_proj.weight, memory.key.weight),
        (theirs.v_proj.weight, memory.value.weight),
        (torch.cat([cell.igate.weight, cell.fgate.weight]), memory.cell.gates.weight),
        (torch.cat([cell.igate.bias, cell.fgate.bias]), memory.cell.gates.bias),
        (1 + cell.outnorm.weight, memory.cell.scale),  # theirs is kept as the difference from 1
        (theirs.learnable_skip, memory.skip),
        (theirs.proj_down.weight, memory.output.weight),
    )
    assert_same(memory, inputs, theirs(inputs.transpose(0, 1)))


def test_the_diagonal_recurrence_of_the_lru(ours: SimpleNamespace, inputs: Any) -> None:
    from s5.s5_model import apply_ssm

    layer = ours.lru.LinearRecurrence(WIDTH, 24)
    into, out_of = (torch.complex(*part.detach()) for part in (layer.into, layer.out_of))
    with torch.no_grad():
        scaled = layer.log_gamma.exp()[:, None] * into
        eigenvalues = layer.eigenvalues()
        for env in range(ENVS):
            steps = inputs[:, env]
            expected, last = apply_ssm(eigenvalues, scaled, out_of, layer.skip, steps)
            start = torch.zeros(1, 24, dtype=torch.complex64)
            outputs, state = layer(steps[:, None], start)
            torch.testing.assert_close(outputs[:, 0], expected, rtol=1e-5, atol=1e-5)
            torch.testing.assert_close(state[0], last, rtol=1e-5, atol=1e-5)


def test_scans(ours: SimpleNamespace) -> None:
    """Both forms, values and derivatives, against Mamba's parallel scan of mambapy."""
    from mambapy.pscan import pscan

    torch.manual_seed(0)
    parts = torch.rand(64, 2, 4, 3), torch.randn(64, 2, 4, 3)
    weights = torch.randn(64, 2, 4, 3)

    def values_and_derivatives(function: Any) -> list[Any]:
        decay, entered = (part.clone().requires_grad_() for part in parts)
        states = function(decay, entered)
        (states * weights).sum().backward()
        return [states.detach(), decay.grad, entered.grad]

    def theirs(decay: Any, entered: Any) -> Any:
        return pscan(decay.transpose(0, 1), entered.transpose(0, 1)).transpose(0, 1)

    expected = values_and_derivatives(theirs)
    for form in (ours.scan.loop, ours.scan.associative_scan):
        zeros = torch.zeros(2, 4, 3)
        got = values_and_derivatives(lambda a, b, form=form, zeros=zeros: form(a, b, zeros))
        for one, other in zip(got, expected):
            torch.testing.assert_close(one, other, rtol=1e-4, atol=1e-5)


def test_the_gates_of_the_transformer(ours: SimpleNamespace, inputs: Any) -> None:
    from x_transformers.x_transformers import GRUGating

    theirs, gate = shake(GRUGating(WIDTH)), ours.gtrxl.Gate(WIDTH)
    gate.cell.load_state_dict(theirs.gru.state_dict())
    layer = torch.randn_like(inputs)
    torch.testing.assert_close(gate(inputs, layer), theirs(layer, inputs), rtol=1e-5, atol=1e-5)


def test_the_attention_of_the_transformer(ours: SimpleNamespace, inputs: Any) -> None:
    """By content. The terms of distance are zero: python/tests/test_memory_zoo.py has them."""
    from x_transformers import Attention

    theirs = Attention(WIDTH, dim_head=WIDTH // 2, heads=2, causal=True, flash=False)
    attention = ours.gtrxl.RelativeAttention(WIDTH, 2, window=STEPS)
    key_and_value = torch.cat([theirs.to_k.weight, theirs.to_v.weight])
    copy(
        (theirs.to_q.weight, attention.query.weight),
        (key_and_value, attention.key_and_value.weight),
        (torch.zeros(WIDTH, WIDTH), attention.distance.weight),
        (theirs.to_out.weight, attention.output.weight),
    )
    steps = inputs.transpose(0, 1)
    expected = theirs(steps)
    expected = expected[0] if isinstance(expected, tuple) else expected
    there = torch.ones(ENVS, 40, dtype=torch.bool)
    whole = attention(steps, steps[:, :0], there[:, :0])
    torch.testing.assert_close(whole, expected, rtol=1e-5, atol=1e-5)
    later = attention(steps[:, 40:], steps[:, :40], there)
    torch.testing.assert_close(later, expected[:, 40:], rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("name", ["gru", "lstm"])
def test_layers_of_torch(ours: SimpleNamespace, inputs: Any, name: str) -> None:
    memory = ours.make(name, WIDTH, 2 * WIDTH)
    kind = {"gru": torch.nn.GRUCell, "lstm": torch.nn.LSTMCell}[name]
    cell = kind(WIDTH, 2 * WIDTH)
    cell.load_state_dict(
        {k.removesuffix("_l0"): v for k, v in memory.recurrence.state_dict().items()}
    )
    expected, state = [], None
    for step in inputs:
        state = cell(step, state)
        expected.append(memory.output(state[0] if name == "lstm" else state))
    assert_same(memory, inputs, torch.stack(expected, 1))
