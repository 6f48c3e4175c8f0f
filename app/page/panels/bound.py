"""A widget whose value belongs to the state: it shows what it is told, and reports a hand on it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import viser

HELD_SECONDS = 0.4  # a person is taken to hold a widget this long after its last event


class Bound:
    """One value widget (slider, checkbox, dropdown, text).

    While a person holds it, nothing is written to it: by the time a value has gone through the
    state, the person's hand is elsewhere, and the widget would jump back.

    Args:
        changed: gets the value that a person set; on viser's event loop, so it only hands on.
    """

    def __init__(
        self,
        handle: Any,  # viser's value handles share no public base class
        changed: Callable[[Any], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.handle = handle
        self._changed = changed
        self._clock = clock
        self._held_until = 0.0
        # What the state and the person last said, not what the widget says now: viser stores a
        # person's value a moment before it is heard of here, and must not find it overwritten.
        self._agreed = handle.value
        handle.on_update(self._on_update)

    async def _on_update(self, event: viser.GuiEvent[Any]) -> None:
        if event.client is None:  # our own assignment, not a person
            return
        self._held_until = self._clock() + HELD_SECONDS
        self._agreed = event.target.value
        self._changed(self._agreed)

    def show(self, value: Any) -> None:
        """Show a value of the state, unless it stands there or a person holds the widget."""
        if value != self._agreed and self._clock() >= self._held_until:
            self._agreed = self.handle.value = value

    def offer(self, options: Sequence[str]) -> None:
        """Let a dropdown offer these; it goes to the first where it stands at none of them."""
        if self.handle.options != tuple(options):
            self.handle.options = tuple(options)
            self._agreed = self.handle.value


def on_click(handle: Any, clicked: Callable[[], None]) -> None:
    """Call `clicked` when a person presses a button (viser's event loop: only hand on)."""

    async def pressed(event: viser.GuiEvent[Any]) -> None:
        if event.client is not None:
            clicked()

    handle.on_click(pressed)


def assign(handle: object, **values: object) -> None:
    """Write what differs."""
    for name, value in values.items():
        if getattr(handle, name) != value:
            setattr(handle, name, value)
