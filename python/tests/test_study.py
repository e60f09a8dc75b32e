"""Many runs of one scene."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import mercury_dem as md
import pytest


@pytest.fixture
def study(pour, tmp_path, monkeypatch) -> dict:
    """Three values of the friction of a hundred beads."""
    monkeypatch.chdir(tmp_path)
    pathlib.Path("pour.json").write_text(json.dumps(pour))
    return {
        "study": {
            "scene": "pour.json",
            "folder": "swept",
            "sweep": {"materials.glass.tangential.friction": [0.1, 0.3, 0.5]},
            "results": {"height": "max(particles.z)", "load": 'mean(walls."box.-z".fz, 0.05..)'},
        }
    }


def test_a_study_is_made_in_pieces_and_goes_on(study, tmp_path):
    swept = md.Study(study)
    assert swept.folder == "swept"
    names = swept.check()
    assert names == ["friction=0.1", "friction=0.3", "friction=0.5"]
    assert list(swept.table()["status"]) == ["waiting"] * 3
    assert swept.advance(runs=1) is False
    assert list(swept.table()["status"]) == ["finished", "waiting", "waiting"]
    # Another object goes on where the folder stands.
    again = md.Study(study)
    assert list(again.table()["status"]) == ["finished", "waiting", "waiting"]
    assert again.advance(jobs=2) is True
    assert again.advance() is True
    table = again.table()
    assert list(table["run"]) == names
    assert list(table["materials.glass.tangential.friction"]) == [0.1, 0.3, 0.5]
    assert table["load"].unit == "N" and table["height"].unit == "m"
    assert all(load < 0 for load in table["load"])
    # Its rows are those of single runs.
    alone = md.run(tmp_path / "pour.json", output=tmp_path / "alone", set={"materials.glass.tangential.friction": 0.3})
    assert alone.status == "finished" and alone.cause == "planned"
    record = md.open(tmp_path / "alone")
    assert record.result("max(particles.z)").value == table["height"][1]


def test_a_study_of_the_command_line_is_the_same(study, tmp_path, project):
    solver = os.environ.get("MERCURY_SOLVE", str(project / "target/debug/mercury-solve"))
    if not pathlib.Path(solver).exists():
        pytest.skip("mercury-solve is not built")
    md.Study(study).advance()
    pathlib.Path("study.json").write_text(json.dumps(study))
    ran = subprocess.run([solver, "study.json", "--output", "other", "--quiet"], check=False, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    for run in ["friction=0.1", "friction=0.5"]:
        for file in ["pour.particles.arrow", "pour.walls.csv"]:
            one, other = (tmp_path / folder / run / file for folder in ["swept", "other"])
            assert one.read_bytes() == other.read_bytes(), (run, file)
    # The program takes the folder of Python as its own, and finds nothing to do.
    ran = subprocess.run([solver, "study.json"], check=False, capture_output=True, text=True)
    assert "3 of 3 runs finished (3 before)" in ran.stdout, ran.stdout + ran.stderr


def test_seeds_have_means(study):
    del study["study"]["sweep"]
    with pytest.raises(md.RunError, match="study.seeds"):
        md.Study({"study": {**study["study"], "sweep": {"seed": [1, 2]}, "folder": "two"}}).means()
    study["study"] |= {"seeds": 3, "folder": "seeds"}
    seeds = md.Study(study)
    assert seeds.check() == ["seed=1", "seed=2", "seed=3"]
    assert seeds.advance() is True
    table, means = seeds.table(), seeds.means()
    heights = list(table["height"])
    assert len(set(heights)) == 3
    assert means["height"][0] == pytest.approx(sum(heights) / 3, rel=1e-14)
    assert means["height_error"][0] > 0 and list(means["seeds"]) == [3]


def test_more_seeds_follow_from_the_error(study):
    del study["study"]["sweep"]
    study["study"] |= {"seeds": {"least": 2, "most": 4}, "error": {"load": "1e-9 N"}}
    seeds = md.Study(study)
    assert seeds.check() == ["seed=1", "seed=2"]
    assert seeds.advance() is True
    assert len(seeds.table()) == 4


def test_a_run_that_fails_leaves_the_others_alone(study):
    # The folder of the second run is a file.
    pathlib.Path("swept").mkdir()
    pathlib.Path("swept/friction=0.3").write_text("")
    swept = md.Study(study)
    with pytest.raises(md.RunError, match="run `friction=0.3`"):
        swept.advance(jobs=1)
    assert list(swept.table()["status"]) == ["finished", "failed", "finished"]
    assert swept.advance() is True


def test_slips_are_refused(study, pour):
    with pytest.raises(TypeError, match="a path or a mapping"):
        md.Study(3)
    with pytest.raises(md.RunError, match="did you mean `sweep`"):
        md.Study({"study": {"scene": "pour.json", "swep": {}}})
    with pytest.raises(md.SceneError, match="none.toml"):
        md.Study({"study": {"scene": "none.toml", "sweep": {"seed": [1, 2]}}})
    with pytest.raises(ValueError, match="at least 1"):
        md.Study(study).advance(jobs=0)
    study["study"]["sweep"] = {"materials.glass.density": [-1.0]}
    with pytest.raises(md.SceneError) as refused:
        md.Study(study).check()
    assert refused.value.problems[0].key == "materials.glass.density"
    study["study"]["results"] = {"load": "mean(walls.lid.fz)"}
    study["study"]["sweep"] = {"materials.glass.density": [1000.0]}
    with pytest.raises(md.RunError, match="no wall `lid`"):
        md.Study(study).check()


def test_one_thread_at_a_time_uses_a_study(study):
    swept = md.Study(study)
    thread = threading.Thread(target=lambda: swept.advance(jobs=1))
    thread.start()
    # It holds the study when its folder is there.
    while not pathlib.Path("swept").exists():
        time.sleep(0.001)
    refused = False
    while thread.is_alive() and not refused:
        try:
            swept.table()
        except md.RunError as error:
            refused = "another thread" in str(error)
        time.sleep(0.001)
    thread.join()
    assert refused


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_stops_with_checkpoints(study, pour, tmp_path, request):
    # A shell lets programs in the background ignore it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, before))
    pour["time"]["end"] = 2.0
    pathlib.Path("pour.json").write_text(json.dumps(pour))
    swept = md.Study(study)
    swept.check()
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        swept.advance(jobs=2)
    timer.join()
    states = list(swept.table()["status"])
    assert "stopped" in states and "failed" not in states
    for name, state in zip(swept.table()["run"], states):
        if state == "stopped":
            assert list((tmp_path / "swept" / name).glob("*.restart")), name


def test_progress_goes_to_standard_error_of_python(pour, tmp_path, capsys, monkeypatch):
    class Terminal:
        """A stream that says that it is a terminal."""

        def __init__(self) -> None:
            self.text = ""

        def write(self, text: str) -> int:
            self.text += text
            return len(text)

        def flush(self) -> None: ...
        def isatty(self) -> bool:
            return True

    pour["time"]["end"] = 0.6
    shown, hidden = Terminal(), Terminal()
    for stream, progress in [(shown, None), (hidden, False)]:
        monkeypatch.setattr(sys, "stderr", stream)
        with md.Run(pour, output=tmp_path / f"run-{progress}", progress=progress) as run:
            run.advance()
    assert "t = " in shown.text and "%" in shown.text
    assert hidden.text == ""
