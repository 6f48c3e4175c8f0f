"""Files as people have them (tests/field): read, asked about, or refused in words."""

from __future__ import annotations

import json
import random
import re
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.motion import Motion, format_motion
from rnnpb_explorer.core.recognition import recognize
from rnnpb_explorer.core.recognition_run import RecognitionConfig, RecognitionResult
from rnnpb_explorer.robot.description import load_robot
from rnnpb_explorer.robot.export import export_motion
from rnnpb_explorer.robot.formats import FORMATS
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS
from rnnpb_explorer.robot.reading import Reading, Said, Unclear, read_motions

FIELD = Path(__file__).parents[1] / "field" / "motions"
ANGLES = [i for i, joint in enumerate(PEPPER_JOINTS) if not joint.endswith("Hand")]


def read(name: str, said: Said | None = None) -> Reading:
    return read_motions((FIELD / name).read_bytes(), name, PEPPER_JOINTS, said=said, fps=25.0)


def words(name: str, said: Said | None = None) -> str:
    """Why it is refused, in one line."""
    with pytest.raises(InputError) as refused:
        read(name, said)
    line = str(refused.value)
    assert "\n" not in line
    assert line.startswith(name)
    return line


@pytest.fixture(scope="module")
def control() -> NDArray[np.float32]:
    return read("00-control.csv").motion().positions


# --- what is read ---
@pytest.mark.parametrize(
    ("name", "remark"),
    [
        ("00-control.csv", ""),
        ("comment-lines.csv", ""),
        ("decimal-comma.csv", ""),
        ("sep-line.csv", ""),
        ("trailing-comma-rows.csv", ""),
        ("headerless-space.txt", ""),
        ("header-numpy-hash.csv", ""),
        ("header-lower.csv", "headpitch for HeadPitch"),
        ("header-unit-suffix.csv", "HeadPitch [rad] for HeadPitch"),
        ("header-plotjuggler.csv", "/joint_states/HeadPitch/position"),
        ("rostopic-echo-p.csv", ""),
        ("webots.motion", ""),
        ("utf16.csv", "UTF-16"),
        ("latin1-comment-column.csv", "left out: Bemerkung"),
    ],
)
def test_the_same_motion_in_other_dress(
    name: str, remark: str, control: NDArray[np.float32]
) -> None:
    reading = read(name)
    motion = reading.motion()
    assert motion.joints == PEPPER_JOINTS
    assert motion.fps == reading.fps == 25.0
    np.testing.assert_allclose(motion.positions, control, atol=1e-6)
    assert any(remark in one for one in reading.remarks) if remark else not reading.remarks


def test_a_faster_recording_is_brought_to_the_models_rate(control: NDArray[np.float32]) -> None:
    reading = read("rate-100hz-with-time.csv")
    motion = reading.motion()
    assert (reading.fps, motion.fps) == (100.0, 25.0)
    assert any("100 Hz" in one and "resampled to 25 Hz" in one for one in reading.remarks)
    np.testing.assert_allclose(motion.positions[: len(control)], control, atol=1e-6)


def test_degrees_that_can_be_nothing_else(control: NDArray[np.float32]) -> None:
    for name in ("degrees-large.csv", "degrees-small.csv"):
        reading = read(name)
        assert reading.unit == "degrees"
        assert any(one.startswith("in degrees") for one in reading.remarks)
    positions = read("degrees-large.csv").motion().positions
    np.testing.assert_allclose(positions, control, atol=1e-3)
    said = read("degrees-large.csv", Said(unit="degrees"))
    np.testing.assert_array_equal(said.motion().positions, positions)


def test_degrees_that_may_be_radians_are_left_as_they_are() -> None:
    """A slow turn of the head by a degree is as good as one of a radian."""
    content = b"HeadYaw,LElbowYaw\n1,0.5\n1.2,0.4\n"
    reading = read_motions(content, "x.csv", ("HeadYaw", "LElbowYaw"))
    assert reading.unit == "radians"
    assert reading.motion().positions[0, 0] == 1


def test_hands_in_per_cent(control: NDArray[np.float32]) -> None:
    reading = read("hand-percent.csv")
    assert "hands in per cent" in reading.remarks
    np.testing.assert_allclose(reading.motion().positions, control, atol=1e-3)


