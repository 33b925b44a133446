"""Two baselines after the paper's reference [8], each producing the same kind of result as the method.

Reference [8] divides a map by virtual doors found with a generalised Voronoi diagram and an eroded configuration space.
Its details are not known here, so each idea is a separate baseline.
"""

from vdoor.baselines.critical_lines import CriticalLines
from vdoor.baselines.eroded_space import ErodedSpace, ErodedSpacePipeline, GrownRooms
from vdoor.baselines.skeleton import Skeleton
from vdoor.baselines.voronoi_doors import VoronoiDoorsPipeline

__all__ = ["CriticalLines", "ErodedSpace", "ErodedSpacePipeline", "GrownRooms", "Skeleton", "VoronoiDoorsPipeline"]
