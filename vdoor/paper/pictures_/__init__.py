"""The paper's figures drawn again, in the paper's colours, as PNG."""

from vdoor.paper.pictures_.compared import Compared, comparison
from vdoor.paper.pictures_.courses import Course, search_picture
from vdoor.paper.pictures_.stages import sub_case, walk_through

__all__ = ["Compared", "Course", "comparison", "search_picture", "sub_case", "walk_through"]
