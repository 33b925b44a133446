"""`vdoor edit`: a page to edit a result on."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vdoor.errors import say

Folder = Annotated[Path, typer.Argument(metavar="RESULT", help="A folder from `vdoor run --out`.")]


def edit(
    result: Folder,
    *,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port on 127.0.0.1; 0 takes a free one.")] = 0,
) -> None:
    """Serve a page on 127.0.0.1 to name, split and merge rooms, add and remove doors, undo and redo.

    Prints the page's address. Each edit is stored at once, as by the commands of the same names. Ctrl-C ends it.
    """
    from vdoor.editpage.server import Server
    from vdoor.editpage.session import Session
    from vdoor.outputs import Interrupted, interruptible

    session = Session(result)
    with session.opened(), Server(session, port) as server:
        print(server.url, flush=True)
        say("open this address in a browser of this machine; Ctrl-C ends the page")
        try:
            with interruptible():
                server.serve_forever()
        except Interrupted:
            return
