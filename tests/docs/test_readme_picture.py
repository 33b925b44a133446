"""The README's picture is what the command that recordings/README.md names makes of the example map."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from commands import call
from PIL import Image
from project import HOME

COMMANDS = (
    "vdoor run recordings/flat.yaml --mcap out.mcap",
    "vdoor shot out.mcap -o pictures --stage Overview",
)


def test_the_picture_is_what_the_command_makes(tmp_path: Path) -> None:
    said = " ".join((HOME / "recordings" / "README.md").read_text().split())
    assert f"`{' && '.join(COMMANDS)}`" in said
    for line in COMMANDS:
        words = [word.replace("out.mcap", str(tmp_path / "out.mcap")) for word in line.split()[1:]]
        call(
            *[
                str(tmp_path / word) if word == "pictures" else word.replace("recordings/", f"{HOME}/recordings/")
                for word in words
            ]
        )
    made, shown = (
        np.asarray(Image.open(path).convert("RGB"), np.int16)
        for path in (tmp_path / "pictures" / "0_overview.png", HOME / "recordings" / "overview.png")
    )
    assert made.shape == shown.shape
    changed = (np.abs(made - shown) > 40).any(axis=2)  # other versions of a font library change the edges of letters
    assert changed.mean() < 0.01
