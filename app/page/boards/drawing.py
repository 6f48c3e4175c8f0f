"""Pictures of the two boards: the map of learned PBs and the correlation landscape.

Pure functions from values to a `Board`: a (size, size, 3) uint8 picture, and the `PlotFrame` that
says where data lies on it. What does not change while a puck is dragged (axes, ticks, titles) is
rendered once and kept; a redraw copies it and draws the rest over it. No picture has a puck in it.
"""

from __future__ import annotations

from .landscape_board import draw_landscape, landscape_frame
from .map_board import axis_names, draw_map, map_frame
from .overlay import RecognitionPath
from .palette import Legend, PointStyle, plain_points, style_points
from .plot import Board, PlotFrame

__all__ = [
    "Board",
    "Legend",
    "PlotFrame",
    "PointStyle",
    "RecognitionPath",
    "axis_names",
    "draw_landscape",
    "draw_map",
    "landscape_frame",
    "map_frame",
    "plain_points",
    "style_points",
]
