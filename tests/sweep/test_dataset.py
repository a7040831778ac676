"""Table and states, written and read back."""

from __future__ import annotations

import pickle
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from many import written

import sheetmorph as sm
from sheetmorph.sweep.dataset import Sweep
from sheetmorph.sweep.plan import Plan
from sheetmorph.sweep.states import write_states
from sheetmorph.sweep.table import read_about, write_table
from sheetmorph.sweep.task import lost, solve


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep of four designs, the second of which was lost."""
    place = tmp_path_factory.mktemp("sweep")
    plan = Plan.load(written(place))
    outcomes = [solve(plan.task(k)) if k != 1 else lost(plan.task(1), "why") for k in range(4)]
    write_table(plan, lambda: (o.row for o in outcomes), place / "results.parquet", complete=True)
    arrays = ((k, o.arrays) for k, o in enumerate(outcomes))
    write_states(arrays, 4, plan.fingerprint, place / "states.h5")
    return place


def test_the_table_has_types_units_and_an_order(folder: Path) -> None:
    table = pq.read_table(folder / "results.parquet")
    names = table.column_names
    assert names[:5] == [
        "index", "id", "actuation.eps_pre", "layers.print.thickness", "mesh.size",
    ]  # fmt: skip
    assert names.index("aspect_ratio") < names.index("status") < names.index("seconds")
    types = {field.name: field.type for field in table.schema}
    assert types["index"] == types["nodes"] == pa.int64()
    assert types["aspect_ratio"] == types["seconds"] == pa.float64()
    assert types["stable"] == pa.bool_()
    assert types["reason"] == pa.string()
    assert table["status"].to_pylist() == [
        "completed", "worker_lost", "completed", "completed",
    ]  # fmt: skip
    assert table["reason"].to_pylist()[1] == "why"
    assert table["aspect_ratio"].to_pylist()[1] is None
    units = Sweep.load(folder).units
    assert units["layers.print.thickness"] == units["bbox_m.x"] == "m"
    assert units["energy_J.total"] == "J"
    assert "aspect_ratio" not in units
    about = read_about(folder / "results.parquet")
    assert (about["complete"], about["designs"], about["version"]) == (True, 4, sm.__version__)
    assert about["sweep"] == (folder / "stars.toml").read_text("utf-8")


def test_a_sweep_is_a_data_set_with_a_length_and_entries(folder: Path) -> None:
    sweep = Sweep.load(folder)
    plan = Plan.load(folder / "stars.toml")
    assert len(sweep) == 4
    assert sweep.rows_with_shape() == [0, 2, 3]
    for place in (3, -1):
        entry = sweep[place]
        result = sm.simulate(plan.task(3).make())
        assert entry["row"]["aspect_ratio"] == result.summary["aspect_ratio"]
        np.testing.assert_array_equal(entry["positions"], result.positions[-1:])
        np.testing.assert_array_equal(entry["triangles"], result.mesh.triangles)
    assert sweep[1]["positions"].shape == (0, 0, 3)
    with pytest.raises(IndexError):
        sweep[4]
    copy = pickle.loads(pickle.dumps(sweep))  # noqa: S301  workers of a data loader do this
    np.testing.assert_array_equal(copy[2]["positions"], sweep[2]["positions"])
    assert [entry["row"]["index"] for entry in sweep] == [0, 1, 2, 3]


def test_the_states_lie_end_to_end_in_chunks(folder: Path) -> None:
    with h5py.File(folder / "states.h5") as file:
        starts = file["node_start"][()]
        assert starts[0] == 0
        assert starts[1] == starts[2]
        assert starts[-1] == len(file["nodes"]) == len(file["positions"])
        assert file["triangle_start"][-1] == len(file["triangles"]) == len(file["in_pattern"])
        assert file["positions"].chunks is not None
        assert file["positions"].attrs["unit"] == "m"


def test_what_is_no_sweep_is_refused(tmp_path: Path) -> None:
    with pytest.raises(sm.InputError, match="holds no"):
        Sweep.load(tmp_path)
    path = tmp_path / "results.parquet"
    for write in (lambda: path.write_bytes(b"PAR1"), lambda: pq.write_table(pa.table({}), path)):
        write()
        with pytest.raises(sm.InputError, match="no table of a sweep"):
            Sweep.load(tmp_path)


def test_damaged_states_are_told(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "results.parquet").write_bytes((folder / "results.parquet").read_bytes())
    (tmp_path / "states.h5").write_bytes((folder / "states.h5").read_bytes()[:2000])
    with pytest.raises(sm.InputError, match="cannot be read"):
        Sweep.load(tmp_path)[0]
    (tmp_path / "states.h5").unlink()
    assert set(Sweep.load(tmp_path)[0]) == {"row"}
