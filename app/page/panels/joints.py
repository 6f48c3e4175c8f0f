"""The Joints panel: target dashed, generated solid, time cursor, the observed part shaded."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import viser
from numpy.typing import NDArray

from ...state import intents as do
from ...state.picture import Picture
from ...state.wanted import given_target
from .bound import Bound

MOST_MOVING = "those that move most"
CURSOR_INTERVAL = 0.25  # seconds between moves of the cursor while playing
COLORS = ("#1f77b4", "#2a9d5c", "#8e5bb5")

Curves = tuple[NDArray[np.float64], ...]


class JointsPanel:
    """Three small plots; of the joints that move most, or of one joint and its neighbours."""

    def __init__(
        self,
        gui: viser.GuiApi,
        joints: tuple[str, ...],
        send: Callable[[do.Intent], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._clock = clock
        self._joint = Bound(
            gui.add_dropdown("Joints", [MOST_MOVING, *joints]),
            lambda name: send(do.SetJoint("" if name == MOST_MOVING else name)),
        )
        gui.add_markdown("Generated solid, target dashed; shaded: observed. Radians over seconds.")
        # Made here, all of them: made later they would land outside of their tab.
        self._plots = [self._add_plot(gui, color) for color in COLORS[: len(joints)]]
        self._drawn: tuple[object, ...] = ()
        self._curves: tuple[object, object] = (None, None)  # the motion and the target in them
        self._next_cursor = 0.0

    def show(self, picture: Picture) -> None:
        facts, joint = picture.model, picture.document.joint
        self._joint.offer((MOST_MOVING, *facts.joints))
        self._joint.show(joint if joint in facts.joints else MOST_MOVING)
        motion, reference = picture.motion(), picture.reference()
        if motion is None or reference is None:
            return
        shaded = observed_frames(picture, len(reference))
        # An uploaded motion makes its array anew each time.
        given = given_target(picture.facts, picture.document, picture.active)
        compared = (motion, reference if given is None else given)
        same = all(one is drawn for one, drawn in zip(compared, self._curves, strict=True))
        what = (joint, shaded, picture.active)
        frame = picture.frame()
        if (
            same
            and what == self._drawn[:-1]
            and (
                frame == self._drawn[-1]
                or (picture.document.playback.playing and self._clock() < self._next_cursor)
            )
        ):
            return
        self._next_cursor = self._clock() + CURSOR_INTERVAL
        self._drawn, self._curves = (*what, frame), compared
        columns = shown_joints(facts.joints, joint, reference)
        for plot, column in zip(self._plots, columns, strict=False):
            data, low, high = curves(
                motion[:, column], reference[:, column], frame, facts.fps, shaded
            )
            self._draw(plot, facts.joints[column], data, low, high)

    @staticmethod
    def _add_plot(gui: viser.GuiApi, color: str) -> viser.GuiUplotHandle:
        unseen = "rgba(0,0,0,0)"
        return gui.add_uplot(
            (np.array([0.0, 1.0]),) * 6,
            (
                {"label": "s"},
                {"label": "generated", "stroke": color, "width": 2},
                {"label": "target", "stroke": "#444444", "width": 1.5, "dash": (5, 4)},
                {"label": "now", "stroke": "#d62728", "width": 1.5},
                {"label": "observed", "stroke": unseen},
                {"label": "observed", "stroke": unseen},
            ),
            bands=({"series": (4, 5), "fill": "rgba(31,119,180,0.12)"},),
            scales={"x": {"time": False}},
            legend={"show": False},
            cursor={"show": False},
            height=150,
            visible=False,
        )

    @staticmethod
    def _draw(
        plot: viser.GuiUplotHandle, joint: str, data: Curves, low: float, high: float
    ) -> None:
        scales: dict[str, viser.uplot.Scale] = {
            "x": {"time": False, "range": (0.0, float(data[0][-1]))},
            "y": {"range": (low, high)},
        }
        plot.data = data
        if plot.title != joint:
            plot.title = joint
        if plot.scales != scales:
            plot.scales = scales
        if not plot.visible:
            plot.visible = True


def observed_frames(picture: Picture, frames: int) -> int:
    """How many frames of the target are observed; 0 where nothing is recognised."""
    if given_target(picture.facts, picture.document, picture.active) is None:
        return 0
    return int(picture.document.recognition.observed * frames)


def shown_joints(joints: tuple[str, ...], chosen: str, reference: NDArray[np.float32]) -> list[int]:
    """Columns to plot: the chosen joint and the ones after it, or those of the widest range."""
    if chosen in joints:
        first = min(joints.index(chosen), max(len(joints) - len(COLORS), 0))
        shown = list(range(first, min(first + len(COLORS), len(joints))))
        return [joints.index(chosen), *(c for c in shown if c != joints.index(chosen))]
    widest = np.argsort(-np.ptp(reference, axis=0), kind="stable")[: len(COLORS)]
    return [int(column) for column in widest]


def curves(
    generated: NDArray[np.float32],
    target: NDArray[np.float32],
    frame: int,
    fps: float,
    observed: int,
) -> tuple[Curves, float, float]:
    """The plot's series over one time axis, and its vertical range.

    Args:
        generated, target: (T,) and (T',), radians.
        frame: where the cursor stands.
        observed: frames to shade.

    Returns:
        seconds, generated, target, cursor, the shade's top and bottom, each (S,), NaN where a
        curve has nothing; low, high.
    """
    frames = max(len(generated), len(target))
    values = np.concatenate([generated, target])
    low, high = float(values.min()), float(values.max())
    margin = max(0.1 * (high - low), 0.05)
    low, high = low - margin, high + margin
    # The cursor is an upright stroke: two samples at (nearly) the same time.
    times = np.arange(frames) / fps
    now = frame / fps
    seconds = np.insert(times, frame + 1, now + 1e-6)

    def spread(curve: NDArray[np.float32]) -> NDArray[np.float64]:
        full = np.full(frames, np.nan)
        full[: len(curve)] = curve
        return np.insert(full, frame + 1, full[frame])

    cursor = np.full(len(seconds), np.nan)
    cursor[frame], cursor[frame + 1] = low, high
    # A band that ends would end in a slope; one that goes on without height is not seen.
    top = np.where(seconds < observed / fps, high, low)
    bottom = np.full(len(seconds), low)
    return (seconds, spread(generated), spread(target), cursor, top, bottom), low, high
