"""The recipes and the notebook of the documentation, and the stub."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest


def test_recipes_run(project, tmp_path, monkeypatch):
    text = (project / "docs" / "how-to" / "from-python.md").read_text()
    recipes = re.findall(r"^## (.*?)\n.*?^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert len(recipes) >= 10
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    shutil.copytree(project / "scenes", "scenes")
    # A fifth of the beads, as the package of these tests is not optimized.
    settle = pathlib.Path("scenes/settle.toml")
    whole = settle.read_text()
    fewer = whole.replace("number = 2000", "number = 400")
    assert fewer != whole
    settle.write_text(fewer)
    names: dict[str, object] = {}
    for title, code in recipes:
        exec(compile(code.replace("== 2000", "== 400"), title, "exec"), names)


def test_notebook_runs(project, tmp_path):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    notebook = nbformat.read(project / "docs" / "how-to" / "from-a-notebook.ipynb", as_version=4)
    for cell in notebook.cells:
        assert not cell.get("outputs"), "a notebook without its outputs"
    shutil.copytree(project / "scenes", tmp_path / "scenes")
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    # Objects at the end of cells are shown as HTML.
    shown = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert sum("text/html" in output.get("data", {}) for output in shown) >= 3


def test_stub_is_right(tmp_path):
    # Both read the installed package.
    for arguments in (
        ["mypy.stubtest", "mercury_dem", "--ignore-missing-stub"],
        ["mypy", "--strict", "-c", USE],
    ):
        done = subprocess.run(
            [sys.executable, "-m", *arguments], cwd=tmp_path, capture_output=True, text=True, env={**os.environ, "NO_COLOR": "1"}
        )
        assert done.returncode == 0, done.stdout + done.stderr


# A program with types, as users write it.
USE = '''
import mercury_dem as md

def top(scene: md.Scene) -> float:
    with md.Run(scene.with_set({"time.end": 1}), results={"a": "max(particles.z)"}) as run:
        while run.advance(by=0.1) == "reached":
            print(run.time + 1.0, run.particles(["z"])["z"][0])
    value = run.finish().results["a"].value
    return 0.0 if value is None else value

top(md.Scene({"title": "a"}))
names: list[str] = list(md.open("run").frame())
'''
