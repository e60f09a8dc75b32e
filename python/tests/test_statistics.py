"""Results of series in files, against a plain text of the method of docs/how-to/results-and-errors.md."""

import csv
import itertools
import math

import mercury_dem as md
import pytest

ROWS = 3000


def record(rows: list[float]) -> list[float]:
    """Means of equal stretches of rows, 1,024 at most, each twice as long where there would be more."""
    width = 1
    while len(rows) // width > 1024:
        width *= 2
    return [math.fsum(rows[k * width : (k + 1) * width]) / width for k in range(len(rows) // width)]


def mean(values: list[float]) -> float:
    return math.fsum(values) / len(values)


def batches(bins: list[float], size: int) -> list[float]:
    """Means of batches of so many bins, counted from the end."""
    count = len(bins) // size
    begin = len(bins) - count * size
    return [mean(bins[begin + k * size : begin + (k + 1) * size]) for k in range(count)]


def variance_of_a_batch(means: list[float], most: float) -> tuple[float, float]:
    """The variance of the mean times the number of batches, and the correlation of neighbours that is put right in it."""
    middle = mean(means)
    d = [y - middle for y in means]
    c0 = math.fsum(x * x for x in d)
    c1 = math.fsum(a * b for a, b in itertools.pairwise(d))
    phi = min(max(c1 / c0 + 1 / len(means), 0.0), most)
    return c0 / (len(means) - 1) * (1 + phi) / (1 - phi), phi


def start_up(bins: list[float]) -> int:
    """Bins to cut: twice the truncation of MSER, where the test of Heidelberger and Welch fails."""
    size = max(1, len(bins) // 128)
    y = batches(bins, size)
    variance, _ = variance_of_a_batch(y[len(y) // 2 :], 0.9)
    middle = mean(y)
    sums = itertools.accumulate(value - middle for value in y)
    if math.fsum(s * s for s in sums) / (variance * len(y) ** 2) <= 0.209:
        return 0
    groups = [mean(bins[k * size : (k + 1) * size]) for k in range(len(bins) // size)]
    errors = []
    for cut in range(len(groups) - max(5, len(groups) // 20) + 1):
        left = groups[cut:]
        middle = mean(left)
        errors.append(math.fsum((g - middle) ** 2 for g in left) / len(left) ** 2)
    return 2 * errors.index(min(errors)) * size


def student_t_975(degrees: float) -> float:
    """The 97.5 % quantile: the density integrated from 0 by Simpson's rule with 1,000 intervals, and halving."""
    front = math.exp(math.lgamma((degrees + 1) / 2) - math.lgamma(degrees / 2)) / math.sqrt(degrees * math.pi)

    def half(t: float) -> float:
        h = t / 1000
        weights = (1 if k in (0, 1000) else 2 + 2 * (k % 2) for k in range(1001))
        return front * h / 3 * math.fsum(w * (1 + (k * h) ** 2 / degrees) ** (-(degrees + 1) / 2) for k, w in enumerate(weights))

    low, high = 1.9, 13.0
    for _ in range(44):
        middle = (low + high) / 2
        low, high = (middle, high) if half(middle) < 0.475 else (low, middle)
    return (low + high) / 2


def expected(rows: list[float], is_cut: bool) -> tuple[int, float, float, float, float]:
    """Bins that are cut, value, standard error, half of the interval, independent batches."""
    bins = record(rows)
    cut = start_up(bins) if is_cut else 0
    kept = bins[cut:]
    means = batches(kept, max(1, len(kept) // 64))
    variance, phi = variance_of_a_batch(means, 0.95)
    error = math.sqrt(variance / len(means))
    independent = len(means) * (1 - phi) / (1 + phi)
    # In a window given in numbers the value is that of all rows, also of those that fill no bin.
    value = mean(kept) if is_cut else mean(rows)
    return cut, value, error, student_t_975(max(2.0, independent - 1)) * error, independent


def autoregressive(phi: float, start: float = 0.0, seed: int = 1) -> list[float]:
    """An autoregressive process of first order, with a start-up that decays."""
    state, y, rows = seed, 0.0, []
    for _ in range(ROWS):
        state = (1103515245 * state + 12345) % 2**31
        y = phi * y + state / 2**31 - 0.5
        start *= 0.99
        rows.append(y + start)
    return rows


SERIES = {
    "fx": autoregressive(0.9),
    "fy": autoregressive(0.9, start=20.0),
    "fz": autoregressive(0.0, seed=7),
    "tx": autoregressive(0.99, seed=3),
    "ty": [math.sin(2 * math.pi * k / 37) + x for k, x in enumerate(autoregressive(0.5, seed=5))],
    "tz": [math.exp(x) for x in autoregressive(0.95, seed=11)],
}


@pytest.fixture
def run(tmp_path):
    """A run whose loads on a wall are the series."""
    scene = {
        "time": {"step": 1e-5, "end": ROWS * 1e-5},
        "domain": {"min": [-0.1, -0.1, 0], "max": [0.1, 0.1, 0.3]},
        "materials": {"steel": {"density": 7800.0, "normal": {"law": "linear", "stiffness": 1e5, "restitution": 0.5}}},
        "walls": [{"name": "floor", "shape": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "material": "steel"}],
        "particles": [{"material": "steel", "radius": 0.01, "position": [0, 0, 0.1]}],
        "output": {"interval": ROWS * 1e-5, "rows_interval": 1e-5, "pictures": False},
    }
    with md.Run(scene, output=tmp_path / "series") as made:
        made.advance()
    (path,) = (tmp_path / "series").glob("*.walls.csv")
    with path.open(newline="") as file:
        names, *rows = csv.reader(file)
    columns = [name.split(" ")[0] for name in names]
    assert set(SERIES) <= set(columns)
    # That of the start is a row as any other.
    assert len(rows) == ROWS + 1
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerow(rows[0])
        for k, row in enumerate(rows[1:]):
            new = {name: repr(values[k]) for name, values in SERIES.items()}
            writer.writerow([new.get(name, value) for name, value in zip(columns, row, strict=True)])
    return md.open(tmp_path / "series")


@pytest.mark.parametrize("column", SERIES)
@pytest.mark.parametrize(("window", "is_cut"), [("steady..", True), ("0..", False)])
def test_results_are_those_of_the_text(run, column, window, is_cut):
    result = run.result(f"mean(walls.floor.{column}, {window})")
    rows = [float(value) for value in run.table("walls")[column]]
    cut, value, error, half, independent = expected(rows, is_cut)
    print(column, window, cut, value, error, independent)
    assert result.value == pytest.approx(value, rel=1e-12, abs=1e-12 * error)
    assert result.error == pytest.approx(error, rel=1e-12)
    assert result.batches == pytest.approx(independent, rel=1e-12)
    assert result.interval == pytest.approx((value - half, value + half), abs=1e-9 * error)
    width = 4 if len(rows) > 2048 else 1
    assert (result.warm_up or 0.0) == pytest.approx(cut * width * 1e-5, abs=1e-9)


def test_the_text_has_the_check_values_of_the_method():
    assert expected(SERIES["fx"], True)[:3] == (0, pytest.approx(-0.004440912, abs=5e-10), pytest.approx(0.056678163, abs=5e-10))
    assert expected(SERIES["fy"], True)[:3] == (140, pytest.approx(0.013687026, abs=5e-10), pytest.approx(0.054232967, abs=5e-10))
