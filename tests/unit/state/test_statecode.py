"""The state code: what it restores, and that nothing which it may hold does any harm."""

from __future__ import annotations

import base64
import math
import tracemalloc
import zlib
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import MAX_PB, Document, Latent, vector
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.on_latent import put_latent
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.statecode import (
    MAX_BYTES,
    MAX_CODE_LENGTH,
    MAX_LINE,
    PREFIX,
    decode,
    encode,
)
from rnnpb_explorer.app.state.wanted import wanted
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.motion import MAX_FRAMES

from ..app_states import (
    FACTS,
    ONE_DIMENSION,
    RUN,
    TWELVE_DIMENSIONS,
    Page,
    after,
    make_facts,
    make_target,
    make_trace,
    opened,
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
    do.SetTarget(make_target()),
    do.SetUseTarget(False),
    do.SetMapAxes((2, 0)),
    do.SetLandscapeAxes((1, 2)),
    do.SetGhosts(True),
)


def unpack(code: str) -> dict[str, Any]:
    packed = code.removeprefix(PREFIX)
    raw = zlib.decompress(base64.urlsafe_b64decode(packed + "=" * (-len(packed) % 4)))
    content: dict[str, Any] = msgspec.msgpack.decode(raw)
    return content


def pack(content: object) -> str:
    raw = content if isinstance(content, bytes) else msgspec.msgpack.encode(content)
    return PREFIX + base64.urlsafe_b64encode(zlib.compress(raw, 9)).decode().rstrip("=")


def with_run() -> Document:
    """The busy document with a run that is through, and one of its iterations on the screen."""
    option = do.SetRecognitionOption("iterations", 2)
    page = Page(FACTS, opened(FACTS, *BUSY)).do(option, do.StartRecognition())
    page.deliver(RUN, make_trace(np.full((3, 1, 3), 0.25)))
    return page.do(do.ScrubRecognition(1, 0)).document


DOCUMENT = with_run()
CODE = encode(DOCUMENT)


def assert_refused(code: str, facts: Facts = FACTS, match: str | None = None) -> None:
    with pytest.raises(InputError, match=match) as refused:
        decode(facts, code)
    line = str(refused.value)
    assert "\n" not in line
    assert len(line) < 200


def assert_harmless(code: str) -> None:
    """A code from anywhere is refused in one line, or makes a document that can be shown."""
    try:
        document = decode(FACTS, code)
    except InputError:
        assert_refused(code)
        return
    assert decode(FACTS, encode(document)) == document
    page = Page(FACTS, document).compute()
    for intent in (do.Seek(3), do.NewNoise(), do.SelectMotion(1), do.SetWindow("sd"), do.Undo()):
        page.do(intent)
        assert wanted(FACTS, page.document)


# --- the way there and back ---
@pytest.mark.parametrize("facts", [FACTS, ONE_DIMENSION, TWELVE_DIMENSIONS, TWO])
def test_a_code_restores_exactly_what_is_on_the_screen(facts: Facts) -> None:
    document = opened(facts, *BUSY)
    if len(facts) > 1:
        document = after(facts, document, do.SelectModel(1), do.RandomiseLatent(), do.NewNoise())
    restored = decode(facts, f"  {encode(document)}\n")
    assert restored == document
    assert wanted(facts, restored) == wanted(facts, document)
    # What is random goes on as it would have.
    assert after(facts, restored, do.NewNoise()) == after(facts, document, do.NewNoise())


def test_an_upload_and_its_run_are_in_the_code() -> None:
    restored = decode(FACTS, CODE)
    assert restored == DOCUMENT
    assert restored.target == make_target()
    assert restored.run is not None
    assert (restored.run.shown, restored.run.done, restored.run.settled) == (1, 2, True)
    picture = Picture(FACTS, restored, Page().computed)
    assert picture.run_status == "finished"


@pytest.mark.parametrize("facts", [FACTS, TWO])
def test_undo_leads_back_to_all_that_a_code_replaced_and_redo_to_it_again(facts: Facts) -> None:
    page = Page(facts).do(do.SetTarget(make_target()), do.SetMu(0, 0.9), do.StartRecognition())
    before, other = page.document, opened(facts, *BUSY)
    page.do(do.RestoreCode(encode(other)))
    assert page.document == other
    page.do(do.Undo())
    assert page.document == replace(before, playback=other.playback)
    assert page.wanted == wanted(facts, before)
    assert page.do(do.Redo()).document == other


def test_a_code_that_is_refused_changes_nothing() -> None:
    page = Page().do(do.SetMu(0, 0.9))
    history = page.history
    with pytest.raises(InputError):
        page.do(do.RestoreCode(CODE[:-10]))
    assert page.history is history


