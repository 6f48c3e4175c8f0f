"""The robot on the screen: the safety light, the limited motion, eyes, files, other robots."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import viser
from arm import write_arm

from rnnpb_explorer.app.page.panels.robot import (
    INSISTED,
    LIGHTS,
    RobotPanel,
    SafetyLight,
    joint_lines,
    note_html,
    report_html,
)
from rnnpb_explorer.app.page.panels.view import ViewPanel
from rnnpb_explorer.app.page.robot_nodes import add_robot
from rnnpb_explorer.app.page.robots import (
    ROOT,
    Part,
    RobotNames,
    cast_of,
    robot_names,
    robots_shown,
)
from rnnpb_explorer.app.page.stage import stage_for
from rnnpb_explorer.app.page.uploads import Upload, read_upload
from rnnpb_explorer.app.page.views import curves_shown
from rnnpb_explorer.app.page.words import light_words, safety_lines
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.computed import Entry
from rnnpb_explorer.app.state.document import ExportOptions, target_of_motion
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.picture import Picture
from rnnpb_explorer.app.state.results import ExportedFile
from rnnpb_explorer.app.state.update import update
from rnnpb_explorer.app.state.wanted import export_work, eyes_of, wanted
from rnnpb_explorer.core.motion import format_motion
from rnnpb_explorer.robot.description import Robot, load_robot, match_joints
from rnnpb_explorer.robot.export import export_motion
from rnnpb_explorer.robot.pepper import EYE_COLUMNS
from rnnpb_explorer.robot.safety_report import SafetyReport, Violation

from ..app_states import FACTS, JOINTS, Page, make_facts, make_target, motion_of, target_motion
from .pictures import after, answered, checked, open_screen

PAIR = (make_facts(name="one"), make_facts(name="two"))
TRACK = np.random.default_rng(0).random((10, 2, 8, 3)).astype(np.float32)
FAST = Violation("velocity", "a", 12, 15, 8.94, 7.3, 1.22)
FAR = Violation("position", "<b>", 3, 3, -2.5, -2.0, 0.5)


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    return load_robot(str(write_arm(tmp_path_factory.mktemp("robot"))))


@pytest.fixture
def scene(server: viser.ViserServer) -> Iterator[viser.SceneApi]:
    yield server.scene
    server.scene.reset()


def report(*violations: Violation) -> SafetyReport:
    return SafetyReport(violations, ())


# --- the safety light ---
def test_the_light_says_which_joints_and_frames() -> None:
    found = checked(open_screen(), FAST).checked
    assert found is not None
    assert safety_lines(report(FAST)) == ["a: velocity 8.9 rad/s over 7.3, frames 12–15"]
    assert "a: velocity 8.9 rad/s over 7.3, frames 12–15" in report_html(found)
    assert light_words(report(FAST)) == "1 joint a little beyond the limits"
    assert light_words(report(FAST, FAR)) == "1 joint far beyond the limits"
    assert light_words(report()) == "within the robot's limits"


def test_the_light_is_not_green_for_joints_that_are_not_checked() -> None:
    some = SafetyReport((), ("d", "e"))
    assert some.light == "grey"
    assert light_words(some) == "nothing beyond the limits, but 2 joints not checked"
    assert light_words(SafetyReport((FAST,), ("e",))) == (
        "1 joint a little beyond the limits; 1 joint not checked"
    )


def test_many_faults_are_few_lines() -> None:
    again = [Violation("velocity", "a", n, n + 1, 8.0, 7.3, 1.1) for n in range(20, 60, 8)]
    (line,) = safety_lines(report(FAST, *again))
    assert line == "a: velocity 8.9 rad/s over 7.3, frames 12–15, 20–21, 28–29 and 3 more times"
    many = [Violation("position", f"j{n}", 1, 1, 3.0, 2.0, 1.0) for n in range(17)]
    lines = safety_lines(report(*many))
    assert len(lines) == 5
    assert lines[-1] == "and 13 more"


def test_names_from_anywhere_stay_text() -> None:
    found = checked(open_screen(), FAR).checked
    assert found is not None
    for html in (report_html(found), note_html(found, ExportOptions())):
        assert "&lt;b&gt;" in html
        assert "<b>" not in html


def test_the_light_is_of_the_active_model(gui: viser.GuiApi, arm: Robot) -> None:
    light = SafetyLight(gui, arm)
    picture = checked(checked(open_screen(PAIR), unchecked=("e",)), FAST, model=1)
    light.show(picture)
    assert "nothing beyond the limits, but 1 joint not checked" in light._html.content
    assert LIGHTS["grey"] in light._html.content
    light.show(after(picture, do.SelectModel(1)))
    assert "a little beyond" in light._html.content


def test_a_robot_of_other_joints_stands_still_and_the_screen_says_so(
    gui: viser.GuiApi, arm: Robot
) -> None:
    facts = (make_facts(name="other", joints=("v", "w", "x", "y", "z")),)
    light = SafetyLight(gui, arm)
    light.show(checked(open_screen(facts), unchecked=facts[0].joints))
    assert (
        "arm stands still: it has none of the joints of other (v, w, x and 2 more)"
        in light._html.content
    )
    assert LIGHTS["grey"] in light._html.content


def test_the_screen_names_the_meshes_that_are_missing(gui: viser.GuiApi, tmp_path: Path) -> None:
    path = write_arm(tmp_path)
    boxes = path.read_text()
    for number in range(5):
        boxes = re.sub("<box size=[^>]*>", f'<mesh filename="m/{number}<.stl"/>', boxes, count=1)
    path.write_text(boxes.replace("<.stl", "&lt;.stl"))
    light = SafetyLight(gui, load_robot(str(path)))
    light.show(checked(open_screen()))
    shown = light._html.content
    assert "5 meshes missing, joints drawn instead: 0&lt;.stl, 1&lt;.stl, " in shown
    assert "2&lt;.stl and 2 more" in shown


def test_until_a_new_motion_is_checked_the_light_stays(gui: viser.GuiApi, arm: Robot) -> None:
    light = SafetyLight(gui, arm)
    light.show(checked(open_screen(), FAST))
    moved = answered(after(checked(open_screen(), FAST), do.SetMu(0, 0.7)))
    assert moved.checked is None
    light.show(moved)
    assert "a little beyond" in light._html.content
    light.show(checked(moved))
    assert "within the robot" in light._html.content


# --- raw and limited ---
def test_the_limited_motion_is_made_only_while_it_is_seen_and_of_the_active_model() -> None:
    def checks(*asked: do.DocumentIntent) -> list[str]:
        works = wanted(PAIR, after(open_screen(PAIR), *asked).document)
        return [motion_of(works, index).check for index in (0, 1)]

    assert checks() == ["report", "report"]
    assert checks(do.SetSideBySide(True)) == ["limited", "report"]
    assert checks(do.SetSideBySide(True), do.SelectModel(1)) == ["report", "limited"]
    assert checks(do.SetSideBySide(True), do.SetSideBySide(False)) == ["report", "report"]


@pytest.mark.parametrize(
    ("facts", "names"),
    [(FACTS, ["tiny, raw", "tiny, limited"]), (PAIR, ["one, raw", "two", "one, limited"])],
    ids=["one model", "two models"],
)
def test_each_robot_says_which_it_is(facts: Facts, names: list[str]) -> None:
    picture = open_screen(facts)
    assert robot_names(picture) == ([] if len(facts) == 1 else ["one", "two"])
    assert robot_names(after(picture, do.SetSideBySide(True))) == names


def test_a_robot_each_and_one_within_the_limits(scene: viser.SceneApi, arm: Robot) -> None:
    spots = stage_for(3, 0.5, 1.2).robots
    add_robot(scene, arm, ROOT)
    cast = (Part(0), Part(1), Part(1, "limited"))
    shown = robots_shown(arm, PAIR, spots, cast).robots
    assert [one.copy_of for one in shown] == [None, 0, 0]
    np.testing.assert_allclose([one.spot for one in shown], spots)
    assert arm.tree.frames[0].joint == "a"  # turns about z
    assert (shown[0].columns[0], shown[0].axes[0].tolist()) == (JOINTS.index("a"), [0, 0, 1])


def test_the_target_has_a_robot_of_its_own() -> None:
    picture = after(open_screen(PAIR), do.SetTarget(make_target()), do.SelectModel(1))
    assert cast_of(picture) == (Part(0), Part(1), Part(1, "target"))
    assert robot_names(picture) == ["one", "two", "target"]
    assert len(cast_of(after(picture, do.SetShowTarget(False)))) == 2
    assert len(cast_of(after(picture, do.ClearTarget()))) == 2


def test_of_the_target_one_sees_what_is_observed_until_one_asks() -> None:
    target = make_target(10)
    picture = after(open_screen(), do.SetTarget(target), do.SetRecognitionOption("observed", 0.4))
    assert picture.seen_target is not None
    np.testing.assert_array_equal(picture.seen_target, target.array[:4])
    curves = curves_shown(picture).reference
    assert curves is not None
    np.testing.assert_array_equal(curves[:4], target.array[:4])
    assert len(curves) == 10
    assert np.isnan(curves[4:]).all()
    picture = after(picture, do.SetRevealed(True))
    np.testing.assert_array_equal(picture.seen_target, target.array)
    np.testing.assert_array_equal(curves_shown(picture).reference, target.array)
    assert not after(picture, do.SetTarget(target)).document.revealed  # another is hidden again


def test_names_come_and_go(scene: viser.SceneApi) -> None:
    spots = stage_for(2, 0.5, 1.2).robots
    names = RobotNames(scene, 1.2)
    picture = after(open_screen(), do.SetSideBySide(True))
    names.show(picture, spots)
    assert [label.text for label in names._labels.values()] == ["tiny, raw", "tiny, limited"]
    names.show(after(picture, do.SetSideBySide(False)), spots)
    assert names._labels == {}


# --- export ---
def test_what_is_on_the_screen_is_exported() -> None:
    picture = after(open_screen(), do.SetMu(0, 0.7), do.SetExportOption("file_format", "json"))
    work = export_work(FACTS, picture.document)
    assert (work.motion.pb, work.motion.steps) == (picture.choice.latent.pb, 12)
    assert (work.name, work.options) == ("wave tiny", ExportOptions("json"))
    other = after(picture, do.SetExportOption("file_format", "bvh"))
    assert other.document == picture.document  # no such format


def test_the_panel_warns_of_a_file_beyond_the_limits(gui: viser.GuiApi, arm: Robot) -> None:
    panel = RobotPanel(gui, arm, lambda _: None)
    picture = checked(open_screen(), FAST)
    panel.show(picture)
    assert "Limited in the file: a." in panel._note.content
    panel.show(checked(open_screen()))
    assert "is within the limits; it is exported as it is" in panel._note.content
    panel.show(checked(open_screen(), unchecked=("e",)))
    assert "is beyond no limit known; it is exported as it is" in panel._note.content
    panel.show(after(picture, do.SetExportOption("beyond_limits", True)))
    assert INSISTED in panel._note.content
    assert panel._beyond.handle.value


def test_what_was_written_is_said_of_this_motion_and_these_options_alone(
    gui: viser.GuiApi, arm: Robot
) -> None:
    panel = RobotPanel(gui, arm, lambda _: None)
    page = Page().compute()
    work = export_work(FACTS, page.document)
    file = Entry(work, ExportedFile("wave.csv", "a", "wave.csv: 12 frames"), done=True)
    page.computed = page.computed.put({("export", 0): work}, ("export", 0), file)
    panel.show(page.picture)
    assert "wave.csv: 12 frames" in panel._written.content
    for change in (do.SetExportOption("safe_posture", True), do.SetMu(0, 0.7)):
        other = replace(page.picture, document=update(FACTS, page.document, change))
        panel.show(other)
        assert panel._written.content == ""
        panel.show(page.picture)
        assert "wave.csv" in panel._written.content


# --- eyes ---
def with_eyes() -> Picture:
    return after(open_screen(), do.SetTarget(target_of_motion(target_motion(), TRACK)))


def test_the_targets_colours_are_shown_while_it_is_compared_with() -> None:
    def colours(*asked: do.DocumentIntent) -> object:
        return eyes_of(FACTS, after(with_eyes(), *asked).document, 0)

    shown = colours()
    assert isinstance(shown, np.ndarray)
    np.testing.assert_allclose(shown, TRACK, atol=0.5 / 255)
    assert colours(do.SetUseTarget(False)) is None
    assert colours(do.ClearTarget()) is None
    assert colours(do.SetTarget(make_target())) is None  # it has none of its own


def test_the_datas_colours_go_with_the_motion() -> None:
    facts = (replace(FACTS[0], eyes=(None, TRACK, None, None)),)
    opened = open_screen(facts)
    assert eyes_of(facts, opened.document, 0) is None
    assert eyes_of(facts, after(opened, do.SelectMotion(1)).document, 0) is TRACK
    given = after(opened, do.SelectMotion(1), do.SetTarget(make_target()))
    assert eyes_of(facts, given.document, 0) is None  # the target has no colours


def test_the_switch_is_there_only_with_a_track(gui: viser.GuiApi) -> None:
    sent: list[do.Intent] = []
    panel = ViewPanel(gui, sent.append, has_eyes=True)
    panel.show(open_screen())
    assert not panel._eyes.handle.visible
    panel.show(with_eyes())
    assert panel._eyes.handle.visible
    blind = ViewPanel(gui, sent.append)
    blind.show(with_eyes())
    assert not blind._eyes.handle.visible


def led_csv(value: str = "0.5") -> bytes:
    rows = format_motion(target_motion()).splitlines()
    leds = [",".join(EYE_COLUMNS), *[",".join([value] * len(EYE_COLUMNS))] * (len(rows) - 1)]
    return "\n".join(f"{row},{led}" for row, led in zip(rows, leds, strict=True)).encode()


def uploaded(name: str, content: bytes, robot: Robot) -> tuple[do.Intent, ...]:
    return read_upload(Upload(name, lambda: content, FACTS[0]), content, robot)


def test_an_upload_with_led_columns_brings_its_colours(arm: Robot) -> None:
    intent, _, told = uploaded("blue.csv", led_csv(), arm)
    assert isinstance(intent, do.SetTarget)
    assert intent.target.eye_track is not None
    assert intent.target.eye_track.shape == (10, 2, 8, 3)
    np.testing.assert_allclose(intent.target.eye_track, 0.5, atol=0.5 / 255)
    assert isinstance(told, do.Say)
    assert "with eye colours" in told.text


def test_bad_colours_leave_a_good_motion(arm: Robot) -> None:
    intent, _, told = uploaded("blue.csv", led_csv("7"), arm)
    assert isinstance(intent, do.SetTarget)
    assert intent.target.eye_track is None
    assert isinstance(told, do.Say)
    assert "left out" in told.text
    assert "\n" not in told.text


# --- uploads of exports ---
@pytest.mark.parametrize("name", ["wave.json", "WAVE.JSON"])
def test_an_export_can_be_uploaded(arm: Robot, name: str) -> None:
    content = export_motion(target_motion(), arm, "json", enforce_limits=False).content
    intent, *_ = uploaded(name, content.encode(), arm)
    assert isinstance(intent, do.SetTarget)
    assert intent.target.name in ("wave", "WAVE")
    np.testing.assert_allclose(intent.target.array, target_motion().positions, atol=1e-6)


@pytest.mark.parametrize("name", ["../../x.json", "x.py", ".json", "x.json.csv"])
def test_a_bad_export_is_refused_in_one_line(arm: Robot, name: str) -> None:
    (told,) = uploaded(name, b"{]\nnope", arm)
    assert isinstance(told, do.Say)
    assert not told.good
    assert "\n" not in told.text


# --- joints that do not match ---
def test_joints_without_a_match_are_named_on_the_screen(gui: viser.GuiApi, arm: Robot) -> None:
    panel = RobotPanel(gui, arm, lambda _: None)
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
