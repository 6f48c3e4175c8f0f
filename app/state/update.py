"""The one way from a state to the next: which intent is handled by which pure function.

An intent comes from a widget, a board, the clock or a worker. Its handler returns the next state
and the work that this state wants; the session hands the work to the worker, whose results come
back as intents.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import intents as do
from . import on_latent, on_recognition, on_robot, on_view
from .document import AppState
from .statecode import restore
from .transitions import Facts, Update

_HANDLERS: dict[type, Callable[[Facts, AppState, Any], Update]] = {
    do.SelectModel: on_latent.select_model,
    do.SelectMotion: on_latent.select_motion,
    do.SetMu: on_latent.set_mu,
    do.SetSigma: on_latent.set_sigma,
    do.MoveOnMap: on_latent.move_on_map,
    do.MoveOnLandscape: on_latent.move_on_landscape,
    do.ResetLatent: on_latent.reset,
    do.RandomiseLatent: on_latent.randomise,
    do.NewNoise: on_latent.new_noise,
    do.ClearNoise: on_latent.clear_noise,
    do.Undo: on_latent.undo,
    do.Redo: on_latent.redo,
    do.SetPlaying: on_view.set_playing,
    do.TogglePlaying: on_view.toggle_playing,
    do.Seek: on_view.seek,
    do.SetSpeed: on_view.set_speed,
    do.SetLoop: on_view.set_loop,
    do.Tick: on_view.tick,
    do.SetMapAxes: on_view.set_map_axes,
    do.SetLandscapeAxes: on_view.set_landscape_axes,
    do.SetWindow: on_view.set_window,
    do.SetColouring: on_view.set_colouring,
    do.SetJoint: on_view.set_joint,
    do.SetUseTarget: on_view.set_use_target,
    do.SetEyes: on_view.set_eyes,
    do.SetSideBySide: on_robot.set_side_by_side,
    do.SetExportOption: on_robot.set_export_option,
    do.ExportMotion: on_robot.export_motion,
    do.DownloadMotion: on_robot.download_motion,
    do.SetTarget: on_recognition.set_target,
    do.RefuseTarget: on_recognition.refuse_target,
    do.ClearTarget: on_recognition.clear_target,
    do.SetRecognitionOption: on_recognition.set_option,
    do.StartRecognition: on_recognition.start,
    do.CancelRecognition: on_recognition.cancel,
    do.ScrubRecognition: on_recognition.scrub,
    do.RecognitionStepped: on_recognition.stepped,
    do.RecognitionFinished: on_recognition.finished,
    do.MotionReady: on_view.motion_ready,
    do.MotionChecked: on_robot.motion_checked,
    do.ExportReady: on_robot.export_ready,
    do.LandscapeReady: on_view.landscape_ready,
    do.WorkFailed: on_recognition.failed,
    do.RestoreCode: restore,
}


def update(facts: Facts, state: AppState, intent: do.Intent) -> Update:
    """The next state, and the work that it asks for."""
    return _HANDLERS[type(intent)](facts, state, intent)
