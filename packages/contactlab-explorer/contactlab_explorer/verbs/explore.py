"""Open a page in the browser with sliders for a motor or a law by itself, and up to four laws side by side.

Groups and keys are those of a run, law=A,B for several laws. The page is on this machine alone, and opens by
the link that is printed.
"""

import webbrowser

from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE, RefusalError
from contactlab.config import ConfigurationError, build
from contactlab.suggestion import suggestion


def main(arguments: list[str]) -> int:
    """Serve the page until it is interrupted, and return the exit status.

    Raises:
        RefusalError: a key, a law or the port is refused.
    """
    parser = Parser(__name__, __doc__, "[KEY=VALUE ...]", "of a run: resonator=modal resonator.file=FILE")
    parser.option("law", "NAME,NAME", "laws side by side, up to four: newton, friction/dahl")
    parser.option("see", "VIEW", "what is seen: motor, path or impact")
    parser.option("port", "NUMBER", "of this machine; 0, the default, takes a free one")
    parser.option("browser", "true|false", "whether the browser is opened")
    own = {"law", "see", "port", "browser"}
    options = [word for word in arguments if word.partition("=")[0] in own or word.startswith("-")]
    _, values = parser.read(options)
    # Imported here: they bring the engine, which --help does not need.
    from contactlab_explorer.guard import free_port
    from contactlab_explorer.state import MOST, VIEWS, State, laws, options_of

    chosen = values.get("law", "newton").split(",")
    for law in chosen:
        if law not in laws():
            hint = suggestion(law, laws(), f"There are {', '.join(laws())}.")
            raise RefusalError(f"There is no law '{law}'. {hint}")
    if len(chosen) > MOST:
        raise RefusalError(f"law names {len(chosen)} laws; they must be {MOST} at most.")
    if (view := values.get("see", "motor")) not in VIEWS:
        raise RefusalError(f"see is {view}; it must be one of {', '.join(VIEWS)}.")
    if (browser := values.get("browser", "true")) not in ("true", "false"):
        raise RefusalError(f"browser is {browser}; it must be true or false.")
    text = values.get("port", "0")
    if not text.isdecimal() or int(text) > 65535:
        raise RefusalError(f"port is {text}; it must be a whole number from 0 to 65535.")
    try:
        # Numbers and parts of a law are those of the first.
        first = [f"{group}={name}" for group, name in options_of(chosen[0]).items()]
        base = build([*first, *(word for word in arguments if word not in options)])
        port = free_port(int(text))
    except ConfigurationError as error:
        raise RefusalError(str(error)) from error
    except OSError as error:
        raise RefusalError(
            f"port is {text}, which cannot be had ({error.strerror}); give another."
        ) from error
    # Imported here: it brings the server, which no refusal needs.
    from contactlab_explorer.serve import serve

    serve(State(base, view, tuple(chosen)), port, webbrowser.open if browser == "true" else None)
    return COMPLETE