def test_the_largest_documents_have_a_code() -> None:
    """Every number another one with all its digits, and the longest of uploads."""
    facts = tuple(make_facts(128, f"model {i}") for i in range(4))
    draw, document = np.random.default_rng(0), opened(facts)
    for index in range(4):
        numbers = draw.uniform(0.0, MAX_PB, (4, 128))
        latent = Latent(0, *(vector(row) for row in numbers[:3]))
        document = put_latent(document, index, latent, anchor=vector(numbers[3]))
    assert decode(facts, encode(document)) == document
    assert len(encode(document)) < MAX_LINE
    noise = draw.standard_normal((MAX_FRAMES, 17)).astype("<f4").tobytes()
    eyes = draw.integers(0, 256, MAX_FRAMES * 48, dtype=np.uint8).tobytes()
    joints = tuple(f"j{n}" for n in range(17))
    target = replace(make_target(), joints=joints, positions=noise, eyes=eyes)
    document = replace(document, target=target)
    code = encode(document)
    assert MAX_LINE < len(code) < MAX_CODE_LENGTH
    assert decode(facts, code) == document


def test_a_code_of_before_there_was_a_choice_opens() -> None:
    content = unpack(encode(opened(FACTS, do.SetMu(0, 0.9))))
    for key in list(content):
        if key != "models":
            del content[key]
    document = decode(FACTS, pack(content))
    assert document == Document(opened(FACTS, do.SetMu(0, 0.9)).models)


# --- damaged codes ---
@pytest.mark.parametrize(
    ("code", "says"),
    [
        ("", "not a state code"),
        ("hello", "begins with rnnpb2-"),
        (CODE.removeprefix(PREFIX), "not a state code"),
        ("rnnpb1-eNptUNtqxCAU", "older version"),
        (PREFIX, "damaged"),
        (PREFIX + "!!!!", "damaged"),
        (PREFIX + "é", "damaged"),
        (PREFIX + "AAAA", "damaged"),
        (CODE[:-10], "damaged"),
        (CODE[:40] + CODE[60:], "damaged"),
        (CODE + "A" * (4 - len(CODE.removeprefix(PREFIX)) % 4) + "AAAA", "damaged"),
        (CODE + "A" * MAX_CODE_LENGTH, "longer than 12000000 characters"),
        (pack(b"no msgpack"), "damaged"),
        (pack(b"\xff\xfe\xfd"), "damaged"),
        (pack(b"\x91" * 90_000), "damaged"),
        (pack([]), "damaged"),
        (pack(7), "damaged"),
        (pack({}), "damaged"),
        (pack({"models": 3}), "damaged"),
        (pack({"models": []}), "damaged"),
        (pack({**unpack(CODE), "smell": 1}), "damaged"),
    ],
    ids=lambda value: value[:30],
)
def test_what_is_no_code_is_refused(code: str, says: str) -> None:
    assert_refused(code, match=says)


NAN = math.nan
RUN_OF_CODE = unpack(CODE)["run"]
TARGET_OF_CODE = unpack(CODE)["target"]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *[("active", value) for value in (-1, 1, None, math.inf, 2**63)],
        *[("playback", {"phase": value}) for value in (NAN, math.inf, -0.1, 1.1, None, 2**63)],
        *[("playback", {"speed": value}) for value in (NAN, math.inf, 0.0, 9.0)],
        ("playback", [True, 0.5, 1.0, True]),
        *[("map_axes", axes) for axes in ([0], [0, 0], [0, 1, 1], [0, 1, 2], [0, 3], [-1, 0], [])],
        *[("map_axes", value) for value in ([NAN, 0], [2**63, 0], 1, "pca")],
        *[("landscape_axes", value) for value in ("xy", [1, 1], [0, 3], [0], None)],
        *[("first_slider", value) for value in (-1, 3, 128, 0.5)],
        *[("draws", value) for value in (NAN, "many", -1, 2**32)],
        *[("seed", value) for value in (NAN, [], -1, 2**32)],
        ("window", 7),
        ("colouring", "smell"),
        ("joint", "x" * 300),
        ("use_target", 1),
        *[("export", value) for value in (7, [], {"file_format": "bvh"}, {"beyond_limits": 1})],
        *[("recognition", {name: 0}) for name in ("observed", "iterations", "trials", "init")],
        *[("recognition", {"iterations": 1000}), ("recognition", {"trials": 20})],
        *[("recognition", {"observed": NAN}), ("recognition", {"init": "nonsense"})],
        *[("target", {**TARGET_OF_CODE, "fps": value}) for value in (0.0, NAN, -25.0, 1e9)],
        *[("target", {**TARGET_OF_CODE, "positions": value}) for value in (b"", b"\0" * 21, "x")],
        ("target", {**TARGET_OF_CODE, "positions": np.full(50, NAN, "<f4").tobytes()}),
        ("target", {**TARGET_OF_CODE, "positions": bytes(20 * (MAX_FRAMES + 1))}),
        ("target", {**TARGET_OF_CODE, "eyes": b"\0" * 47}),
        ("target", {**TARGET_OF_CODE, "joints": ["v", "w", "x", "y", "z"]}),  # there is a run
        ("target", None),
        *[("run", {**RUN_OF_CODE, "model": value}) for value in (-1, 1)],
        *[("run", {**RUN_OF_CODE, "done": value}) for value in (-1, 3, 301, 1)],  # 1: at most 2nd
        *[("run", {**RUN_OF_CODE, "trial": value}) for value in (-1, 1, 10)],
        *[("run", {**RUN_OF_CODE, "shown": value}) for value in (-1, 2, 300)],
    ],
    ids=lambda value: str(value)[:40],
)
def test_a_value_out_of_place_is_refused(key: str, value: object) -> None:
    assert_refused(pack({**unpack(CODE), key: value}))


