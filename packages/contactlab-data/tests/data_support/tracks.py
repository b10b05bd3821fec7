"""A ball that bounces by a known law, tracked with a known noise."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contactlab.arrays import Array
from contactlab.motor.table import read_table
from contactlab_data.measured.impacts import MeasuredImpacts
from contactlab_data.measured.tracks import impacts_of_tracks

MASS, RADIUS, INERTIA, GRAVITY = 5e-3, 10e-3, 2e-7, 9.81
RESTITUTION, FRICTION = 0.7, 0.05
HEAD = {"mass": "5 g", "inertia": "2e-7 kg m^2", "radius": "10 mm"}
UNITS = {"time": "s", "x": "m", "y": "m", "angle": "rad"}


class Throw(NamedTuple):
    """Times of the frames [s], and x, y, angle; times of the impacts, velocities before and after each."""

    time: Array
    position: Array
    instant: Array
    before: Array
    after: Array


def throw(
    rng: np.random.Generator,
    impacts: int = 1,
    rate: float = 200.0,
    noise: tuple[float, ...] = (0.0, 0.0, 0.0),
) -> Throw:
    """Draw a throw that ends in flight; by Newton's restitution and Coulomb's friction of a solid sphere."""
    start, velocity = (
        np.array([0.0, rng.uniform(0.2, 0.4), 0.0]),
        rng.uniform([-2.0, -0.5, -100.0], [2.0, 0.5, 100.0]),
    )
    begin, flights = 0.0, []
    instants, before, after = [], [], []
    for number in range(impacts + 1):
        flights.append((begin, start, velocity))
        rise, height = velocity[1], start[1]
        length = (rise + np.sqrt(rise**2 + 2.0 * GRAVITY * height)) / GRAVITY
        if number == impacts:
            begin += rng.uniform(0.5, 0.9) * length
            break
        begin, start = begin + length, start + velocity * length
        start[1] = 0.0
        velocity = velocity - [0.0, GRAVITY * length, 0.0]
        before.append(velocity)
        pressing = -(1.0 + RESTITUTION) * velocity[1]
        rubbing = np.clip(
            (velocity[0] + RADIUS * velocity[2]) / 3.5, -FRICTION * pressing, FRICTION * pressing
        )
        velocity = velocity + np.array([-rubbing, pressing, -rubbing * MASS * RADIUS / INERTIA])
        after.append(velocity)
        instants.append(begin)
    time = np.arange(rng.uniform(0.0, 1.0 / rate), begin, 1.0 / rate)
    position = np.empty((time.size, 3))
    for begin, start, velocity in flights:
        s = (time - begin)[:, None]
        late = time >= begin
        position[late] = (start + velocity * s - [0.0, 0.5 * GRAVITY, 0.0] * s**2)[late]
    position += rng.normal(size=position.shape) * noise
    return Throw(time, position, np.array(instants), np.array(before), np.array(after))


def text_of(columns: Mapping[str, Array], units: Mapping[str, str] = UNITS, **head: str) -> str:
    """Return a CSV file of columns with units, below lines of constants."""
    lines = [f"# {name}: {value}" for name, value in head.items() if value]
    lines.append(",".join(f"{name} [{units[name]}]" if name in units else name for name in columns))
    lines += [",".join(map(repr, row)) for row in np.column_stack([*columns.values()]).tolist()]
    return "\n".join(lines) + "\n"


def columns_of(made: Throw) -> dict[str, Array]:
    """Return the columns of a throw."""
    return {"time": made.time, **dict(zip(("x", "y", "angle"), made.position.T, strict=True))}


def read(text: str) -> MeasuredImpacts:
    """Return the impacts of a CSV file with tracks."""
    return impacts_of_tracks(read_table(text.encode()), "Throws")


def write_throws(path: Path, count: int, impacts: int, noise: tuple[float, ...], seed: int) -> None:
    """Write a file with several throws."""
    rng = np.random.default_rng(seed)
    throws = [columns_of(throw(rng, impacts, noise=noise)) for _ in range(count)]
    labelled = [{"track": np.full(x["time"].size, at), **x} for at, x in enumerate(throws, 1)]
    every = {name: np.concatenate([x[name] for x in labelled]) for name in labelled[0]}
    path.write_text(text_of(every, **HEAD))
