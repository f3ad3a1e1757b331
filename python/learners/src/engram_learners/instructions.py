"""Instructions as inputs of a policy: bags of words, and their embedding.

The vocabulary has the words of the wordings that are trained on. Other words are skipped, numbers
too: the angle of a Rotate task is an observation of its own.
"""

import re

import torch
from torch import nn

HELD_OUT = 2  # last wordings of every instruction, never trained on
EMBEDDING = 16  # numbers that an instruction becomes


def words_of(sentence):
    return set(re.findall(r"[a-z]+", re.sub(r"\{\w*\}", "", sentence.lower())))


def turns_of(sentences):
    """Angles (N, 1) by which sentences ask to turn something, in units of pi; 0 without one."""
    asked = [re.search(r"(-?\d+) degrees", sentence) for sentence in sentences]
    return torch.tensor([[int(found[1]) / 180 if found else 0.0] for found in asked])


def vocabulary(tasks):
    """Words of the wordings that are trained on, from the descriptions of tasks."""
    wordings = [text for task in tasks for text in trained(task["instruction"], task)]
    return sorted(set().union(*map(words_of, wordings)))


def trained(instruction, words):
    """Wordings that are trained on. words: has "paraphrases"; a task without any has its own."""
    return [instruction, *words["paraphrases"][:-HELD_OUT]]


def own(batch):
    """The instruction of every environment of a batch, as the benchmark has it."""
    return list(batch.instructions)


def drawn(batch):
    """One of the trained wordings for every environment, drawn anew at each call."""
    result = []
    for instruction, words in zip(batch.instructions, batch.words()):
        wordings = trained(instruction, words)
        result.append(wordings[torch.randint(len(wordings), ())])
    return result


def held_out(batch):
    """The wordings that are not trained on, in turns; the own one of tasks without others."""
    result = []
    for i, (instruction, words) in enumerate(zip(batch.instructions, batch.words())):
        wordings = words["paraphrases"][-HELD_OUT:] or [instruction]
        result.append(wordings[i % len(wordings)])
    return result


class BagOfWords:
    """Which words of a vocabulary a sentence has: (N, V) of zeros and ones."""

    def __init__(self, words):
        self.words = list(words)
        self.index = {word: i for i, word in enumerate(self.words)}

    def __call__(self, sentences):
        bags = torch.zeros(len(sentences), len(self.words))
        for bag, sentence in zip(bags, sentences):
            bag[[self.index[word] for word in words_of(sentence) if word in self.index]] = 1
        return bags


class InstructionEncoder(nn.Module):
    """Embeds bags of words (..., V): the scaled sum of the words' vectors."""

    def __init__(self, words):
        super().__init__()
        self.vectors = nn.Linear(words, EMBEDDING)
        nn.init.normal_(self.vectors.weight)  # so that few words in common are few numbers alike
        nn.init.zeros_(self.vectors.bias)

    def forward(self, bags):
        return self.vectors(bags / bags.sum(-1, keepdim=True).clamp(min=1).sqrt())
