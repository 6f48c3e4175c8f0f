"""The Joints panel: target dashed, generated solid, time cursor, the observed part shaded."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import viser
from numpy.typing import NDArray

from .. import intents as do
from ..state import AppState, ModelFacts
from .bound import Bound
from .playback import frame_of

PLOTS = 3
MOST_MOVING = "those that move most"
CURSOR_INTERVAL = 0.15  # seconds between moves of the cursor while playing
COLORS = ("#1f77b4", "#2a9d5c", "#8e5bb5")

Curves = tuple[NDArray[np.float64], ...]


class JointsPanel:
    """Three small plots; of the joints that move most, or of one joint and its neighbours."""

    def __init__(
        self,
        gui: viser.GuiApi,
        facts: tuple[ModelFacts, ...],
        send: Callable[[do.Intent], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._gui, self._facts, self._clock = gui, facts, clock
        self._joint = Bound(
            gui.add_dropdown("Joints", [MOST_MOVING, *facts[0].joints]),
            lambda name: send(do.SetJoint("" if name == MOST_MOVING else name)),
        )
        gui.add_markdown("Generated solid, target dashed; shaded: observed. Radians over seconds.")
        self._plots: list[viser.GuiUplotHandle] = []
        self._drawn: tuple[object, ...] = ()
        self._next_cursor = 0.0

    def show(self, state: AppState) -> None:
        motion, facts = state.current.motion, self._facts[state.active]
        if self._joint.handle.options != (MOST_MOVING, *facts.joints):
            self._joint.handle.options = (MOST_MOVING, *facts.joints)
        self._joint.show(state.joint or MOST_MOVING)
        if motion is None:
            return
        shaded = observed_frames(state, len(motion.reference))
        what = (motion, state.joint, shaded, state.active)
        frame = frame_of(state)
        if what == self._drawn[:4] and (
            frame == self._drawn[4]
            or (state.playback.playing and self._clock() < self._next_cursor)
        ):
            return
        self._next_cursor = self._clock() + CURSOR_INTERVAL
        self._drawn = (*what, frame)
        columns = shown_joints(facts.joints, state.joint, motion.reference)
        for slot in range(min(PLOTS, len(columns))):
            column = columns[slot]
            data, low, high = curves(
                motion.positions[:, column], motion.reference[:, column], frame, facts.fps, shaded
            )
            self._draw(slot, facts.joints[column], data, low, high)

    def _draw(self, slot: int, joint: str, data: Curves, low: float, high: float) -> None:
        scales: dict[str, viser.uplot.Scale] = {"x": {"time": False}, "y": {"range": (low, high)}}
        if slot < len(self._plots):
            plot = self._plots[slot]
            plot.data = data
            if plot.title != joint:
                plot.title = joint
            if plot.scales != scales:
                plot.scales = scales
            return
        self._plots.append(
            self._gui.add_uplot(
                data,
                (
                    {"label": "s"},
                    {"label": "generated", "stroke": COLORS[slot], "width": 2},
                    {"label": "target", "stroke": "#444444", "width": 1.5, "dash": (5, 4)},
                    {"label": "now", "stroke": "#d62728", "width": 1.5},
                    {
                        "label": "observed",
                        "stroke": "rgba(0,0,0,0)",
                        "fill": "rgba(31,119,180,0.12)",
                    },
                ),
                title=joint,
                scales=scales,
                legend={"show": False},
                cursor={"show": False},
                height=150,
            )
        )


def observed_frames(state: AppState, frames: int) -> int:
    """How many frames of the target are observed; 0 where nothing is recognised."""
    recognition = state.recognition
    if recognition.target is None or not state.use_target:
        return 0
    return int(recognition.observed * frames)


def shown_joints(joints: tuple[str, ...], chosen: str, reference: NDArray[np.float32]) -> list[int]:
    """Columns to plot: the chosen joint and the ones after it, or those of the widest range."""
    if chosen in joints:
        first = min(joints.index(chosen), max(len(joints) - PLOTS, 0))
        shown = list(range(first, min(first + PLOTS, len(joints))))
        return [joints.index(chosen), *(c for c in shown if c != joints.index(chosen))]
    widest = np.argsort(-np.ptp(reference, axis=0), kind="stable")[:PLOTS]
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
        seconds, generated, target, cursor, shade, each (S,), NaN where a curve has nothing; low, high.
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
    shade = np.where(seconds < observed / fps, high, np.nan)
    return (seconds, spread(generated), spread(target), cursor, shade), low, high
