"""docs/notebooks: they run, and print what the site shows."""

from __future__ import annotations

import base64
import io
import sys
from pathlib import Path
from typing import Any

import pytest

for package in ("nbclient", "ipykernel", "torch", "matplotlib"):
    pytest.importorskip(package)

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import nbformat  # noqa: E402
from pages.notebooks import FOLDER, executed  # noqa: E402

sys.path.pop(0)


def printed(cell: Any) -> str:
    assert not [o for o in cell.outputs if o.get("name") == "stderr"], cell.outputs
    return "".join(o["text"] for o in cell.outputs if o.output_type == "stream")


def pictures(cell: Any) -> list[Any]:
    from matplotlib.image import imread

    found = [o["data"]["image/png"] for o in cell.outputs if "image/png" in o.get("data", {})]
    return [imread(io.BytesIO(base64.b64decode(picture))) for picture in found]


def code_cells(notebook: Any) -> list[Any]:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


@pytest.fixture(scope="module", params=["first_rollout", "demonstrations_to_score"])
def notebook(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Stored outputs, and those of a run."""
    file = FOLDER / f"{request.param}.ipynb"
    fresh = executed(file, tmp_path_factory.mktemp(request.param))
    return request.param, code_cells(nbformat.read(file, as_version=4)), code_cells(fresh)


def test_it_prints_the_output_of_the_site(notebook: Any) -> None:
    name, stored, fresh = notebook
    for old, new in zip(stored, fresh):
        if "varies" in old.metadata.get("tags", []):
            assert bool(printed(old)) == bool(printed(new))  # a network's numbers, by machine
        else:
            assert printed(new) == printed(old), f"{name} is stale: run tools/docs.py notebooks"
        assert len(pictures(new)) == len(pictures(old))


def test_its_pictures_show_something(notebook: Any) -> None:
    for cell in notebook[2]:
        for picture in pictures(cell):
            assert min(picture.shape[:2]) > 100
            assert picture[..., :3].std() > 0.1  # not one colour


def test_descriptions_match_the_environment(notebook: Any) -> None:
    name, _, cells = notebook
    words = [line.rsplit(maxsplit=1) for cell in cells for line in printed(cell).splitlines()]
    values = {row[0].strip(): row[1] for row in words if len(row) == 2}
    if name == "first_rollout":
        assert float(values["oracle"]) > 0.95
        assert float(values["blind"]) < float(values["sweep"]) < 0.6
        assert sum(len(pictures(cell)) for cell in cells) == 1
    else:
        assert float(values["with memory"]) > 0.7
        assert float(values["without"]) < 0.5


def test_every_notebook_is_run() -> None:
    names = {file.stem for file in FOLDER.glob("*.ipynb")}
    assert names == {"first_rollout", "demonstrations_to_score"}
