"""The page: the paper's evidence for a reader who has the paper beside it, in Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from string import Template

from vdoor.method.search.optimisers import ExhaustiveSearch
from vdoor.paper.claims import Evidence, Size, claims
from vdoor.paper.door_counts import FIRST_SEED, MATCHED_WITHIN_M, METHOD_TITLES, PROPOSED, DoorCount
from vdoor.paper.figures import SubCaseResult
from vdoor.paper.pictures import FIGURE_5, SEARCH, TABLE_1, picture_of
from vdoor.paper.runs import Run
from vdoor.paper.tables import NEAR, all_tables, met

PAGE = Template("""\
# The paper's evidence, done again

For a reader who has "Generating Topological Map from Occupancy Grid-map using Virtual Door Detection" at hand: its
figures, its table and its claims, each done again by the preset `paper`, the method as printed. This page, its
pictures, [`numbers.json`](numbers.json) and the recordings come from one command:

```sh
$command
```

Equal seeds give equal pages. The paper's maps are not public. Apartments of its kind stand in for them, drawn at 20 cm
with their true doors (`vdoor synth`); those that carry a claim about doors by seeds that were settled before any method
ran on them.

$holds

$claims

## Figure 3: from the map to virtual doors

Each part on a tiny map of its own, in the figure's colours.

$cases

$figure_3

## Figure 4: the genetic operators

$figure_4

$rates

## Figure 5: the walk-through

The map has four rooms and three doors, which the figure ends with, and furniture. It was chosen so that its corners
come near the printed number; so it says how the numbers hang together, and nothing about how often they come out so.

![Six stages, as in the figure]($picture_5)

$figure_5

$met

## Section III: the search

All choices of doors are tried here, so the optimum is known. The load that the paper states does not follow from its
own numbers, and in which generation the optimum comes is one seed's luck: the picture on the right has many.

![Cost per generation, and the generation in which each of many searches reaches the optimum]($picture_search)

$search

The same on $graphs other initial maps: the first that have 1 to $most_doors virtual doors, of apartments with 3 to 6
rooms, every other one furnished (its islands taken out). Where there are too many doors to try all choices, no optimum
of eq. 7 is proven; preset `default` searches another cost, with a certificate.

$hits

## Table I: three environments

The paper's three homes are not public; these have as many real doors, by the first seeds that give so many. A virtual
door matches a real one when their middles are at most $matched m apart. The existing algorithm [8] could not be had
either: Voronoi doors (preset `voronoi-doors`) and eroded space (`eroded-space`) stand in for it, built after what is
known of it. Homes have furniture, so the second table is the one to compare with the printed numbers.

$table_1_empty

$table_1_furnished

![Doors that each method finds in the furnished environments, as in figure 6]($picture_1)

$together

## Table I over $apartments apartments

Three environments carry little. These are $apartments apartments of 4 to 6 rooms, by the seeds from $first_seed up,
each empty and with furniture.

$apartments_table

## Room by room against the whole space

$coverage

## What cannot be taken by the letter

$errata

## What is not printed

`vdoor config --preset paper` prints every setting, `vdoor sweep` shows what one of them does.

$unprinted

## Recordings

Each is a whole run with all its stages. `vdoor verify` runs them again and compares; `vdoor show FILE` draws one in
the terminal, `vdoor step FILE` walks through it, `vdoor replay FILE --save out.rrd` makes a Rerun recording of it.

$recordings
""")


def page(evidence: Evidence, runs: Sequence[Run]) -> str:
    """The whole page; equal evidence gives equal pages."""
    tables = {name: table.to_markdown() for name, table in all_tables(evidence).items()}
    return PAGE.substitute(
        {name: text for name, text in tables.items() if name != "apartments"},
        command=command_of(evidence.size),
        holds=_verdict(evidence),
        cases="\n\n".join(map(_case, evidence.figure_3)),
        picture_5=FIGURE_5,
        picture_search=SEARCH,
        picture_1=TABLE_1,
        graphs=len(evidence.search.graphs),
        most_doors=ExhaustiveSearch().most_edges,
        matched=f"{MATCHED_WITHIN_M:g}",
        met=_met(evidence),
        together=_together(evidence),
        apartments=evidence.size.apartments,
        apartments_table=tables["apartments"],
        first_seed=FIRST_SEED,
        recordings="\n".join(["| recording | what |", "| --- | --- |", *map(_recording, runs)]),
    )


def command_of(size: Size) -> str:
    """What to type for a page of that size."""
    default = Size()
    changed = [
        f"--{name} {getattr(size, name)}"
        for name in ("apartments", "graphs", "seed")
        if getattr(size, name) != getattr(default, name)
    ]
    return " ".join(["vdoor paper --out recordings/paper --force", *changed])


def _verdict(evidence: Evidence) -> str:
    made = claims(evidence)
    failed = sum(not claim.holds for claim in made)
    return f"{failed} of {len(made)} claims do not hold:" if failed else f"All {len(made)} claims hold:"


def _met(evidence: Evidence) -> str:
    """Which printed numbers are met, which nearly, which not."""
    lines = evidence.figure_5.lines
    named = {
        verdict: [line.what for line in lines if met(line.printed, line.ours) == verdict]
        for verdict in ("yes", "nearly", "no")
    }
    said = {"yes": "Met", "nearly": f"Nearly met, within {NEAR:.0%}", "no": "Not met"}
    return "\n\n".join(f"{said[verdict]}: {', '.join(names)}." for verdict, names in named.items() if names)


def _together(evidence: Evidence) -> str:
    """The furnished table in a sentence."""
    _, rows = evidence.table_1
    printed = {name: sum((row.printed[name] for row in rows), DoorCount()) for name in rows[0].printed}
    found = {name: sum((row.found[name] for row in rows), DoorCount()) for name in rows[0].found}
    existing, proposed = (printed[name].accuracy.value for name in ("existing", PROPOSED))
    here = ", ".join(f"{count.accuracy.value:.2f} for {METHOD_TITLES[name]}" for name, count in found.items())
    return (
        f"Furnished, the three together, matched / virtual is {here}; in print {existing:.2f} for the existing "
        f"algorithm and {proposed:.2f} for the proposed one."
    )


def _case(shown: SubCaseResult) -> str:
    case = shown.case
    return f"**{case.part}, {case.name}:** {case.claim}.\n\n![{case.name}]({picture_of(case)})"


def _recording(run: Run) -> str:
    return f"| [`{run.name}.mcap`]({run.name}.mcap) | {run.what} |"