def test_several_motions_are_told_apart(control: NDArray[np.float32]) -> None:
    reading = read("two-motions-id-column.csv")
    assert [motion.name for motion in reading.motions] == ["A", "B"]
    np.testing.assert_allclose(reading.motion("A").positions, control, atol=1e-6)
    with pytest.raises(Unclear, match="2 motions: A, B") as unclear:
        reading.motion()
    assert (unclear.value.question, unclear.value.choices) == ("motion", ("A", "B"))
    with pytest.raises(Unclear, match="no motion 'C'"):
        reading.motion("C")


def test_peppers_own_animations() -> None:
    reading = read("animation.qianim")
    motion = reading.motion()
    assert (reading.format, len(motion)) == ("Pepper animation", 26)
    yaw, hand = motion.positions[
        :, [PEPPER_JOINTS.index("HeadYaw"), PEPPER_JOINTS.index("LHand")]
    ].T
    np.testing.assert_allclose(yaw, np.radians(np.linspace(0, 4.962, 26)), atol=1e-6)
    np.testing.assert_allclose(hand, np.linspace(0.6, 0.6866, 26), atol=1e-6)


def test_a_choregraphe_script() -> None:
    motion = read("choregraphe-simple.py").motion()
    assert len(motion) == 21  # from the first key at 0.4 s to the last at 1.2 s
    yaw = motion.positions[:, PEPPER_JOINTS.index("HeadYaw")]
    np.testing.assert_allclose(yaw[[0, 5, 10, 20]], [0, 0.0433, 0.0866, -0.0866], atol=1e-6)


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("empty-cells-merge.csv", "row 3, column HeadPitch: the cell is empty"),
        ("nan-first-row.csv", "row 2, column HeadPitch: nan is not finite"),
        ("upper-body-only.csv", "no column for HipPitch, HipRoll, KneePitch, LHand, RHand"),
        ("lafan-36col.csv", "36 columns are a Unitree G1"),
        ("poppy-move.json", "seems to be a move recorded on a Poppy robot"),
        ("joint-trajectory.json", "seems to be a ROS joint trajectory"),
    ],
)
def test_what_is_refused_says_what_would_be_right(name: str, line: str) -> None:
    assert line in words(name)


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"HIERARCHY\nROOT Hips\n", "motion capture (BVH)"),
        (b"PAR1\x15\x04", "LeRobot"),
        (b"PK\x03\x04....poses.npy....", "AMASS"),
        (b"PK\x03\x04....xl/workbook.xml", "save the sheet as CSV"),
        (b"\x93NUMPY\x01\x00", "numpy.savetxt"),
        (b'<?xml version="1.0"?><ChoregrapheProject/>', "a Choregraphe behaviour"),
        (b'<?xml version="1.0"?><Package name="x"/>', "a Choregraphe project"),
        (b'<?xml version="1.0"?><robot name="x"/>', "--robot"),
        (b"#ROSBAG V2.0\n", "rostopic echo -p"),
    ],
)
def test_other_kinds_of_motion_are_known_by_sight(content: bytes, line: str) -> None:
    with pytest.raises(InputError) as refused:
        read_motions(content, "x.any", PEPPER_JOINTS)
    assert line in str(refused.value)
    assert "\n" not in str(refused.value)


# --- the formats against each other ---
def _ros1(motion: Motion) -> str:
    return "".join(
        f"header: \n  seq: {i}\n  stamp: \n    secs: 17\n    nsecs: {i * 40_000_000}\n"
        f"  frame_id: ''\nname: [{', '.join(motion.joints)}]\n"
        f"position: [{', '.join(map(repr, row))}]\nvelocity: []\neffort: []\n---\n"
        for i, row in enumerate(motion.positions.tolist())
    )


def _ros2(motion: Motion) -> str:
    def listed(values: list[str]) -> str:
        return "".join(f"- {value}\n" for value in values)

    return "".join(
        f"header:\n  stamp:\n    sec: 17\n    nanosec: {i * 40_000_000}\n  frame_id: base\nname:\n"
        f"{listed(list(motion.joints))}position:\n{listed(list(map(repr, row)))}velocity: []\n---\n"
        for i, row in enumerate(motion.positions.tolist())
    )


