"""Marks in the viewer: which labels are written, and the shape of arrows."""

from __future__ import annotations

import numpy as np

from vdoor.frame import Frame
from vdoor.viz.marks.kinds import Arrows, Dots, Lines
from vdoor.viz.rerun.marks import _labels, _with_heads

FRAME = Frame(600, 600, 0.05)
"""A pixel for each cell, as the viewer is taken to show it."""


def test_labels_that_would_cover_others_are_left_to_the_pointer_and_dots_come_first() -> None:
    doors = [np.array([[100.0, 90.0], [100.0, 110.0]]), np.array([[300.0, 90.0], [300.0, 110.0]])]
    lines = Lines(name="doors", frame=FRAME, strips=doors, colour=(1, 2, 3), labels=["7", "8"])
    rooms = np.array([[105.0, 104.0], [105.0, 500.0]])
    dots = Dots(name="nodes", frame=FRAME, cell=rooms, colour=(1, 2, 3), labels=["1: 9.7 m²", "2: 3.1 m²"])
    drawn = _labels([lines, dots], 1.0)
    assert drawn.labels is not None
    assert drawn.labels.as_arrow_array().to_pylist() == ["1: 9.7 m²", "2: 3.1 m²", "8"]


def test_arrows_go_from_tail_to_tip_and_their_heads_grow_with_them() -> None:
    arrow = Arrows(name="a", frame=FRAME, cell=np.array([[5.0, 5.0]]), vector=np.array([[0.0, 10.0]]), colour=(1, 2, 3))
    assert _with_heads(arrow).tolist() == [[[5, 5], [5, 15], [7, 11], [5, 15], [3, 11]]]
