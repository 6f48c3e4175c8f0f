"""The one way from a document to the next: what an intent does to it. Pure.

An intent may come later than what it speaks of (a motion of another model, axes that are no longer
drawn); the document then stays as it is. What a person should be told is an `InputError`, and the
document stays as well.
"""

from __future__ import annotations

from typing import assert_never

from msgspec.structs import replace

from . import intents as do
from .document import Document
from .facts import Facts
from .on_latent import hold_pucks, update_latent
from .on_recognition import update_recognition
from .on_view import update_playback, update_view


def update(facts: Facts, document: Document, intent: do.DocumentIntent) -> Document:
    """The next document.

    Raises:
        InputError: one line on why there is none.
    """
    if isinstance(intent, do.PlaybackIntent):
        return update_playback(facts, document, intent)
    before = document
    if isinstance(intent, do.LatentIntent):
        document = update_latent(facts, document, intent)
    elif isinstance(intent, do.ViewIntent):
        document = update_view(facts, document, intent)
    elif isinstance(intent, do.RecognitionIntent):
        document = update_recognition(facts, document, intent)
    else:
        assert_never(intent)
    walked = isinstance(intent, do.WalkTo)
    if document.walk is not None and not walked and not _stands(before, document):
        document = replace(document, walk=None)  # something else has moved it
    return hold_pucks(facts, document)


def _stands(before: Document, after: Document) -> bool:
    """Whether all models are where they were."""
    return [one.latent for one in before.models] == [one.latent for one in after.models]
