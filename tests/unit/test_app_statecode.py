"""The state code: what it restores, and that nothing which it may hold does any harm."""

from __future__ import annotations

import base64
import json
import math
import tracemalloc
import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import (
    AppState,
    ExportOptions,
    Playback,
    initial_state,
)
from rnnpb_explorer.app.state.on_latent import MAX_MU, MAX_SIGMA
from rnnpb_explorer.app.state.slices import drawable_axes
from rnnpb_explorer.app.state.statecode import MAX_CODE_LENGTH, PREFIX, decode, encode
from rnnpb_explorer.app.state.transitions import Facts, opening_work, put_model
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.core.errors import InputError

from .app_states import (
    FACTS,
    JOINTS,
    ONE_DIMENSION,
    TWELVE_DIMENSIONS,
    after,
    landscapes,
    make_facts,
    motions,
    open_screen,
    target_motion,
)

TWO = (make_facts(name="one"), make_facts(12, "two", ("bow", "jump", "nod")))
BUSY = (
    do.SelectMotion(2),
    do.NewNoise(),
    do.SetSigma(0, 0.123456789),
    do.SetMu(0, 3.1),
    do.SetWindow("sd"),
    do.SetColouring("arousal"),
    do.SetJoint("c"),
    do.SetSpeed(0.3),
    do.SetLoop(False),
    do.SetSideBySide(True),
    do.SetEyes(False),
    do.SetExportOption("file_format", "naoqi"),
    do.SetExportOption("safe_posture", True),
    do.Tick(0.2),
)


def unpack(code: str) -> dict[str, Any]:
    packed = code.removeprefix(PREFIX)
    content: dict[str, Any] = json.loads(
        zlib.decompress(base64.urlsafe_b64decode(packed + "=" * (-len(packed) % 4)))
    )
    return content


def pack(content: object) -> str:
    text = content if isinstance(content, bytes) else json.dumps(content).encode()
    return PREFIX + base64.urlsafe_b64encode(zlib.compress(text, 9)).decode().rstrip("=")


def busy_screen(facts: Facts) -> AppState:
    state = after(facts, open_screen(facts), *BUSY)
    if len(state.map_axes) == 2:
        state = after(facts, state, do.SetMapAxes((2, 0)), do.SetLandscapeAxes((1, 2)))
    return state


CODE = encode(FACTS, busy_screen(FACTS))
OPEN = open_screen()


def assert_sound(facts: Facts, state: AppState) -> None:
    """Everything on this screen can be shown."""
    assert len(state.models) == len(facts)
    assert 0 <= state.active < len(facts)
    dim = facts[state.active].pb_dim
    assert drawable_axes(state.map_axes, dim)
    assert state.landscape_axes == "pca" or drawable_axes(state.landscape_axes, dim)
    assert 0.0 <= state.playback.phase <= 1.0
    assert 0.0 < state.playback.speed < math.inf
    assert state.joint in ("", *facts[state.active].joints)
    assert 0 <= state.seed < 2**32
    assert 0 <= state.draws < 2**32
    for one, model in zip(facts, state.models, strict=True):
        assert 0 <= model.latent.motion < len(one.motions)
        for vector in (model.latent.mu, model.latent.sigma, model.latent.epsilon, model.anchor):
            assert vector.shape == (one.pb_dim,)
            assert vector.dtype == np.float64
            assert np.isfinite(vector).all()
        assert (model.latent.sigma >= 0).all()
    _, works = opening_work(facts, state)
    assert len(works) == 2 * len(facts)
    encode(facts, state)


def assert_harmless(code: str) -> None:
    """A code from anywhere is refused in one line, or makes a screen that can be shown."""
    before = OPEN
    state, works = update(FACTS, before, do.RestoreCode(code))
    if works:
        assert_sound(FACTS, state)
        return
    assert state.models is before.models
    assert state.undo is before.undo
    assert state.notice is not None
    assert not state.notice.good
    assert "\n" not in state.notice.text
    assert len(state.notice.text) < 200
    with pytest.raises(InputError):
        decode(FACTS, before, code)


