"""Few linear equations, solved in place."""

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel


@inner_kernel
def solve_linear(system: Array, n: int) -> None:
    """Solve n linear equations in place, their right side in column n, with row pivots."""
    for p in range(n):
        best = p
        for row in range(p + 1, n):
            if abs(system[row, p]) > abs(system[best, p]):
                best = row
        for column in range(p, n + 1):
            held = system[p, column]
            system[p, column] = system[best, column]
            system[best, column] = held
        for row in range(n):
            if row != p:
                ratio = system[row, p] / system[p, p]
                for column in range(p, n + 1):
                    system[row, column] -= ratio * system[p, column]
    for p in range(n):
        system[p, n] /= system[p, p]
