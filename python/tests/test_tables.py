"""Columns and tables in the packages that read them."""

import gc
import resource

import mercury_dem as md
import numpy as np
import pandas
import polars
import pyarrow
import pytest


@pytest.fixture
def table(pour) -> md.Table:
    with md.Run(pour) as run:
        run.advance(0.05)
        return run.particles()


def address(array: np.ndarray) -> int:
    return array.__array_interface__["data"][0]


def test_numpy_polars_and_pyarrow_share_the_memory(table):
    column = table["x"]
    array = np.asarray(column)
    assert array.dtype == np.float64 and len(array) == len(column) == len(table)
    assert not array.flags.writeable
    assert list(array) == list(column)
    there = column.__array_interface__["data"][0]
    assert address(array) == there
    assert address(pyarrow.array(column).to_numpy()) == there
    assert address(pyarrow.table(table)["x"].chunk(0).to_numpy()) == there
    assert address(polars.Series(column).to_numpy(allow_copy=False)) == there
    assert address(polars.DataFrame(table)["x"].to_numpy(allow_copy=False)) == there


def test_values_outlive_the_run_and_the_table(pour):
    with md.Run(pour) as run:
        run.advance(0.05)
        table = run.particles()
        array = np.asarray(table["z"])
        frame = polars.DataFrame(table)
    kept = array.copy()
    del run, table
    gc.collect()
    assert (array == kept).all() and (frame["z"].to_numpy() == kept).all()


def test_frames_of_pandas(table):
    frame = pandas.DataFrame({name: np.asarray(table[name]) for name in ["id", "x", "vz"]})
    assert frame["vz"].mean() == pytest.approx(np.asarray(table["vz"]).mean())
    frame = pyarrow.table(table).to_pandas()
    assert list(frame.columns) == list(table.columns)


def test_units_are_in_the_schema(table):
    schema = pyarrow.table(table).schema
    assert schema.field("x").metadata[b"unit"] == b"m"
    assert table["mass"].unit == "kg"


def test_rows_without_a_value_and_texts(pour):
    with md.Run(pour) as run:
        run.advance(0.1)
        contacts, walls = run.contacts(), run.walls()
    partners = list(contacts["j"])
    assert None in partners
    with pytest.raises(TypeError, match="rows without a value"):
        np.asarray(contacts["j"]).sum()
        contacts["j"].__array_interface__
    assert pyarrow.array(contacts["j"]).null_count == partners.count(None)
    with pytest.raises(TypeError, match="texts"):
        walls["name"].__array_interface__
    assert "box.-z" in list(walls["name"])
    assert polars.DataFrame(walls).filter(polars.col("name") == "box.-z")["fz"][0] < 0


def test_rows_and_columns_by_place_and_name(table):
    column = table["id"]
    assert column[0] == 0 and column[-1] == len(column) - 1
    for row in (len(column), -len(column) - 1):
        with pytest.raises(IndexError, match="column `id`, which has 100"):
            column[row]
    assert "x" in table and "u" not in table
    with pytest.raises(KeyError, match="no column `u`"):
        table["u"]
    assert table.time == pytest.approx(0.05, abs=1e-4)
    html = table._repr_html_()
    assert "<th>x<br>m</th>" in html and html.count("<tr>") == 12


def test_a_thousand_tables_leave_no_memory(pour):
    with md.Run(pour) as run:
        run.advance(0.05)
        for _ in range(200):
            polars.DataFrame(run.particles())
        gc.collect()
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(1000):
            table = run.particles()
            table.__arrow_c_stream__(), table["x"].__arrow_c_array__()
            polars.DataFrame(table)
        gc.collect()
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # Each table holds some 20 kB: that would be 20 MB.
    assert after - before <= 1024, f"{after - before} kB"


def test_tables_of_a_record(pour, tmp_path):
    pour["output"]["ene"] = True
    md.run(pour, output=tmp_path / "run")
    record = md.open(tmp_path / "run")
    assert record.summary.status == "finished"
    energy = record.table("energy")
    assert energy["traKineticEnergy"].unit == "J" and len(energy) == len(record.times)
    assert record.frame(0).time == 0.0 and record.frame(-1).time == pytest.approx(0.1)
    assert record.frame(columns=["z", "id"]).columns == ("z", "id")
    with pytest.raises(IndexError, match="no frame 99"):
        record.frame(99)
    with pytest.raises(KeyError, match="no column `u`"):
        record.frame(columns=["u"])
    with pytest.raises(md.RunError, match="no table `wals`"):
        record.table("wals")
    with pytest.raises(md.RunError, match="regions.csv cannot be read"):
        record.table("regions")
    with pytest.raises(md.RunError, match="no run is there"):
        md.open(tmp_path)
