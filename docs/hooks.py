"""What the site has beside the pages in docs/: generated parts, pictures, and files of the repository it links to.

In a page, these comments are filled in::

    <!-- readme -->              the README up to where it says what to read
    <!-- settings -->            and commands, records, api MODULE: see `generated.py`
    <!-- picture NAME: TITLE --> a picture of `pictures.py`
    <!-- output -->              what the command before printed, or lines 1-9 of it: see `blocks.py`

A link that leaves docs/ brings its file into the site, so that pages can be read in the repository as well.
"""

# ruff: noqa: INP001  # part of the site, not of a package
from __future__ import annotations

import functools
import posixpath
import re
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import blocks
import generated
import pictures
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.pages import Page

HOME = Path(__file__).parent.parent
DOCS = "docs/"
LINK = re.compile(r"(\]\()([^)#\s:]+)((?:#[^)\s]*)?\))")
COMMENT = re.compile(r"<!-- (readme|settings|commands|records|api|picture)(?: (.*?))? -->")
OUTSIDE = re.compile(r'<(?:script|link|img|iframe|source)\b[^>]*(?:src|href)="?(?:https?:)?//[^>]*>')
READ_ON = "\n## Read on"
GENERATED: dict[str, Callable[[], str]] = {
    "settings": generated.settings,
    "commands": generated.commands,
    "records": generated.records,
}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pictures, and the files of the repository that pages link to."""
    for name in pictures.PICTURES:
        files.append(File.generated(config, f"pictures/{name}.png", content=pictures.drawn(name)))
    pages = [DOCS + file.src_uri for file in files.documentation_pages()]
    for path in _linked([*pages, "README.md"]):
        files.append(File.generated(config, path, abs_src_path=str(HOME / path)))
    return files


def _linked(pages: list[str]) -> list[str]:
    """Files outside docs/ that pages link to, or that pages among these do."""
    found: list[str] = []
    queue = [*pages]
    for page in queue:
        for target in _targets(page):
            if target not in (*found, "README.md") and not target.startswith(DOCS):
                found.append(target)
                queue += [target] if target.endswith(".md") else []
    return found


def _targets(page: str) -> Iterator[str]:
    """Files of the repository that a page links to."""
    for link in LINK.finditer((HOME / page).read_text(encoding="utf-8")):
        target = _target(page, link[2])
        if (HOME / target).is_file():
            yield target


def _target(page: str, link: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(page), link))


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Fill in what is generated, and turn links to where things are in the site."""
    source = page.file.src_uri
    path = DOCS + source if (HOME / DOCS / source).is_file() else source
    markdown = _with_outputs(markdown)
    markdown = COMMENT.sub(lambda found: _generated(found[1], found[2] or ""), markdown)
    return LINK.sub(lambda link: f"{link[1]}{_moved(path, source, link[2])}{link[3]}", markdown)


def on_post_page(output: str, page: Page, **_: Any) -> str:
    """The page as it is; an error where it loads anything from elsewhere: the site is to be read without a network."""
    for tag in OUTSIDE.finditer(output):
        raise PluginError(f"{page.file.src_uri}: wanted nothing from elsewhere, found {tag[0]}")
    return output


def _generated(kind: str, words: str) -> str:
    if kind == "readme":
        return _readme()
    if kind == "picture":
        name, _, title = words.partition(": ")
        return f"![{title}](pictures/{name}.png)\n\n*{title}.*\n{{ .caption }}"
    return generated.api(words) if kind == "api" else GENERATED[kind]()


def _readme() -> str:
    """The README between its title and what to read next, its links as seen from docs/."""
    text = (HOME / "README.md").read_text(encoding="utf-8").partition(READ_ON)[0].partition("\n")[2]
    return LINK.sub(lambda link: f"{link[1]}{posixpath.relpath(link[2], DOCS)}{link[3]}", text)


def _moved(path: str, source: str, link: str) -> str:
    """A link of a page of the repository as its page in the site has it."""
    target = _target(path, link)
    if not (HOME / target).is_file():
        return link
    return posixpath.relpath(
        "README.md" if target == "README.md" else target.removeprefix(DOCS), posixpath.dirname(source) or "."
    )


def _with_outputs(markdown: str) -> str:
    """The page with what its commands print, where it wants that."""
    wanted = blocks.OUTPUT.findall(markdown)
    return _run(markdown) if wanted else markdown


@functools.cache
def _run(markdown: str) -> str:
    parts, done, printed = [], 0, ""
    steps = blocks.steps(markdown)
    last = max(number for number, step in enumerate(steps) if step.kind == "output")
    with tempfile.TemporaryDirectory() as folder:
        blocks.ready(Path(folder))
        for step in steps[: last + 1]:
            if step.kind != "output":
                printed = blocks.run(step, Path(folder)) or printed
                continue
            parts += [markdown[done : step.start], _block(printed, step.text)]
            done = step.end
    return "".join([*parts, markdown[done:]])


def _block(printed: str, lines: str) -> str:
    """What was printed as a block, or some lines of it."""
    shown = [line.rstrip() for line in printed.strip("\n").splitlines()]
    if lines:
        first, last = map(int, lines.split("-"))
        shown = shown[first - 1 : last]
    return "\n".join(["```text", *shown, "```"])
