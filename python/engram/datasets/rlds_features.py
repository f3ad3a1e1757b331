"""features.json of RLDS data sets: what tensorflow_datasets is told about the fields."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from engram.datasets import checks
from engram.datasets.labels import STEP_FIELDS, Labels
from engram.datasets.spaces import Spaces

_DTYPES: dict[type, str] = {np.bool_: "bool", np.int32: "int32", np.float32: "float32"}


def features(spaces: Spaces, labels: Labels | None) -> dict[str, Any]:
    """The document; labels: those of an episode, if they are to be in the set."""
    steps = {
        "observation": _dict(
            image=_image(),
            wrist_image=_image(),
            proprio=_tensor("float32", len(spaces.proprio_names)),
        ),
        "action": _tensor("float32", len(spaces.action_names)),
        "reward": _tensor("float32"),
        "discount": _tensor("float32"),
        "is_first": _tensor("bool"),
        "is_last": _tensor("bool"),
        "is_terminal": _tensor("bool"),
        "language_instruction": _text(),
    }
    metadata = {"env_id": _text(), "episode_seed": _tensor("int64")}
    if labels is not None:
        steps["privileged"] = _dict(**_label_features(labels))
        metadata["paraphrases"] = _sequence(_text())
    return _dict(
        steps=_class("dataset_feature.Dataset")
        | {"sequence": {"feature": _dict(**steps), "length": "-1"}},
        episode_metadata=_dict(**metadata),
    )


# --- labels ---


def _label_features(labels: Labels) -> dict[str, Any]:
    numbers = {
        name: _tensor(_DTYPES[STEP_FIELDS[name][0]], *STEP_FIELDS[name][1]) for name in labels.steps
    }
    return numbers | {name: _text() for name in _texts(labels)}


def _texts(labels: Labels) -> dict[str, list[str]]:
    return {
        "subtask": labels.subtasks(),
        "plan": labels.plans(),
        "memory": labels.memories(),
        "object": labels.objects(),
    }


def label_values(labels: Labels, instruction: str) -> dict[str, Sequence[Any]]:
    """The fields of an episode's record."""
    values: dict[str, Sequence[Any]] = {}
    for name, array in labels.steps.items():
        numbers = array.astype(np.int64) if array.dtype == np.bool_ else array
        values[f"steps/privileged/{name}"] = numbers.ravel().tolist()
    for name, texts in _texts(labels).items():
        values[f"steps/privileged/{name}"] = [text.encode() for text in texts]
    wordings = dict.fromkeys([instruction, *labels.paraphrases])
    values["episode_metadata/paraphrases"] = [wording.encode() for wording in wordings]
    return values


# --- kinds of features ---


def _class(name: str) -> dict:
    return {"pythonClassName": f"tensorflow_datasets.core.features.{name}"}


def _tensor(dtype: str, *shape: int) -> dict:
    kind = "tensor_feature.Tensor" if shape else "scalar.Scalar"
    dimensions = {"dimensions": [str(size) for size in shape]} if shape else {}
    return _class(kind) | {"tensor": {"dtype": dtype, "encoding": "none", "shape": dimensions}}


def _image() -> dict:
    return _class("image_feature.Image") | {
        "image": {
            "dtype": "uint8",
            "encodingFormat": "png",
            "shape": {"dimensions": [str(size) for size in checks.CAMERA_SHAPE]},
        }
    }


def _text() -> dict:
    return _class("text_feature.Text") | {"text": {}}


def _dict(**features: dict) -> dict:
    return _class("features_dict.FeaturesDict") | {"featuresDict": {"features": features}}


def _sequence(feature: dict[str, Any]) -> dict[str, Any]:
    return _class("sequence_feature.Sequence") | {"sequence": {"feature": feature, "length": "-1"}}
