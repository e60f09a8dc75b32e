"""Checks from outside that frames open in pyarrow, pandas, polars and DuckDB, also while they are being written.

    pip install pyarrow pandas polars duckdb
    python common/tests/frames_pyarrow.py FILE.particles.arrow            a file at rest
    python common/tests/frames_pyarrow.py FILE.particles.arrow --follow   a file that another process begins to
                                                                          write, for 10 s
"""

import os
import sys
import time

import pyarrow as pa


def frames_of(path):
    """Time, step and table of each frame, the empty ones too."""
    with pa.OSFile(path) as file, pa.ipc.open_stream(file) as stream:
        while True:
            try:
                batch, metadata = stream.read_next_batch_with_custom_metadata()
            except StopIteration:
                return
            yield float(metadata[b"time"]), int(metadata[b"step"]), batch


def at_rest(path):
    import duckdb
    import pandas as pd
    import polars as pl

    frames = list(frames_of(path))
    rows = sum(batch.num_rows for _, _, batch in frames)
    for when, _, batch in frames:
        batch.validate(full=True)
        assert all(t == when for t in batch.column("time").to_pylist())
    steps = [step for _, step, _ in frames]
    assert steps == sorted(set(steps))
    with pa.OSFile(path) as file:
        schema = pa.ipc.open_stream(file).schema
    print(len(frames), "frames,", rows, "rows, schema", dict(schema.metadata))
    for field in schema:
        print(f"  {field.name:12} {str(field.type):8}", field.metadata[b"unit"].decode())

    with pa.OSFile(path) as file:
        table = pa.ipc.open_stream(file).read_all()
    particles = table
    frame = table.to_pandas()
    assert isinstance(frame, pd.DataFrame) and len(frame) == rows
    print("pandas  ", frame.groupby("time").size().head(3).to_dict())
    frame = pl.read_ipc_stream(path)
    assert frame.height == rows and frame.columns == table.column_names
    print("polars  ", frame.group_by("time", maintain_order=True).len().head(3).rows())
    print("duckdb  ", duckdb.sql("select time, count(*) from particles group by time order by time limit 3").fetchall())


def follow(path):
    import polars as pl

    opened = grown = known = 0
    print("waiting for the writer", flush=True)
    begun = time.monotonic()
    while not os.path.exists(path) and time.monotonic() - begun < 30:
        time.sleep(0.001)
    begun = time.monotonic()
    while time.monotonic() - begun < 10:
        frames = rows = 0
        for when, step, batch in frames_of(path):
            assert step == frames, (step, frames)
            if batch.num_rows:
                assert batch.column("time")[0].as_py() == when == batch.column("time")[-1].as_py()
            frames += 1
            rows += batch.num_rows
        height = pl.read_ipc_stream(path).height if frames else 0
        assert height >= rows, (height, rows)
        assert frames >= known
        grown += frames > known
        known = frames
        opened += 1
    print(f"opened {opened} times, longer than before {grown} times, at last {known} frames")
    assert grown > 1


if __name__ == "__main__":
    follow(sys.argv[1]) if "--follow" in sys.argv else at_rest(sys.argv[1])