def _ros2_csv(motion: Motion) -> str:
    return "".join(
        f"17,{i * 40_000_000},base,{','.join(motion.joints)},{','.join(map(repr, row))}\n"
        for i, row in enumerate(motion.positions.tolist())
    )


def _almemory(motion: Motion) -> str:
    names = [f"Device/SubDeviceList/{joint}/Position/Sensor/Value" for joint in motion.joints]
    rows = [",".join(map(repr, row)) for row in motion.positions.tolist()]
    return "\n".join([",".join(names), *rows])


def _formatted(motion: Motion) -> str:
    """A script of ours after a formatter has been over it."""
    script = export_motion(motion, load_robot("pepper"), "naoqi", enforce_limits=False).content
    script = re.sub(r'"(\w+)"', r"'\1'", script)
    script = re.sub(r", (?=\d|-|')", ",\n    ", script)
    return re.sub(r"\]\n", ",\n]\n", script, count=1)


def _bezier(motion: Motion) -> str:
    """Key frames at every frame, with handles on the straight line between them."""
    lines = ["names = list()", "times = list()", "keys = list()"]
    at = [round(0.04 * (i + 1), 6) for i in range(len(motion))]
    for joint, values in zip(motion.joints, motion.positions.T.tolist(), strict=True):
        slopes = np.gradient(values).tolist()
        keys = [
            [value, [3, -0.04 / 3, -slope / 3], [3, 0.04 / 3, slope / 3]]
            for value, slope in zip(values, slopes, strict=True)
        ]
        lines += [f'names.append("{joint}")', f"times.append({at})", f"keys.append({keys})"]
    return "\n".join([*lines, "motion.angleInterpolationBezier(names, times, keys)"])


def _table(motion: Motion, delimiter: str) -> str:
    rows = [motion.joints, *(map(repr, row) for row in motion.positions.tolist())]
    return "\n".join(delimiter.join(row) for row in rows)


@pytest.mark.parametrize(
    ("name", "write", "tolerance"),
    [
        ("x.txt", _ros1, 1e-6),
        ("x.yaml", _ros2, 1e-6),
        ("x.csv", _ros2_csv, 1e-6),
        ("x.csv", _almemory, 1e-6),
        ("x.py", _formatted, 1e-6),
        ("x.py", _bezier, 1e-3),
        ("x.tsv", lambda motion: _table(motion, "\t"), 1e-6),
        ("x.csv", lambda motion: _table(motion, ";"), 1e-6),
        ("x.txt", lambda motion: _table(motion, "  "), 1e-6),
        ("x.csv", format_motion, 0),
    ],
)
def test_every_format_brings_the_joints(
    name: str,
    write,
    tolerance: float,
    control: NDArray[np.float32],  # type: ignore[no-untyped-def]
) -> None:
    motion = Motion("x", PEPPER_JOINTS, control)
    reading = read_motions(write(motion).encode(), name, PEPPER_JOINTS, fps=25.0)
    back = reading.motion()
    assert (back.joints, back.fps, len(back)) == (PEPPER_JOINTS, 25.0, len(control))
    np.testing.assert_allclose(back.positions, control, atol=tolerance)


@pytest.mark.parametrize("file_format", FORMATS)
def test_our_own_files_come_back(file_format: str, control: NDArray[np.float32]) -> None:
    motion = Motion("x", PEPPER_JOINTS, control)
    robot = load_robot("pepper")
    export = export_motion(
        motion,
        robot,
        file_format,
        safe_posture=file_format != "csv",
        enforce_limits=False,  # type: ignore[arg-type]
    )
    back = read_motions(export.content.encode(), f"x{export.suffix}", PEPPER_JOINTS).motion()
    np.testing.assert_allclose(back.positions, control, atol=1e-6)


EASED = """
names = ["HeadYaw"]
times = [[0.5, 1.5]]
keys = [[[0.0, [3, -0.1, 0.0], [3, {after}, 0.0]], [1.0, [3, {before}, 0.0], [3, 0.1, 0.0]]]]
"""
EASED_QIANIM = """<Animation><ActuatorCurve actuator="HeadYaw" unit="radian" fps="10">
<Key frame="0" value="0"><Tangent side="right" interpType="bezier" abscissaParam="{after}"
ordinateParam="0"/></Key>
<Key frame="10" value="1"><Tangent side="left" interpType="bezier_auto" abscissaParam="{before}"
ordinateParam="0"/></Key></ActuatorCurve></Animation>"""


