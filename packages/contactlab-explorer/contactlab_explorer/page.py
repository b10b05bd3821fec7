"""The page: sliders, sentences and charts of a state, by NiceGUI."""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from math import cos, pi, sin
from typing import Any, Final, final
from urllib.parse import urlencode

from nicegui import background_tasks, ui
from starlette.requests import Request

from contactlab.config import ConfigurationError
from contactlab_explorer.pictures import approach, pictures, saved
from contactlab_explorer.pool import FAULT, STOPPED, Pool
from contactlab_explorer.scales import position, steps_of, value_at
from contactlab_explorer.state import MOST, OF_MOTOR, History, State, laws

COLOURS: Final = "#0072b2", "#d55e00", "#009e73", "#cc79a7"
"""Of the laws, in the order of their choice; told apart without colour vision (Okabe and Ito 2008)."""

OPEN: Final = "law", "plant", "drive", "contact", "path", "impact"
"""Groups whose sliders are shown at first."""

PATIENCE: Final = 0.5
"""Time for which the law that was touched first is waited for before a newer state is computed [s]."""

Axis = tuple[str, str]

CHARTS: Final[dict[str, dict[str, Axis]]] = {
    "motor": {
        "tip": ("tip, tangential (um)", "tip, normal (um)"),
        "gap": ("time (periods of the drive)", "gap (um)"),
        "force": ("time (periods of the drive)", "normal force (N)"),
        "approach": ("time (ms)", "rotor velocity (rad/s)"),
        "multipliers": ("Floquet multipliers, real", "imaginary"),
        "energy": ("mean power (mW)", ""),
    },
    "plant": {
        "position": ("time (ms)", "position (um), support dashed"),
        "gap": ("time (ms)", "gap (um)"),
        "force": ("time (ms)", "normal force (N)"),
        "multipliers": ("Floquet multipliers, real", "imaginary"),
        "energy": ("mean power (mW)", ""),
    },
    "path": {"loop": ("slip (um)", "friction force (N)")},
    "impact": {
        "restitution": ("speed of the approach (m/s)", "restitution (1)"),
        "contact_time": ("speed of the approach (m/s)", "contact time (us)"),
    },
}
"""Axes of the charts of each view, and of a small plant in place of the motor."""

CIRCLE: Final = [[cos(0.02 * pi * i), sin(0.02 * pi * i)] for i in range(101)]
"""The unit circle, within which multipliers of a stable orbit lie."""


@final
class Slider(ui.slider):
    """A slider whose own moves do not come back to it: late, they would undo those of a quick hand."""

    LOOPBACK = False


def chart(name: str, x: str, y: str) -> ui.echart:
    """Return an empty chart."""
    # Readable on light and on dark ground.
    grey, faint = {"color": "#808080"}, {"lineStyle": {"color": "rgba(128,128,128,0.25)"}}
    axis: dict[str, Any] = {"nameLocation": "middle", "scale": True, "splitLine": faint}
    axis |= {"nameTextStyle": grey, "axisLabel": grey, "axisLine": {"lineStyle": grey}}
    options: dict[str, Any] = {
        "animation": False,
        "color": [*COLOURS],
        "aria": {"enabled": True},
        "grid": {"left": 66, "right": 60 if name == "force" else 16, "top": 16, "bottom": 44},
        "xAxis": {"type": "value", "name": x, "nameGap": 26, **axis},
        "yAxis": [{"type": "value", "name": y, "nameGap": 46, **axis}],
        "series": [],
    }
    if name == "force":
        second = {"name": "impulse of an impact (uN s)", "nameGap": 40, "position": "right", "min": 0}
        options["yAxis"].append({"type": "value", **axis, **second, "splitLine": {"show": False}})
    if name == "energy":
        # Names stand one below the other: side by side they would overlap on a narrow screen.
        options["grid"]["left"] = 90
        options["yAxis"] = [{"type": "category", "inverse": True, "axisLabel": {"interval": 0, **grey}}]
    if name in ("restitution", "contact_time"):
        options["xAxis"]["type"] = "log"
    return ui.echart(options).classes("w-full h-64").props(f'data-chart="{name}"')


