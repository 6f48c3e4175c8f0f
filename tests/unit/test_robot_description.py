"""Loading robots: ours, the published one, anyone's; what is missing is said in one line."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.motion import Motion
from rnnpb_explorer.robot.description import Robot, load_robot, match_joints
from rnnpb_explorer.robot.kinematics import link_poses
from rnnpb_explorer.robot.openings import pepper_openings
from rnnpb_explorer.robot.pepper import PEPPER_JOINTS, PEPPER_URDF
from rnnpb_explorer.robot.safety import check_motion

VISUAL = '<visual><origin xyz="0 0 {z}"/><geometry>{geometry}</geometry>{material}</visual>'
BODY = """<robot name="thing">
  <link name="base">{base}</link>
  <link name="arm">{arm}</link>
  <joint name="bend" type="{kind}"><parent link="base"/><child link="arm"/>
    <origin xyz="0 0 1"/><axis xyz="0 1 0"/>{limit}</joint>
</robot>"""


def _write(folder: Path, arm: str = "", base: str = "", kind: str = "revolute") -> Path:
    limit = '<limit lower="-1" upper="2" velocity="3" effort="1"/>' if kind == "revolute" else ""
    path = folder / "urdf" / "thing.urdf"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(BODY.format(arm=arm, base=base, kind=kind, limit=limit))
    return path


def _mesh(name: str, scale: str = "") -> str:
    geometry = f'<mesh filename="{name}" {scale}/>'
    return VISUAL.format(z=0, geometry=geometry, material="")


def _heights(robot: Robot) -> dict[str, tuple[float, float]]:
    """Lowest and highest point of every link that has shapes, all joints in neutral."""
    links = tuple(dict.fromkeys(shape.link for shape in robot.shapes))
    carriers = {shape.link: shape.frame for shape in robot.shapes}
    frames = tuple(frame.link for frame in robot.tree.frames)
    poses = link_poses(robot, (), np.zeros((1, 0)), frames)[0]
    out = {}
    for link in links:
        points = np.concatenate([s.mesh.vertices for s in robot.shapes if s.link == link])
        pose = np.eye(4) if carriers[link] < 0 else poses[carriers[link]]
        z = points @ pose[2, :3] + pose[2, 3]
        out[link] = (float(z.min()), float(z.max()))
    return out


def test_pepper_is_all_there() -> None:
    pepper = load_robot("pepper")
    assert pepper.warnings == ()
    assert set(pepper.joints) == set(PEPPER_JOINTS)
    match = match_joints(pepper, PEPPER_JOINTS)
    assert (match.missing, match.unmoved) == ((), ())
    assert match.columns["RWristYaw"] == 16
    assert pepper.limits["LHand"] == (0.0, 1.0)


def test_openings_are_what_a_description_makes_of_them(tmp_path: Path) -> None:
    assert load_robot("pepper").openings == {"LHand", "RHand"} == pepper_openings()
    path = tmp_path / "gripper.urdf"
    names = ("grip", "finger", "elbow", "wide", "follower", "jaw", "tooth")
    links = "".join(f'<link name="{name}"/>' for name in ("base", *names))

    def joint(name: str, upper: float, kind: str = "revolute", mimic: str = "") -> str:
        follows = f'<mimic joint="{mimic}" multiplier="0.8"/>' if mimic else ""
        return (
            f'<joint name="{name}" type="{kind}"><parent link="base"/><child link="{name}"/>'
            f'<axis xyz="0 0 1"/><limit lower="0" upper="{upper}" velocity="1" effort="1"/>'
            f"{follows}</joint>"
        )

    joints = [
        joint("grip", 1),
        joint("finger", 1, mimic="grip"),
        joint("elbow", 1),  # an angle that nothing follows
        joint("wide", 1.5),
        joint("follower", 1, mimic="wide"),
        joint("jaw", 1, "prismatic"),  # metres
        joint("tooth", 1, "prismatic", mimic="jaw"),
    ]
    path.write_text(f'<robot name="gripper">{links}{"".join(joints)}</robot>')
    robot = load_robot(str(path))
    assert robot.openings == {"grip"}
    half_open = Motion("m", robot.joints, np.full((3, 4), 1.2, dtype=np.float32))
    units = {v.joint: v.unit for v in check_motion(half_open, robot).violations}
    assert units == {"grip": "", "elbow": "rad", "jaw": "m"}


def test_pepper_stands_on_the_floor_and_is_as_tall_as_the_robot() -> None:
    heights = _heights(load_robot("pepper"))
    assert min(low for low, _ in heights.values()) == pytest.approx(0.0, abs=0.002)
    assert max(high for _, high in heights.values()) == pytest.approx(1.21, abs=0.005)


def test_pepper_is_light() -> None:
    size = sum(file.stat().st_size for file in PEPPER_URDF.parent.rglob("*.*"))
    triangles = sum(len(shape.mesh.faces) for shape in load_robot("pepper").shapes)
    assert size < 2_000_000
    assert triangles < 60_000


@pytest.mark.parametrize(
    ("ours", "theirs", "apart"),
    [
        ("skirt", ("Tibia", "WheelFL_link", "WheelFR_link", "WheelB_link"), 0.03),
        ("thigh", ("Pelvis",), 0.03),
        ("torso", ("torso",), 0.03),
        ("head", ("Head",), 0.015),
        ("l_upper_arm", ("LBicep",), 0.02),
        ("l_forearm", ("LForeArm",), 0.01),
        ("r_hand", ("r_wrist",), 0.01),
        ("l_finger1_1", ("LFinger11_link",), 0.01),
    ],
)
def test_pepper_has_the_proportions_of_the_robot(
    ours: str, theirs: tuple[str, ...], apart: float, published_pepper: Path
) -> None:

    def bounds(robot: Robot, links: tuple[str, ...]) -> np.ndarray:
        points = [s.mesh.vertices for s in robot.shapes if s.link in links]
        together = np.concatenate(points)
        return np.stack([together.min(axis=0), together.max(axis=0)])

    mine = bounds(load_robot("pepper"), (ours,))
    np.testing.assert_allclose(mine, bounds(load_robot(str(published_pepper)), theirs), atol=apart)


def test_a_missing_mesh_is_one_warning_that_names_it(tmp_path: Path) -> None:
    lost = _mesh("package://some_pkg/meshes/lost.stl")
    box = VISUAL.format(z=0.5, geometry='<box size="1 1 1"/>', material="")
    robot = load_robot(str(_write(tmp_path, arm=lost + lost, base=box + lost)))
    assert len(robot.warnings) == 1
    assert "package://some_pkg/meshes/lost.stl" in robot.warnings[0]
    assert robot.missing_meshes == ("package://some_pkg/meshes/lost.stl",)
    assert robot.joints == ("bend",)
    heights = _heights(robot)
    assert heights["base"] == (0.0, 1.0)
    assert heights["arm"] == pytest.approx((0.98, 1.02))  # its joint is drawn


def test_a_broken_mesh_is_one_warning_that_names_it(tmp_path: Path) -> None:
    broken = ("broken.glb", "broken.stl", "broken.dae", "broken.obj", "broken.what")
    path = _write(tmp_path, arm="".join(map(_mesh, broken)))
    for name in broken:
        (path.parent / name).write_bytes(b"no mesh")
    robot = load_robot(str(path))
    assert robot.missing_meshes == broken
    for name, warning in zip(broken, robot.warnings, strict=True):
        assert name in warning
        assert "\n" not in warning


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("ball.stl", "thing/urdf/ball.stl"),
        ("../meshes/ball.stl", "thing/meshes/ball.stl"),
        ("package://thing/meshes/ball.stl", "thing/meshes/ball.stl"),
        ("package://other/meshes/ball.stl", "other/meshes/ball.stl"),
        ("package://renamed/meshes/ball.stl", "thing/meshes/ball.stl"),
        ("package://far/ball.stl", "elsewhere/far/ball.stl"),
    ],
)
def test_meshes_are_found(
    name: str, place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "elsewhere"))
    path = _write(tmp_path / "thing", arm=_mesh(name, 'scale="2 2 2"'))
    file = tmp_path / place
    file.parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.icosphere(radius=0.25).export(file)
    robot = load_robot(str(path))
    assert robot.warnings == ()
    assert _heights(robot)["arm"] == pytest.approx((0.5, 1.5))


def test_a_mirrored_mesh_is_not_inside_out(tmp_path: Path) -> None:
    path = _write(tmp_path, arm=_mesh("ball.stl", 'scale="1 -1 1"'))
    trimesh.creation.icosphere().export(path.parent / "ball.stl")
    (shape,) = load_robot(str(path)).shapes
    assert trimesh.Trimesh(shape.mesh.vertices, shape.mesh.faces).volume > 0
    outward = np.sum(shape.mesh.vertex_normals * shape.mesh.vertices, axis=1)
    assert outward.min() > 0.9


def test_the_urdf_colours_what_has_no_colour(tmp_path: Path) -> None:
    red = '<material name="red"><color rgba="1 0 0 0.5"/></material>'
    box = VISUAL.format(z=0, geometry='<box size="1 1 1"/>', material=red)
    (shape,) = load_robot(str(_write(tmp_path, arm=box))).shapes
    assert shape.material.baseColorFactor.tolist() == [255, 0, 0, 128]
    assert shape.material.metallicFactor == 0


def test_the_published_description_works(published_pepper: Path) -> None:
    robot = load_robot(str(published_pepper))
    assert match_joints(robot, PEPPER_JOINTS).missing == ()
    assert len(robot.warnings) == 1
    assert "d435.dae" in robot.warnings[0]
    assert len({shape.link for shape in robot.shapes}) > 40


def test_a_continuous_joint_has_no_limits(tmp_path: Path) -> None:
    robot = load_robot(str(_write(tmp_path, kind="continuous")))
    assert robot.limits == {"bend": (-np.inf, np.inf)}
    assert robot.velocity_limits == {"bend": np.inf}


def test_a_mimic_of_nothing_is_a_warning(tmp_path: Path) -> None:
    path = _write(tmp_path)
    text = path.read_text().replace("</joint>", '<mimic joint="tail"/></joint>')
    path.write_text(text)
    robot = load_robot(str(path))
    assert robot.joints == ()
    assert "bend" in robot.warnings[0]
    assert "tail" in robot.warnings[0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("no XML at all", "not XML"),
        ("<sdf/>", "<sdf>"),
        (
            '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro/></robot>',
            "xacro",
        ),
        ('<robot name="x"><link name="a"/><joint name="j" type="fixed"/></robot>', "no complete"),
        (
            '<robot name="x"><link name="a"/><joint name="j" type="fixed"><parent link="a"/>'
            '<child link="b"/></joint></robot>',
            "no link 'b'",
        ),
        (
            '<robot name="x"><link name="a"/><link name="b"/>'
            '<joint name="i" type="fixed"><parent link="a"/><child link="b"/></joint>'
            '<joint name="j" type="fixed"><parent link="b"/><child link="a"/></joint></robot>',
            "circle",
        ),
        (
            '<robot name="x"><link name="a"/><link name="b"/><link name="c"/>'
            '<joint name="i" type="fixed"><parent link="a"/><child link="c"/></joint>'
            '<joint name="j" type="fixed"><parent link="b"/><child link="c"/></joint></robot>',
            "joint j: link c has a parent already",
        ),
        ('<robot name="x"/>', "no link"),
    ],
)
def test_no_urdf_is_one_plain_line(text: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.urdf"
    path.write_text(text)
    with pytest.raises(InputError, match=says) as caught:
        load_robot(str(path))
    assert "bad.urdf" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("spec", ["nobody", "/nowhere/robot.urdf", "../_description"])
def test_no_such_robot_is_one_plain_line(spec: str) -> None:
    with pytest.raises(InputError) as caught:
        load_robot(spec)
    assert spec in str(caught.value)


def test_descriptions_need_their_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "robot_descriptions", None)  # as if it were not installed
    with pytest.raises(InputError, match=r"rnnpb-explorer\[robots\]"):
        load_robot("panda_description")


def test_a_description_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As robot_descriptions lays them out: a module a robot, which knows where its URDF is."""
    package = tmp_path / "robot_descriptions"
    package.mkdir()
    (package / "__init__.py").touch()
    shutil.copytree(PEPPER_URDF.parent, tmp_path / "data")
    path = str(tmp_path / "data" / "pepper.urdf")
    (package / "salt_description.py").write_text(f"URDF_PATH = {path!r}\n")
    (package / "lost_description.py").write_text("raise OSError('no network')\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        monkeypatch.delitem(sys.modules, name)
    assert load_robot("salt_description").name == "salt"
    with pytest.raises(InputError, match="sugar_description"):
        load_robot("sugar_description")
    with pytest.raises(InputError, match="lost_description could not be downloaded"):
        load_robot("lost_description")
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        monkeypatch.delitem(sys.modules, name)
