"""Which models are on the page: opened in place of another or beside it, closed. Pure."""

from __future__ import annotations

from msgspec.structs import replace

from ...core.errors import InputError
from .document import MAX_MODELS, Document, ModelChoice
from .facts import Facts, ModelFacts
from .on_latent import end_run, select_model
from .on_view import compare
from .opening import learned_latent
from .planes import fitting_axes


def open_model(facts: Facts, document: Document, newcomer: ModelFacts, *, beside: bool) -> Document:
    """Show a model at the motion that is selected, where it has learnt that.

    Raises:
        InputError: it cannot be compared with the active one, or there are too many on the page.
    """
    document = replace(document, walk=None)
    names = [one.name for one in facts]
    if not beside:
        if newcomer.name in names:
            return select_model(facts, document, names.index(newcomer.name))
        return _put(facts, document, document.active, newcomer)
    if newcomer.name == document.current.name:
        return document
    active = document.active
    other = next((index for index in document.pair if index != active), len(names))
    if newcomer.name in names:
        other = names.index(newcomer.name)
    elif document.compare:  # it takes the other one's place
        facts, document = _replaced(facts, other, newcomer), _put(facts, document, other, newcomer)
    elif len(names) == MAX_MODELS:
        raise InputError(f"{MAX_MODELS} models are on the page, as many as it takes: close one")
    else:
        other = len(names)
        models = (*document.models, _choice(facts[active], document, newcomer))
        facts, document = (*facts, newcomer), replace(document, models=models)
    pair = (active, other) if active < other else (other, active)
    return compare(facts, replace(document, pair=pair), True)


def close_model(facts: Facts, document: Document) -> Document:
    """Without the active model; the last one stays."""
    gone = document.active
    if len(facts) == 1:
        return document
    document = replace(end_run(document), walk=None)
    left = [index for index in range(len(facts)) if index != gone]
    moved = {old: new for new, old in enumerate(left)}
    run = document.run
    pair = tuple(moved[index] for index in document.pair if index in moved)
    others = [index for index in range(len(left)) if index not in pair]
    first, second = (*pair, *others, *pair, 0)[:2] if len(left) > 1 else (0, 1)
    after = next((index for index in document.pair if index in moved), left[0])
    document = replace(
        document,
        models=tuple(document.models[index] for index in left),
        active=moved[after],
        pair=(first, second),
        compare=document.compare and gone not in document.pair,
        run=None if run is None or run.model == gone else replace(run, model=moved[run.model]),
        added=tuple(
            replace(one, model=moved[one.model]) for one in document.added if one.model in moved
        ),
    )
    return _fitted(facts[after], document)


def _put(facts: Facts, document: Document, place: int, newcomer: ModelFacts) -> Document:
    """A model in the place of another; what was of that one goes with it."""
    document = end_run(document)
    choice = _choice(facts[document.active], document, newcomer)
    run = document.run
    document = replace(
        document,
        models=(*document.models[:place], choice, *document.models[place + 1 :]),
        run=None if run is not None and run.model == place else run,
        added=tuple(one for one in document.added if one.model != place),
    )
    if place != document.active:
        return document
    document = _fitted(newcomer, document)
    there = _replaced(facts, place, newcomer)
    return compare(there, document, True) if document.compare else document


def _choice(shown: ModelFacts, document: Document, newcomer: ModelFacts) -> ModelChoice:
    name = shown.motions[document.current.latent.motion]
    motion = newcomer.motions.index(name) if name in newcomer.motions else 0
    latent = learned_latent(newcomer, motion)
    return ModelChoice(newcomer.name, latent, latent.mu)


def _replaced(facts: Facts, place: int, newcomer: ModelFacts) -> Facts:
    return (*facts[:place], newcomer, *facts[place + 1 :])


def _fitted(facts: ModelFacts, document: Document) -> Document:
    """Axes, sliders and joint that the active model has."""
    axes = document.landscape_axes
    return replace(
        document,
        first_slider=0,
        map_axes=fitting_axes(document.map_axes, facts.pb_dim),
        landscape_axes="pca" if axes == "pca" else fitting_axes(axes, facts.pb_dim),
        joint=document.joint if document.joint in facts.joints else "",
    )
