"""Linear recurrences: h[t] = decay[t] * h[t-1] + inputs[t], elementwise, real or complex.

Such a recurrence is associative, so that all steps can be computed together in log2(T) passes over
the whole sequence (`associative_scan`). On an accelerator that is faster than T small steps. On one
core work counts, and the scan does log2(T) times as much: there `loop` goes step by step, with a
derivative of its own, which is the same recurrence backwards.
"""

import torch


def scan(decay, inputs, state):
    """Decay and inputs (T, N, ...), state (N, ...) before the first step -> h (T, N, ...)."""
    decay = decay.expand_as(inputs)
    if inputs.device.type == "cpu":
        return loop(decay, inputs, state)
    return associative_scan(decay, inputs, state)


def associative_scan(decay, inputs, state):
    """After the pass of a distance, h[t] is right for states that far back, and decay[t] theirs."""
    result = torch.cat([inputs[:1] + decay[:1] * state, inputs[1:]])
    distance = 1
    while distance < len(inputs):
        moved = result[distance:] + decay[distance:] * result[:-distance]
        result = torch.cat([result[:distance], moved])
        decay = torch.cat([decay[:distance], decay[distance:] * decay[:-distance]])
        distance *= 2
    return result


class Loop(torch.autograd.Function):
    @staticmethod
    def forward(ctx, decay, inputs, state):
        states = torch.empty_like(inputs)
        last = state
        for t in range(len(inputs)):
            last = torch.addcmul(inputs[t], decay[t], last, out=states[t])
        ctx.save_for_backward(decay, states, state)
        return states

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx, gradients):
        decay, states, state = ctx.saved_tensors
        back = decay.conj().resolve_conj()
        total = torch.empty_like(states)  # with what comes back from later steps
        total[-1] = gradients[-1]
        for t in range(len(total) - 2, -1, -1):
            torch.addcmul(gradients[t], back[t + 1], total[t + 1], out=total[t])
        earlier = torch.cat([state[None], states[:-1]])
        return total * earlier.conj(), total, back[0] * total[0]


loop = Loop.apply
