"""The program `mercury-solve` that comes with the package."""

import json
import pathlib
import signal
import subprocess
import sysconfig
import time

import mercury_dem as md
from test_run import contents

PROGRAM = pathlib.Path(sysconfig.get_path("scripts")) / "mercury-solve"


def solve(*words, **others) -> subprocess.CompletedProcess:
    return subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False, **others)


def test_it_runs_scenes_to_the_same_bytes(pour, tmp_path):
    scene = tmp_path / "pour.json"
    scene.write_text(json.dumps(pour))
    done = solve(scene, "--output", tmp_path / "program", "--json")
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    md.run(scene, output=tmp_path / "module")
    assert contents(tmp_path / "program") == contents(tmp_path / "module")
    assert json.loads(done.stdout)["particles"] == 100
    # The log quotes the command line of the program, not that of the interpreter.
    line = f"{PROGRAM} {scene} --output {tmp_path / 'program'} --json"
    assert line in (tmp_path / "program" / "run.log").read_text()


def test_it_has_the_messages_and_exit_codes_of_the_program(tmp_path):
    assert solve("--version").stdout == f"mercury-solve {md.__version__}\n"
    missing = solve("no.toml", cwd=tmp_path)
    assert missing.returncode == 2 and "no.toml" in missing.stderr and "Traceback" not in missing.stderr
    wrong = solve("no.toml", "--quit", "--json")
    assert wrong.returncode == 2 and "a similar argument exists: '--quiet'" in wrong.stderr
    assert "--quit" in json.loads(wrong.stdout)["problems"][0]["message"]


def test_ctrl_c_stops_it_with_a_checkpoint(pour, tmp_path):
    scene, folder = tmp_path / "pour.json", tmp_path / "run"
    scene.write_text(json.dumps(pour | {"time": {"end": 1000.0}}))
    with subprocess.Popen([PROGRAM, scene, "--output", folder], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        while not (folder / "pour.particles.arrow").exists():
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate()
        assert process.returncode == 75 and "Traceback" not in errors and "KeyboardInterrupt" not in errors
    time_now = md.open(folder).times[-1]
    done = solve(scene, "--output", folder, "--resume", "--set", f"time.end={time_now + 0.01}", "--quiet")
    assert (done.returncode, done.stderr) == (0, "")
