"""`vdoor paper`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vdoor.cli.options import Force, Json, Seed
from vdoor.errors import SettingError, say


def paper(
    *,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Also README.md with pictures, and a recording of each run.")
    ] = None,
    rrd: Annotated[bool, typer.Option("--rrd", help="With --out: also Rerun recordings, to look at.")] = False,
    apartments: Annotated[
        int, typer.Option(min=1, max=100_000, metavar="N", help="Apartments, empty and furnished, for Table I.")
    ] = 200,
    graphs: Annotated[
        int, typer.Option(min=1, max=100_000, metavar="N", help="Maps whose searches are held against the optimum.")
    ] = 60,
    seed: Seed = 0,
    force: Force = False,
    as_json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Nothing on stderr but errors.")] = False,
) -> None:
    """Do the paper's figures, table and claims again, ours beside the printed: 0 if all claims hold, 1 if not."""
    if rrd and out is None:
        raise SettingError("--rrd: wanted a folder for the recordings as well, say --out paper")
    from vdoor.files import refuse_existing, refuse_folder
    from vdoor.paper import document, folder, tables
    from vdoor.paper.claims import claims
    from vdoor.paper.everything import Size, gathered
    from vdoor.viz.charts import require_matplotlib

    if out is not None:
        require_matplotlib()
        refuse_folder(out)
        refuse_existing(folder.files(out, rrd=rrd), force=force)
    told = _nothing if quiet else say
    evidence = gathered(Size(apartments=apartments, graphs=graphs, seed=seed), told)
    if out is not None:
        folder.write(evidence, out, rrd=rrd, told=told)
    print(document.to_json(evidence) if as_json else tables.to_text(evidence))
    raise typer.Exit(int(not all(claim.holds for claim in claims(evidence))))


def _nothing(_: str) -> None:
    """Say nothing."""