def latents(content: dict[str, Any], key: str, value: object) -> dict[str, Any]:
    model = content["models"][0]
    (model if key in model else model["latent"])[key] = value
    return content


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *[(key, [0.1, 0.2]) for key in ("mu", "sigma", "epsilon", "anchor")],
        *[(key, [0.1, 0.2, 0.3, 0.4]) for key in ("mu", "sigma", "epsilon", "anchor")],
        *[(key, [0.1, 0.2, NAN]) for key in ("mu", "sigma", "epsilon", "anchor")],
        *[(key, [0.1, 0.2, 1.1e6]) for key in ("mu", "sigma", "epsilon", "anchor")],
        *[(key, [2**63, 0, 0]) for key in ("mu", "sigma", "epsilon", "anchor")],
        *[(key, [[0.1]] * 3) for key in ("mu", "sigma", "epsilon", "anchor")],
        *[("motion", value) for value in (-1, 4, None, {}, 0.5)],
        *[("name", value) for value in ("other", None, {}, "x" * 300)],
        ("sigma", [-0.1, 0.2, 0.3]),
    ],
    ids=str,
)
def test_a_model_out_of_place_is_refused(key: str, value: object) -> None:
    assert_refused(pack(latents(unpack(CODE), key, value)))


# --- codes of other models ---
@pytest.mark.parametrize(
    ("facts", "says"),
    [
        ((make_facts(name="weak"),), "'weak'"),
        (ONE_DIMENSION, "'line'"),
        (TWO, "of 1 models, here are 2"),
        ((make_facts(4),), "another model"),
        ((make_facts(names=("w", "b")),), "another model"),
    ],
)
def test_the_code_of_other_models_is_refused_by_name(facts: Facts, says: str) -> None:
    assert_refused(CODE, facts, says)


def test_a_name_out_of_a_code_is_shown_shortened_and_harmless() -> None:
    assert_refused(pack(latents(unpack(CODE), "name", "long\nname" * 25)), match="another model")


# --- anything at all ---
def test_a_zip_bomb_does_not_go_off() -> None:
    bomb = pack(b"0" * (5 * MAX_BYTES))
    assert len(bomb) < MAX_CODE_LENGTH  # it gets past the limit on a code's length
    tracemalloc.start()
    try:
        assert_refused(bomb)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 3 * MAX_BYTES


@given(st.text())
def test_any_text_is_harmless(text: str) -> None:
    assert_harmless(text)
    assert_harmless(PREFIX + text)


@given(st.binary())
def test_any_bytes_are_harmless(content: bytes) -> None:
    assert_harmless(PREFIX + base64.urlsafe_b64encode(content).decode())
    assert_harmless(pack(content))


@given(st.integers(0, len(CODE) - 1), st.characters())
def test_any_changed_character_is_harmless(index: int, character: str) -> None:
    assert_harmless(CODE[:index] + character + CODE[index + 1 :])


NUMBERS = st.integers(-(2**63), 2**64 - 1) | st.floats()
VALUES = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text(max_size=5) | st.binary(max_size=60),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=8,
)


def places(content: object) -> list[tuple[Any, Any]]:
    """Every container with every key in it."""
    keys = content if isinstance(content, dict) else range(len(content))  # type: ignore[arg-type]
    here = [(content, key) for key in keys]
    deeper = [content[key] for key in keys if isinstance(content[key], dict | list)]  # type: ignore[index]
    return here + [place for one in deeper for place in places(one)]


@settings(max_examples=150)
@given(st.data())
def test_any_values_in_a_sound_code_are_harmless(data: st.DataObject) -> None:
    content = unpack(CODE)
    for _ in range(data.draw(st.integers(1, 3))):
        container, key = data.draw(st.sampled_from(places(content)))
        old = container[key]
        near = st.just(old)
        if isinstance(old, int | float):
            near = st.floats(-2, 2) | st.integers(-2, 300) | st.booleans()
        container[key] = data.draw(near | VALUES)
    assert_harmless(pack(content))