# --- the way there and back ---
@pytest.mark.parametrize("facts", [FACTS, ONE_DIMENSION, TWELVE_DIMENSIONS, TWO])
def test_a_code_restores_exactly_what_is_on_the_screen(facts: Facts) -> None:
    state = busy_screen(facts)
    if len(facts) > 1:
        state = after(facts, state, do.SelectModel(1), do.RandomiseLatent(), do.NewNoise())
    restored = after(facts, open_screen(facts), do.RestoreCode(encode(facts, state)))
    for was, is_ in zip(state.models, restored.models, strict=True):
        assert is_.latent.motion == was.latent.motion
        assert is_.latent.mu.tolist() == was.latent.mu.tolist()
        assert is_.latent.sigma.tolist() == was.latent.sigma.tolist()
        assert is_.latent.epsilon.tolist() == was.latent.epsilon.tolist()
        assert is_.anchor.tolist() == was.anchor.tolist()
    for name in (
        *("active", "playback", "map_axes", "landscape_axes", "window", "colouring", "joint"),
        *("seed", "draws"),
    ):
        assert getattr(restored, name) == getattr(state, name), name
    assert encode(facts, restored) == encode(facts, state)
    assert_sound(facts, restored)


def test_what_is_random_goes_on_as_it_would_have() -> None:
    state = busy_screen(FACTS)
    restored = after(FACTS, initial_state(FACTS, seed=9), do.RestoreCode(encode(FACTS, state)))
    for one in (state, restored):
        assert after(FACTS, one, do.NewNoise()).current.latent.epsilon.tolist() == (
            after(FACTS, state, do.NewNoise()).current.latent.epsilon.tolist()
        )


def test_restoring_wants_everything_computed_anew() -> None:
    state, works = update(FACTS, open_screen(), do.RestoreCode(CODE))
    assert motions(works)[0].pb.tolist() == state.current.latent.pb.tolist()
    assert motions(works)[0].motion == 2
    assert landscapes(works)[0].directions.tolist() == [[0, 1, 0], [0, 0, 1]]


@pytest.mark.parametrize("facts", [FACTS, TWO])
def test_undo_leads_back_to_all_that_a_code_replaced_and_redo_to_it_again(facts: Facts) -> None:
    target = target_motion()
    code = encode(facts, busy_screen(facts))
    before = after(facts, open_screen(facts), do.SetTarget(target), do.SetMu(0, 0.9), do.Tick(0.3))
    restored = after(facts, before, do.RestoreCode(code))
    assert encode(facts, restored) == code
    state, works = update(facts, restored, do.Undo())
    assert encode(facts, state) == encode(facts, before)
    assert state.current.latent.mu.tolist() == before.current.latent.mu.tolist()
    # What is drawn was asked for: along these axes, in this window, against the target.
    asked = before.current.landscape_asked
    assert asked is not None
    assert landscapes(works)[0].directions.tolist() == asked.directions.tolist()
    assert landscapes(works)[0].radius == asked.radius
    assert landscapes(works)[0].target is target.positions
    assert encode(facts, after(facts, state, do.Redo())) == code
    assert encode(facts, after(facts, state, do.Redo(), do.Undo())) == encode(facts, before)
    assert_sound(facts, state)


def test_undo_of_anything_else_leaves_how_it_is_shown() -> None:
    state = after(FACTS, open_screen(), do.RestoreCode(CODE), do.SetMu(0, 0.2))
    state = after(FACTS, state, do.SetWindow("absolute"), do.SetUseTarget(False), do.Undo())
    assert (state.window, state.use_target) == ("absolute", False)


def test_a_code_of_a_screen_without_an_upload_is_not_compared_with_one_that_is_there() -> None:
    """The sender looked at the model's own target; so does who restores it."""
    sender = busy_screen(FACTS)
    receiver = after(FACTS, open_screen(), do.SetTarget(target_motion()))
    state, works = update(FACTS, receiver, do.RestoreCode(encode(FACTS, sender)))
    assert landscapes(works)[0].target is motions(works)[0].target is None
    assert not state.use_target
    assert state.recognition.target is receiver.recognition.target
    assert state.notice is receiver.notice


@pytest.mark.parametrize(
    "put_off", [do.SetUseTarget(False), do.SetTarget(target_motion(joints=JOINTS[::-1]))]
)
def test_an_upload_that_is_not_looked_at_is_none(put_off: do.Intent) -> None:
    sender = after(FACTS, open_screen(), do.SetTarget(target_motion()), put_off)
    assert not decode(FACTS, open_screen(), encode(FACTS, sender)).use_target


