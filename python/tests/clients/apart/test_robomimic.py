"""HDF5 data sets, read by robomimic as released."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("robomimic")

import numpy as np
import robomimic.utils.file_utils as files
import robomimic.utils.obs_utils as observations
from mapped_dataset import maps_of, write_mapped
from robomimic.utils.dataset import SequenceDataset
from sound_dataset import EPISODES, ID, STEPS, arrays_of

import engram
from engram.datasets.__main__ import main

KEYS = ("proprio", "image", "wrist_image", "depth")
LENGTH = 2  # of a sequence


@pytest.fixture
def path(tmp_path: Path) -> str:
    write_mapped(tmp_path)
    assert main(["hdf5", str(tmp_path), "--depth"]) == 0
    modalities = {"low_dim": ["proprio"], "rgb": ["image", "wrist_image"], "depth": ["depth"]}
    observations.initialize_obs_utils_with_obs_specs({"obs": modalities})
    return str(tmp_path / "data_hdf5" / ID / "demonstrations.hdf5")


def test_it_knows_the_environment_and_its_shapes(path):
    environment = files.get_env_metadata_from_dataset(path)
    assert (environment["env_name"], environment["env_version"]) == (ID, engram.__version__)
    shapes = files.get_shape_metadata_from_dataset(path, all_obs_keys=list(KEYS))
    assert shapes["ac_dim"] == 7
    assert shapes["all_shapes"]["proprio"] == [7]
    assert shapes["all_shapes"]["image"] == [3, 128, 128]
    assert shapes["all_shapes"]["depth"] == [1, 128, 128]
    env = engram.make(environment["env_name"], **environment["env_kwargs"])
    observation, _ = env.reset(seed=0)
    assert set(observation) == {"rgb", "depth", "proprio"}
    env.close()


def test_it_reads_every_sequence(path):
    data = SequenceDataset(
        hdf5_path=path,
        obs_keys=KEYS,
        dataset_keys=("actions", "rewards", "dones"),
        seq_length=LENGTH,
        hdf5_cache_mode=None,
        hdf5_use_swmr=True,
        load_next_obs=False,
    )
    assert len(data) == EPISODES * STEPS
    for number in range(EPISODES):
        arrays, depth = arrays_of(number), maps_of(number)["depth"]
        for step in range(STEPS):
            item = data[number * STEPS + step]
            last = min(step + 1, STEPS - 1)  # padded by the last step
            for index, frame in enumerate((step, last)):
                obs = {key: values[index] for key, values in item["obs"].items()}
                np.testing.assert_array_equal(obs["image"], arrays["rgb"][frame, ..., :3])
                np.testing.assert_array_equal(obs["wrist_image"], arrays["rgb"][frame, ..., 3:])
                np.testing.assert_array_equal(obs["depth"], depth[frame, ..., :1])
                np.testing.assert_array_equal(obs["proprio"], arrays["proprio"][frame])
                np.testing.assert_array_equal(item["actions"][index], arrays["action"][frame])
                assert item["rewards"][index] == arrays["reward"][frame]
                assert item["dones"][index] == arrays["done"][frame]
    data.close_and_delete_hdf5_handle()
