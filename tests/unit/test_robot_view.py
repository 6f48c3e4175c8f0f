"""The robot in a real viser scene, without a browser."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import trimesh
import viser
from scipy.spatial.transform import Rotation

from rnnpb_explorer.app.page.studio import FLOOR_OPAQUE, FLOOR_RADIUS, floor_glb, setup_stage
from rnnpb_explorer.robot.description import Robot, load_robot
from rnnpb_explorer.robot.kinematics import joint_poses, link_poses
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS
from rnnpb_explorer.robot.view import TOLERANCE, RobotView


@pytest.fixture(scope="module")
def pepper() -> Robot:
    return load_robot("pepper")


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


@pytest.fixture
def scene(server: viser.ViserServer) -> Iterator[viser.SceneApi]:
    yield server.scene
    server.scene.reset()


class Sent:
    """The messages that a scene sends from here on."""

    def __init__(self, scene: viser.SceneApi, monkeypatch: pytest.MonkeyPatch) -> None:
        self.messages: list[Any] = []
        send = scene._queue_scene_message

        def record(message: Any) -> None:
            self.messages.append(message)
            send(message)

        monkeypatch.setattr(scene, "_queue_scene_message", record)

    @property
    def nodes(self) -> set[str]:
        return {message.name.rsplit("/", 1)[1] for message in self.messages}


def _two_frames() -> np.ndarray:
    positions = np.zeros((2, len(PEPPER_JOINTS)), dtype=np.float32)
    positions[1, PEPPER_JOINTS.index("HeadYaw")] = 0.5
    positions[1, PEPPER_JOINTS.index("RHand")] = 0.7
    return positions


def _handles(view: RobotView) -> dict[str, viser.FrameHandle]:
    frames = view.robot.tree.frames
    return {frame.joint: handle for frame, handle in zip(frames, view._frames, strict=True)}


def test_what_stands_in_the_scene_is_the_pose(scene: viser.SceneApi, pepper: Robot) -> None:
    view = RobotView(scene, pepper)
    positions = np.random.default_rng(1).uniform(-0.4, 0.4, (3, len(PEPPER_JOINTS)))
    view.show(joint_poses(pepper, PEPPER_JOINTS, positions), 2)
    chain = ("KneePitch", "HipPitch", "HipRoll", "LShoulderPitch", "LShoulderRoll", "LElbowYaw",
             "LElbowRoll", "LWristYaw", "LFinger21", "LFinger22")  # fmt: skip
    pose = np.eye(4)
    handles = _handles(view)
    for joint in chain:
        step = np.eye(4)
        turn = Rotation.from_quat(handles[joint].wxyz, scalar_first=True)
        step[:3, :3] = turn.as_matrix()
        step[:3, 3] = handles[joint].position
        pose = pose @ step
    name = handles["LFinger22"].name
    assert name == "/robot/" + "/".join(chain)
    expected = link_poses(pepper, PEPPER_JOINTS, positions, ("l_finger2_2",))[2, 0]
    np.testing.assert_allclose(pose, expected, atol=1e-5)


def test_a_frame_sends_only_what_moved(
    scene: viser.SceneApi, pepper: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    view = RobotView(scene, pepper)
    poses = joint_poses(pepper, PEPPER_JOINTS, _two_frames())
    view.show(poses, 0)
    sent = Sent(scene, monkeypatch)
    view.show(poses, 0)
    unseen = _two_frames()[:1] + np.float32(TOLERANCE / 2)
    view.show(joint_poses(pepper, PEPPER_JOINTS, unseen), 0)
    assert sent.messages == []
    view.show(poses, 1)
    fingers = {frame.joint for frame in pepper.tree.frames if frame.driver == "RHand"}
    assert sent.nodes == {"HeadYaw", *fingers}
    assert len(sent.messages) == len(sent.nodes)


def test_two_robots_side_by_side(scene: viser.SceneApi, pepper: Robot) -> None:
    first = RobotView(scene, pepper, "/a")
    second = RobotView(scene, pepper, "/b", position=(0, 1, 0))
    second.show(joint_poses(pepper, PEPPER_JOINTS, _two_frames()), 1)
    yaw = {name: _handles(view)["HeadYaw"].wxyz[3] for name, view in (("a", first), ("b", second))}
    assert yaw["a"] == pytest.approx(0.0, abs=1e-6)
    assert yaw["b"] == pytest.approx(np.sin(0.25), abs=1e-6)
    second.remove()
    assert any(name.startswith("/a/") for name in scene._handle_from_node_name)
    assert not any(name.startswith("/b") for name in scene._handle_from_node_name)


def test_eye_colours(scene: viser.SceneApi, pepper: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    view = RobotView(scene, pepper)
    assert view.has_eyes
    sent = Sent(scene, monkeypatch)
    colors = np.zeros((2, 8, 3))
    colors[0, 0] = (1, 0, 0)  # right eye, first LED
    colors[1, 7] = (0, 1, 0)  # left eye, last LED
    view.set_eye_colors(colors)
    view.set_eye_colors(colors)
    assert len(sent.messages) == 1  # all sixteen, and only when they changed
    eyes = scene._handle_from_node_name["/robot/KneePitch/HipPitch/HipRoll/HeadYaw/HeadPitch/eyes"]
    shown = np.asarray(eyes.batched_colors)  # type: ignore[attr-defined]
    assert shown[0].tolist() == [255, shown[1, 0], shown[1, 0]]
    assert shown[15, 1] == 255
    assert (shown[1:15] == shown[1, 0]).all()
    view.set_eye_colors(None)
    assert len(np.unique(np.asarray(eyes.batched_colors), axis=0)) == 1  # type: ignore[attr-defined]


def test_leds_lie_around_the_eyes_in_naoqis_order(pepper: Robot) -> None:
    """0 and 7 on top, 1 and 2 towards the nose, 3 and 4 below, 5 and 6 outside, on both sides."""
    for side, outwards in (("l", 1.0), ("r", -1.0)):
        middle = np.stack([
            np.concatenate([s.mesh.vertices for s in pepper.shapes if s.link == name]).mean(axis=0)
            for name in (f"{side}_eye_led_{led}" for led in range(8))
        ])  # fmt: skip
        from_eye = middle - middle.mean(axis=0)
        assert middle.mean(axis=0)[1] * outwards > 0.03
        top, inside, below, outside = (
            from_eye[[i, j]].sum(0) for i, j in ((0, 7), (1, 2), (3, 4), (5, 6))
        )
        assert top[2] > 0.02 > -0.02 > below[2]
        assert outside[1] * outwards > 0.02 > -0.02 > inside[1] * outwards


def test_a_robot_without_eyes_shows_no_colours(scene: viser.SceneApi, tmp_path: Any) -> None:
    path = tmp_path / "box.urdf"
    box = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    path.write_text(f'<robot name="box"><link name="base">{box}</link></robot>')
    robot = load_robot(str(path))
    view = RobotView(scene, robot, "/box")
    assert not view.has_eyes
    view.set_eye_colors(np.zeros((2, 8, 3)))
    view.show(joint_poses(robot, ("a",), np.zeros((3, 1))), 2)
    assert "/box/shape" in scene._handle_from_node_name


def test_the_stage_has_a_floor_that_fades_out(scene: viser.SceneApi) -> None:
    setup_stage(scene)
    floor: Any = scene._handle_from_node_name["/stage/floor"]
    assert tuple(floor.position) == (0.0, 0.0, 0.0)
    (mesh,) = trimesh.load(io.BytesIO(floor_glb()), file_type="glb").geometry.values()  # type: ignore[attr-defined]
    assert not mesh.vertices[:, 2].any()
    np.testing.assert_allclose(mesh.face_normals, [[0, 0, 1]] * len(mesh.faces), atol=1e-9)
    alpha = mesh.visual.vertex_attributes["color"][:, 3]
    radius = np.linalg.norm(mesh.vertices, axis=1)
    assert (alpha[radius < FLOOR_OPAQUE + 1e-6] == 255).all()
    assert (alpha[radius > FLOOR_RADIUS - 1e-6] == 0).all()
