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
        layout = _layout(view, plans, legends, len(charts), window=window, size=size)
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


def _layout(
    view: View,
    plans: Sequence[Plan],
    legends: Sequence[Sequence[Entry]],
    charts: int,
    *,
    window: Window,
    size: tuple[int, int],
) -> Layout:
    """The layout, found twice: legends and heading need fewer lines where they have more room than the least."""
    if not plans:
        return charts_alone(charts, size[0], _head_px(view, size[0]))
    across, width = LEAST_WIDTH, LEAST_PICTURE
    for _ in range(2):
        lines = max(lines_of(legend, across) for legend in legends)
        wanted = Wanted(
            aspect=window.width / window.height,
            maps=len(plans),
            charts=charts,
            head=_head_px(view, width),
            above=LINE_PX if plans[0].title else 0.0,
            below=BAR_PX + lines * LINE_PX,
        )
        layout = laid_out(wanted, size)
        across, width = layout.across, layout.width
    return layout


def _sentence(view: View, width: float) -> list[str]:
    return folded(view.sentence, width - 2 * MARGIN, TEXT_PX)


def _head_px(view: View, width: float) -> float:
    if not view.sentence:
        return 0.0
    return TITLE_PX + 12 + len(_sentence(view, width)) * LINE_PX + 8


def _write_heading(sheet: Sheet, view: View) -> None:
    """Write the tab's name and its sentence."""
    sheet.write(MARGIN, MARGIN + TITLE_PX / 2, view.tab, size_px=TITLE_PX, fontweight="bold")
    for number, line in enumerate(_sentence(view, sheet.width)):
        sheet.write(MARGIN, MARGIN + TITLE_PX + 12 + (number + 0.5) * LINE_PX - 4, line, size_px=TEXT_PX)
