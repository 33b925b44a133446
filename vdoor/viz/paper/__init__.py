"""The paper's figures drawn again, in the paper's colours, as PNG."""

from vdoor.viz.paper.compared import Compared, comparison
from vdoor.viz.paper.courses import Course, search_picture
from vdoor.viz.paper.stages import sub_case, walk_through

__all__ = ["Compared", "Course", "comparison", "search_picture", "sub_case", "walk_through"]
