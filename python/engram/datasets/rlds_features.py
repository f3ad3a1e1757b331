"""features.json of RLDS data sets: the fields, for tensorflow_datasets."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from engram.datasets import additions, checks
from engram.datasets.frozen import COLUMN
from engram.datasets.labels import STEP_FIELDS, Labels
from engram.datasets.spaces import Spaces

_DTYPES: dict[type, str] = {np.bool_: "bool", np.int32: "int32", np.float32: "float32"}


def features(
    spaces: Spaces,
    added: Collection[str],
    labels: Labels | None,
    is_frozen: bool = False,
    rows: Mapping[str, int] | None = None,
) -> dict[str, Any]:
    """The document; added: additions of the set; labels: those of an episode, if among them.

    rows: widths of state or objects, where they are among them; is_frozen: whether steps say that
    their action was not executed.
    """
    maps = [name for name in additions.MAPS if name in added]
    observation = {
        "image": _image(),
        "wrist_image": _image(),
        **{key: _map() for name in maps for key in additions.map_keys(name)},
        "proprio": _tensor("float32", len(spaces.proprio_names)),
        **{name: _tensor("float32", width) for name, width in (rows or {}).items()},
    }
    steps = {
        "observation": _dict(**observation),
        "action": _tensor("float32", len(spaces.action_names)),
        "reward": _tensor("float32"),
        "discount": _tensor("float32"),
        "is_first": _tensor("bool"),
        "is_last": _tensor("bool"),
        "is_terminal": _tensor("bool"),
        "language_instruction": _text(),
    }
    if is_frozen:
        steps[COLUMN] = _tensor("bool")
    metadata = {"env_id": _text(), "episode_seed": _tensor("int64")}
    if additions.SEGMENTATION in added:
        metadata[additions.SEGMENT_NAMES] = _sequence(_text())
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
    return numbers | {name: _text() for name in labels.step_texts()}


def label_values(labels: Labels, instruction: str) -> dict[str, Sequence[Any]]:
    """The fields of an episode's record."""
    values: dict[str, Sequence[Any]] = {}
    for name, array in labels.steps.items():
        numbers = array.astype(np.int64) if array.dtype == np.bool_ else array
        values[f"steps/privileged/{name}"] = numbers.ravel().tolist()
    for name, texts in labels.step_texts().items():
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


def _image(dtype: str = "uint8", shape: Sequence[int] = checks.CAMERA_SHAPE) -> dict:
    return _class("image_feature.Image") | {
        "image": {
            "dtype": dtype,
            "encodingFormat": "png",
            "shape": {"dimensions": [str(size) for size in shape]},
        }
    }


def _map() -> dict:
    return _image("uint16", additions.MAP_SHAPE)


def _text() -> dict:
    return _class("text_feature.Text") | {"text": {}}


def _dict(**features: dict) -> dict:
    return _class("features_dict.FeaturesDict") | {"featuresDict": {"features": features}}


def _sequence(feature: dict[str, Any]) -> dict[str, Any]:
    return _class("sequence_feature.Sequence") | {"sequence": {"feature": feature, "length": "-1"}}
