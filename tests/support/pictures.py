"""What stands in a figure of matplotlib, and where: for tests that read pictures."""

from collections.abc import Collection, Iterator, Mapping

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text
from matplotlib.transforms import Bbox


def legends_in(figure: Figure) -> list[Legend]:
    """The legends of a figure and of its axes."""
    own = [axes.get_legend() for axes in figure.axes]
    return [*figure.legends, *(legend for legend in own if legend is not None)]


def entries_in(figure: Figure) -> list[str]:
    """The entries of all legends."""
    return [text.get_text().replace("\n", " ") for each in legends_in(figure) for text in each.get_texts()]


def _artists(figure: Figure) -> Iterator[Text]:
    yield from figure.texts
    if figure.get_suptitle():
        yield figure._suptitle
    for legend in legends_in(figure):
        yield legend.get_title()
        yield from legend.get_texts()
    for axes in figure.axes:
        yield from _of_axes(axes)


def _of_axes(axes: Axes) -> Iterator[Text]:
    yield from (axes.title, axes._left_title, axes._right_title)
    yield from axes.texts
    if axes.axison:
        yield from (axes.xaxis.label, axes.yaxis.label)


def texts_in(figure: Figure) -> list[str]:
    """Titles, labels, notes and legends, each in one line."""
    every = (text.get_text().replace("\n", " ") for text in _artists(figure) if text.get_visible())
    return [text for text in every if text.strip()]


def boxes_in(figure: Figure) -> dict[str, Bbox]:
    """The boxes [pixel] of all visible upright texts in a drawn picture, ticks among them."""
    FigureCanvasAgg(figure).draw()
    artists = [*dict.fromkeys(_artists(figure))]
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            artists.append(axis.get_offset_text())
            artists += [
                tick.label1
                for tick in axis.get_major_ticks()
                if low <= tick.get_loc() <= high and tick.label1.get_visible() and axes.axison
            ]
    shown = [text for text in artists if text.get_text().strip() and text.get_visible()]
    return {
        f"{number} {text.get_text()}": text.get_window_extent()
        for number, text in enumerate(shown)
        if text.get_rotation() % 90.0 == 0.0
    }


def offsets_in(figure: Figure) -> list[str]:
    """What stands at an end of an axis in place of digits of its ticks, as "+1e-3"."""
    FigureCanvasAgg(figure).draw()
    every = (axis.get_offset_text().get_text() for axes in figure.axes for axis in (axes.xaxis, axes.yaxis))
    return [text for text in every if text]


def ticks_in(figure: Figure) -> list[str]:
    """The names at the ticks of all axes."""
    return [label.get_text().replace("\n", " ") for axes in figure.axes for label in axes.get_yticklabels()]


def hidden_in(figure: Figure) -> list[tuple[str, str]]:
    """Pairs of texts that cover each other."""
    boxes = list(boxes_in(figure).items())
    return [(a, b) for i, (a, box) in enumerate(boxes) for b, other in boxes[:i] if box.overlaps(other)]


def assert_names_what_it_shows(figures: Mapping[str, Figure], named: Mapping[str, Collection[str]]) -> None:
    """Every figure is there, and has every text that is named."""
    assert {*figures} == {*named}
    for name, wanted in named.items():
        texts, ticks = texts_in(figures[name]), ticks_in(figures[name])
        for text in wanted:
            assert any(text in each for each in [*texts, *ticks]), (name, text, texts)


def assert_can_be_read(figures: Mapping[str, Figure]) -> None:
    """One way to write units, no offset at ticks, no text on another, no caption that is a file's name."""
    for name, figure in figures.items():
        assert not [text for text in texts_in(figure) if "(um)" in text or "(uJ)" in text], name
        assert offsets_in(figure) == [], name
        assert hidden_in(figure) == [], name
        assert figure.get_label().replace("_", " ") not in ("", name.replace("_", " ")), name


def assert_every_law_has_a_name(figure: Figure, laws: Collection[str]) -> None:
    """No text covers another or leaves the picture, and every law stands in a legend or at a tick."""
    assert hidden_in(figure) == []
    width, height = figure.canvas.get_width_height()
    for text, box in boxes_in(figure).items():
        assert min(box.x0, box.y0) >= 0.0, text
        assert box.x1 <= width, text
        assert box.y1 <= height, text
    names = [*entries_in(figure), *ticks_in(figure)]
    assert {*laws} <= {each.partition(",")[0] for each in names}
