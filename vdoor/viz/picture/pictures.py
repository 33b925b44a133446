"""Pictures of the stages of a recorded run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from matplotlib import style

from vdoor.errors import VdoorError
from vdoor.history import History
from vdoor.viz.marks.kinds import Chart
from vdoor.viz.picture.chart import draw_chart
from vdoor.viz.picture.layout import LEAST_PICTURE, LEAST_WIDTH, MARGIN, Layout, Wanted, charts_alone, laid_out
from vdoor.viz.picture.plan import BAR_PX, Window, draw_plan, entries, fitted
from vdoor.viz.picture.sheet import LINE_PX, Entry, Sheet, folded, lines_of
from vdoor.viz.picture.views import Plan, View, tabs_in, view_of_tab

TITLE_PX, TEXT_PX = 18.0, 13.0
SIZE = (1600, 1000)


class Picture(NamedTuple):
    """A picture of a tab."""

    tab: str
    number: int
    """Place of the tab among those of the run."""
    png: bytes


def pictures(run: History, *, tabs: Sequence[str] | None = None, size: tuple[int, int] = SIZE) -> Iterator[Picture]:
    """A picture of each tab, or of some, at most of a size in pixels; `VdoorError` for a tab that there is not."""
    known = tabs_in(run)
    window = Window.around(run.input.frame, run.input.free)
    for tab in tabs or known:
        if tab not in known:
            raise VdoorError(f"pictures: wanted one of the recording's tabs, {', '.join(known)}, found {tab!r}")
        yield Picture(tab, known.index(tab), picture_of(view_of_tab(run, tab), window, size))


def picture_of(view: View, window: Window, size: tuple[int, int] = SIZE) -> bytes:
    """A view as a PNG: heading, maps with their legends, and charts."""
    plans = [Plan(panel.title, fitted(panel.marks)) for panel in view.panels if isinstance(panel, Plan)]
    charts = [panel for panel in view.panels if isinstance(panel, Chart)]
    with style.context("default"):  # whatever the user's own settings of matplotlib are
        legends = [entries(plan.marks) for plan in plans]
        layout = layout_of(view, plans, legends, len(charts), window=window, size=size)
        sheet = Sheet(layout.width, layout.height)
        if view.sentence:
            _write_heading(sheet, view)
        for plan, legend, box in zip(plans, legends, layout.maps, strict=True):
            if plan.title:
                sheet.write(box.left, box.top - LINE_PX / 2, plan.title, size_px=TEXT_PX, fontweight="bold")
            draw_plan(sheet, box, window, plan.marks)
            sheet.legend(legend, box.left, box.top + box.height + BAR_PX, layout.across)
        for chart, box in zip(charts, layout.charts, strict=True):
            draw_chart(sheet, box, chart)
        return sheet.png()


def layout_of(
    view: View,
    plans: Sequence[Plan],
    legends: Sequence[Sequence[Entry]],
    charts: int,
    *,
    window: Window,
    size: tuple[int, int],
) -> Layout:
    """The layout, found twice: legends and heading need fewer lines where they have more room than the least.

    The second is taken only if they have that room in it: a narrower picture needs more lines again.
    """
    if not plans:
        return charts_alone(charts, size[0], head_px(view, size[0]))
    aspect, above = window.width / window.height, LINE_PX if plans[0].title else 0.0

    def arranged(width: float, across: float) -> tuple[Layout, bool]:
        head, below = head_px(view, width), _below_px(legends, across)
        layout = laid_out(Wanted(aspect, len(plans), charts, head, above, below), size)
        fits = head_px(view, layout.width) <= head and _below_px(legends, layout.across) <= below
        return layout, fits

    first, _ = arranged(LEAST_PICTURE, LEAST_WIDTH)
    second, fits = arranged(first.width, first.across)
    return second if fits else first


def _below_px(legends: Sequence[Sequence[Entry]], across: float) -> float:
    return BAR_PX + max(lines_of(legend, across) for legend in legends) * LINE_PX


def _sentence(view: View, width: float) -> list[str]:
    return folded(view.sentence, width - 2 * MARGIN, TEXT_PX)


def head_px(view: View, width: float) -> float:
    """Height of the heading in a picture of a width."""
    if not view.sentence:
        return 0.0
    return TITLE_PX + 12 + len(_sentence(view, width)) * LINE_PX + 8


def _write_heading(sheet: Sheet, view: View) -> None:
    """Write the tab's name and its sentence."""
    sheet.write(MARGIN, MARGIN + TITLE_PX / 2, view.tab, size_px=TITLE_PX, fontweight="bold")
    for number, line in enumerate(_sentence(view, sheet.width)):
        sheet.write(MARGIN, MARGIN + TITLE_PX + 12 + (number + 0.5) * LINE_PX - 4, line, size_px=TEXT_PX)
