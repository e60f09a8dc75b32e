"""Prints what Python costs: two runs in two threads, and Ctrl-C with 100,000 particles.

With the package installed from a release build, on a machine with two free cores: python benches/costs.py
"""

import os
import signal
import threading
import time

import mercury_dem as md


def bed(particles: int) -> md.Run:
    """Beads that fall into a box, on one thread."""
    side = 0.002 * (particles / 2) ** (1 / 3)
    high = [side, side, 8 * side]
    scene = {
        "seed": 1,
        "gravity": [0, 0, -9.81],
        "time": {"end": 10.0},
        "domain": {"min": [0, 0, 0], "max": high},
        "materials": {
            "glass": {
                "density": 2500.0,
                "normal": {"law": "linear", "stiffness": 200.0, "restitution": 0.6},
                "tangential": {"law": "linear", "stiffness_ratio": 0.2857, "friction": 0.3},
            }
        },
        "walls": [{"name": "box", "shape": "box", "material": "glass"}],
        "insertions": [
            {
                "name": "fill",
                "region": {"shape": "box", "min": [0, 0, 0], "max": high},
                "material": "glass",
                "psd": {"kind": "uniform", "min_diameter": 1.8e-3, "max_diameter": 2.2e-3, "weighting": "number"},
                "total": {"number": particles},
            }
        ],
        "output": {"interval": 10.0},
    }
    return md.Run(scene, threads=1)


def timed(*work) -> float:
    """Seconds of all of these, each in a thread of its own."""
    threads = [threading.Thread(target=each) for each in work]
    begin = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return time.perf_counter() - begin


def two_threads() -> float:
    """Times that two runs are faster in two threads than one after the other: the least times of 25 trials from one state."""
    with bed(5000) as one, bed(5000) as other:
        pieces = [lambda run=run: run.advance(by=0.01) for run in (one, other)]
        timed(*pieces)
        saved = [(run, run.save()) for run in (one, other)]

        def again(*work) -> float:
            for run, state in saved:
                run.restore(state)
            return timed(*work)

        one_by_one, both = [], []
        for _ in range(25):
            one_by_one.append(again(pieces[0]) + again(pieces[1]))
            both.append(again(*pieces))
    return min(one_by_one) / min(both)


def interrupted() -> float:
    """Seconds from Ctrl-C to its exception; the longest of nine."""
    took = []
    with bed(100_000) as run:
        run.advance(by=0.001)
        for trial in range(9):
            sent = []

            def press():
                sent.append(time.perf_counter())
                os.kill(os.getpid(), signal.SIGINT)

            timer = threading.Timer(1.0 + 0.037 * trial, press)
            timer.start()
            try:
                run.advance()
            except KeyboardInterrupt:
                took.append(time.perf_counter() - sent[0])
            timer.join()
    return max(took)


if __name__ == "__main__":
    print(f"two runs in two threads: {two_threads():.2f} times as fast as one after the other")
    print(f"Ctrl-C with 100,000 particles: within {1e3 * interrupted():.0f} ms")
