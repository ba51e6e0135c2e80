"""What driving a simulation from Python costs: a loop of step(1) beside one run(), and reading fields beside a step.

    PYTHONPATH=build/release/python .venv/bin/python bench/python_step.py [--particles N] [--repetitions N]

Prints medians over the repetitions, in which the candidates take turns.
"""

import argparse
import statistics
import time
from collections.abc import Callable

import matpoint as mp


def case(particles: int, dt: float = 1e-6) -> mp.Case:
    """A block of rubber in free fall with about so many particles, four in a cell."""
    cells = max(4, round((particles / 4) ** 0.5 / 0.8))
    return mp.Case(
        "bench",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(1, 1), cells=(cells, cells)),
        time=mp.Time(dt=dt, end=1.0),
        output=mp.Output(history_every=1.0),
        body=mp.Body(
            name="block",
            region=mp.Box(lower=(0.1, 0.1), upper=(0.9, 0.9)),
            layout=mp.PerCell(count=4),
            material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
        ),
    )


def seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--particles", type=int, default=100_000)
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--repetitions", type=int, default=15)
    options = parser.parse_args()
    stepped, ran = case(options.particles).build(), case(options.particles).build()
    stepped.step(10)
    ran.run(until=10e-6)
    body = stepped.bodies["block"]

    def steps() -> None:
        for _ in range(options.steps):
            stepped.step(1)

    def run() -> None:
        ran.run(until=(ran.step_count + options.steps) * 1e-6)

    times: dict[str, list[float]] = {name: [] for name in ("step(1)", "run()", "velocity", "deformation_gradient", "stress")}
    for _ in range(options.repetitions):
        times["step(1)"].append(seconds(steps) / options.steps)
        times["run()"].append(seconds(run) / options.steps)
        for field in ("velocity", "deformation_gradient", "stress"):
            times[field].append(seconds(lambda field=field: body.field(field)))
    step = statistics.median(times["run()"])
    print(f"{len(body)} particles, {mp.threads()} threads, {mp.instruction_set()}")
    for name, measured in times.items():
        median = statistics.median(measured)
        print(f"  {name:22s} {1e3 * median:9.3f} ms   {median / step:6.2f} steps")
    ratios = [a / b for a, b in zip(times["step(1)"], times["run()"])]
    print(f"a loop of step(1) over run(): {statistics.median(ratios):.3f} (median of ratios, taken in turn)")


if __name__ == "__main__":
    main()
