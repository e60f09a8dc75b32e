"""Scenes, plans, and what is wrong with them."""

import pathlib
import pickle

import mercury_dem as md
import numpy as np
import pytest


def test_a_scene_is_the_same_from_a_file_a_text_and_a_mapping(project):
    path = project / "scenes" / "two-spheres.toml"
    of_file = md.Scene.read(path)
    of_text = md.Scene(path.read_text())
    of_mapping = md.Scene(of_file.to_dict())
    plans = [scene.check() for scene in (of_file, of_text, of_mapping)]
    # 0.03 s in steps of 4e-5 s.
    assert {plan.steps for plan in plans} == {750}
    assert plans[0].time_step == 4e-5
    assert plans[0].end == pytest.approx(0.03)
    physics = [{**plan.to_dict(), "prefix": "", "scene": ""} for plan in plans]
    assert physics[0] == physics[1] == physics[2]
    assert plans[0].memory > 0 and plans[0].disk > 0
    assert "Space" in plans[0].report()
    assert "<pre>" in plans[0]._repr_html_()


def test_keys_are_replaced_in_a_copy(project):
    scene = md.Scene.read(project / "scenes" / "two-spheres.toml")
    longer = scene.with_set({"time.end": 0.06, "particles.0.velocity": [1, 0, 0]})
    assert scene.check().steps == 750
    assert longer.check().steps == 1500
    assert longer.to_dict()["particles"][0]["velocity"] == [1, 0, 0]
    assert scene.to_dict()["particles"][0]["velocity"] == [0.5, 0, 0]
    assert pickle.loads(pickle.dumps(longer)) == longer != scene


def test_numbers_of_numpy_and_paths_are_values_of_scenes(pour):
    pour["gravity"] = np.array([0, 0, -9.81])
    pour["seed"] = np.int64(1)
    pour["time"]["end"] = np.float32(0.125)
    pour["title"] = pathlib.PurePosixPath("a")
    scene = md.Scene(pour).to_dict()
    assert scene["gravity"] == [0, 0, -9.81]
    assert scene["seed"] == 1 and scene["time"]["end"] == 0.125
    assert scene["title"] == "a"


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        ({1, 2}, TypeError, "time.end: a scene has no value of type set: a set has no order, write a list"),
        (None, TypeError, "time.end: a scene has no value of type NoneType: leave the key out"),
        (b"1", TypeError, "time.end: a scene has no value of type bytes"),
        ({1: 2}, TypeError, "time.end: keys of a scene are text, and 1 is not"),
        (float("nan"), ValueError, "time.end: NaN is not a finite number"),
        (2**64, ValueError, "time.end: 18446744073709551616 has more than 64 bits"),
    ],
)
def test_values_that_no_scene_has_are_refused_by_their_key(pour, value, error, text):
    pour["time"]["end"] = value
    with pytest.raises(error) as raised:
        md.Scene(pour)
    assert text in str(raised.value)


def test_a_mapping_that_holds_itself_is_refused(pour):
    pour["time"]["end"] = pour
    with pytest.raises(ValueError, match="does one hold itself"):
        md.Scene(pour)


def test_all_mistakes_come_at_once_with_their_places(tmp_path, project):
    path = tmp_path / "bad.toml"
    text = (project / "scenes" / "two-spheres.toml").read_text()
    path.write_text(text.replace("density =", "densty =").replace("radius   = 0.5", "radius   = -0.5", 1))
    with pytest.raises(md.SceneError) as raised:
        md.Scene.read(path).check()
    error = raised.value
    assert isinstance(error, ValueError) and isinstance(error, md.MercuryError)
    problems = {problem.key: problem for problem in error.problems}
    assert problems["materials.ball.densty"].help == "did you mean `density`?"
    assert problems["particles[0].radius"].line == 18 and problems["particles[0].radius"].column == 12
    assert all(problem.file == str(path) for problem in error.problems)
    assert f"{len(error.problems)} problems; nothing was run" in str(error)
    with pytest.raises(md.SceneError, match="time.emd"):
        md.Scene(text).with_set({"time.emd": 1}).check()


def test_starters_are_scenes():
    assert md.Scene.starter("hopper").check().steps > 0
    with pytest.raises(md.RunError, match="there is no starter `drm`"):
        md.Scene.starter("drm")


def test_what_is_no_scene_is_refused():
    with pytest.raises(TypeError, match="a scene is a path, a mapping or a Scene, not int"):
        md.Run(1)
    with pytest.raises(md.SceneError, match="missing.toml"):
        md.Run("missing.toml")
