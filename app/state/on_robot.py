"""What concerns the robot: safety report, limited motion beside the raw one, export. Pure."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ...robot.formats import FORMATS
from . import intents as do
from .document import AppState, ExportOptions
from .transitions import Facts, Update, notify, put_model, want_motion


def motion_checked(facts: Facts, state: AppState, intent: do.MotionChecked) -> Update:
    model = state.models[intent.model]
    if model.checked is not None and model.checked.request >= intent.checked.request:
        return state, ()
    return put_model(state, intent.model, replace(model, checked=intent.checked)), ()


def set_side_by_side(facts: Facts, state: AppState, intent: do.SetSideBySide) -> Update:
    """The limited motion is made together with the raw one, so that both move as one."""
    if intent.side_by_side == state.side_by_side:
        return state, ()
    state = replace(state, side_by_side=intent.side_by_side)
    return want_motion(facts, state, state.active) if intent.side_by_side else (state, ())


def set_export_option(facts: Facts, state: AppState, intent: do.SetExportOption) -> Update:
    value: Any = intent.value if intent.name == "file_format" else bool(intent.value)
    if intent.name == "file_format" and value not in FORMATS:
        return state, ()
    return replace(state, export=replace(state.export, **{intent.name: value}, written="")), ()


def export_motion(facts: Facts, state: AppState, intent: do.ExportMotion) -> Update:
    """Export what is on the screen now."""
    return _write(facts, state, state.export)


def download_motion(facts: Facts, state: AppState, intent: do.DownloadMotion) -> Update:
    return _write(facts, state, ExportOptions("csv", beyond_limits=True))


def _write(facts: Facts, state: AppState, options: ExportOptions) -> Update:
    motion, one = state.current.motion, facts[state.active]
    if motion is None:
        return state, ()
    request = state.requests + 1
    export = replace(state.export, request=request, written="")
    name = f"{one.motions[state.current.latent.motion]} {one.name}"
    work = do.ExportWork(state.active, request, name, motion.positions, options)
    return replace(state, export=export, requests=request), (work,)


def export_ready(facts: Facts, state: AppState, intent: do.ExportReady) -> Update:
    if intent.request != state.export.request:
        return state, ()
    state = replace(state, export=replace(state.export, written=intent.summary))
    state = notify(state, intent.summary, good=True)
    return state, (do.SendFile(intent.file_name, intent.content),)
