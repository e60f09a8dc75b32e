"""Branches of runs, and runs compared with their chains."""

import mercury_dem as md
import pytest
from test_run import contents


def test_a_branch_without_changes_has_the_bytes_of_its_run(pour, tmp_path):
    whole = tmp_path / "whole"
    summary = md.run(pour, output=whole)
    for part in (0.3, 0.7):
        at = part * summary.to_dict()["time"]
        folder = tmp_path / str(part)
        with md.Run.branch(whole, at, output=folder) as run:
            assert run.time >= at
            assert run.advance() == "ended"
        ended = run.finish()
        assert contents(folder) == contents(whole)
        assert ended.link == summary.link and ended.to_dict()["branch_of"]["step"] > 0


def test_a_branch_with_changes_goes_another_way(pour, tmp_path):
    whole = tmp_path / "whole"
    summary = md.run(pour, output=whole)
    with md.Run.branch(whole, 0.02, output=tmp_path / "other", set={"gravity": [0.0, 0.0, -5.0]}) as run:
        run.advance()
    assert run.finish().link != summary.link
    with pytest.raises(md.RunError, match="--at 1000000"):
        md.Run.branch(whole, 1e6, output=tmp_path / "late")
    with pytest.raises(md.RunError, match="may not differ"):
        md.Run.branch(whole, 0.02, output=tmp_path / "seed", set={"seed": 7})


def test_a_run_is_verified(pour, tmp_path):
    folder = tmp_path / "run"
    summary = md.run(pour, output=folder)
    found = md.open(folder).verify(1.0)
    assert found and found.right and found.share == 1.0 and found.first_difference is None
    assert found.link == summary.link
    assert found.to_dict()["physics"] == md.PHYSICS == summary.to_dict()["physics"]
    energies = next(folder.glob("*.ene"))
    changed = bytearray(energies.read_bytes())
    changed[len(changed) // 2] ^= 1
    energies.write_bytes(changed)
    found = md.open(folder).verify(seed=1)
    assert not found and energies.name in (found.first_difference or "")
    with pytest.raises(ValueError, match="share"):
        md.open(folder).verify(0.0)
    with pytest.raises(md.RunError):
        md.open(tmp_path / "none")
