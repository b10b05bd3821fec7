"""Print the versions of contactlab, of Python, and of the packages that can change a result."""

from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE
from contactlab.results.provenance import checkout_state, versions


def main(arguments: list[str]) -> int:
    """Print a line each, contactlab first, with the revision of a checkout, and return the exit status."""
    Parser(__name__, __doc__).read(arguments)
    revision, dirty = checkout_state()
    rows = {name.removesuffix("_version"): version for name, version in versions().items()}
    if dirty in (0, 1):
        rows["contactlab"] += f" (revision {revision}{', changed' if dirty else ''})"
    print(*(f"{name} {version}" for name, version in rows.items()), sep="\n")
    return COMPLETE
