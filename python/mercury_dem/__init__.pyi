"""Mercury: discrete element simulations. All quantities are in SI units."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, final

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

_Path: TypeAlias = str | PathLike[str]
_SceneLike: TypeAlias = Scene | Plan | Mapping[str, Any] | _Path

PHYSICS: int
"""Programs with this number give the same bytes."""
__version__: str

class MercuryError(Exception):
    """The base of all errors."""

class SceneError(MercuryError, ValueError):
    """All mistakes of a scene at once, as the command line prints them."""

    problems: tuple[Problem, ...]
    def __init__(self, message: str, problems: Iterable[Problem] = ()) -> None: ...

class RunError(MercuryError, RuntimeError):
    """The simulation or its output failed, or the request makes no sense."""

@final
class Problem:
    """One mistake of a scene. Lines and columns are counted from 1."""

    @property
    def key(self) -> str | None: ...
    @property
    def message(self) -> str: ...
    @property
    def help(self) -> str | None: ...
    @property
    def file(self) -> str | None: ...
    @property
    def line(self) -> int | None: ...
    @property
    def column(self) -> int | None: ...

@final
class Scene:
    """A scene as typed. It never changes, and can be pickled."""

    def __new__(cls, scene: Mapping[str, Any] | str, *, base: _Path | None = None) -> Scene:
        """A scene from a mapping, or from text in TOML or JSON. `base`: the folder from which file names start."""

    @staticmethod
    def read(path: _Path) -> Scene:
        """Reads a file."""

    @staticmethod
    def starter(name: str) -> Scene:
        """A scene to start from, as `mercury-solve new` writes it."""

    def with_set(self, changes: Mapping[str, Any]) -> Scene:
        """A copy with keys replaced, as by `--set`: `{"time.end": 0.1, "materials.0.normal.stiffness": 2e4}`."""

    def check(self) -> Plan:
        """The meaning of the scene. Raises SceneError with all problems."""

    def to_dict(self) -> dict[str, Any]:
        """All keys, with those of `with_set`."""

    def __eq__(self, other: object, /) -> bool: ...

@final
class Plan:
    """A consistent scene."""

    @property
    def time_step(self) -> float:
        """s"""

    @property
    def steps(self) -> int: ...
    @property
    def end(self) -> float:
        """s"""

    @property
    def memory(self) -> int:
        """Largest memory that the run is expected to take, bytes."""

    @property
    def disk(self) -> int:
        """Size of the files that the run is expected to write, bytes."""

    @property
    def warnings(self) -> tuple[str, ...]: ...
    def report(self) -> str:
        """The text of `mercury-solve --check`."""

    def to_dict(self) -> dict[str, Any]:
        """The object of `mercury-solve --check --json`, without its files."""

@final
class Column:
    """Read-only values, shared with numpy, polars and pyarrow without a copy. They outlive the run."""

    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str:
        """SI unit; `1` of plain numbers."""

    def __len__(self) -> int: ...
    def __getitem__(self, row: int, /) -> float | int | str | None: ...
    def __iter__(self) -> Iterator[float | int | str | None]: ...
    def __arrow_c_array__(self, requested_schema: object | None = None) -> tuple[object, object]:
        """The Arrow PyCapsule interface."""

    @property
    def __array_interface__(self) -> dict[str, Any]:
        """The interface of numpy. Raises TypeError where there are texts or rows without a value."""

@final
class Table:
    """Columns of one length; `time` (s) and `step` of a single state."""

    @property
    def time(self) -> float | None: ...
    @property
    def step(self) -> int | None: ...
    @property
    def columns(self) -> tuple[str, ...]: ...
    def __len__(self) -> int: ...
    def __getitem__(self, name: str, /) -> Column: ...
    def __iter__(self) -> Iterator[str]: ...
    def __contains__(self, name: str, /) -> bool: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """The Arrow PyCapsule interface."""

@final
class Estimate:
    """A named result. `error`: one standard error; `interval`: 95 %; None where `problem` or `why_no_error` says why."""

    @property
    def name(self) -> str: ...
    @property
    def of(self) -> str:
        """Its definition."""

    @property
    def unit(self) -> str: ...
    @property
    def value(self) -> float | None: ...
    @property
    def error(self) -> float | None: ...
    @property
    def interval(self) -> tuple[float, float] | None: ...
    @property
    def batches(self) -> float | None:
        """Number of independent batches."""

    @property
    def window(self) -> tuple[float, float] | None:
        """Times of the first and the last row that count, s."""

    @property
    def warm_up(self) -> float | None:
        """Start-up that was cut, s."""

    @property
    def steady(self) -> bool | None: ...
    @property
    def note(self) -> str | None: ...
    @property
    def problem(self) -> str | None: ...
    @property
    def why_no_error(self) -> str | None: ...

@final
class Summary:
    """How a run ended, and its numbers: the content of `summary.json`."""

    @property
    def status(self) -> Literal["finished", "stopped"]: ...
    @property
    def cause(self) -> str | None:
        """Why the run ended: `planned`, `at_rest`, `worn`, `known`, `request`, `file` (STOP) or `time_limit`; None for runs of earlier versions."""

    @property
    def link(self) -> str | None:
        """The last link of the chain of the run: equal for equal runs."""

    @property
    def time(self) -> float | None:
        """s"""

    @property
    def steps(self) -> int | None: ...
    @property
    def warnings(self) -> tuple[str, ...]: ...
    @property
    def results(self) -> dict[str, Estimate]: ...
    def to_dict(self) -> dict[str, Any]: ...

@final
class State:
    """State of a run in memory, for `Run.restore`."""

@final
class Run:
    """A run that is made in pieces, which change no byte of its files. A context manager: at its end the files of the end, or a checkpoint,
    are written. One thread at a time uses it; other threads of Python go on while it computes."""

    def __new__(
        cls,
        scene: _SceneLike,
        *,
        output: _Path | None = None,
        set: Mapping[str, Any] | None = None,
        results: Mapping[str, str] | None = None,
        threads: int | None = None,
        replace: bool = False,
        resume: bool = False,
        checkpoint_every: float | None = ...,
        progress: bool | None = None,
    ) -> Run:
        """Begins a run in the folder `output`; without it, in a temporary folder that goes with the object.

        `set`: keys of the scene to replace. `results`: definitions by name, as `--result`. `threads`: at most so many; the results do not
        depend on them. `replace`: an earlier run in the folder is removed; `resume`: it goes on. `checkpoint_every`: seconds of the clock
        between checkpoints, 600 by default; None: none are written. `progress`: whether `advance` shows how far the run is, on `sys.stderr`;
        None: in a terminal."""

    @classmethod
    def branch(
        cls,
        run: _Path,
        at: float,
        *,
        output: _Path | None = None,
        set: Mapping[str, Any] | None = None,
        threads: int | None = None,
    ) -> Run:
        """Begins a branch of the run in a folder: it has its bytes up to the time `at` (s), and from there the scene with the changes of `set`."""

    @property
    def time(self) -> float:
        """s"""

    @property
    def step(self) -> int: ...
    @property
    def is_ended(self) -> bool: ...
    @property
    def plan(self) -> Plan: ...
    @property
    def folder(self) -> str: ...
    def advance(self, until: float | None = None, *, by: float | None = None) -> Literal["reached", "ended"]:
        """Goes on to the first step at or after a time (s), by a time, or to the end. Ctrl-C pauses behind the present step: nothing is lost,
        and `advance` goes on."""

    def finish(self) -> Summary:
        """Writes the files of the end. A run that has not come to its end makes one more step and counts as stopped."""

    def checkpoint(self) -> None:
        """Writes a checkpoint of now."""

    def particles(self, columns: Sequence[str] | None = None) -> Table:
        """All particles now, by id: one copy into columns, those of `.particles.arrow`."""

    def contacts(self) -> Table:
        """All contacts now, with the columns of `.contacts.arrow`."""

    def walls(self) -> Table:
        """Walls now, a row each, with the columns of `.walls.csv`: loads, poses and velocities."""

    def drive_wall(
        self,
        wall: str,
        *,
        place: Sequence[float],
        turn: Sequence[float] = ...,
        velocity: Sequence[float] = ...,
        angular_velocity: Sequence[float] = ...,
    ) -> None:
        """Drives a wall with `motion = "external"` during the next `advance`: its reference point goes on with `velocity` (m/s) and is at the
        end at `place` (m); the wall turns with `angular_velocity` (rad/s) to `turn`, a quaternion w, x, y, z since the start. By default it rests, not turned."""

    def wall_load(self, wall: str) -> tuple[list[float], list[float]]:
        """Force (N) and torque (N m) of the particles on a wall, six numbers: in the last step, and the mean over the last `advance`. For scenes
        with a driven wall."""

    def save(self) -> State:
        """The present state in memory."""

    def restore(self, state: State) -> None:
        """Goes back to a saved state of this run. Its files are cut back, and all comes out as if the steps behind it had never been made."""

    def result(self, name: str) -> Estimate:
        """A result that was named at the beginning, from the rows until now."""

    def __enter__(self) -> Run: ...
    def __exit__(self, *exc: object) -> None: ...

def run(
    scene: _SceneLike,
    *,
    output: _Path | None = None,
    set: Mapping[str, Any] | None = None,
    results: Mapping[str, str] | None = None,
    threads: int | None = None,
    replace: bool = False,
) -> Summary:
    """Runs a scene to its end."""

def open(run: _Path) -> Record:
    """A run that is there, ended or not."""

@final
class Record:
    """The files of a run."""

    @property
    def folder(self) -> str: ...
    @property
    def summary(self) -> Summary | None:
        """None while the run goes on."""

    @property
    def times(self) -> Column:
        """Times of the frames, s."""

    def frame(self, number: int = ..., columns: Sequence[str] | None = None) -> Table:
        """Particles of a frame, by default the last; only the named columns are read."""

    def contacts(self, number: int = ..., columns: Sequence[str] | None = None) -> Table:
        """Contacts of a frame, by default the last."""

    def table(self, name: str) -> Table:
        """A table of rows over time: `energy`, `walls`, `regions`, `flux`, `track`, `results` and so on."""

    def result(self, request: str) -> Estimate:
        """A result such as `mean(walls.drum.ty, 1..)`, also one that the run did not name."""

    def verify(self, steps: float = ..., *, seed: int | None = None) -> Verification:
        """Compares all files with the chain of the run, and makes a share of its steps again, 0.01 by default. Ctrl-C stops it."""

@final
class Verification:
    """The result of `Record.verify`. True if nothing differs."""

    @property
    def right(self) -> bool: ...
    @property
    def share(self) -> float:
        """Share of the steps that were made again."""

    @property
    def first_difference(self) -> str | None: ...
    @property
    def link(self) -> str:
        """The last link of the chain."""

    def to_dict(self) -> dict[str, Any]: ...
    def __bool__(self) -> bool: ...

@final
class Study:
    """Many runs of one scene, and the table of their results. It goes on where its folder stands. One thread at a time uses it."""

    def __new__(cls, study: Mapping[str, Any] | _Path, *, folder: _Path | None = None) -> Study:
        """A mapping or a file with the table `[study]`. `folder`: where its runs and tables go, instead of what the study says."""

    @property
    def folder(self) -> str: ...
    def check(self) -> list[str]:
        """Checks that all runs can be made, and gives their names; seeds that may follow from errors are not among them."""

    def advance(self, *, jobs: int | None = None, runs: int | None = None) -> bool:
        """Makes the runs that are missing, at most so many; `jobs` at a time, by default as the study says or as the machine has processors.
        True when all is done. Runs that fail leave the others alone: RunError names them at the end. Ctrl-C stops the runs with a checkpoint each."""

    def table(self) -> Table:
        """A row for each run, as in `study.csv`."""

    def means(self) -> Table:
        """A row for each point, as in `study.means.csv`, for studies with seeds."""
