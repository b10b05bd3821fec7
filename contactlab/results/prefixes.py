"""Handy multiples of SI units for people to read."""


def prefixed_unit(size: float, symbol: str, smallest: float = 1.0) -> tuple[str, float]:
    """The unit in which a quantity is a handy number, from the unit itself down to its nano-part.

    Args:
        size: of the quantity in the unit without a prefix.
        symbol: of the unit without a prefix.
        smallest: number that the quantity shall have at least.

    Returns:
        The symbol with its prefix, and its size in the unit without one.
    """
    for prefix, scale in (("", 1.0), ("m", 1e-3), ("µ", 1e-6)):
        # A hair below counts, so that a round-off does not turn 1 ms into 1000 µs.
        if size >= 0.999 * smallest * scale:
            return f"{prefix}{symbol}", scale
    return f"n{symbol}", 1e-9


def prefixed(size: float, symbol: str) -> str:
    """A quantity to four digits with a handy unit, e.g. `248.3 µs`; zero keeps the plain unit."""
    unit, scale = prefixed_unit(abs(size), symbol) if size else (symbol, 1.0)
    return f"{size / scale:.4g} {unit}"