def series_of(name: str, picture: dict[str, Any], law: str, colour: str) -> list[dict[str, Any]]:
    """Return what a chart draws of a law."""
    common = {"name": law, "itemStyle": {"color": colour}, "lineStyle": {"color": colour}}
    if name not in picture:
        return []
    if name == "energy":
        return [{**common, "type": "bar", "data": [[power, flow] for flow, power in picture[name]]}]
    if name == "multipliers":
        return [{**common, "type": "scatter", "symbolSize": 7, "data": picture[name]}]
    drawn = [{**common, "type": "line", "showSymbol": False, "data": picture[name]}]
    if name == "force":
        drawn.append({**drawn[0], "yAxisIndex": 1, "data": picture["impulse"]})
    if name == "position":
        dashed = {"color": colour, "type": "dashed"}
        drawn.append({**drawn[0], "lineStyle": dashed, "data": picture["under"]})
    return drawn


@final
class Page:
    """One page in one browser, with a state of its own.

    Args:
        state: that it begins with.
        pool: what computes.
        client: of NiceGUI.
    """

    def __init__(self, state: State, pool: Pool, client: Any) -> None:
        self._history, self._pool, self._client = History(state), pool, client
        self._number, self._wanted = pool.page(), asyncio.Event()
        self._ticket, self._touched = pool.ticket(self._number), ""
        self._pictures: dict[str, dict[str, Any]] = {}
        self._colours = {law: COLOURS[place] for place, law in enumerate(state.laws)}
        self._faults: dict[str, ui.label] = {}
        self._charts: dict[str, ui.echart] = {}

    @property
    def state(self) -> State:
        """What is shown."""
        return self._history.state

    def build(self) -> None:
        """Make all elements."""
        ui.dark_mode(None)
        with ui.row().classes("w-full no-wrap max-md:flex-wrap items-start"):
            with ui.column().classes(
                "w-80 max-md:w-full shrink-0 max-md:max-h-[45vh] max-md:overflow-y-auto no-wrap"
            ):
                self._view = ui.select(self.state.views, value=self.state.view, label="what is seen").classes(
                    "w-full"
                )
                self._view.on_value_change(lambda e: self._choose(replace(self.state, view=e.value)))
                self._laws = ui.select(
                    laws(), multiple=True, value=[*self.state.laws], label=f"laws, up to {MOST}"
                ).classes("w-full")
                self._laws.props('use-chips aria-label="laws"')
                self._laws.on_value_change(lambda e: self._choose(self.state.with_laws(e.value)))
                with ui.row().classes("gap-1"):
                    ui.button("undo", on_click=self.undo).props("dense outline no-caps")
                    ui.button("stop", on_click=self.stop).props("dense outline no-caps")
                    for kind in ("run.nc", "run.png"):
                        ui.button(kind, on_click=lambda k=kind: self.save(k)).props("dense outline no-caps")
                self._sliders = ui.column().classes("w-full gap-1")
            with ui.column().classes("grow min-w-0 max-md:w-full"):
                self._said = ui.row().classes("gap-x-4 gap-y-0").props('role="status" data-state="computing"')
                self._fault = ui.label().classes("text-red-700 dark:text-red-400").props('role="alert"')
                self._grid = ui.grid().classes("w-full grid-cols-1 lg:grid-cols-2")
                with ui.expansion("command, Python, YAML of what is seen").classes("w-full"):
                    self._texts = ui.column().classes("w-full")
        self._show()

    def _show(self) -> None:
        """Make sliders and charts of the state anew."""
        state = self.state
        # What is left keeps its colour.
        free = [c for c in COLOURS if c not in [self._colours.get(law) for law in state.laws]]
        self._colours = {law: self._colours.get(law) or free.pop(0) for law in state.laws}
        self._view.value, self._laws.value = state.view, sorted(state.laws, key=laws().index)
        self._faults.clear()
        self._sliders.clear()
        groups: dict[str, list[str]] = {name: [] for name in ("law", *(state.view,), *OF_MOTOR)}
        for key in state.sliders:
            groups.setdefault(key.partition(".")[0], []).append(key)
        with self._sliders:
            for group, keys in groups.items():
                if keys:
                    with ui.expansion(group, value=group in OPEN).classes("w-full").props("dense"):
                        for key in keys:
                            self.add_slider(key)
        self._grid.clear()
        with self._grid:
            self._charts = {name: chart(name, *axes) for name, axes in CHARTS[state.scene].items()}
        self._draw()

    def add_slider(self, key: str) -> None:
        """Make a slider with a labelled number beside it, and a place for a sentence."""
        number = self.state.sliders[key]
        value = number.value if isinstance(number.value, float | int) else None
        law = key.partition("@")[2]
        unit = "" if number.unit == "1" else f" ({number.unit})"
        label = f"{number.symbol}{unit} {number.meaning}{law and f', {law}'}".strip()
        with ui.row().classes("w-full items-center gap-1 no-wrap"):
            ui.label(label).classes("text-xs grow")
            box = ui.number(value=value, format="%.5g").classes("w-24")
            box.props(f'dense aria-label="{label}" data-number="{key}"')
        slider = Slider(min=0, max=steps_of(number), step=1, value=position(number, value))
        slider.props(f'aria-label="{label}" data-key="{key}"').tooltip(f"{key}: {number.range}")
        self._faults[key] = ui.label().classes("text-xs text-red-700 dark:text-red-400").props('role="alert"')

        def moved(place: float | None) -> None:
            now = self.state.sliders[key]
            if place is None or position(now, now.value) == place:
                return
            box.value = value_at(now, place)
            self._set(key, value_at(now, place))

        def typed() -> None:
            if box.value is not None:
                self._set(key, float(box.value))
                slider.value = position(number, float(box.value))

        slider.on_value_change(lambda e: moved(e.value))
        box.on("change", typed)

    def _set(self, key: str, value: float) -> None:
        """Take another number."""
        self._touched = key
        self._history.change(self.state.with_number(key, value))
        self._wanted.set()

    def _choose(self, state: State) -> None:
        """Take other laws or another view."""
        if (state.view, {*state.laws}) != (self.state.view, {*self.state.laws}):
            self._history.change(state)
            self._pictures.clear()
            self._show()
            self._wanted.set()

    def undo(self) -> None:
        """Go back to the state before the last change."""
        if self._history.undo():
            self._pictures.clear()
            self._show()
            self._wanted.set()

    def stop(self) -> None:
        """End what is being computed."""
        self._ticket = self._pool.ticket(self._number)

    async def save(self, kind: str) -> None:
        """Let the browser save a run or a figure of the law that was touched last."""
        state, law = self.state, self.state.laws[0]
        self._fault.text = f"computing {kind} of {law}"
        content = await self._pool.work(self._number, self._ticket, saved, state, law, kind)
        refused = content.get(FAULT, "stopped") if isinstance(content, dict) else ""
        self._fault.text = refused
        if not refused:
            ui.download.content(content, kind)

    def _draw(self) -> None:
        """Put the pictures that there are into the charts."""
        for name, each in self._charts.items():
            each.options["series"] = [
                one
                for law in sorted(self._pictures, key=laws().index)
                for one in series_of(name, self._pictures[law], law, self._colours[law])
            ]
            if name == "multipliers":
                ring = {"type": "line", "data": CIRCLE, "showSymbol": False, "silent": True}
                each.options["series"].append({**ring, "lineStyle": {"color": "#888", "width": 1}})
            each.update()

    def _tell(self, doing: str = "") -> None:
        """Say what each law does, in its colour, and what is being done; nothing is if all is there."""
        self._said.clear()
        with self._said:
            for law in sorted(self._pictures, key=laws().index):
                ui.label(f"\u25a0 {self._pictures[law].get('said', law)}").style(
                    f"color: {self._colours[law]}"
                )
            if doing:
                ui.label(f"{doing} ...").classes("text-gray-500")
        self._said.props(f'data-state="{"computing" if doing else "ready"}"')

    def refused(self) -> bool:
        """Say what the checks refuse, beside the slider that was moved; return whether they do."""
        for label in self._faults.values():
            label.text = ""
        self._fault.text, state = "", self.state
        try:
            for law in state.laws:
                state.setup(law)
            _ = state.motion if state.view != "motor" else None
        except (ConfigurationError, ValueError) as fault:
            self._faults.get(self._touched, self._fault).text = str(fault)
            return True
        return False

    async def work(self) -> None:
        """Compute the newest state again and again, the law that was touched before the others."""
        while True:
            await self._wanted.wait()
            self._wanted.clear()
            if self.refused():
                self._tell()
                continue
            state = self.state
            self._ticket = self._pool.ticket(self._number)
            self._tell("computing")
            with self._client:
                whole = await self._all(pictures, state)
                if whole and state.scene == "motor":
                    self._tell("approach to the steady state")
                    whole = await self._all(approach, state)
                if whole:
                    self._tell()
                    self.finish(state)
                elif not self._wanted.is_set():
                    self._tell()
                    self._fault.text = "Stopped: what was not yet there is left out."

    async def _all(self, function: Callable[..., Any], state: State) -> bool:
        """Draw what a function returns of each law as it is ready; return whether nothing newer came."""
        ticket, first = self._ticket, state.laws[0]
        tasks = {
            asyncio.ensure_future(self._pool.work(self._number, ticket, function, state, law)): law
            for law in state.laws
        }
        newer = asyncio.ensure_future(self._wanted.wait())
        waiting, began = {*tasks}, asyncio.get_running_loop().time()
        while waiting:
            urgent = first in {tasks[each] for each in waiting} and function is pictures
            elapsed = asyncio.get_running_loop().time() - began
            if self._wanted.is_set() and not (urgent and elapsed < PATIENCE):
                break
            look = waiting if urgent and elapsed < PATIENCE else {*waiting, newer}
            done, _ = await asyncio.wait(look, timeout=PATIENCE, return_when=asyncio.FIRST_COMPLETED)
            for each in done - {newer}:
                waiting.discard(each)
                self.take(tasks[each], each.result(), function)
            if elapsed > 4 * PATIENCE and waiting:
                names = ", ".join(tasks[each] for each in waiting)
                self._tell(f"computing {names} for {elapsed:.0f} s; the first time its code is compiled")
        newer.cancel()
        return not waiting and not self._wanted.is_set() and ticket == self._ticket

    def take(self, law: str, picture: dict[str, Any], function: Callable[..., Any]) -> None:
        """Draw what was computed of a law, or say why there is nothing."""
        if law not in self.state.laws or STOPPED in picture:
            return
        if FAULT in picture:
            self._fault.text = f"{law}: {picture[FAULT]}"
            self._pictures.pop(law, None)
        elif function is pictures:
            # The way to the steady state stays until the next one is there.
            before = {k: v for k, v in self._pictures.get(law, {}).items() if k == "approach"}
            self._pictures[law] = before | picture
        elif law in self._pictures:
            self._pictures[law] |= picture
        self._draw()

    def finish(self, state: State) -> None:
        """Put the state into the link, and its texts below the charts."""
        ui.navigate.history.replace(f"/?{urlencode(state.query())}")
        self._texts.clear()
        with self._texts:
            for language, text in state.texts(state.laws[0]).items():
                ui.code(text, language=language).classes("w-full").props(f'data-text="{language}"')

    def close(self) -> None:
        """End the page's work."""
        self._pool.leave(self._number)

    def begin(self) -> None:
        """Compute what the page begins with."""
        self._wanted.set()


def add_page(state: State, pool: Pool) -> None:
    """Add the page, which begins with a state unless its link has another."""

    @ui.page("/")
    async def page(request: Request) -> None:
        client = ui.context.client
        made = Page(state.of_query(dict(request.query_params)), pool, client)
        made.build()
        client.on_delete(made.close)
        await client.connected()
        task = background_tasks.create(made.work())
        client.on_delete(task.cancel)
        made.begin()
