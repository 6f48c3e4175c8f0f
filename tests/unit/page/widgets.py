"""A person's hand on viser's widgets."""

from __future__ import annotations

import inspect
from types import SimpleNamespace
from typing import Any

import viser

from ..app_states import hand_on


def hand(handle: Any, value: object = True) -> None:
    """A person sets a widget: viser stores the value, then tells of it with the person's client."""
    handle._impl.value = value
    event = SimpleNamespace(client=object(), client_id=0, target=handle)
    for callback in handle._impl.update_cb:
        result = callback(event)
        if inspect.iscoroutine(result):
            hand_on(result)


def labelled(gui: viser.GuiApi, label: str) -> Any:
    """The widget with this label."""
    found = [
        handle
        for handle in gui._gui_input_handle_from_uuid.values()
        if getattr(handle, "label", None) == label
    ]
    (handle,) = found
    return handle
