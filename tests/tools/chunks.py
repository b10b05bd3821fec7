"""Work on consecutive numbers, spread over several processes."""

from collections.abc import Callable

import pandas
from joblib import Parallel, delayed
from tqdm import tqdm


def in_chunks(
    work: Callable[[range], pandas.DataFrame], numbers: range, size: int, workers: int
) -> pandas.DataFrame:
    """Return the rows that a function makes for chunks of numbers, in the order of the numbers."""
    chunks = [numbers[i : i + size] for i in range(0, len(numbers), size)]
    parts = Parallel(n_jobs=workers, return_as="generator")(delayed(work)(chunk) for chunk in chunks)
    return pandas.concat(tqdm(parts, total=len(chunks), unit=f" x {size}", disable=None), ignore_index=True)
