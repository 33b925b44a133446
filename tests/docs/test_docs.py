"""The pages say all there is: generated ones from the code, the others held against its lists."""

from __future__ import annotations

import dataclasses
import inspect
import io
import re
import sys
from typing import Any

import pytest
import typer
import yaml
from PIL import Image
from project import HOME, PAGES

import vdoor
import vdoor.cli
import vdoor.export
from vdoor.config import all_settings_of
from vdoor.editing.edits import FORMS
from vdoor.formats import READERS
from vdoor.pipeline import METHODS, PRESETS, RECORDS
from vdoor.record import specs

DOCS = HOME / "docs"
sys.path.insert(0, str(DOCS))
import generated  # noqa: E402
import pictures  # noqa: E402

WORDS = "cell sample candidate corner conflict region atom node edge room passage"


def page(name: str) -> str:
    return (DOCS / name).read_text()


def navigation() -> list[str]:
    class Loader(yaml.SafeLoader):
        """Reads the site's settings without making what their tags name."""

    Loader.add_multi_constructor("tag:yaml.org,2002:python/", lambda *_: None)
    table = yaml.load((HOME / "mkdocs.yml").read_text(), Loader)  # noqa: S506  # a safe one
    return list(files_in(table["nav"]))


def files_in(nav: Any) -> Any:
    for item in nav:
        for below in item.values():
            yield from [below] if isinstance(below, str) else files_in(below)


def test_every_page_is_in_the_navigation_and_the_index() -> None:
    names = {one.name for one in PAGES if one.parent == DOCS}
    assert names <= set(navigation())
    assert all(f"]({name})" in page("README.md") for name in names - {"README.md"})
    assert all(f"](docs/{name})" in (HOME / "README.md").read_text() for name in names - {"records.md"})


def test_settings_are_all_there() -> None:
    text = generated.settings()
    kinds = {type(getattr(preset, field.name)) for preset in PRESETS.values() for field in dataclasses.fields(preset)}
    kinds |= {kind for ways in METHODS.values() for kind in ways.values()}
    for kind in kinds:
        assert (inspect.getdoc(kind) or "").splitlines()[0] in text
        assert all(f"\n| `{field.name}` |" in text for field in dataclasses.fields(kind))
    for preset in PRESETS.values():
        assert all(f"## `{stage}`\n" in text for stage in all_settings_of(preset, METHODS))
    assert "| `max_island_m` | `1.0` | `0.0` | 0 to 100 | Free-standing obstacles" in text


def test_commands_are_all_there() -> None:
    text = generated.commands()
    group: Any = typer.main.get_command(vdoor.cli.app)
    sections = dict(zip(group.commands, text.split("## `vdoor ")[1:], strict=True))
    for name, command in group.commands.items():
        assert sections[name].startswith(f"{name}`\n\n{command.help.splitlines()[0]}")
        options = [option for one in command.params if one.param_type_name == "option" for option in one.opts]
        assert all(re.search(rf"[` ]{option}[` ,]", sections[name]) for option in options)


def test_records_are_all_there() -> None:
    text = generated.records()
    for record in RECORDS:
        section = text.split(f"## {record.__name__}\n")[1].split("\n## ")[0]
        assert f"`/vdoor/{record.topic}/" in section
        assert all(f"| `{field}` |" in section for field in specs(record))


@pytest.mark.parametrize("module", [vdoor, vdoor.export])
def test_public_names_are_all_there(module: Any) -> None:
    listed = re.findall(rf"::: {module.__name__}\.(\w+)", generated.api(module.__name__))
    assert sorted(listed) == sorted(module.__all__)
    assert f"<!-- api {module.__name__} -->" in page("api.md")


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("formats.md", [suffix for reader in READERS for suffix in reader.suffixes]),
        ("formats.md", [writer.name for writer in vdoor.export.WRITERS]),
        ("research.md", PRESETS),
        ("rooms.md", FORMS),
        ("debugging.md", specs(next(one for one in RECORDS if one.topic == "doors"))["verdict"][0].words[1:]),
        ("debugging.md", specs(next(one for one in RECORDS if one.topic == "door_scores"))["judgement"][0].words[1:]),
        ("method.md", [f"## {word}" for word in ("Corners", "Virtual doors", "Search", "Final map")]),
        ("method.md", [field.name for field in dataclasses.fields(PRESETS["default"])]),
    ],
)
def test_page_names_all_there_is(name: str, wanted: Any) -> None:
    assert [word for word in wanted if word not in page(name)] == []


def test_glossary_has_the_words() -> None:
    terms = " ".join(re.findall(r"\*\*([^*]+)\*\*", page("glossary.md"))).lower()
    assert [word for word in [*WORDS.split(), "virtual door"] if word not in terms] == []


def test_settings_that_pages_name_exist() -> None:
    known = {
        f"{stage.name}.{name}"
        for preset in PRESETS.values()
        for stage in dataclasses.fields(preset)
        for kind in [type(getattr(preset, stage.name)), *METHODS.get(stage.name, {}).values()]
        for name in ["method", *(field.name for field in dataclasses.fields(kind))]
    }
    stages = "|".join({name.partition(".")[0] for name in known})
    for one in PAGES:
        for named in re.findall(rf"(?:`|--set |sweep )((?:{stages})\.[a-z_0-9]+)(?=[`=])", one.read_text()):
            assert named in known, (one.name, named)


def test_pictures_are_those_that_pages_show() -> None:
    shown = [name for one in PAGES for name in re.findall(r"<!-- picture (\w+): .+ -->", one.read_text())]
    assert sorted(shown) == sorted(pictures.PICTURES)


@pytest.mark.parametrize("name", pictures.PICTURES)
def test_picture_is_drawn_and_always_the_same(name: str) -> None:
    png = pictures.drawn(name)
    assert len(Image.open(io.BytesIO(png)).convert("RGB").getcolors(10**6) or ()) > 2
    assert pictures.drawn(name) == png


def test_ci_builds_the_site_as_contributing_says() -> None:
    (said,) = [line for line in (HOME / "CONTRIBUTING.md").read_text().splitlines() if "mkdocs build --strict" in line]
    done = [line.strip() for line in (HOME / ".ci" / "run").read_text().splitlines()]
    assert all(part in done for part in said.split(" && "))