@pytest.mark.parametrize(
    ("name", "text", "unit"), [("x.py", EASED, 1), ("x.qianim", EASED_QIANIM, 10)]
)
def test_handles_bend_the_way_between_keys(name: str, text: str, unit: float) -> None:
    """With handles of a third of the way time is the parameter itself, and the way is known."""
    content = text.format(after=unit / 3, before=-unit / 3).encode()
    motion = read_motions(content, name, ("HeadYaw",), fps=25.0).motion()
    t = np.arange(26) / 25
    np.testing.assert_allclose(motion.positions[:, 0], 3 * t**2 - 2 * t**3, atol=1e-3)
    # A long handle after the first key and none before the last: time runs ahead of the parameter.
    content = text.format(after=0.9 * unit, before=0).encode()
    late = read_motions(content, name, ("HeadYaw",), fps=25.0).motion().positions[:, 0]
    u = np.linspace(0, 1, 2001)
    at = 3 * 0.9 * u * (1 - u) ** 2 + 3 * u**2 * (1 - u) + u**3
    np.testing.assert_allclose(late, np.interp(t, at, 3 * u**2 - 2 * u**3), atol=2e-3)


def test_a_first_line_may_say_what_separates() -> None:
    motion = read_motions(b"sep=|\nHeadYaw|RHand\n0.1|0.5\n0.2|0.6\n", "x.csv", ("RHand",)).motion()
    np.testing.assert_allclose(motion.positions[:, 0], [0.5, 0.6])


def test_a_script_is_read_not_run(tmp_path: Path) -> None:
    mark = tmp_path / "ran"
    with pytest.raises(InputError, match="neither a script that was exported here nor"):
        read_motions(f"open({str(mark)!r}, 'w')\nnames = open('y')".encode(), "x.py", PEPPER_JOINTS)
    assert not mark.exists()


# --- names, time, units: what is not guessed ---
def test_two_columns_that_can_be_meant_are_named() -> None:
    content = b"a/HeadYaw/x,b/HeadYaw/x\n0,0\n0,0\n"
    with pytest.raises(InputError, match="more than one column for HeadYaw: 'a/HeadYaw/x' or 'b"):
        read_motions(content, "x.csv", ("HeadYaw",))


def test_a_velocity_is_no_position() -> None:
    content = b"HeadYaw_position,HeadYaw_velocity\n0.1,5\n0.2,5\n"
    motion = read_motions(content, "x.csv", ("HeadYaw",)).motion()
    np.testing.assert_allclose(motion.positions[:, 0], [0.1, 0.2])


@pytest.mark.parametrize(
    ("stamps", "fps"),
    [
        ("0,0.02,0.04,0.06", 50.0),
        ("0,20,40,60", 50.0),  # ms
        ("1700000000.0,1700000000.02,1700000000.04,1700000000.06", 50.0),
        ("1700000000000000000,1700000000020000000,1700000000040000000,1700000000060000000", 50.0),
        ("0,1,2,3", 25.0),  # counts frames
    ],
)
def test_stamps_of_any_unit(stamps: str, fps: float) -> None:
    rows = "".join(f"{stamp},0.1\n" for stamp in stamps.split(","))
    reading = read_motions(f"time,HeadYaw\n{rows}".encode(), "x.csv", ("HeadYaw",), fps=25.0)
    assert reading.fps == pytest.approx(fps, abs=0.05)
    assert (reading.fps_source == "assumed") == (fps == 25.0)


def test_stamps_that_go_back_are_refused_and_gaps_are_named() -> None:
    back = b"time,HeadYaw\n0,0\n0.04,0\n0.02,0\n0.08,0\n"
    with pytest.raises(InputError, match=r"column time: frame 3 is at 0\.02, not after"):
        read_motions(back, "x.csv", ("HeadYaw",))
    rows = "".join(f"{0.04 * i + (1.0 if i > 5 else 0):g},{0.01 * i:g}\n" for i in range(12))
    reading = read_motions(f"time,HeadYaw\n{rows}".encode(), "x.csv", ("HeadYaw",), fps=25.0)
    assert any("nothing for 1.04 s after frame 6" in one for one in reading.remarks)
    assert len(reading.motion()) == 37  # the way over the gap is straight
    np.testing.assert_allclose(reading.motion().positions[18, 0], 0.055, atol=1e-3)


