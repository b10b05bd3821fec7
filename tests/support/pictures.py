"""What stands in a figure of matplotlib, and where: for tests that read pictures."""

from collections.abc import Iterator

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
