"""`vdoor fleet-bench`."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from typing import Annotated

import typer

from vdoor.errors import SettingError, no_such, say

PARTS = ("rates", "kills", "report", "model")


def fleet_bench(
    *,
    maps: Annotated[int, typer.Option(min=12, metavar="N", help="Synthetic homes for the rates.")] = 1000,
    kill_maps: Annotated[int, typer.Option(min=12, metavar="N", help="Synthetic homes for each kill.")] = 60,
    kills: Annotated[int, typer.Option(min=1, metavar="N", help="Kills of each kind.")] = 10,
    part: Annotated[
        list[str] | None, typer.Option(metavar="PART", help="rates, kills, report or model; repeatable. Default: all.")
    ] = None,
) -> None:
    """Measure batches: rate and overhead of each engine, kills, the report of 100,000 rows, a model of a large fleet.

    The machine must have two idle cores, or rates are those of what else it does.
    """
    from vdoor.batch.job import Recipe, rows_of
    from vdoor.engines import Limits, processes
    from vdoor.experiments import fleet_benchmark as bench
    from vdoor.experiments import fleet_model as model

    if unknown := [name for name in part or () if name not in PARTS]:
        raise SettingError(f"--part: {no_such('part', unknown[0], PARTS)}")
    wanted = part or PARTS
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores before the start")
    with tempfile.TemporaryDirectory(prefix="vdoor-fleet-") as name:
        folder = Path(name)
        say(f"drawing {maps} homes")
        items = bench.homes(folder / "maps", maps)
        if "rates" in wanted:
            found = []
            for rate in bench.rates(items, folder):
                found.append(rate)
                print(rate.to_text(found[0]), flush=True)
        if "kills" in wanted:
            for killed in bench.kills(items[:kill_maps], folder / "kills", kills):
                print(killed.to_text(), flush=True)
        if {"report", "model"} & {*wanted}:
            begin_s, out = time.perf_counter(), folder / "few"
            rows = list(rows_of(items[:kill_maps], Recipe(batch=out), processes, Limits(workers=2)))
            wall_s = time.perf_counter() - begin_s
        if "report" in wanted:
            seconds, peak_mb = bench.report_of_many(rows)
            print(f"report of {bench.MANY_ROWS:,} rows: {seconds:.1f} s, {peak_mb:.0f} MB")
        if "model" in wanted:
            costs = model.measured_costs(rows, out, folder / "probe")
            print("\n".join(model.lines(costs, len(rows), wall_s)))