def test_what_is_said_counts_where_the_file_does_not_say() -> None:
    content = b"HeadYaw\n0\n0.1\n0.2\n"
    reading = read_motions(content, "x.csv", ("HeadYaw",), said=Said(fps=12.5), fps=25.0)
    assert (reading.fps, reading.fps_source) == (12.5, "said")
    np.testing.assert_allclose(reading.motion().positions[:, 0], [0, 0.05, 0.1, 0.15, 0.2])


def test_who_says_a_rate_is_believed_over_stamps() -> None:
    content = b"time,HeadYaw\n0,0\n0.01,0.1\n0.02,0.2\n"
    reading = read_motions(content, "x.csv", ("HeadYaw",), said=Said(fps=50.0))
    assert (reading.fps, reading.fps_source, reading.left_out) == (50.0, "said", ())


def test_a_file_that_says_its_unit_is_believed() -> None:
    script = export_motion(
        Motion("x", PEPPER_JOINTS, np.zeros((3, 17), np.float32)), load_robot("pepper"), "json",
        enforce_limits=False,
    ).content  # fmt: skip
    with pytest.raises(InputError, match="is in radians, as JSON files are"):
        read_motions(script.encode(), "x.json", PEPPER_JOINTS, said=Said(unit="degrees"))


@pytest.mark.parametrize("value", ["20", "57"])
def test_hands_that_can_be_per_cent_or_degrees_are_asked_about(value: str) -> None:
    content = f"RHand\n0\n{value}\n".encode()
    with pytest.raises(Unclear, match="is it per cent, or degrees") as unclear:
        read_motions(content, "x.csv", ("RHand",))
    assert unclear.value.question == "hands"
    share = read_motions(content, "x.csv", ("RHand",), said=Said(hands="percent")).motion()
    assert share.positions[1, 0] == pytest.approx(float(value) / 100)


# --- recognition does not care how a file is written ---
def test_another_rate_and_another_unit_are_recognised_alike(strong: RNNPB) -> None:
    index = strong.motion_index("Happy_4")
    positions = strong.reconstruct(index).numpy()
    joints = strong.info.joints
    degrees = positions.astype(np.float64)
    angles = [i for i, joint in enumerate(joints) if not joint.endswith("Hand")]
    degrees[:, angles] = np.degrees(degrees[:, angles])
    half = np.arange(2 * len(positions) - 1) / 2
    fast = np.column_stack(
        [np.interp(half, np.arange(len(positions)), column) for column in positions.T]
    )
    stamps = np.arange(len(fast)) * 0.02

    def rows(values: NDArray[np.float64]) -> str:
        return "\n".join(",".join(f"{value:.9g}" for value in row) for row in values)

    plain = ",".join(joints)
    files = [
        f"{plain}\n{rows(positions)}",
        f"{plain}\n{rows(degrees)}",
        f"time,{plain}\n{rows(np.column_stack([stamps, fast]))}",
    ]
    errors = []
    for content in files:
        motion = read_motions(content.encode(), "x.csv", joints, fps=strong.info.fps).motion()
        assert len(motion) == len(positions)
        run = RecognitionResult.from_steps(
            recognize(strong, motion.positions, RecognitionConfig(iterations=15, trials=2))
        )
        errors.append(run.reconstruction_loss.mean())
    np.testing.assert_allclose(errors[1:], errors[0], rtol=0.05)


# --- whatever comes in ---
SEEDS = 40  # mutations of each file
INNER = re.compile(r"Error\b|Traceback|object at 0x|NoneType|invalid literal|codec")


ODD = (b"\0", b"nan", b"1e999", b"[" * 50, b'"', b"\xff\xfe", b"-", b",", b";", b"\n\n")


