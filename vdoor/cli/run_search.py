"""`vdoor run`: what is said of a search that did not run to its end."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vdoor.errors import say

if TYPE_CHECKING:
    from vdoor.emit import Sink
    from vdoor.method.search.memetic import MemeticSearch
    from vdoor.pipeline import AnyPipeline
    from vdoor.record import Record


class SearchNotes:
    """A sink that says on stderr if the search ended because its work is limited."""

    def __init__(self, search: MemeticSearch) -> None:
        self._search = search
        self._best_costs: list[float] = []

    @classmethod
    def sinks(cls, pipeline: AnyPipeline, *, quiet: bool) -> list[Sink]:
        """One such sink if the run's search has a limit, unless quiet."""
        from vdoor.method.search.memetic import MemeticSearch

        search = getattr(pipeline, "search", None)
        return [cls(search)] if isinstance(search, MemeticSearch) and not quiet else []

    def write(self, step: int, record: Record) -> None:
        """Note the generations, and say it with the record that follows them."""
        from vdoor.method.search.generation import Generation

        del step
        if isinstance(record, Generation):
            if not len(record.removed):
                return
            self._best_costs.append(record.best_cost)
        elif self._best_costs:
            if self._search.cut_short(self._best_costs):
                generation = len(self._best_costs) - 1
                say(f"note: too many doors to search to the end; stopped in generation {generation}")
            self._best_costs = []

    def close(self) -> None:
        """Nothing to finish."""
