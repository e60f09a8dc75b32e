"""Runs in pieces, and the files that they leave."""

import concurrent.futures
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import mercury_dem as md
import pytest


def contents(folder: pathlib.Path) -> dict[str, bytes]:
    """The files that promise equal bytes."""
    left_out = ("run.log", "summary.json", ".restart", ".svg", ".png", ".lock", "plan.toml")
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if not path.name.endswith(left_out)}


def test_pieces_and_looks_change_no_byte(pour, tmp_path):
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    summary = md.run(pour, output=whole)
    assert summary.status == "finished" and summary.steps == md.Scene(pour).check().steps
    with md.Run(pour, output=pieces) as run:
        assert (run.time, run.step, run.is_ended) == (0.0, 0, False)
        while run.advance(by=0.0037) == "reached":
            assert len(run.particles()) == len(run.particles(["x"])["x"])
            run.contacts(), run.walls()
        assert run.is_ended and run.advance() == "ended"
    assert contents(whole) == contents(pieces)
    assert len(contents(whole)) > 4
    assert run.finish().to_dict()["particles"] == summary.to_dict()["particles"] == 100


def test_particles_now_are_those_of_the_frame_of_this_time(pour, tmp_path):
    with md.Run(pour, output=tmp_path / "run") as run:
        run.advance(0.05)
        now = run.particles()
        contacts = run.contacts()
        walls = run.walls()
    record = md.open(tmp_path / "run")
    at = [round(time, 6) for time in record.times].index(0.05)
    frame = record.frame(at)
    assert (now.time, now.step, now.columns) == (frame.time, frame.step, frame.columns)
    for name in now:
        assert list(now[name]) == list(frame[name]), name
        assert now[name].unit == frame[name].unit
    of_frame = record.contacts(at)
    assert contacts.columns == of_frame.columns and len(contacts) == len(of_frame) > 0
    for name in contacts:
        assert list(contacts[name]) == list(of_frame[name]), name
    rows = record.table("walls")
    row = next(row for row, time in enumerate(rows["time"]) if abs(time - 0.05) < 1e-4 and rows["name"][row] == "box.-z")
    here = list(walls["name"]).index("box.-z")
    assert walls["fz"][here] == rows["fz"][row] < 0
    assert walls["fz"].unit == "N" and rows["fz"].unit == "N"


def test_a_step_that_was_not_observed_has_no_contacts(pour, tmp_path):
    with md.Run(pour, output=tmp_path / "run") as run:
        assert len(run.contacts()) == 0
        run.advance(0.02)
        run.checkpoint()
    with md.Run(pour, output=tmp_path / "run", resume=True) as run:
        assert run.step > 0
        with pytest.raises(md.RunError, match="advance the run first"):
            run.contacts()
        run.advance(by=1e-4)
        run.contacts()


def test_a_stopped_run_goes_on_to_the_same_bytes(pour, tmp_path):
    md.run(pour, output=tmp_path / "whole")
    folder = tmp_path / "parts"
    with md.Run(pour, output=folder) as run:
        run.advance(0.03)
    assert run.finish().status == "stopped"
    with pytest.raises(md.RunError, match="resume=True goes on with it, replace=True replaces it"):
        md.Run(pour, output=folder)
    with md.Run(pour, output=folder, resume=True) as run:
        assert run.time > 0.03
        run.advance()
    assert contents(tmp_path / "whole") == contents(folder)
    with pytest.raises(md.RunError, match="has come to its end at t = 0.1"):
        md.Run(pour, output=folder, resume=True)
    # The folder is free again.
    md.run(pour, output=folder, replace=True, set={"time.end": 0.001})


def test_the_program_and_the_module_write_the_same_bytes(pour, tmp_path, project):
    program = project / "target" / "debug" / "mercury-solve"
    program = pathlib.Path(os.environ.get("MERCURY_SOLVE", program))
    if not program.exists():
        pytest.skip("the program mercury-solve is not built")
    md.run(project / "scenes" / "two-spheres.toml", output=tmp_path / "module")
    command = [program, project / "scenes" / "two-spheres.toml", "--output", tmp_path / "program", "--quiet"]
    subprocess.run(command, check=True)
    assert contents(tmp_path / "module") == contents(tmp_path / "program")


def test_results_have_errors(pour, tmp_path):
    pour["output"]["interval"] = 0.001
    load = {"load": "mean(walls.box.-z.fz, 0.05..)", "top": "max(particles.z)"}
    load["load"] = 'mean(walls."box.-z".fz, 0.05..)'
    with md.Run(pour, output=tmp_path / "run", results=load) as run:
        run.advance(0.04)
        assert run.result("load").value is None
        assert "no rows" in run.result("load").problem
        run.advance()
        before = run.result("load")
    summary = run.finish()
    result = summary.results["load"]
    assert (result.value, result.error) == (before.value, before.error)
    assert result.unit == "N" and result.interval[0] < result.value < result.interval[1]
    assert result.window == (pytest.approx(0.05, abs=1e-3), pytest.approx(0.1, abs=1e-3))
    assert summary.results["top"].error is None and summary.results["top"].why_no_error
    again = md.open(tmp_path / "run").result(load["load"])
    assert again.value == result.value and "±" in again._repr_html_()
    assert summary._repr_html_().count("<p>") >= 3