def _mutated(content: bytes, rng: random.Random) -> bytes:
    """Bytes lost, doubled, swapped, changed; pieces cut out and put elsewhere."""
    data = bytearray(content)
    for _ in range(rng.randint(1, 4)):
        at, size = rng.randrange(len(data) + 1), rng.choice((1, 3, 20, 200))
        match rng.randrange(6):
            case 0:
                del data[at : at + size]
            case 1:
                data[at:at] = data[at : at + size] * rng.choice((1, 2, 50))
            case 2:
                data[at:at] = rng.choice(
                    (
                        b"\0",
                        b"nan",
                        b"1e999",
                        b"[" * 50,
                        b'"',
                        b"\xff\xfe",
                        b"-",
                        b",",
                        b";",
                        b"\n\n",
                    )
                )
            case 3:
                for i in range(at, min(at + size, len(data))):
                    data[i] = rng.randrange(256)
            case 4:
                other = rng.randrange(len(data) + 1)
                data[at : at + size], data[other : other + size] = (
                    data[other : other + size],
                    data[at : at + size],
                )
            case 5:
                data = data[:at]
        if not data:
            return b""
    return bytes(data)


def _exports() -> list[tuple[str, bytes]]:
    motion = Motion("x", PEPPER_JOINTS, np.full((6, 17), 0.3, np.float32))
    robot = load_robot("pepper")
    return [
        (f"x{export.suffix}", export.content.encode())
        for export in (export_motion(motion, robot, one, enforce_limits=False) for one in FORMATS)
    ] + [("x.txt", _ros1(motion).encode()), ("x.yaml", _ros2(motion).encode())]


@pytest.mark.parametrize("joints", [PEPPER_JOINTS, None], ids=["Pepper", "any"])
def test_whatever_comes_in_is_a_motion_or_one_line(joints: tuple[str, ...] | None) -> None:
    files = [(file.name, file.read_bytes()) for file in sorted(FIELD.iterdir())] + _exports()
    rng = random.Random(7)
    for name, content in files:
        for _ in range(SEEDS):
            spoiled = _mutated(content, rng)
            began = time.perf_counter()
            try:
                reading = read_motions(spoiled, name, joints, fps=25.0)
            except InputError as refused:
                line = str(refused)
                assert "\n" not in line, (name, line)
                assert len(line) < 1500, (name, line)
                assert not INNER.search(line), (name, line)
            else:
                for motion in reading.motions:
                    assert np.isfinite(motion.positions).all(), name
                assert not any("\n" in remark for remark in reading.remarks)
            assert time.perf_counter() - began < 20, name  # only what would never end


@pytest.mark.parametrize(
    "value",
    [
        "[" * 100_000,
        "\n" + "- " * 100_000,
        "\n" + "[\n" * 100_000,
        "\n" + "? " * 100_000,
        "&a [*a]",
    ],
    ids=["lists", "dashes", "lines", "keys", "references"],
)
def test_messages_that_nest_deep_are_refused_before_they_are_parsed(value: str) -> None:
    """The parser would take the whole process down."""
    with pytest.raises(InputError, match="this is no line of a printed joint state"):
        read_motions(f"name:\nposition: {value}".encode(), "x.yaml", PEPPER_JOINTS)


@pytest.mark.parametrize("end", ["9e9", "1e15", "1000"])
def test_stamps_that_are_far_apart_are_refused_before_there_are_frames(end: str) -> None:
    rows = "".join(f"{0.001 * i:g},0\n" for i in range(6))
    content = f"time,HeadYaw\n{rows}{end},0\n".encode()
    with pytest.raises(InputError, match="frames; a motion has at most 5,000"):
        read_motions(content, "x.csv", ("HeadYaw",), fps=25.0)


def test_a_large_file_is_not_read() -> None:
    for name in ("x.json", "x.py", "x.qianim"):
        with pytest.raises(InputError, match="too large; at most 4 MB"):
            read_motions(b" {" + b" " * 4_100_000, name, PEPPER_JOINTS)


def test_a_table_that_begins_often_and_never_ends_is_looked_at_once() -> None:
    """Each of these beginnings, followed to the end of the file, would take hours in all."""
    content = ("\nANGLES = [\n" * 300_000).encode()
    with pytest.raises(InputError, match="neither a script"):
        read_motions(content, "x.py", PEPPER_JOINTS)


def test_json_that_is_no_export_is_one_plain_line() -> None:
    for content in ("{", "[]", "[" * 100_000, json.dumps({"format": "other"}), '{"format": 1}'):
        with pytest.raises(InputError, match=r"^x\.json.* (JSON|array)") as refused:
            read_motions(content.encode(), "x.json", PEPPER_JOINTS)
        assert "\n" not in str(refused.value)
