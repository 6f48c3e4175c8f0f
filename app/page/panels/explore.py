"""The Explore panel: which model, which motion, and one mu and one sigma slider a dimension."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import viser

from ...state import intents as do
from ...state.document import MAX_PB, Hand
from ...state.facts import Facts, ModelFacts
from ...state.picture import Picture
from ..words import smoothness_table
from .bound import Bound, assign, on_click
from .text import table, write
from .ways import WaysPart

Send = Callable[[do.Intent], None]

NOTHING = "nothing"
HANDS: dict[str, Hand] = {
    "moves this model alone": "alone",
    "moves all, as far in μ": "absolute",
    "moves all, as many sd of μ": "sd",
    "moves all along the way to a motion": "way",
}
PAGE = 8  # dimensions shown at a time; a model may have 128
STEPS = 500  # of a slider from zero to its end


class ExplorePanel:
    """Everything that moves the latent by numbers instead of by hand."""

    def __init__(
        self, gui: viser.GuiApi, facts: Facts, offers: tuple[str, ...], send: Send
    ) -> None:
        self._gui, self._facts, self._send = gui, facts, send
        self._offers = offers
        self._active = 0  # the model whose motions are in the list
        self._model = Bound(
            gui.add_dropdown("Model", offers, hint="loaded when it is chosen"),
            lambda name: send(do.OpenModel(name)),
        )
        self._beside = Bound(
            gui.add_dropdown(
                "Compare with",
                [NOTHING, *offers],
                hint="the maps and landscapes of two models, one hand for both",
            ),
            self._choose_beside,
        )
        self._motion = Bound(
            gui.add_dropdown("Motion", facts[0].motions, hint="μ and σ jump to what was learnt"),
            self._choose_motion,
        )
        self._ways = WaysPart(gui, facts[0].motions, send)
        self._buttons()
        self._hand = Bound(
            gui.add_dropdown(
                "One hand",
                list(HANDS),
                visible=False,
                hint="what a drag or a μ slider does to the other models",
            ),
            lambda label: send(do.SetHand(HANDS[label])),
        )
        self._smoothness = gui.add_html("")
        self._sliders = gui.add_folder("Parametric bias: N(μ, σ²)")
        self._note = gui.add_markdown("")
        self._close = gui.add_button(
            "Close", visible=False, color="gray", hint="the model takes its robot along"
        )
        on_click(self._close, lambda: send(do.CloseModel()))
        self._mu: list[Bound] = []
        self._sigma: list[Bound] = []
        self._page: Bound | None = None
        self._built: tuple[str, int] | None = None  # model and first dimension of the sliders

    def _buttons(self) -> None:
        group = self._gui.add_button_group(
            "Go to", ("Reset", "Random", "Undo"), hint="learned μ, σ of the motion; a random μ"
        )
        noise = self._gui.add_button_group(
            "Noise ε", ("New", "None"), hint="PB = μ + σ·ε: another sample, or μ itself"
        )
        actions: dict[str, do.Intent] = {
            "Reset": do.ResetLatent(),
            "Random": do.RandomiseLatent(),
            "Undo": do.Undo(),
        }
        on_click(group, lambda: self._send(actions[group.value]))
        on_click(
            noise, lambda: self._send(do.NewNoise() if noise.value == "New" else do.ClearNoise())
        )

    def _choose_beside(self, name: str) -> None:
        self._send(do.SetCompare(False) if name == NOTHING else do.OpenModel(name, beside=True))

    def _choose_motion(self, name: str) -> None:
        motions = self._facts[self._active].motions
        if name in motions:
            self._send(do.SelectMotion(motions.index(name)))

    def _choose_page(self, label: str) -> None:
        self._send(do.ShowSliders(int(label.split("–")[0]) - 1))

    def show(self, picture: Picture) -> None:
        self._active, self._facts = picture.active, picture.facts
        facts, latent = picture.model, picture.choice.latent
        first = picture.document.first_slider // PAGE * PAGE
        if self._built is None or self._built[0] != facts.name:
            self._motion.offer(facts.motions)
        if self._built != (facts.name, first):
            self._build_sliders(facts, first)
            self._built = (facts.name, first)
        self._show_models(picture)
        self._motion.show(facts.motions[latent.motion])
        hand = picture.document.hand
        self._hand.show(next(label for label, known in HANDS.items() if known == hand))
        assign(self._hand.handle, visible=len(self._facts) > 1)
        write(self._smoothness, table(smoothness_table(picture)))
        self._ways.show(picture)
        for bound, value in zip(self._mu, latent.mu[first:], strict=False):
            _show_slider(bound, value)
        for bound, value in zip(self._sigma, latent.sigma[first:], strict=False):
            _show_slider(bound, value)
        self._show_note(picture)

    def _show_models(self, picture: Picture) -> None:
        """Those on the page are offered even where the server offers them no more."""
        document, name = picture.document, picture.model.name
        here = [one.name for one in picture.facts]
        offers = [*self._offers, *(one for one in here if one not in self._offers)]
        self._model.offer(offers)
        self._model.show(name)
        self._beside.offer([NOTHING, *(one for one in offers if one != name)])
        others = [here[index] for index in document.on_boards if index != picture.active]
        self._beside.show(others[0] if others else NOTHING)
        assign(self._close, visible=len(here) > 1, label=f"Close {name}")

    def _build_sliders(self, facts: ModelFacts, first: int) -> None:
        for bound in [*self._mu, *self._sigma, *([self._page] if self._page else [])]:
            bound.handle.remove()
        self._page = None
        dims = range(first, min(first + PAGE, facts.pb_dim))
        mu_end = _round_up(1.5 * float(abs(facts.mu).max()))
        sigma_end = max(1.0, _round_up(1.5 * float(facts.sigma.max())))
        with self._sliders:
            if facts.pb_dim > PAGE:
                starts = range(0, facts.pb_dim, PAGE)
                pages = [f"{s + 1}–{min(s + PAGE, facts.pb_dim)}" for s in starts]
                self._page = Bound(
                    self._gui.add_dropdown("Dimensions", pages, initial_value=pages[first // PAGE]),
                    self._choose_page,
                )
            self._mu = [
                Bound(
                    self._gui.add_slider(
                        f"μ {dim + 1}", -mu_end, mu_end, _step(mu_end), 0.0, hint="mean of the PB"
                    ),
                    partial(self._set_mu, dim),
                )
                for dim in dims
            ]
            self._sigma = [
                Bound(
                    self._gui.add_slider(
                        f"σ {dim + 1}", 0.0, sigma_end, _step(sigma_end), 0.0, hint="its spread"
                    ),
                    partial(self._set_sigma, dim),
                )
                for dim in dims
                if facts.stochastic
            ]

    def _set_mu(self, dim: int, value: float) -> None:
        self._send(do.SetMu(dim, value))

    def _set_sigma(self, dim: int, value: float) -> None:
        self._send(do.SetSigma(dim, value))

    def _show_note(self, picture: Picture) -> None:
        facts, latent = picture.model, picture.choice.latent
        beyond = facts.latent_map.extrapolation(latent.mu)
        lines = []
        if not facts.stochastic:
            lines.append("*Deterministic model: PB = μ, there is no σ.*")
        elif not any(latent.epsilon):
            lines.append("ε = 0: the motion at μ itself.")
        else:
            noise = ", ".join(f"{value:+.2f}" for value in latent.epsilon[:PAGE])
            lines.append(f"ε = ({noise}{', …' if facts.pb_dim > PAGE else ''})")
        if beyond > 1:
            lines.append(
                f"**Extrapolating**: {beyond:.1f}× farther from everything learnt than learnt "
                "motions lie from each other."
            )
        content = "\n\n".join(lines)
        if self._note.content != content:
            self._note.content = content


def _step(end: float) -> float:
    """A power of ten, so that the number beside the slider has few digits."""
    step: float = 10.0 ** math.floor(math.log10(end / STEPS))
    return step


def _round_up(value: float) -> float:
    """To one significant digit and a half, so that a slider ends at a round number."""
    if value <= 0:
        return 1.0
    unit: float = 10.0 ** math.floor(math.log10(value)) / 2
    return round(math.ceil(value / unit) * unit, 12)  # 0.85, not 0.8500000000000001


def _show_slider(bound: Bound, value: float) -> None:
    """viser does not clamp what it is given: widen the slider for a value beyond its end."""
    handle = bound.handle
    if value > handle.max:
        handle.max = min(_round_up(value), MAX_PB)
    if value < handle.min:
        handle.min = -min(_round_up(-value), MAX_PB)
    bound.show(min(max(value, handle.min), handle.max))
