"""The document that a page opens with, and whether one fits the models that are loaded."""

from __future__ import annotations

from ...core.errors import InputError
from .document import Document, Latent, ModelChoice, vector
from .facts import Facts, ModelFacts
from .planes import drawable_axes


def learned_latent(facts: ModelFacts, motion: int) -> Latent:
    """The learned PB of a motion without noise: its reconstruction."""
    return Latent(
        motion=motion,
        mu=vector(facts.mu[motion]),
        sigma=vector(facts.sigma[motion]),
        epsilon=(0.0,) * facts.pb_dim,
    )


def opening_document(facts: Facts, seed: int = 0, motion: int = 0) -> Document:
    """One motion, playing; the same of every model that has learnt it."""
    first = facts[0]
    name = first.motions[min(motion, len(first.motions) - 1)]
    models = []
    for one in facts:
        index = one.motions.index(name) if name in one.motions else motion
        latent = learned_latent(one, min(index, len(one.motions) - 1))
        models.append(ModelChoice(one.name, latent, latent.mu))
    axes = (0, 1)[: first.pb_dim]
    return Document(tuple(models), map_axes=axes, landscape_axes=axes, seed=seed)


def check_fits(facts: Facts, document: Document) -> None:
    """Whether a document from elsewhere can be shown with these models.

    Raises:
        InputError: it is of other models, or names what they do not have.
    """
    if len(document.models) != len(facts):
        raise InputError(
            f"the state code is of {len(document.models)} models, here are {len(facts)}"
        )
    for one, choice in zip(facts, document.models, strict=True):
        _check_choice(one, choice)
    if len({choice.name for choice in document.models}) < len(document.models):
        raise InputError("the state code holds a model twice")
    if document.active >= len(facts):
        raise InputError("the state code names a model that it does not hold")
    if len(facts) > 1 and (max(document.pair) >= len(facts) or len(set(document.pair)) < 2):
        raise InputError("the state code names two models to compare that are not here")
    dim = facts[document.active].pb_dim
    axes = document.landscape_axes
    drawable = all(drawable_axes(one, dim) for one in (document.map_axes, axes) if one != "pca")
    if not drawable or document.first_slider >= dim:
        raise InputError("the state code names dimensions that the model does not have")
    run = document.run
    if run is not None and (
        run.model >= len(facts)
        or document.target is None
        or document.target.joints != facts[run.model].joints
        or (run.settings.method == "paper" and run.done > run.settings.iterations)
        or (run.settings.method == "paper" and run.trial >= run.settings.trials)
        or (run.shown is not None and run.shown >= run.done)
        or not set(run.settings.joints) <= set(facts[run.model].joints)
    ):
        raise InputError("the state code holds a recognition that cannot be")
    for added in document.added:
        dims = {len(added.mu), len(added.sigma)}
        if added.model >= len(facts) or dims != {facts[added.model].pb_dim}:
            raise InputError("the state code holds a point that is on none of these maps")


def _check_choice(facts: ModelFacts, choice: ModelChoice) -> None:
    latent = choice.latent
    if choice.name != facts.name:
        raise InputError(
            f"the state code is of another model, {choice.name[:40]!r}; here is {facts.name!r}"
        )
    sizes = {len(latent.mu), len(latent.sigma), len(latent.epsilon), len(choice.anchor)}
    if latent.motion >= len(facts.motions) or sizes != {facts.pb_dim}:
        raise InputError(f"the state code is of another model that was called {facts.name!r}, too")