def test_a_result_that_the_run_does_not_write_is_refused(pour):
    with pytest.raises(md.RunError, match="there is no wall `lid`"):
        md.Run(pour, results={"load": "mean(walls.lid.fz)"})
    with pytest.raises(md.RunError, match="no function `meen`"):
        md.Run(pour, results={"load": "meen(walls.lid.fz)"})


def test_wrong_arguments_are_refused(pour, tmp_path):
    for wrong, text in [
        ({"replace": True, "resume": True, "output": tmp_path}, "set one of them"),
        ({"resume": True}, "needs `output`"),
        ({"threads": 0}, "at least 1"),
        ({"checkpoint_every": -1.0}, "at least 0 s"),
    ]:
        with pytest.raises(ValueError, match=text):
            md.Run(pour, **wrong)
    with md.Run(pour) as run:
        with pytest.raises(TypeError, match="one of them"):
            run.advance(0.1, by=0.1)
        with pytest.raises(ValueError, match="not a number"):
            run.advance(float("nan"))
        with pytest.raises(KeyError, match="no column `u`"):
            run.particles(["u"])
        with pytest.raises(md.RunError, match="no result `a`"):
            run.result("a")
        folder = run.folder
        assert pathlib.Path(folder).is_dir()
        run.advance(0.001)
    with pytest.raises(md.RunError, match="the run is finished"):
        run.advance()
    del run
    assert not pathlib.Path(folder).exists()


def test_a_failed_run_says_why(pour):
    # Stiffer than the step allows: the guard stops the run.
    pour["time"]["step"] = 5e-4
    pour["time"]["end"] = 1.0
    with pytest.raises(md.MercuryError) as raised:
        md.run(pour)
    assert str(raised.value)


def test_an_exception_in_the_block_is_the_one_that_counts(pour, tmp_path):
    with pytest.raises(ZeroDivisionError):
        with md.Run(pour, output=tmp_path / "run") as run:
            run.advance(0.01)
            1 / 0
    assert (tmp_path / "run" / "summary.json").exists()


def test_another_thread_is_refused_and_python_goes_on(pour):
    pour["time"]["end"] = 5.0
    pour["output"] = {"interval": 1.0}
    with md.Run(pour, threads=1) as run:
        counted, ended = [0], threading.Event()

        def count():
            while not ended.is_set():
                counted[0] += 1
                time.sleep(0.001)

        counter = threading.Thread(target=count)
        counter.start()
        with concurrent.futures.ThreadPoolExecutor() as pool:
            advanced = pool.submit(run.advance, 1.0)
            time.sleep(0.05)
            if not advanced.done():
                with pytest.raises(md.RunError, match="one thread at a time"):
                    run.time
            advanced.result()
        ended.set()
        counter.join()
        assert counted[0] > 5
        run.advance(by=0.0)


INTERRUPTED = """
import sys, time, mercury_dem as md
with md.Run(sys.argv[1], set={"time.end": 1000.0}, output=sys.argv[2]) as run:
    print("ready", flush=True)
    try:
        run.advance()
    except KeyboardInterrupt:
        print(time.time(), flush=True)
        step = run.step
        assert run.advance(by=1e-4) == "reached" and run.step > step
"""


def test_ctrl_c_pauses_the_run(project, tmp_path):
    scene = project / "scenes" / "settle.toml"
    command = [sys.executable, "-c", INTERRUPTED, scene, tmp_path / "run"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(1.0)
        sent = time.time()
        process.send_signal(signal.SIGINT)
        took = float(process.stdout.readline()) - sent
        assert process.wait() == 0
    print(f"Ctrl-C came after {1e3 * took:.0f} ms")
    # Signals are looked for ten times a second; a machine that does other work may take longer.
    assert took < 2.0


def test_a_fork_of_a_run_is_refused(pour):
    with md.Run(pour) as run:
        child = os.fork()
        if child == 0:
            try:
                run.advance(0.01)
            except md.RunError:
                os._exit(7)
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7


def test_a_wall_is_driven_and_the_run_goes_back(pour):
    pour["walls"].append(
        {
            "name": "lid",
            "shape": "disc",
            "origin": [0.01, 0.01, 0.035],
            "axis": [0, 0, -1],
            "radius": 0.02,
            "material": "glass",
            "motion": "external",
        }
    )
    with md.Run(pour) as run:
        with pytest.raises(md.RunError, match="no wall `led`"):
            run.drive_wall("led", place=[0, 0, 0])
        with pytest.raises(md.RunError, match="motion = .external."):
            run.drive_wall("box.-z", place=[0, 0, 0])
        run.advance(0.05)
        before = run.save()
        loads = []
        for height in (0.03, 0.012, 0.03):
            # 0.25 or 1.15 m/s.
            run.drive_wall("lid", place=[0.01, 0.01, height], velocity=[0, 0, (height - 0.035) / 0.02])
            run.advance(by=0.02)
            now, mean = run.wall_load("lid")
            loads.append(mean[2])
            row = list(run.walls()["name"]).index("lid")
            assert run.walls()["z"][row] == height
            assert run.walls()["fz"][row] == pytest.approx(now[2], rel=1e-12, abs=1e-15)
            run.restore(before)
        assert loads[0] == loads[2] < loads[1]


def test_loads_are_summed_up_for_driven_walls_only(pour):
    with md.Run(pour) as run:
        with pytest.raises(md.RunError, match="without loads on walls"):
            run.wall_load("box.-z")
