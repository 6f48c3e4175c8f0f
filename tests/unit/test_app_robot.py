"""The robot on the screen: the safety light, the limited motion, export, eyes, other robots."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import viser
from arm import write_arm

from rnnpb_explorer.app.page.panels.robot import (
    INSISTED,
    RobotPanel,
    SafetyLight,
    joint_lines,
    note_html,
    report_html,
)
from rnnpb_explorer.app.page.panels.view import ViewPanel
from rnnpb_explorer.app.page.robots import Robots, robot_names
from rnnpb_explorer.app.page.stage import stage_for
from rnnpb_explorer.app.page.uploads import read_upload
from rnnpb_explorer.app.page.words import export_summary, light_words, safety_lines
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import (
    AppState,
    CheckedMotion,
    ExportOptions,
    initial_state,
)
from rnnpb_explorer.app.state.transitions import Facts, eyes_of
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.core.motion import Motion, format_motion
from rnnpb_explorer.robot.description import Robot, load_robot, match_joints
from rnnpb_explorer.robot.export import export_motion
from rnnpb_explorer.robot.pepper import EYE_COLUMNS
from rnnpb_explorer.robot.safety_report import SafetyReport, Violation

from .app_states import FACTS, JOINTS, after, make_facts, motions, open_screen, target_motion

PAIR = (make_facts(name="one"), make_facts(name="two"))
TRACK = np.random.default_rng(0).random((10, 2, 8, 3)).astype(np.float32)
FAST = Violation("velocity", "a", 12, 15, 8.94, 7.3, 1.22)
FAR = Violation("position", "<b>", 3, 3, -2.5, -2.0, 0.5)


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    return load_robot(str(write_arm(tmp_path_factory.mktemp("robot"))))


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    running = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield running
    running.stop()


@pytest.fixture
def gui(server: viser.ViserServer) -> Iterator[viser.GuiApi]:
    yield server.gui
    server.gui.reset()


@pytest.fixture
def scene(server: viser.ViserServer) -> Iterator[viser.SceneApi]:
    yield server.scene
    server.scene.reset()


def report(*violations: Violation) -> SafetyReport:
    return SafetyReport(violations, ())


def checked(
    state: AppState, *violations: Violation, request: int = 99, limited: float | None = None
) -> AppState:
    """The state once its motion was checked."""
    motion = state.current.motion
    assert motion is not None
    within = None if limited is None else np.full_like(motion.positions, limited)
    result = CheckedMotion(request, report(*violations), within)
    return after(FACTS, state, do.MotionChecked(state.active, result))


# --- the safety light ---
def test_the_light_says_which_joints_and_frames() -> None:
    state = checked(open_screen(), FAST)
    assert safety_lines(report(FAST)) == ["a: velocity 8.9 rad/s over 7.3, frames 12–15"]
    assert "a: velocity 8.9 rad/s over 7.3, frames 12–15" in report_html(state)
    assert light_words(report(FAST)) == "1 joint a little beyond the limits"
    assert light_words(report(FAST, FAR)) == "1 joint far beyond the limits"
    assert light_words(report()) == "within the robot's limits"


def test_many_faults_are_few_lines() -> None:
    again = [Violation("velocity", "a", n, n + 1, 8.0, 7.3, 1.1) for n in range(20, 60, 8)]
    (line,) = safety_lines(report(FAST, *again))
    assert line == "a: velocity 8.9 rad/s over 7.3, frames 12–15, 20–21, 28–29 and 3 more times"
    many = [Violation("position", f"j{n}", 1, 1, 3.0, 2.0, 1.0) for n in range(17)]
    lines = safety_lines(report(*many))
    assert len(lines) == 5
    assert lines[-1] == "and 13 more"


def test_names_from_anywhere_stay_text() -> None:
    state = checked(open_screen(), FAR)
    for html in (report_html(state), note_html(state)):
        assert "&lt;b&gt;" in html
        assert "<b>" not in html


def test_the_light_is_of_the_active_model(gui: viser.GuiApi, arm: Robot) -> None:
    light = SafetyLight(gui, PAIR, arm)
    state = open_screen(PAIR)
    for model, violations in ((0, ()), (1, (FAST,))):
        result = CheckedMotion(99, report(*violations), None)
        state = after(PAIR, state, do.MotionChecked(model, result))
    light.show(state)
    assert "within the robot" in light._html.content
    assert "; 1 not on it" in light._html.content  # the arm has no joint e
    light.show(after(PAIR, state, do.SelectModel(1)))
    assert "a little beyond" in light._html.content


def test_an_older_check_does_not_replace_a_newer_one() -> None:
    state = checked(open_screen(), FAST, request=9)
    assert checked(state, request=8).current.checked is state.current.checked
    newer = checked(state, request=10).current.checked
    assert newer is not None
    assert newer.report.light == "green"


# --- raw and limited ---
def test_the_limited_motion_is_made_only_while_it_is_seen() -> None:
    state = open_screen()
    assert [work.limited for work in motions(update(FACTS, state, do.SetMu(0, 0.1))[1])] == [False]
    state, works = update(FACTS, state, do.SetSideBySide(True))
    assert [work.limited for work in motions(works)] == [True]
    assert [work.limited for work in motions(update(FACTS, state, do.SetMu(0, 0.1))[1])] == [True]
    assert update(FACTS, state, do.SetSideBySide(True)) == (state, ())
    state, works = update(FACTS, state, do.SetSideBySide(False))
    assert (state.side_by_side, works) == (False, ())


def test_the_limited_motion_is_the_active_models() -> None:
    state = after(PAIR, open_screen(PAIR), do.SetSideBySide(True))
    state, works = update(PAIR, state, do.SelectModel(1))
    assert [(work.model, work.limited) for work in motions(works)] == [(1, True)]
    assert state.side_by_side


def test_undo_leaves_the_view_alone() -> None:
    state = after(FACTS, open_screen(), do.SetMu(0, 0.1), do.SetSideBySide(True), do.Undo())
    assert state.side_by_side


@pytest.mark.parametrize(
    ("facts", "names"),
    [(FACTS, ["raw", "limited"]), (PAIR, ["one, raw", "two", "one, limited"])],
    ids=["one model", "two models"],
)
def test_each_robot_says_which_it_is(facts: Facts, names: list[str]) -> None:
    state = open_screen(facts)
    assert robot_names(facts, state) == ([] if len(facts) == 1 else ["one", "two"])
    assert robot_names(facts, after(facts, state, do.SetSideBySide(True))) == names


def test_a_second_robot_comes_and_goes(scene: viser.SceneApi, arm: Robot) -> None:
    robots = Robots(scene, arm, FACTS, stage_for(2).robots, 1.2)
    state = after(FACTS, open_screen(), do.SetSideBySide(True))
    robots.show(checked(state, FAST, limited=0.4))
    assert robots._limited is not None
    raw, limited = robots._views[0], robots._limited
    assert not np.allclose(raw._wxyz, limited._wxyz)
    frame = arm.tree.frames[0]  # joint a turns about z
    assert frame.joint == "a"
    np.testing.assert_allclose(limited._wxyz[0], [np.cos(0.2), 0, 0, np.sin(0.2)], atol=1e-6)
    assert [label.text for label in robots._labels.values()] == ["raw", "limited"]
    robots.show(after(FACTS, state, do.SetSideBySide(False)))
    assert robots._limited is None
    assert robots._labels == {}


# --- export ---
def test_what_is_on_the_screen_is_exported() -> None:
    state = after(FACTS, open_screen(), do.SetExportOption("file_format", "json"))
    state, (work,) = update(FACTS, state, do.ExportMotion())
    assert isinstance(work, do.ExportWork)
    assert state.current.motion is not None
    assert work.positions is state.current.motion.positions
    assert (work.name, work.options.file_format) == ("wave tiny", "json")
    assert not work.options.beyond_limits
    ready = do.ExportReady(work.request, "wave.json", "{}", "wave.json: 12 frames")
    state, works = update(FACTS, state, ready)
    assert works == (do.SendFile("wave.json", "{}"),)
    assert state.export.written == "wave.json: 12 frames"
    assert state.notice is not None
    assert state.notice.good


def test_a_download_is_the_motion_as_it_is_whatever_an_export_would_be() -> None:
    state = after(
        FACTS,
        open_screen(),
        do.SetExportOption("file_format", "json"),
        do.SetExportOption("safe_posture", True),
    )
    state, (work,) = update(FACTS, state, do.DownloadMotion())
    assert isinstance(work, do.ExportWork)
    assert state.current.motion is not None
    assert work.positions is state.current.motion.positions
    assert work.options == ExportOptions("csv", safe_posture=False, beyond_limits=True)
    assert (state.export.file_format, state.export.beyond_limits) == ("json", False)
    ready = do.ExportReady(work.request, "wave.csv", "a", "wave.csv: 12 frames")
    assert update(FACTS, state, ready)[1] == (do.SendFile("wave.csv", "a"),)


def test_an_export_that_is_no_longer_wanted_is_not_sent() -> None:
    state = open_screen()
    state, (first,) = update(FACTS, state, do.ExportMotion())
    state, (second,) = update(FACTS, state, do.ExportMotion())
    assert isinstance(first, do.ExportWork)
    assert isinstance(second, do.ExportWork)
    assert update(FACTS, state, do.ExportReady(first.request, "x", "", "")) == (state, ())
    assert len(update(FACTS, state, do.ExportReady(second.request, "x", "", ""))[1]) == 1


def test_before_the_first_motion_there_is_nothing_to_export() -> None:
    state = initial_state(FACTS)
    assert update(FACTS, state, do.ExportMotion()) == (state, ())


def test_an_export_that_fails_says_why() -> None:
    state = after(FACTS, open_screen(), do.WorkFailed("export", 3, "NAOqi has no joint a"))
    assert state.notice is not None
    assert (state.notice.text, state.notice.good) == ("NAOqi has no joint a", False)


def test_a_format_that_there_is_not_changes_nothing() -> None:
    state = open_screen()
    assert update(FACTS, state, do.SetExportOption("file_format", "bvh")) == (state, ())


def test_the_panel_warns_of_a_file_beyond_the_limits(gui: viser.GuiApi, arm: Robot) -> None:
    panel = RobotPanel(gui, FACTS, arm, lambda intent: None)
    state = checked(open_screen(), FAST)
    panel.show(state)
    assert "Limited in the file: a." in panel._note.content
    panel.show(checked(open_screen()))
    assert "exported as it is" in panel._note.content
    panel.show(after(FACTS, state, do.SetExportOption("beyond_limits", True)))
    assert INSISTED in panel._note.content
    assert panel._beyond.handle.value


def test_the_summary_names_what_was_limited(arm: Robot) -> None:
    positions = np.zeros((4, 5), dtype=np.float32)
    positions[:, 1] = 2.25  # joint b ends at 2
    motion = Motion("m", JOINTS, positions, 20.0)
    limited = export_summary("m.csv", export_motion(motion, arm, "csv"), insisted=False)
    assert limited == "m.csv: 4 frames, limited: b by up to 0.250"
    raw = export_motion(motion, arm, "csv", enforce_limits=False)
    assert export_summary("m.csv", raw, insisted=True).endswith("beyond the limits of the robot")
    calm = export_motion(Motion("m", JOINTS, 0 * positions, 20.0), arm, "csv")
    assert export_summary("m.csv", calm, insisted=False).endswith("within the limits as generated")


# --- eyes ---
def with_eyes(name: str = "given") -> AppState:
    return after(FACTS, open_screen(), do.SetTarget(target_motion(name=name), TRACK))


def test_the_targets_colours_are_shown_while_it_is_compared_with() -> None:
    state = with_eyes()
    assert eyes_of(FACTS, state, 0) is TRACK
    assert eyes_of(FACTS, after(FACTS, state, do.SetUseTarget(False)), 0) is None
    assert eyes_of(FACTS, after(FACTS, state, do.ClearTarget()), 0) is None
    assert eyes_of(FACTS, after(FACTS, state, do.ClearTarget(), do.Undo()), 0) is TRACK
    other = do.SetTarget(target_motion())
    assert eyes_of(FACTS, after(FACTS, state, other), 0) is None  # it has none of its own


def test_the_datas_colours_go_with_the_motion() -> None:
    facts = (replace(FACTS[0], eyes=(None, TRACK, None, None)),)
    state = open_screen(facts)
    assert eyes_of(facts, state, 0) is None
    assert eyes_of(facts, after(facts, state, do.SelectMotion(1)), 0) is TRACK
    given = after(facts, state, do.SelectMotion(1), do.SetTarget(target_motion()))
    assert eyes_of(facts, given, 0) is None  # the target has no colours


def test_the_switch_is_there_only_with_a_track(gui: viser.GuiApi) -> None:
    sent: list[do.Intent] = []
    actions = (lambda: "", lambda: None)
    panel = ViewPanel(gui, FACTS, sent.append, *actions, has_eyes=True)
    panel.show(open_screen())
    assert not panel._eyes.handle.visible
    panel.show(with_eyes())
    assert panel._eyes.handle.visible
    blind = ViewPanel(gui, FACTS, sent.append, *actions)
    blind.show(with_eyes())
    assert not blind._eyes.handle.visible


def test_the_eyes_follow_the_motion_and_rest_without(scene: viser.SceneApi) -> None:
    pepper = load_robot("pepper")
    robots = Robots(scene, pepper, FACTS, stage_for(2).robots, 1.2)
    assert robots.have_eyes
    eyes = robots._views[0]._eyes
    assert eyes is not None
    robots.show(open_screen())
    rest = np.array(eyes.batched_colors)
    state = after(FACTS, with_eyes(), do.SetPlaying(False))
    colors = []
    for phase in (0.0, 1.0):
        robots.show(replace(state, playback=replace(state.playback, phase=phase)))
        colors.append(np.array(eyes.batched_colors))
    for seen, frame in zip(colors, (TRACK[0], TRACK[-1]), strict=True):
        assert np.corrcoef(seen.ravel(), frame.ravel())[0, 1] > 0.999
    robots.show(after(FACTS, state, do.SetEyes(False)))
    np.testing.assert_array_equal(eyes.batched_colors, rest)


def led_csv(value: str = "0.5") -> bytes:
    rows = format_motion(target_motion()).splitlines()
    leds = [",".join(EYE_COLUMNS), *[",".join([value] * len(EYE_COLUMNS))] * (len(rows) - 1)]
    return "\n".join(f"{row},{led}" for row, led in zip(rows, leds, strict=True)).encode()


def test_an_upload_with_led_columns_brings_its_colours() -> None:
    intent = read_upload("blue.csv", led_csv(), FACTS[0])
    assert isinstance(intent, do.SetTarget)
    assert intent.eyes is not None
    assert intent.eyes.shape == (10, 2, 8, 3)
    state = after(FACTS, open_screen(), intent)
    assert state.notice is not None
    assert "with eye colours" in state.notice.text


def test_bad_colours_leave_a_good_motion() -> None:
    intent = read_upload("blue.csv", led_csv("7"), FACTS[0])
    assert isinstance(intent, do.SetTarget)
    assert intent.eyes is None
    assert "left out" in intent.remark
    assert "\n" not in intent.remark


# --- uploads of exports ---
@pytest.mark.parametrize("name", ["wave.json", "WAVE.JSON"])
def test_an_export_can_be_uploaded(arm: Robot, name: str) -> None:
    content = export_motion(target_motion(), arm, "json", enforce_limits=False).content
    intent = read_upload(name, content.encode(), FACTS[0])
    assert isinstance(intent, do.SetTarget)
    assert intent.motion.name in ("wave", "WAVE")
    np.testing.assert_allclose(intent.motion.positions, target_motion().positions, atol=1e-6)


@pytest.mark.parametrize("name", ["../../x.json", "x.py", ".json", "x.json.csv"])
def test_a_bad_export_is_refused_in_one_line(name: str) -> None:
    intent = read_upload(name, b"{]\nnope", FACTS[0])
    assert isinstance(intent, do.RefuseTarget)
    assert "\n" not in intent.reason


# --- joints that do not match ---
def test_joints_without_a_match_are_named_on_the_screen(gui: viser.GuiApi, arm: Robot) -> None:
    panel = RobotPanel(gui, FACTS, arm, lambda intent: None)
    panel.show(open_screen())
    for line in (
        "arm: 4 of the 5 joints of the model.",
        "Not on this robot, so not seen: e.",
        "Not moved by the model: slide.",
    ):
        assert line in panel._joints.content


def test_many_joints_without_a_match_are_few_words(arm: Robot) -> None:
    facts = make_facts(joints=tuple(f"j{n}" for n in range(40)))
    lines = joint_lines(arm, facts, match_joints(arm, facts.joints))
    assert lines[1] == "Not on this robot, so not seen: j0, j1, j2, j3, j4, j5 and 34 more."


def test_where_all_fits_no_more_is_said() -> None:
    facts = make_facts(joints=load_robot("pepper").joints)
    pepper = load_robot("pepper")
    assert len(joint_lines(pepper, facts, match_joints(pepper, facts.joints))) == 1


def test_what_a_description_lacks_is_said(tmp_path: Path) -> None:
    path = write_arm(tmp_path)
    path.write_text(
        path.read_text().replace(
            '<cylinder radius="0.15" length="0.1"/>', '<mesh filename="package://arm/no.stl"/>'
        )
    )
    robot = load_robot(str(path))
    lines = joint_lines(robot, FACTS[0], match_joints(robot, JOINTS))
    assert any("no.stl" in line for line in lines)
