"""Runs of several laws in one motor -> scorecard, tables, figures, and one page that holds them all."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from html import escape
from pathlib import Path
from typing import Final

import xarray
from tqdm import tqdm

from contactlab.comparison.causes import settled_of, with_causes
from contactlab.comparison.findings import conclusion, differences, first, verdicts
from contactlab.comparison.measured import judged
from contactlab.comparison.measurements import read_all
from contactlab.comparison.page import bulleted, filled, pictured
from contactlab.comparison.reruns import refined
from contactlab.comparison.runs import ComparisonError, Source, collect
from contactlab.comparison.samples import Design, Factor, Samples, factors_of
from contactlab.comparison.scorecard import MINUS, PLUS_MINUS, Cell, as_csv, as_latex, rows, scorecard
from contactlab.comparison.weighing import sample_count, unclear, written_share
from contactlab.metrics import CANNOT_TELL, FAIL, NOT_APPLICABLE, PASS, Metric
from contactlab.results.files import whole_file, whole_netcdf

SAMPLES: Final = 32  # rows of a design: a minute or two for three laws
STARTS: Final = 6

PAGE: Final = Path(__file__).with_name("report.html")  # the page without its words

KINDS: Final = {PASS: "pass", FAIL: "fail", NOT_APPLICABLE: "none", CANNOT_TELL: "none"}
"""Classes of the cells."""

CAPTIONS: Final = {
    "settled_quantities": "{headline} Marks are the settled motor with every law, or its run as recorded "
    "where the first lines say so, bars how far each cause "
    "moves it: one as long as marks are apart is of a cause that may explain their difference. A question "
    "mark is a cause that is not known.",
    "variance_shares": "What law, parameters, basis and step have of the variance of the settled rotor "
    "velocity over all motors drawn, with 95 % intervals.",
    "contact_force": "Normal force and friction of one contact, means over the record intervals. Peaks of "
    "rigid impacts grow without bound as the step falls; they are named, not drawn. {motion}",
    "tip_trajectory": "Path of the tip in the last two drive periods. {motion}",
    "rotor_velocity": "Rotor velocity, with its numerical error as a band that may be thinner than the line. "
    "Below: range of the laws, in black, and numerical error of each, as medians over a drive period.",
    "energy_flow": "Where the work of the drive has gone. {motion}",
    "phase_portrait": "Mean gap rate and slip over the gap in the last two drive periods. {motion}",
}
MOTION: Final = {
    True: "The settled motion; one period of it where it repeats itself.",
    False: "The transient, from the start of the recorded runs to their end.",
}


def compare(
    sources: Sequence[Source],
    output: str | Path | None = None,
    *,
    refine: bool = True,
    transient: bool = False,
    samples: int = SAMPLES,
    starts: int = STARTS,
    ranges: Mapping[str, float] | None = None,
    measured: Sequence[str | Path] = (),
    announce: Callable[[str], object] = bool,
) -> xarray.Dataset:
    """Compare contact laws in one motor, once it has settled.

    Every difference is weighed against the numerical error, the resonator's basis, the parameters within
    their ranges and other starts; `contactlab.comparison.weighing` has the rule.

        >>> import contactlab as cl
        >>> setups = [cl.build([f"law={law}"]) for law in ("newton", "hertz_penalty")]
        >>> runs = [cl.simulate(setup, duration=5e-4) for setup in setups]
        >>> found = cl.compare(runs, refine=False, transient=True)
        >>> found["value"].sel(metric="contact_count").to_series().to_dict()
        {'newton': 2.0, 'hertz_penalty': 2.0}

    Args:
        sources: run folders, their datasets, folders of such folders, or runs in memory; all of one
            motor with one drive.
        output: folder for tables, figures and the report; None writes nothing.
        refine: whether every law is run again at finer steps, with more friction, on another basis, from
            other starts and with other parameters; without, nothing is known of what a difference is due to.
        transient: whether the runs are compared as they were recorded, from their start on.
        samples: rows of the design in which law, parameters, basis and step are drawn together, a power of
            two; about six times as many steady states. 0 draws none.
        starts: from which each law's steady states are looked for.
        ranges: half the range of a parameter over its value, by full key, beside or in place of what the
            section `uncertainty` of the runs states; 0 is known exactly.
        measured: files of impacts (docs/measured_data.md) or of the motor's series that were measured; the
            laws are held against them with the parameters of their runs.
        announce: told how long the drawn motors will take, before they are made.

    Returns:
        Values, verdicts and numerical errors over the dimensions `law` and `metric`, the energy flow over
        `law` and `term`, and what `contactlab.comparison.causes.with_causes` adds.

    Raises:
        ComparisonError: the runs cannot be compared so; a sentence each.
        OSError: the folder cannot be written to.
    """
    if samples < 0 or samples & (samples - 1):
        raise ComparisonError(
            [f"samples is {samples}; it must be a power of two, or 0 for none. {SAMPLES} is usual."]
        )
    runs, notes = collect(sources, transient=transient)
    measurements = judged(read_all(measured), runs)
    bar = tqdm(runs, unit=" laws", disable=None, delay=1.0, leave=False)
    again = partial(refined, transient=transient, refine=refine, starts=starts)
    laws = [again(run) for run in bar]
    factors: tuple[Factor, ...] = ()
    drawn = None
    if refine and not transient and (complete := settled_of(laws)):
        factors = factors_of(complete, ranges or {})
        drawn = _drawn(Design(complete, factors, samples), announce) if samples else None
    data = scorecard(laws, notes, measurements)
    data = data.assign_attrs(first="") if transient else with_causes(data, laws, factors, drawn, ranges or {})
    if output is None:
        return data
    # It brings the plotting.
    from contactlab.comparison.figures import draw_all

    folder = Path(output)
    folder.mkdir(parents=True, exist_ok=True)
    with whole_netcdf(folder / "metrics.nc") as part:
        data.to_netcdf(part, engine="netcdf4")
    report = page(data, draw_all(laws, data, folder))
    texts = {"scorecard.csv": as_csv(data), "scorecard.tex": as_latex(data), "report.html": report}
    for name, text in texts.items():
        with whole_file(folder / name) as part:
            part.write_text(text, encoding="utf-8")
    return data


def _drawn(design: Design, announce: Callable[[str], object]) -> Samples:
    """Let motors settle that are drawn together."""
    announce(
        f"{design.size} motors are drawn and brought to their steady states; that takes about "
        f"{tqdm.format_interval(design.estimate)}. Fewer by --samples."
    )
    bar = tqdm(design.run(), total=design.size, unit=" motors", disable=None, leave=False)
    return design.samples([*bar])


def page(data: xarray.Dataset, pictures: Iterable[Path]) -> str:
    """Write the report: one page that holds its pictures, PNG files, itself and fetches nothing."""
    labels, notes = [str(label) for label in data["law"].values], data.attrs["notes"].splitlines()
    table, said_of = rows(data), [_typeset(said) for said in differences(data)]
    shown = {path.stem: _picture(path, said_of, settled="cause" in data.dims) for path in pictures}
    code = {k.removesuffix("_version"): v for k, v in data.attrs.items() if "_version" in k}
    versions = [f"{k} {v}" for k, v in code.items()] + [f"revision {data.attrs['git_revision']}"]
    said = {
        "title": escape("Contact laws compared" if len(labels) > 1 else f"Contact law {labels[0]}"),
        "first": bulleted(first(data)),
        "headline": escape(next(iter(said_of), "")),
        "differences": bulleted(said_of[1:]),
        "causes": "\n".join(shown.pop(name, "") for name in ("settled_quantities", "variance_shares")),
        "conclusion": escape(conclusion(data)),
        "head": "".join(f"<th>{escape(word)}</th>" for word in ("metric", "must be", *labels)),
        "scorecard": "\n".join(_row(*row) for row in table),
        "pictures": "\n".join(shown.values()),
        "shares": _shares(data),
        "verdicts": "\n".join(f"<h3>{escape(k)}</h3>{bulleted(v)}" for k, v in verdicts(data).items()),
        "measured": _measured(data),
        "notes": f"<h2>Notes</h2>{bulleted(notes)}" if notes else "",
        "definitions": "\n".join(_definition(metric) for metric, _ in table),
        "configurations": "\n".join(_configuration(data.sel(law=label)) for label in labels),
        "versions": escape("; ".join(versions)),
    }
    return filled(PAGE, said)


def _typeset(sentence: str) -> str:
    """Give a sentence as a page has it; an error stays in the line of its number."""
    return sentence.replace(" +- ", f"\u00a0{PLUS_MINUS}\u00a0")


def _row(metric: Metric, cells: dict[str, Cell]) -> str:
    line = f"<tr><td title='{escape(metric.meaning)}'>{escape(metric.brief + metric.bracketed)}</td>"
    line += f"<td>{escape(metric.threshold)}</td>"
    for cell in cells.values():
        kind = KINDS.get(cell.verdict, "")
        number, sign, error = cell.number.partition(f" {PLUS_MINUS}")
        small = f" <small>{PLUS_MINUS}{error}</small>" if sign else ""
        line += f"<td class='{kind}'>{number}{small} {cell.word}</td>"
    return f"{line}</tr>"


def _measured(data: xarray.Dataset) -> str:
    """Say where the rows come from that are measured; nothing where none is."""
    if "measured" not in data.dims:
        return ""
    names = ("measured", "measured_contents", "measured_source", "measured_file", "measured_digest")
    said = []
    for title, contents, source, path, digest in zip(*(data[name].values for name in names), strict=True):
        words = f"{title}: {contents}, as of {path}, SHA-256 {digest}."
        said.append(f"{words} Source: {source}" if source else words)
    return (
        "<p>The last rows hold the laws, with the parameters as run, against what was measured; there \u00b1 "
        f"is half of a 95 % interval by resampling the impacts. The data:</p>{bulleted(said)}"
    )


def _shares(data: xarray.Dataset) -> str:
    """Make the table of the shares in the variance of the settled velocity; nothing where none was drawn."""
    if "total_order" not in data:
        return ""
    here, count = data.sel(quantity="rotor_velocity"), sample_count(data)
    lines = []
    for name, alone, both in zip(
        data["factor"].values, here["first_order"].values, here["total_order"].values, strict=True
    ):
        cells = "".join(
            f"<td>{f'{count} samples do not tell' if unclear(*each[1:]) else written_share(*each)}</td>"
            for each in (alone, both)
        )
        lines.append(f"<tr><td>{escape(str(name))}</td>{cells}</tr>".replace("-", MINUS))
    head = "<tr><th>factor</th><th>alone</th><th>with others</th></tr>"
    ranges = escape(str(data.attrs["parameters"]).replace("+-", PLUS_MINUS))
    return (
        "<h2>Shares in the variance of the settled rotor velocity</h2>"
        f"<p>Of {data.sizes['motor']} motors drawn together: every law, both bases and three steps equally "
        f"likely, {ranges}.</p><div class='box'><table>{head}{''.join(lines)}</table></div>"
    )


def _picture(path: Path, said_of: Sequence[str], *, settled: bool) -> str:
    words = {"motion": MOTION[settled], "headline": next(iter(said_of), "")}
    return pictured(path, CAPTIONS[path.stem].format(**words).strip())


def _definition(metric: Metric) -> str:
    """Give key, symbol, meaning and the threshold's reason of a metric."""
    limit = f" Must be {metric.threshold}: {metric.reason}." if metric.threshold else ""
    source = f" Source: {metric.source}." if metric.source else ""
    text = escape(f"{metric.symbol}{metric.bracketed}: {metric.meaning}.{limit}{source}")
    return f"<li><code>{escape(metric.key)}</code> = {text}</li>"


def _configuration(law: xarray.Dataset) -> str:
    said = {str(key): escape(str(law[key].item())) for key in law.coords if not law[key].dims}
    return (
        f"<h3>{said['law']}</h3><p>{said['run']}, recorded by contactlab {said['contactlab_version']}; "
        f"values at {said['refined']}.</p><details><summary>Configuration</summary>"
        f"<pre>{said['configuration']}</pre></details>"
    )