def test_who_restores_the_code_of_a_screen_with_an_upload_is_told_that_it_is_not_in_it() -> None:
    sender = after(FACTS, busy_screen(FACTS), do.SetTarget(target_motion(name="mine")))
    code = encode(FACTS, sender)
    state, works = update(FACTS, open_screen(), do.RestoreCode(code))
    assert landscapes(works)[0].target is None
    assert state.notice is not None
    assert state.notice.text.endswith("does not hold; here the model's own stands in")
    other = target_motion(name="another")
    state, works = update(
        FACTS, after(FACTS, open_screen(), do.SetTarget(other)), do.RestoreCode(code)
    )
    assert landscapes(works)[0].target is other.positions
    assert state.notice is not None
    assert state.notice.text.endswith("does not hold; here another stands in")


def test_restoring_leaves_the_target_and_stops_its_run() -> None:
    target = target_motion()
    state = after(FACTS, open_screen(), do.SetTarget(target), do.StartRecognition())
    state, works = update(FACTS, state, do.RestoreCode(CODE))
    assert isinstance(works[0], do.CancelRecogniseWork)
    assert state.recognition.target is target
    assert state.recognition.status == "cancelled"
    for _ in range(3):
        state = after(FACTS, state, do.Undo())
        assert state.recognition.status != "running"


def test_spaces_around_a_code_do_not_matter() -> None:
    state = after(FACTS, open_screen(), do.RestoreCode(f"  {CODE}\n"))
    assert state.current.latent.motion == 2


def test_the_largest_screens_have_a_code() -> None:
    facts = tuple(make_facts(128, f"model {i}") for i in range(4))
    state = open_screen(facts)
    for index in range(4):
        state = after(facts, state, do.SelectModel(index), do.RandomiseLatent(), do.NewNoise())
        state = after(facts, state, *(do.SetSigma(dim, math.pi / (dim + 7)) for dim in range(128)))
        state = after(facts, state, do.SetMu(0, 7.0 + index / 3))
    restored = decode(facts, open_screen(facts), encode(facts, state))
    assert restored.models[3].latent.epsilon.tolist() == state.models[3].latent.epsilon.tolist()


def test_four_models_of_128_dimensions_of_which_everything_was_moved_fit_into_a_code() -> None:
    """Every number another one with all its digits: nothing is left to compress."""
    facts = tuple(make_facts(128, f"model {i}") for i in range(4))
    random, state = np.random.default_rng(0), busy_screen(facts)
    for index, model in enumerate(state.models):
        latent = replace(
            model.latent,
            mu=random.uniform(-MAX_MU, MAX_MU, 128),
            sigma=random.uniform(0.0, MAX_SIGMA, 128),
            epsilon=random.standard_normal(128),
        )
        anchor = latent.mu + random.uniform(-0.1, 0.1, 128)
        anchor = np.clip(anchor, -MAX_MU, MAX_MU)
        state = put_model(state, index, replace(model, latent=latent, anchor=anchor))
    code = encode(facts, state)
    assert 20_000 < len(code) < 0.75 * MAX_CODE_LENGTH
    assert encode(facts, after(facts, open_screen(facts), do.RestoreCode(code))) == code


def test_a_code_that_is_too_long_is_called_that() -> None:
    with pytest.raises(InputError, match="longer than 64000 characters"):
        decode(FACTS, open_screen(), CODE + "A" * MAX_CODE_LENGTH)


# --- damaged codes ---
@pytest.mark.parametrize(
    "code",
    [
        "",
        "hello",
        PREFIX,
        PREFIX + "!!!!",
        PREFIX + "é",
        PREFIX + "AAAA",
        CODE[:-10],
        CODE[:40] + CODE[60:],
        CODE.removeprefix(PREFIX),
        CODE + "AAAA" * 20_000,
        pack(b"no json"),
        pack(b"\xff\xfe\xfd"),
        pack(b"[" * 90_000),
        pack([]),
        pack(7),
        pack({}),
        pack({"models": 3}),
        pack({"models": []}),
    ],
)
def test_what_is_no_code_is_refused_and_the_screen_stays(code: str) -> None:
    state, works = update(FACTS, open_screen(), do.RestoreCode(code))
    assert works == ()
    assert state.current.latent.motion == 0
    assert_harmless(code)


