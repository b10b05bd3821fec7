"""Processor time of runs, records, steady states and batches over the history of the repository.

    pip install asv virtualenv
    cd benchmarks && asv run COMMIT..main && asv publish && asv preview

asv (https://asv.readthedocs.io) installs each commit in an environment of its own and times all of them in
turn on one machine; nothing is compiled while the clock runs.
"""

from time import process_time

import contactlab as cl

LAWS = ["hertz_penalty", "lagrange_stick", "newton", "lagrange_ageing"]


class Motor:
    """The default motor under a law of each family."""

    params, param_names = [LAWS], ["law"]
    timer = staticmethod(process_time)
    # The first of a law compiles.
    timeout = 600.0

    resonator = "ritz"

    def setup(self, law: str) -> None:
        """Build the motor, and compile what it needs."""
        self.motor = cl.build([f"law={law}", f"resonator={self.resonator}"])
        self.motor.run(duration=2e-3, record_interval=2e-3)

    def time_tenth_of_a_second(self, _law: str) -> None:
        """A run with two records."""
        self.motor.run(duration=0.1, record_interval=0.1)

    def time_records_every_microsecond(self, _law: str) -> None:
        """A run with 20,000 records."""
        self.motor.run(duration=0.02, record_interval=1e-6)

    def time_short_run(self, _law: str) -> None:
        """What a batch repeats."""
        self.motor.run(duration=2e-3, record_interval=2e-3)

    def time_steady_state(self, _law: str) -> None:
        """The periodic orbit, its multipliers and its curves."""
        cl.steady(self.motor)


class ConvergedBeam(Motor):
    """The default motor on the converged beam."""

    resonator = "finite_element"
