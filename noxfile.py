"""What `.ci/run` does, step by step and in environments of its own: `nox -l` lists the sessions."""

import nox

PACKAGES = "-e", "packages/contactlab-data", "-e", "packages/contactlab-explorer"
PYTHONS = ("3.11", "3.12", "3.13", "3.14", "3.15")

LOWEST = (
    *("tests/cli/test_app.py", "tests/config", "tests/engine/test_case_a.py"),
    *("tests/laws/test_registry.py", "tests/results", "tests/studies/test_tables.py"),
)
"""Tests of what an old version of a dependency may lack."""

nox.options.sessions = ("lint", "tests")
nox.options.reuse_existing_virtualenvs = True


@nox.session(python=PYTHONS)
def tests(session: nox.Session) -> None:
    """Run the suite, or what is named: `nox -s tests-3.12 -- tests/laws`."""
    session.install("-e", ".[test]", *PACKAGES)
    session.run("pytest", *session.posargs)


@nox.session
def lint(session: nox.Session) -> None:
    """Check style, format, types and import contracts."""
    session.install("-e", ".[test]", *PACKAGES, "playwright")
    checks = "ruff check", "ruff format --check", "mypy", "lint-imports", "python docs/tools/plain_words.py"
    for command in checks:
        session.run(*command.split())


@nox.session(python=PYTHONS[0], venv_backend="uv")
def lowest(session: nox.Session) -> None:
    """Run tests with the lowest versions that pyproject.toml states."""
    session.run_install("uv", "pip", "install", "--resolution", "lowest-direct", "-e", ".")
    # The tests' own tools may be new.
    session.install("hypothesis", "psutil", "pytest", "pytest-xdist")
    # An old matplotlib calls a new pyparsing by its old names.
    session.run("pytest", "-Wignore::DeprecationWarning", *(session.posargs or LOWEST))


@nox.session
def docs(session: nox.Session) -> None:
    """Build the documentation into build/site; a warning is a failure."""
    session.install("-e", ".[docs]")
    session.run("python", "-m", "sphinx", "-W", "-n", "--keep-going", "docs", "build/site", *session.posargs)


@nox.session
def pictures(session: nox.Session) -> None:
    """Make the pictures of README, the home page and the paper, and the drawings of the documentation."""
    session.install("-e", ".")
    session.run("python", "docs/tools/readme_pictures.py")
    session.run("python", "docs/tools/reader_pictures.py")
    session.run("python", "docs/tools/drawings.py")


@nox.session
def film(session: nox.Session) -> None:
    """Make the film of the explorer, in Chromium."""
    session.install("-e", ".", "-e", "packages/contactlab-explorer", "playwright")
    session.run("python", "docs/tools/explorer_film.py")


@nox.session
def paper(session: nox.Session) -> None:
    """Write numbers, sentences and figures of the papers; what has fallen or is missing is a failure."""
    session.install("-e", ".[design,experiments]", "-e", "packages/contactlab-data")
    session.run("python", "experiments/papers.py")