HUGE = int("9" * 400)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("active", -1),
        ("active", 1),
        ("active", None),
        ("active", math.inf),
        ("active", HUGE),
        ("playback", [True, math.nan, 1.0, True]),
        ("playback", [True, 0.5, math.inf, True]),
        ("playback", [True, HUGE, 1.0, True]),
        ("playback", [True, 0.5]),
        ("playback", {}),
        ("map_axes", [0]),
        ("map_axes", [0, 0]),
        ("map_axes", [0, 1, 1]),
        ("map_axes", [0, 1, 2]),
        ("map_axes", [0, 3]),
        ("map_axes", [-1, 0]),
        ("map_axes", [math.nan, 0]),
        ("map_axes", [HUGE, 0]),
        ("map_axes", 1),
        ("landscape_axes", "xy"),
        ("landscape_axes", [1, 1]),
        ("landscape_axes", None),
        ("draws", math.inf),
        ("draws", "many"),
        ("seed", math.nan),
        ("seed", []),
    ],
)
def test_a_value_out_of_place_is_refused(key: str, value: object) -> None:
    code = pack({**unpack(CODE), key: value})
    with pytest.raises(InputError):
        decode(FACTS, open_screen(), code)
    assert_harmless(code)


@pytest.mark.parametrize("key", ["mu", "sigma", "epsilon", "anchor", "name", "motion"])
@pytest.mark.parametrize(
    "value",
    [[0.1, 0.2], [0.1, 0.2, 0.3, 0.4], [0.1, 0.2, math.nan], [HUGE, 0, 0], [[0.1]] * 3, None, {}],
    ids=str,
)
def test_a_model_out_of_place_is_refused(key: str, value: object) -> None:
    content = unpack(CODE)
    content["models"][0][key] = value
    with pytest.raises(InputError):
        decode(FACTS, open_screen(), pack(content))
    assert_harmless(pack(content))


LATER = ("side_by_side", "eyes", "export", "target")  # than the first codes


def test_a_code_of_before_there_was_an_export_opens() -> None:
    content = {key: value for key, value in unpack(CODE).items() if key not in LATER}
    state = decode(FACTS, open_screen(), pack(content))
    assert (state.side_by_side, state.eyes, state.export) == (False, True, ExportOptions())
    assert not state.use_target


def test_the_first_codes_still_open() -> None:
    code = (
        "rnnpb1-eNptUNtqxCAU_JWQ52w4XnLbXyllOVW7tTUa1DRdlv33eiwUCkUfPDPjOM69XYM2LrXn5uneelxNO"
        "bXZ-lvbNYXLNnhCokm5IjspRc-6BnreNSfop-eCJ3tdkSjoGRdyGKd5IcmPjhRmS9ZVs6oZJgGcM1iEKLsaM"
        "VFmOY-CL0wAq_dHCZLzcQApBZ85Iyf06i3Ef3I8Kquy_aRfQBk2h7cXVB8kznE3NRIsf9ZEYEnwii4Zclhxu"
        "-CXqZ0UayDModdJ4WZ-mfJy_ddhvQ4HdZQ0NaSCC3u0_koQxrAndIS_B-szYYomHfEgG0bdGaMp7-MbICZoa"
        "g"
    )
    state = after(FACTS, open_screen(), do.RestoreCode(code))
    assert state.current.latent.motion == 2
    assert state.current.latent.mu[0] == 3.1
    assert state.window == "sd"


def test_nobody_insists_for_another() -> None:
    state = after(FACTS, open_screen(), do.SetExportOption("beyond_limits", True))
    assert not decode(FACTS, open_screen(), encode(FACTS, state)).export.beyond_limits


@pytest.mark.parametrize("export", [["bvh", True], [[], 1], [None, None]])
def test_a_format_that_there_is_not_gives_way_to_csv(export: object) -> None:
    state = decode(FACTS, open_screen(), pack({**unpack(CODE), "export": export}))
    assert state.export.file_format == "csv"


@pytest.mark.parametrize("export", [7, "x", [], ["csv"], {}])
def test_an_export_out_of_shape_is_refused(export: object) -> None:
    with pytest.raises(InputError):
        decode(FACTS, open_screen(), pack({**unpack(CODE), "export": export}))


