"""The CSV contract: what is read, what is refused, and with which words."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from rnnpb_explorer.core import InputError, Motion, write_motion
from rnnpb_explorer.core.motion import MAX_CSV_BYTES, MAX_FRAMES, format_motion
from rnnpb_explorer.robot.reading import Said, Unit, read_motion, read_motions

JOINTS = ("HeadPitch", "HeadYaw", "LHand")
PLAIN = "HeadPitch,HeadYaw,LHand\n0.1,0.2,0.3\n-1,2e-1,.5\n"
RADIANS = Said(unit="radians")
VALUES = np.array([[0.1, 0.2, 0.3], [-1.0, 0.2, 0.5]], dtype=np.float32)


def parse(
    text: str | bytes,
    said: Said | None = None,
    openings: Collection[str] = (),
    joints: tuple[str, ...] = JOINTS,
) -> Motion:
    content = text.encode() if isinstance(text, str) else text
    return read_motions(
        content, "walk.csv", joints, said=said, fps=25.0, limits={}, openings=openings
    ).motion()


def message(text: str | bytes, said: Said | None = None, openings: Collection[str] = ()) -> str:
    with pytest.raises(InputError) as caught:
        parse(text, said, openings)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        "HeadYaw,LHand,HeadPitch\n0.2,0.3,0.1\n0.2,0.5,-1\n",  # any order
        ",id,HeadPitch,HeadYaw,LHand,R0R\n0,walk,0.1,0.2,0.3,x\n1,walk,-1,0.2,0.5,\n",  # others
        "0.1,0.2,0.3\n-1,0.2,0.5\n",  # no header
        "HeadPitch;HeadYaw;LHand\n0,1;0,2;0,3\n-1;0,2;,5\n",  # decimal commas
        "0,1;0,2;0,3\n-1;0,2;0,5\n",
        "HeadPitch\tHeadYaw\tLHand\n0,1\t0.2\t0.3\n-1\t0.2\t0.5\n",
        "\n \nHeadPitch, HeadYaw , LHand\n\n0.1, 0.2,0.3\n\n-1,0.2,0.5\n\n",  # blank lines, spaces
        '"HeadPitch","HeadYaw","LHand"\n"0.1","0.2","0.3"\n"-1","0.2","0.5"',
        PLAIN + ",,\n,,\n",  # the empty rows that a spreadsheet leaves at the end
        '"note, with comma",HeadPitch,HeadYaw,LHand\n"a\nb",0.1,0.2,0.3\nc,-1,0.2,0.5\n',
    ],
)
@pytest.mark.parametrize("bom", ["", "\ufeff"])
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_reads(text: str, bom: str, newline: str) -> None:
    motion = parse(bom + text.replace("\n", newline))
    np.testing.assert_array_equal(motion.positions, VALUES)
    assert motion.positions.dtype == np.float32
    assert (motion.name, motion.joints, motion.fps) == ("walk", JOINTS, 25.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "walk.csv is empty"),
        ("\n \n,,,\n", "walk.csv is empty"),
        ("HeadPitch,LHand\n1,2\n1,2\n", "no column for HeadYaw"),
        ("a,b,c\n1,2,3\n", "no column for HeadPitch, HeadYaw, LHand"),
        ("HeadPitch,HeadYaw,LHand,HeadYaw\n1,2,0,1\n1,2,0,1\n", "more than one column for HeadYaw"),
        ("1,2\n1,2\n", "no header and 2 columns; without a header there must be exactly 3"),
        ("1,2,3,4\n1,2,3,4\n", "no header and 4 columns"),
        ("HeadPitch,HeadYaw,LHand\n", "a header and no frames"),
        ("HeadPitch,HeadYaw,LHand\n1,2,0\n", "1 frame; a motion has from 2 to"),
        ("1,2,3\n", "1 frame;"),
        (PLAIN + "1,2\n", "row 4: 2 columns, expected 3"),
        (PLAIN + "1,2,3,4\n", "row 4: 4 columns, expected 3"),
        (PLAIN + "1,,3\n", "row 4, column HeadYaw: the cell is empty"),
        (PLAIN + ",,\n1,2,3\n", "row 4, column HeadPitch: the cell is empty"),
        (PLAIN + "\n1,abc,3\n", "row 5, column HeadYaw: 'abc' is no number"),
        (PLAIN + "1,nan,3\n", "row 4, column HeadYaw: nan is not finite"),
        (PLAIN + "1,-Infinity,3\n", "row 4, column HeadYaw: -Infinity is not finite"),
        (PLAIN + "1,1e999,3\n", "row 4, column HeadYaw: 1e999 is not finite"),
        (PLAIN + "1,1_0,3\n", "'1_0' is no number"),
        (PLAIN + "1,0x1,3\n", "'0x1' is no number"),
        (PLAIN + "1,\u0661,3\n", "is no number"),  # an Arabic digit, which float() would take
        (PLAIN + "1,90,0\n", "row 4, column HeadYaw: 90 is no plausible angle in radians"),
        (PLAIN + '1,"2,3\n', "row 4: this is not CSV"),
        ("nan,2,3\n1,2,3\n", "row 1, column HeadPitch: nan is not finite"),
        # A pattern with two ways to take a digit would look at these for hours.
        (PLAIN + f"1,{'1' * 100_000}x,3\n", f"'{'1' * 20}' is no number"),
        ("0.1,text,0.3\n1,2,3\n", "row 1, column HeadYaw: 'text' is no number"),
        ("HeadPitch;HeadYaw;LHand\n1.234,5;1;1\n1;1;1\n", "row 2, column HeadPitch: '1.234,5'"),
        ("h," * 3 + "x" * 200_000 + "\n", "not CSV: field larger than field limit"),
    ],
)
def test_refuses(text: str, words: str) -> None:
    said = message(text)
    assert words in said
    assert said.startswith("walk.csv")


def test_refuses_what_is_no_text() -> None:
    assert "no text" in message(bytes(range(256)))


def test_degrees_only_when_asked_for_and_never_for_openings() -> None:
    text = "HeadPitch,HeadYaw,LHand\n90,-45,0.5\n0,10,1\n"
    assert "is the file in degrees" in message(text)
    motion = parse(text, Said(unit="degrees"), openings={"LHand"})
    expected = [[np.pi / 2, -np.pi / 4, 0.5], [0.0, np.pi / 18, 1.0]]
    np.testing.assert_allclose(motion.positions, expected, rtol=1e-6)
    far = message(text + "7300,0,0\n", Said(unit="degrees"))
    assert "row 4, column HeadPitch: 127.409 is no plausible angle in radians" in far


@pytest.mark.parametrize("unit", ["radians", "degrees"])
@pytest.mark.parametrize("value", [500, -7, -2.5])
def test_an_opening_is_bounded_in_any_unit(unit: Unit, value: float) -> None:
    text = f"HeadPitch,HeadYaw,LHand\n0.1,0.2,1.2\n0.1,0.2,{value}\n"
    said = message(text, Said(unit=unit), openings={"LHand"})
    assert said == (
        f"walk.csv, row 3, column LHand: {value:g} is no plausible opening (from 0 to 1, or to 100 "
        "in per cent)"
    )


def test_size_limits() -> None:
    assert "too large" in message(b"1,2,3\n" * (MAX_CSV_BYTES // 6 + 1))
    assert f"from 2 to {MAX_FRAMES}" in message("1,2,3\n" * (MAX_FRAMES + 1))
    assert len(parse("1,2,3\n" * MAX_FRAMES)) == MAX_FRAMES


def test_no_file(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.csv", Path("nul\0l")):
        with pytest.raises(InputError):
            read_motion(path, JOINTS)


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "walk.csv"
    path.write_text("precious")
    unprintable = Motion("walk", ("\ud800",), np.zeros((2, 1), dtype=np.float32))
    with pytest.raises(UnicodeEncodeError):
        write_motion(unprintable, path)
    assert path.read_text() == "precious"
    with pytest.raises(InputError, match="no folder"):
        write_motion(parse(PLAIN), tmp_path / "none" / "walk.csv")
    assert list(tmp_path.iterdir()) == [path]


NAMES = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Z")), min_size=1, max_size=12
).filter(lambda name: name == name.strip() and not name.startswith("\ufeff"))


@st.composite
def motions(draw: st.DrawFn) -> Motion:
    joints = draw(st.lists(NAMES, min_size=1, max_size=6, unique=True))
    shape = (draw(st.integers(2, 6)), len(joints))
    values = st.floats(-12.5, 12.5, width=32)
    positions = draw(arrays.arrays(np.float32, shape, elements=values))
    return Motion("x", tuple(joints), positions)


@given(motions())
@example(Motion("x", (";",), np.zeros((2, 1), dtype=np.float32)))
def test_round_trip_is_exact(motion: Motion) -> None:
    back = parse(format_motion(motion).encode(), RADIANS, joints=motion.joints)
    assert back.positions.tobytes() == motion.positions.tobytes()


@given(motions(), st.randoms(), st.sampled_from(",;\t"), st.booleans(), st.sampled_from("\n\r"))
def test_columns_in_any_order_and_dress(
    motion: Motion, random: object, delimiter: str, bom: bool, newline: str
) -> None:
    assume(not any(c in name for name in motion.joints for c in ',;"'))
    order = list(range(len(motion.joints)))
    random.shuffle(order)  # type: ignore[attr-defined]
    extra = max(motion.joints, key=len) + "_extra"
    rows = [[*(motion.joints[i] for i in order), extra]]
    rows += [[*(f"{row[i]:.9g}" for i in order), "ignored"] for row in motion.positions]
    text = newline.join(delimiter.join(row) for row in rows)
    content = text.encode("utf-8-sig" if bom else "utf-8")
    back = parse(content, RADIANS, joints=motion.joints)
    assert back.positions.tobytes() == motion.positions.tobytes()


@given(
    st.binary(max_size=300)
    | st.text(alphabet='HeadPitchYaw,LHand;\t\n\r"01.5e-naif\0\ufeff', max_size=300).map(
        str.encode
    ),
    st.sampled_from(["", PLAIN]),
)
def test_whatever_comes_in_only_input_errors_come_out(content: bytes, before: str) -> None:
    try:
        motion = parse(before.encode() + content)
    except InputError:
        return
    assert np.isfinite(motion.positions).all()
    assert motion.positions.shape == (len(motion), len(JOINTS))
