"""Mercury: discrete element simulations. All quantities are in SI units."""

from ._mercury_dem import (
    PHYSICS,
    Column,
    Estimate,
    Plan,
    Problem,
    Record,
    Run,
    Scene,
    State,
    Study,
    Summary,
    Table,
    Verification,
    __version__,
    open,
    run,
)

__all__ = [
    "PHYSICS",
    "Column",
    "Estimate",
    "MercuryError",
    "Plan",
    "Problem",
    "Record",
    "Run",
    "RunError",
    "Scene",
    "SceneError",
    "State",
    "Study",
    "Summary",
    "Table",
    "Verification",
    "__version__",
    "open",
    "run",
]


class MercuryError(Exception):
    """The base of all errors."""


class SceneError(MercuryError, ValueError):
    """All mistakes of a scene at once, as the command line prints them."""

    def __init__(self, message, problems=()):
        super().__init__(message)
        self.problems = tuple(problems)


class RunError(MercuryError, RuntimeError):
    """The simulation or its output failed, or the request makes no sense."""
