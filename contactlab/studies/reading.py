"""What a file holds: the solution of a run, or the result of a study."""

from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from contactlab.checks import checked_arguments
from contactlab.config import ConfigurationError, Setup, rebuild
from contactlab.metrics.run import checked_run, opened
from contactlab.results.yaml_text import read_yaml
from contactlab.simulation import Solution, solution_in
from contactlab.studies.keys import study_in
from contactlab.studies.study import STUDY, Result


@checked_arguments()
def load(path: str | Path) -> Solution | Result:
    """Return what a file holds, checked to be as it was left: a run, or any study.

        >>> import contactlab as cl
        >>> cl.simulate(cl.build(), duration=5e-4).save("run.nc")
        >>> cl.load("run.nc").contacts["peak_normal_force"].values.round(2)
        array([3.63, 9.87])

    Raises:
        ValueError: it cannot be read, or neither a run nor a study of contactlab's left it; a sentence.
    """
    tree = opened(Path(path))
    if STUDY not in tree.attrs:
        return solution_in(checked_run(tree, path), path)
    try:
        result = Result(study_in(read_yaml(str(tree.attrs[STUDY]))), {}, tree)
        setups: dict[str, Setup] = {}
        for label, configuration in result.configurations.items():
            # It cannot be built again of a motor made in Python, or with a law that is not installed here.
            with suppress(ConfigurationError):
                setups[label] = rebuild(configuration)
        return replace(result, setups=setups)
    except (LookupError, TypeError, ValueError) as error:
        raise ValueError(f"'{path}' holds a study that cannot be read: {error}") from error
