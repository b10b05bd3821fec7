"""`contactlab characterise [KEY=VALUE ...]`: the data sheet of a motor, under one law or several."""

from pathlib import Path

from contactlab.cli.arguments import Parser
from contactlab.cli.jobs import check_output, unwritable
from contactlab.cli.terminal import COMPLETE, RefusalError


def main(arguments: list[str]) -> int:
    """Characterise a motor, write the files and print the sheet.

    Returns:
        The exit status.

    Raises:
        RefusalError: the motor cannot be characterised, or the folder cannot be written to.
    """
    parser = Parser(
        "characterise",
        ". The sheet is in the motor's own sense of rotation, of which it says whether it is positive in the "
        "model: a load that brakes has a positive torque there, one that drives the motor a negative one. "
        "rotor.load_torque is positive against positive rotation of the model: it brakes a motor that "
        "turns in the positive sense and drives one that turns in the negative.",
    )
    words = "the motor, as for a run; law=A,B,C is --law A,B,C"
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE", help=words)
    parser.add_argument("--law", metavar="A,B,C", help="laws that share the sheet; default: the motor's own")
    parser.add_output("datasheet", "sheet.html, sheet.nc and the figure")
    given = parser.read(arguments)
    # Imported here: they bring Hydra and the plotting, which --help does not need.
    from contactlab.cli.idle_words import KEPT, LASTING, refuse_idle
    from contactlab.config import ConfigurationError, build
    from contactlab.datasheet import as_text, characterise
    from contactlab.orbits import NoPeriodError

    output: Path = given.output
    check_output(output)
    chosen = [word for word in given.overrides if word.startswith("law=")]
    if given.law and chosen:
        raise RefusalError(f"{chosen[0]} and --law are both given; it must be one of them. Leave one out.")
    listed = chosen[-1].removeprefix("law=") if chosen and "," in chosen[-1] else given.law
    laws = [f"law={name.strip()}" for name in listed.split(",")] if listed else []
    rest = [word for word in given.overrides if word not in chosen] if laws else given.overrides
    refuse_idle(given.overrides, "a data sheet", *KEPT, *LASTING)
    try:
        setups = [build([*rest, law]) for law in laws] or [build(rest)]
        data = characterise(setups, output=output)
    except ConfigurationError as error:
        raise RefusalError("\n".join(error.faults)) from error
    except NoPeriodError as error:
        raise RefusalError(str(error)) from error
    except OSError as error:
        raise unwritable(output, error) from error
    print(as_text(data))
    print(f"\nWritten to {output}: sheet.html, sheet.nc, sheet.png and sheet.pdf.")
    return COMPLETE
