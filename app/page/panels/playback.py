"""The Playback panel: play, frame, speed, loop."""

from __future__ import annotations

import time
from collections.abc import Callable

import viser

from ...state import intents as do
from ...state.document import MAX_SPEED, MIN_SPEED
from ...state.picture import Picture
from .bound import Bound, on_click

FRAME_INTERVAL = 0.1  # seconds between writes of the frame slider while playing


class PlaybackPanel:
    """Playing and seeking; a motion keeps its phase while the latent moves."""

    def __init__(
        self,
        gui: viser.GuiApi,
        send: Callable[[do.Intent], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._clock = clock
        self._play = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, hint="Space")
        on_click(self._play, lambda: send(do.TogglePlaying()))
        self._frame = Bound(
            gui.add_slider("Frame", 0, 1, 1, 0, hint="drag to look at one frame"),
            lambda frame: send(do.Seek(int(frame))),
        )
        self._speed = Bound(
            gui.add_slider("Speed ×", MIN_SPEED, MAX_SPEED, 0.1, 1.0),
            lambda value: send(do.SetSpeed(value)),
        )
        self._loop = Bound(gui.add_checkbox("Loop", True), lambda value: send(do.SetLoop(value)))
        self._playing = True
        self._next_write = 0.0

    def show(self, picture: Picture) -> None:
        playback, motion = picture.document.playback, picture.motion()
        if playback.playing != self._playing:
            self._playing = playback.playing
            self._play.label = "Pause" if playback.playing else "Play"
            self._play.icon = (
                viser.Icon.PLAYER_PAUSE if playback.playing else viser.Icon.PLAYER_PLAY
            )
        self._speed.show(playback.speed)
        self._loop.show(playback.loop)
        if motion is None:
            return
        last = max(len(motion) - 1, 1)
        if self._frame.handle.max != last:
            self._frame.handle.max = last
        # Ten times a second is enough for a slider to look at.
        if not playback.playing or self._clock() >= self._next_write:
            self._next_write = self._clock() + FRAME_INTERVAL
            self._frame.show(picture.frame())
