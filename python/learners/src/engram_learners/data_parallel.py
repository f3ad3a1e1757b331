"""Data-parallel training in processes of `torchrun`: gradients are averaged.

torchrun --nproc-per-node 2 -m engram_learners.ppo_recurrent --id RememberColor3-VLA-v0
"""

import os

import torch
from torch import distributed


def start():
    """-> rank of this process, number of processes."""
    processes = int(os.environ.get("WORLD_SIZE", 1))
    if processes > 1:
        distributed.init_process_group("gloo")
    return int(os.environ.get("RANK", 0)), processes


def broadcast(module):
    """Copies the first process's weights and buffers to all processes."""
    if distributed.is_initialized():
        for tensor in module.state_dict().values():
            distributed.broadcast(tensor, 0)


def average(module):
    """Averages gradients over the processes."""
    if not distributed.is_initialized():
        return
    gradients = [p.grad for p in module.parameters() if p.grad is not None]
    flat = torch.cat([g.flatten() for g in gradients])
    distributed.all_reduce(flat)
    flat /= distributed.get_world_size()
    for gradient, part in zip(gradients, flat.split([g.numel() for g in gradients])):
        gradient.copy_(part.view_as(gradient))


def end():
    if distributed.is_initialized():
        distributed.barrier()
        distributed.destroy_process_group()
