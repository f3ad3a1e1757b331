"""Files of converted data sets: a changed one is refused, and what is no file is not waited for."""

from __future__ import annotations

import json
import os

import pytest
from sound_dataset import write_sound

pytest.importorskip("pyarrow")
pytest.importorskip("av")
pytest.importorskip("google_crc32c")
pytest.importorskip("h5py")

import pyarrow as pa
import pyarrow.parquet as pq

from engram.datasets import DatasetError, DemonstrationFolder, hdf5, lerobot, rlds
from engram.datasets.readers import READERS

SETS = ["rlds", "hdf5", "lerobot 3.0", "lerobot 2.1"]


@pytest.fixture(params=SETS)
def stored(request, tmp_path):
    """A small data set: its folder, and a function that reads all of its episodes."""
    source = DemonstrationFolder(write_sound(tmp_path))
    name, _, version = request.param.partition(" ")
    writers = {"rlds": rlds, "hdf5": hdf5, "lerobot": lerobot}
    path = writers[name].convert(source, tmp_path, **({"version": version} if version else {}))
    return path, lambda: list(READERS[name](source, tmp_path))


def listed(path):
    (document,) = path.rglob("engram.json")
    return sorted(json.loads(document.read_text())["files"])


def test_every_file_but_the_card_is_listed(stored):
    path, read = stored
    files = {str(file.relative_to(path)) for file in path.rglob("*") if file.is_file()}
    (document,) = path.rglob("engram.json")
    others = {"README.md", ".engram_files.json", str(document.relative_to(path))}
    assert set(listed(path)) == files - others
    (path / "README.md").write_text("mine")
    (path / ".gitattributes").write_text("of a hub")
    assert len(read()) == 2


def test_a_changed_byte_of_any_file_is_noticed(stored):
    path, read = stored
    for name in listed(path):
        whole = (path / name).read_bytes()
        for place in (0, len(whole) // 2, len(whole) - 1):
            (path / name).write_bytes(
                whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :]
            )
            with pytest.raises(DatasetError, match="changed since it was written"):
                read()
        (path / name).unlink()
        with pytest.raises(DatasetError, match="missing"):
            read()
        (path / name).write_bytes(whole)
    (document,) = path.rglob("engram.json")
    document.write_text(document.read_text().replace("pd_ee_delta_pose", "pd_joint_delta_pos"))
    with pytest.raises(DatasetError, match="it was edited"):
        read()


def test_a_pipe_is_not_waited_for(stored):
    path, read = stored
    (document,) = path.rglob("engram.json")
    for name in [*listed(path), str(document.relative_to(path))]:
        (path / name).rename(path / "aside")
        os.mkfifo(path / name)
        with pytest.raises(DatasetError, match="missing, or no file"):
            read()
        (path / "aside").replace(path / name)
        if name.endswith((".parquet", "-of-00001")):  # one more, which nothing lists
            beside = (path / name).with_name(f"mikasa_dataset-train.tfrecord-9{name[-8:]}")
            os.mkfifo(beside)
            if name.startswith(("meta/episodes", "mikasa")):
                with pytest.raises(DatasetError, match="missing, or no file"):
                    read()
            beside.unlink()


@pytest.mark.parametrize(
    "column", ["timestamp", "frame_index", "index", "task_index", "episode_index", "action"]
)
def test_changed_columns_of_lerobot_are_noticed(tmp_path, column):
    source = DemonstrationFolder(write_sound(tmp_path))
    file = lerobot.convert(source, tmp_path) / "data" / "chunk-000" / "file-000.parquet"
    table = pq.read_table(file)
    rows = table.column(column).to_pylist()
    rows[1] = rows[2]
    place = table.column_names.index(column)
    changed = pa.array(rows, table.schema.field(column).type)
    pq.write_table(table.set_column(place, table.schema.field(column), changed), file)
    with pytest.raises(DatasetError, match="changed since it was written"):
        list(READERS["lerobot"](source, tmp_path))
