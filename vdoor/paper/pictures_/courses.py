"""The search of section III: cost generation by generation, and how soon other seeds get there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vdoor.viz.charts import drawing, to_png
from vdoor.viz.rerun import style

PRINTED = 9
"""The generation in which the paper has its optimum."""
NEAR = 0.01
"""Costs that differ by less cannot be told apart in the picture."""


@dataclass(frozen=True, kw_only=True)
class Course:
    """Cost of one generation's choices."""

    generation: int
    best: float
    mean: float
    worst: float


def search_picture(courses: Sequence[Course], *, optimum: float, reached: Sequence[int], searches: int) -> bytes:
    """Cost per generation beside the proven optimum, and the generations in which searches reached that, as a PNG."""
    number = [course.generation for course in courses]
    first = next((course.generation for course in courses if course.best <= optimum * (1 + 1e-9)), None)
    near = next(course.generation for course in courses if course.best <= courses[-1].best * (1 + NEAR))
    with drawing(9.2, 3.3) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(3, 2))
        for name, colour in (("worst", style.WORST), ("mean", style.MEAN), ("best", style.BEST)):
            rgb = tuple(part / 255 for part in colour)
            left.plot(number, [getattr(course, name) for course in courses], color=rgb, label=name, linewidth=1.6)
        left.axhline(optimum, color="black", linewidth=0.8, linestyle=":", label=f"proven optimum, {optimum:.4f}")
        if first is not None:
            left.plot([first], [optimum], "o", color="black", markersize=5)
            sooner = f", within {NEAR:.0%} from {near} on" if near < first else ""
            text = f"reached in generation {first}{sooner}"
            left.annotate(text, (first, optimum), (8, 14), textcoords="offset points")
        left.set(xlabel="generation", ylabel="cost (eq. 7)", xlim=(0, number[-1]), title="cost of the population")
        left.legend()
        if reached:
            right.hist(reached, bins=[at - 0.5 for at in range(max(reached) + 2)], color=_grey(0.45))
        right.axvline(PRINTED, color="black", linewidth=0.8, linestyle=":")
        right.annotate(
            f"printed: {PRINTED}",
            (PRINTED, 0.9),
            (5, 0),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
        )
        right.set(
            xlabel="generation of the optimum",
            ylabel="searches",
            title=f"{len(reached)} of {searches} searches reach it",
        )
        return to_png(figure)


def _grey(light: float) -> tuple[float, float, float]:
    return light, light, light
