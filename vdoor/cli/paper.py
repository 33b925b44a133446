"""`vdoor paper`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vdoor.cli.options import Force, Jobs, Json, Seed
from vdoor.errors import SettingError, say


def paper(
    *,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Also write README.md, pictures, and a recording of each run."),
    ] = None,
    rrd: Annotated[bool, typer.Option("--rrd", help="With --out: also Rerun recordings.")] = False,
    apartments: Annotated[
        int,
        typer.Option(min=1, max=100_000, metavar="N", help="Number of apartments for Table I, empty and furnished."),
    ] = 200,
    graphs: Annotated[
        int,
        typer.Option(min=1, max=100_000, metavar="N", help="Number of maps for comparing the search with the optimum."),
    ] = 60,
    seed: Seed = 0,
    jobs: Jobs = 1,
    force: Force = False,
    as_json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only errors on stderr.")] = False,
) -> None:
    """Reproduce the paper's figures, table and claims beside the printed ones: 0 if all claims hold, 1 if not."""
    if rrd and out is None:
        raise SettingError("--rrd: wanted --out with a folder for the recordings, found none")
    from vdoor.engines import over
    from vdoor.files import refuse_existing, refuse_folder
    from vdoor.paper import report, tables
    from vdoor.paper.claims import Size, claims, gather_evidence
    from vdoor.paper.walkthrough import no_progress

    if out is not None:
        refuse_folder(out)
        refuse_existing(report.files(out, rrd=rrd), force=force)
    progress = no_progress if quiet else say
    with over(jobs) as each:
        evidence = gather_evidence(Size(apartments=apartments, graphs=graphs, seed=seed), progress, each)
    if out is not None:
        report.write(evidence, out, rrd=rrd, progress=progress)
    print(report.to_json(evidence) if as_json else tables.to_text(evidence))
    raise typer.Exit(int(not all(claim.holds for claim in claims(evidence))))