@pytest.mark.parametrize("key", [key for key in unpack(CODE) if key not in LATER])
def test_nothing_may_be_missing(key: str) -> None:
    content = unpack(CODE)
    del content[key]
    with pytest.raises(InputError):
        decode(FACTS, open_screen(), pack(content))


def test_values_beyond_reason_are_brought_back_to_it() -> None:
    content = unpack(CODE)
    content["models"][0].update(mu=[1e300, 0, 0], sigma=[-1, 1e300, 0], epsilon=[-1e300, 0, 0])
    content.update(playback=[True, 7.0, -5.0, True], seed=-5, draws=10**30)
    state = decode(FACTS, open_screen(), pack(content))
    assert state.current.latent.mu.tolist() == [20.0, 0.0, 0.0]
    assert state.current.latent.sigma.tolist() == [0.0, 5.0, 0.0]
    assert state.current.latent.epsilon.tolist() == [-10.0, 0.0, 0.0]
    assert state.playback == Playback(True, 1.0, 0.1, True)
    assert_sound(FACTS, state)


def test_words_that_are_not_known_give_way_to_the_usual_ones() -> None:
    content = {**unpack(CODE), "joint": "knee", "colouring": "smell", "window": 7}
    state = decode(FACTS, open_screen(), pack(content))
    assert (state.joint, state.colouring, state.window) == ("", "class", "absolute")


def test_a_puck_outside_of_its_window_takes_the_window_along() -> None:
    content = unpack(CODE)
    content["models"][0]["anchor"] = [-9.0, -9.0, -9.0]
    state = after(FACTS, open_screen(), do.RestoreCode(pack(content)))
    assert state.current.anchor.tolist() == state.current.latent.mu.tolist()


# --- codes of other screens ---
@pytest.mark.parametrize(
    ("facts", "says"),
    [
        ((make_facts(name="weak"),), "'weak'"),
        (ONE_DIMENSION, "'line'"),
        (TWO, "of 1 models, here are 2"),
        ((make_facts(names=("w", "b", "r", "n")),), "another model"),
    ],
)
def test_the_code_of_other_models_is_refused_by_name(facts: Facts, says: str) -> None:
    before = open_screen(facts)
    with pytest.raises(InputError, match=says):
        decode(facts, before, CODE)
    state, works = update(facts, before, do.RestoreCode(CODE))
    assert works == ()
    assert state.models is before.models


def test_a_name_out_of_a_code_is_shown_shortened_and_harmless() -> None:
    content = unpack(CODE)
    content["models"][0]["name"] = "long\nname" * 5000
    assert_harmless(pack(content))


# --- anything at all ---
def test_a_zip_bomb_does_not_go_off() -> None:
    bomb = PREFIX + base64.urlsafe_b64encode(zlib.compress(b"0" * 14_000_000, 9)).decode()
    assert len(bomb) < MAX_CODE_LENGTH  # it gets past the limit on a code's length
    tracemalloc.start()
    try:
        assert_harmless(bomb)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 2_000_000


@settings(deadline=None)
@given(st.text())
def test_any_text_is_harmless(text: str) -> None:
    assert_harmless(text)
    assert_harmless(PREFIX + text)


@settings(deadline=None)
@given(st.binary())
def test_any_bytes_are_harmless(content: bytes) -> None:
    assert_harmless(PREFIX + base64.urlsafe_b64encode(content).decode())
    assert_harmless(pack(content))


@settings(deadline=None)
@given(st.integers(0, len(CODE) - 1), st.characters())
def test_any_changed_character_is_harmless(index: int, character: str) -> None:
    assert_harmless(CODE[:index] + character + CODE[index + 1 :])


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=8,
)


@settings(deadline=None, max_examples=300)
@given(st.data())
def test_any_values_in_a_sound_code_are_harmless(data: st.DataObject) -> None:
    content = unpack(CODE)
    for key in data.draw(st.lists(st.sampled_from(list(content)), unique=True, max_size=3)):
        content[key] = data.draw(VALUES, label=key)
    models = content["models"]
    if isinstance(models, list) and models and isinstance(models[0], dict):
        for key in data.draw(st.lists(st.sampled_from(list(models[0]) or ["x"]), max_size=2)):
            models[0][key] = data.draw(VALUES, label=key)
    assert_harmless(pack(content))
