"""What the tests share: a small scene, and the folder of the project."""

import pathlib

import pytest

PROJECT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture
def project() -> pathlib.Path:
    return PROJECT


@pytest.fixture
def pour() -> dict:
    """A hundred beads fall into a box: some 0.1 s of work."""
    return {
        "title": "Beads fall into a box",
        "seed": 1,
        "gravity": [0, 0, -9.81],
        "time": {"end": 0.1},
        "domain": {"min": [0, 0, 0], "max": [0.02, 0.02, 0.04]},
        "materials": {
            "glass": {
                "density": 2500.0,
                "normal": {"law": "linear", "stiffness": 100.0, "restitution": 0.6},
                "tangential": {"law": "linear", "stiffness_ratio": 0.2857, "friction": 0.5},
            }
        },
        "walls": [{"name": "box", "shape": "box", "material": "glass"}],
        "insertions": [
            {
                "name": "rain",
                "region": {"shape": "box", "min": [0.001, 0.001, 0.002], "max": [0.019, 0.019, 0.039]},
                "material": "glass",
                "psd": {"kind": "uniform", "min_diameter": 1.8e-3, "max_diameter": 2.2e-3, "weighting": "number"},
                "total": {"number": 100},
            }
        ],
        "output": {"interval": 0.01, "fstat": True},
    }
