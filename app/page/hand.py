"""What a hand on the boards and the time bar asks of the document: `asked.py` as intents. Pure."""

from __future__ import annotations

from typing import assert_never

from ..state import intents as do
from ..state.picture import Picture
from . import asked


def intent_of(word: asked.ByHand, picture: Picture) -> do.Intent:
    """The intent for what a page asks; `picture` is what is on its screen."""
    match word:
        case asked.MoveOnMap():
            return do.MoveOnMap(word.model, tuple(word.axes), tuple(word.to), word.gesture)
        case asked.MoveOnLandscape():
            return do.MoveOnLandscape(word.model, tuple(word.axes), tuple(word.to), word.gesture)
        case asked.SelectMotion(model, index):
            return do.SelectMotion(index, model)
        case asked.SelectAdded(index):
            return do.SelectAdded(index)
        case asked.WalkTo(step):
            return do.WalkTo(step)
        case asked.SetPlaying(playing, frame):
            return do.SetPlaying(playing, frame)
        case asked.Seek(frame):
            return do.Seek(frame)
        case asked.SetSpeed(speed):
            return do.SetSpeed(speed)
        case asked.SetLoop(loop):
            return do.SetLoop(loop)
        case asked.SetJoint(joint):
            joints = picture.model.joints
            return do.SetJoint("" if joint is None or joint >= len(joints) else joints[joint])
        case asked.SetObserved(share):
            return do.SetRecognitionOption("observed", share)
        case asked.Undo():
            return do.Undo()
        case asked.Redo():
            return do.Redo()
        case _:
            assert_never(word)
