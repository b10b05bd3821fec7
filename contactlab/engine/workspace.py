"""What runs of like motors share: step responses, which depend on resonator, drive and step alone."""

from typing import final

from contactlab.engine.plant import Plant
from contactlab.engine.tables import Tables, tables_for


@final
class Workspace:
    """Keeps the step responses of the last motor for a next one that has the same.

    A response is a function of the plant and the length of the step, whoever asks first, so that a run
    is the same to the last bit with a workspace and without. Runs that share one follow each other: it
    is also their scratch memory.
    """

    def __init__(self) -> None:
        self._key: tuple[object, ...] = ()
        self._tables: Tables | None = None

    def tables(self, plant: Plant, contact_step: float, duration: float, exact: bool) -> Tables:
        """A ladder for a plant, see `contactlab.engine.tables.tables_for`."""
        key = (
            plant.stiffness.tobytes(),
            plant.damping.tobytes(),
            plant.row_u.tobytes(),
            plant.row_th.tobytes(),
            plant.row_r.tobytes(),
            plant.omega.tobytes(),
            contact_step,
            duration,
            exact,
        )
        if self._tables is None or key != self._key:
            self._tables = tables_for(plant, contact_step, duration, exact)
            self._key = key
        return self._tables
