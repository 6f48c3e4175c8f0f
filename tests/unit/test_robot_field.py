"""Robot descriptions as people have them; each of `tests/field/urdf` stands for a kind."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import trimesh

from rnnpb_explorer.app.page.stage import AS_IT_IS, SHOWN_SIZE, staged
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.robot import meshes, urdf_file
from rnnpb_explorer.robot.description import Robot, load_robot
from rnnpb_explorer.robot.kinematics import extent, link_poses
from rnnpb_explorer.robot.mesh_files import MeshFinder
from rnnpb_explorer.robot.skeleton import COLOR
from rnnpb_explorer.robot.urdf_file import read_numbers

FIELD = Path(__file__).parents[1] / "field" / "urdf"
PART = ((0, 0, 0), (0.1, 0.1, 0.3))  # all that those with a mesh show


@dataclass(frozen=True)
class Read:
    """What is expected of a description: extent (metres), joints, and words of its warnings."""

    extent: tuple[tuple[float, float, float], tuple[float, float, float]] = PART
    joints: tuple[str, ...] = ("j1",)
    warnings: tuple[str, ...] = ()


TABLE = {
    "capsule": Read(((-0.1, -0.1, -0.3), (0.1, 0.1, 0.3)), (), ("capsule",)),
    "collada-unit-cm": Read(),
    "collada-unit-m": Read(),
    "collada-y-up": Read(),
    "entity": Read(),
    "latin1-undeclared": Read(warnings=("read as iso-8859-1",)),
    "legs-below-base": Read(((-0.1, -0.15, -0.8), (0.1, 0.15, 0.05)), ("hip",)),
    "mesh-backslash": Read(warnings=("\\ taken for /",)),
    "mesh-case-differs": Read(warnings=("other case",)),
    "mesh-file-uri": Read(),
    "mesh-find": Read(warnings=("taken for package://",)),
    "mesh-model-uri": Read(warnings=("taken for package://",)),
    "mesh-negative-scale": Read(((0, -0.1, 0), (0.1, 0, 0.3))),
    "mesh-package-name": Read(),
    "mesh-space": Read(),
    "mimic-limit": Read(),
    "no-limit-revolute": Read(),
    "no-meshes-found": Read(
        ((-0.02, -0.02, -0.06), (0.02, 0.02, 0.06)), warnings=("none.dae: no such file",)
    ),
    "spaces-in-number": Read(warnings=("-1.0f",)),
    "unbound-prefix": Read(warnings=("line 6: a prefix is declared nowhere",)),
    "unicode-names": Read(joints=("関節1",)),
    "utf16": Read(),
    "utf8-bom": Read(),
    "world-link-implicit": Read(warnings=("link world",)),
    "xacro-leftover": Read(warnings=("<xacro:grey>",)),
}


def test_the_table_has_every_file() -> None:
    assert sorted(TABLE) == sorted(path.stem for path in FIELD.glob("*.urdf"))


@pytest.mark.parametrize("name", TABLE)
def test_each_is_read(name: str) -> None:
    robot, expected = load_robot(str(FIELD / f"{name}.urdf")), TABLE[name]
    assert robot.joints == expected.joints
    np.testing.assert_allclose(extent(robot), expected.extent, atol=1e-6)
    for warning, words in zip(robot.warnings, expected.warnings, strict=True):
        assert words in warning
    bound = {"j1": (-np.pi, np.pi)} if name == "entity" else {"j1": (-1, 1)}
    if "j1" in robot.joints and name != "no-limit-revolute":
        assert robot.limits["j1"] == pytest.approx(bound["j1"], abs=1e-5)


# --- text ---
LINKS = '<link name="base"/><link name="arm"/>'
JOINT = (
    '<joint name="j1" type="revolute"><parent link="base"/><child link="arm"/>'
    '<origin xyz="0 0 1"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="2"/></joint>'
)
WHOLE = f'<robot name="r">{LINKS}{JOINT}</robot>'


def _load(folder: Path, text: str | bytes) -> Robot:
    path = folder / "thing.urdf"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return load_robot(str(path))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (WHOLE, ""),
        (WHOLE.replace('name="r"', ""), "the robot has no name"),
        (WHOLE.replace('<robot name="r"', '<robot xmlns="http://www.ros.org" name="r"'), ""),
        (f"\n<?xml version='1.0'?>{WHOLE}", "before <?xml"),
        (WHOLE.replace("<joint", "<!-- a -- b --><joint"), "-- in a comment"),
        (WHOLE.replace('name="r"', 'name="r & d"'), "an & that begins"),
        (WHOLE.replace('name="r"', 'name="r" name="s"'), "given twice"),
        (WHOLE + "<robot/>", "follows </robot>"),
        (f"<?xml version='0.0'?>{WHOLE}", "an unknown version"),
        (f"<?xml encoding='utf-8'?>{WHOLE}", "without a version"),
        (WHOLE.replace("0 0 1", "$(optenv UP 0 0 1)", 1), "is not 3 numbers"),
        (WHOLE.replace("<joint", "<sensor:camera/><joint"), "prefix is declared nowhere"),
        (WHOLE.replace("<joint", '<gazebo x:y="1"/><joint'), "prefix is declared nowhere"),
        (WHOLE.replace("<joint", "<xacro:grey/><joint"), "<xacro:grey>"),
        (WHOLE.replace("<joint", "<gazebo><a/></gazebo><transmission/><joint"), ""),
        (b"<?xml version='1.0' encoding='utf-16'?>" + WHOLE.encode(), "read as utf-8"),
        (b"<?xml version='1.0' encoding='klingon'?>" + WHOLE.encode(), "read as utf-8"),
        (b"<?xml version='1.0' encoding='cp1252'?>" + WHOLE.encode("cp1252"), ""),
        ("\ufeff" + WHOLE, ""),
        (WHOLE.encode("utf-16"), ""),
        (WHOLE.replace('type="revolute"', 'type="ball"'), "'ball'; it stays still"),
        (WHOLE.replace('<axis xyz="0 0 1"', '<axis xyz="0 0 0"'), "no axis"),
        (WHOLE.replace("<link", '<link name="arm"/><link', 1), "two links arm"),
        (WHOLE.replace('"2"', '"fast"'), 'velocity="fast"> is not a number'),
        (WHOLE.replace("0 0 1", "0 0", 1), 'xyz="0 0"> is not 3 numbers'),
        (WHOLE.replace("0 0 1", "1e300 0 0", 1), 'xyz="1e300 0 0"> is not 3 numbers'),
        (WHOLE.replace("0 0 1", "inf 0 0", 1), 'xyz="inf 0 0"> is not 3 numbers'),
        (WHOLE.replace('upper="1"', 'upper="1e300"'), ""),
        (WHOLE.replace("0 0 1", "0, 0, 1"), ""),
        (WHOLE.replace("0 0 1", "0 0 1d", 1), "read as 0 0 1"),
    ],
)  # fmt: skip
def test_what_other_readers_take_is_taken(text: str | bytes, says: str, tmp_path: Path) -> None:
    robot = _load(tmp_path, text)
    assert set(robot.tree.links) == {"base", "arm"}
    assert any(says in warning for warning in robot.warnings) if says else robot.warnings == ()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (b" \n", "is empty"),
        (WHOLE[:-8], "line 1, column 2.*: it ends within <robot>"),
        (WHOLE.replace("</joint>", "</link>"), "line 1.*: a tag is closed that is not the open"),
        (WHOLE.replace('"base"', '"${base}"'), "a xacro file; expand it first"),
        (WHOLE.replace("0 0 1", "0 0 ${up}"), "a xacro file; expand it first"),
        (
            WHOLE.replace(
                '"arm"/>',
                '"arm"><visual><geometry><mesh filename="${a}.stl"/></geometry></visual></link>',
                1,
            ),
            "a xacro file; expand it first",
        ),
        (WHOLE.replace("<joint", "<xacro:include filename='a'/><joint"), "a xacro file"),
        (WHOLE.replace('"j1"', '""'), "a joint has no name"),
        (WHOLE.replace('<parent link="base"/>', ""), "joint j1 has no <parent"),
        (WHOLE.replace('<child link="arm"', '<child link="leg"'), "there is no link 'leg'"),
        (WHOLE.replace('<parent link="base"', '<parent link="leg"'), "there is no link 'leg'"),
    ],
)
def test_what_no_reader_can_take_is_one_plain_line(
    text: str | bytes, says: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=rf"thing\.urdf.*{says}") as caught:
        _load(tmp_path, text)
    assert "\n" not in str(caught.value)


def test_entities_stay_within_bounds_and_open_no_file(tmp_path: Path) -> None:
    lines = [f'<!ENTITY e{n + 1} "{f"&e{n};" * 10}">' for n in range(12)]
    bomb = f'<!DOCTYPE robot [<!ENTITY e0 "0123456789">{"".join(lines)}]>'
    with pytest.raises(InputError, match="without end"):
        _load(tmp_path, bomb + WHOLE.replace('name="r"', 'name="&e12;"'))
    (tmp_path / "secret").write_text("secret")
    doctype = f'<!DOCTYPE robot [<!ENTITY s SYSTEM "file://{tmp_path}/secret">]>'
    robot = _load(tmp_path, doctype + WHOLE.replace('"arm"', '"arm&s;"'))
    assert set(robot.tree.links) == {"base", "arm"}


def test_what_is_too_large_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(urdf_file, "MAX_BYTES", 500)
    with pytest.raises(InputError, match="no URDF is so large"):
        _load(tmp_path, WHOLE + " " * 500)
    monkeypatch.undo()
    many = "".join(f'<link name="l{n}"/>' for n in range(urdf_file.MAX_LINKS))
    with pytest.raises(InputError, match=r"over 5000 links"):
        _load(tmp_path, WHOLE.replace("<joint", many + "<joint"))
    balls = '<visual><geometry><sphere radius="1"/></geometry></visual>' * 5
    monkeypatch.setattr(meshes, "MAX_VISUALS", 3)
    robot = _load(tmp_path, WHOLE.replace('"arm"/>', f'"arm">{balls}</link>', 1))
    assert len(robot.shapes) == 3
    too_many = ("too many shapes to be shown; left out from link arm on",)
    assert robot.warnings == too_many
    monkeypatch.setattr(meshes, "MAX_FACES", 1300)  # a ball has 1280
    robot = load_robot(str(tmp_path / "thing.urdf"))
    assert (len(robot.shapes), robot.warnings) == (1, too_many)


def test_a_chain_of_any_length_is_a_robot(tmp_path: Path) -> None:
    links = "".join(f'<link name="l{n}"/>' for n in range(3000))
    joints = "".join(
        f'<joint name="j{n}" type="fixed"><parent link="l{n}"/><child link="l{n + 1}"/></joint>'
        for n in range(2999)
    )
    assert len(_load(tmp_path, f'<robot name="r">{links}{joints}</robot>').tree.links) == 3000


@pytest.mark.parametrize(
    ("text", "count", "values", "exact"),
    [
        ("1", 1, [1.0], True),
        (" -1.5e-3 ", 1, [-0.0015], True),
        ("+.5", 1, [0.5], True),
        ("1.", 1, [1.0], True),
        ("1.0f", 1, [1.0], False),
        ("- 1", 1, [-1.0], True),
        ("\N{MINUS SIGN}1", 1, [-1.0], True),
        ("1,5", 1, [1.5], False),
        ("INF", 1, [np.inf], True),
        ("nan", 1, None, False),
        ("", 1, None, False),
        ("pi", 1, None, False),
        ("1 2", 1, None, False),
        ("1,2,3", 3, [1.0, 2.0, 3.0], True),
        ("1, 2\t3\n", 3, [1.0, 2.0, 3.0], True),
        ("0,1 0,2 0,3", 3, [0.1, 0.2, 0.3], False),
        ("1 -2 - 3", 3, [1.0, -2.0, -3.0], True),
        ("1 0 0", 4, [1.0, 0.0, 0.0, 1.0], True),
    ],
)
def test_numbers_as_people_write_them(
    text: str, count: int, values: list[float] | None, exact: bool
) -> None:
    assert read_numbers(text, count) == (values, exact)


# --- shapes ---
@pytest.mark.parametrize(
    ("geometry", "says"),
    [
        ("<box/>", "a box without size"),
        ('<sphere radius="0"/>', "a sphere of no size"),
        ('<cylinder radius="1"/>', "a cylinder without length"),
        ("<mesh/>", "a mesh without filename"),
        ('<cone radius="1"/>', "<cone> where a shape should be"),
        ("", "nothing where a shape should be"),
    ],
)
def test_a_shape_that_cannot_be_shown_is_left_out(geometry: str, says: str, tmp_path: Path) -> None:
    visual = f"<visual><geometry>{geometry}</geometry></visual>"
    good = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    robot = _load(tmp_path, WHOLE.replace('"arm"/>', f'"arm">{visual}{good}</link>', 1))
    assert [shape.link for shape in robot.shapes] == ["arm"]
    (warning,) = robot.warnings
    assert says in warning


@pytest.mark.parametrize("mimic", ["1e6", "-1e6"])
def test_mimics_of_mimics_stay_finite(mimic: str, tmp_path: Path) -> None:
    links = "".join(f'<link name="l{n}"/>' for n in range(80))
    joints = "".join(
        f'<joint name="m{n}" type="prismatic"><parent link="arm"/><child link="l{n}"/>'
        f'<mimic joint="{f"m{n - 1}" if n else "j1"}" multiplier="{mimic}"/></joint>'
        for n in range(80)
    )
    robot = _load(tmp_path, WHOLE.replace("</robot>", f"{links}{joints}</robot>"))
    ends = link_poses(robot, ("j1",), np.ones((1, 1)), tuple(robot.tree.links))
    assert np.isfinite(ends).all()


# --- a skeleton ---
def test_without_meshes_joints_are_drawn_where_they_are(tmp_path: Path) -> None:
    lost = '<visual><geometry><mesh filename="lost.stl"/></geometry></visual>'
    robot = _load(tmp_path, WHOLE.replace('"arm"/>', f'"arm">{lost}</link>', 1))
    assert robot.missing_meshes == ("lost.stl",)
    assert {shape.link for shape in robot.shapes} == {"base", "arm"}
    np.testing.assert_allclose(extent(robot)[:, 2], [-0.02, 1.06], atol=1e-6)  # 1 m between them
    orange = np.round(255 * np.array(COLOR)).astype(int).tolist()
    assert {tuple(shape.material.baseColorFactor) for shape in robot.shapes} == {tuple(orange)}


def test_what_is_there_is_not_covered_by_a_skeleton(tmp_path: Path) -> None:
    lost = '<visual><geometry><mesh filename="lost.stl"/></geometry></visual>'
    box = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    whole = WHOLE.replace('"base"/>', f'"base">{box}{lost}</link>', 1)
    assert len(_load(tmp_path, whole).shapes) == 1  # of the arm nothing was to be seen


# --- meshes are found ---
@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """Packages as in a ROS workspace: `robot` with the description, `other_v2`, named `other`."""
    ball = trimesh.creation.icosphere(1)
    for file in (
        "robot/meshes/Ball.STL",
        "other_v2/meshes/ball.stl",
        "away/share/far/ball.stl",
        "other_v2/meshes/Ball.STL",
    ):
        path = tmp_path / "src" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(ball.export(file_type="stl"))
    (tmp_path / "src" / "robot" / "urdf").mkdir()
    shutil.copy(tmp_path / "src/robot/meshes/Ball.STL", tmp_path / "src/robot/meshes/a b.stl")
    for folder, name in (("robot", "robot_description"), ("other_v2", "other")):
        (tmp_path / "src" / folder / "package.xml").write_text(
            f"<package><name>{name}</name></package>"
        )
    (tmp_path / "src" / "robot" / "meshes" / "notes.txt").write_text("no mesh")
    return tmp_path / "src"


@pytest.mark.parametrize(
    ("name", "found", "remark"),
    [
        ("../meshes/Ball.STL", "robot/meshes/Ball.STL", ""),
        ("../MESHES/ball.stl", "robot/meshes/Ball.STL", "other case"),
        (r"..\meshes\ball.stl", "robot/meshes/Ball.STL", "\\ taken for /, found in other case"),
        ("../meshes/a%20b.stl", "robot/meshes/a b.stl", "%-signs worked out"),
        ("../meshes/a b.stl", "robot/meshes/a b.stl", ""),
        ("package://robot/meshes/Ball.STL", "robot/meshes/Ball.STL", ""),
        ("package://robot_description/meshes/Ball.STL", "robot/meshes/Ball.STL", "folder robot"),
        ("package://no_such/meshes/Ball.STL", "robot/meshes/Ball.STL", ""),
        ("package://other/meshes/ball.stl", "other_v2/meshes/ball.stl", "is the folder other_v2"),
        ("package://other/meshes/Ball.STL", "other_v2/meshes/Ball.STL", "is the folder other_v2"),
        ("package://far/ball.stl", "away/share/far/ball.stl", ""),
        ("model://robot/meshes/Ball.STL", "robot/meshes/Ball.STL", "model://"),
        ("$(find robot)/meshes/Ball.STL", "robot/meshes/Ball.STL", "$(find ...)"),
        ("file://$(find robot)/meshes/Ball.STL", "robot/meshes/Ball.STL", "$(find ...)"),
        ("file://../meshes/Ball.STL", "robot/meshes/Ball.STL", ""),
        ("file:../meshes/Ball.STL", "robot/meshes/Ball.STL", ""),
        ("file:///../meshes/Ball.STL", "robot/meshes/Ball.STL", "beside the description"),
        ("/home/ann/ws/robot/meshes/Ball.STL", "robot/meshes/Ball.STL", "found in src"),
        (r"C:\ws\robot\meshes\Ball.STL", "robot/meshes/Ball.STL", "found in src"),
    ],
)  # fmt: skip
def test_meshes_are_found_as_ros_does(
    name: str, found: str, remark: str, workspace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{workspace / 'away'}")
    file, how = MeshFinder(workspace / "robot/urdf/r.urdf").find(name)
    assert file is not None, how
    assert file.resolve() == workspace / found
    assert (remark in how) if remark else how == ""


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("../meshes/other.stl", "no such file"),
        ("https://example.org/ball.stl", "nothing is fetched"),
        ("../meshes/notes.txt", "can be read"),
        ("file:///etc/passwd", "can be read"),
        ("", "can be read"),
        ("package://", "can be read"),
        ("a" * 5000 + ".stl", "no such file"),
        ("../meshes/%00.stl", "no such file"),
        ("package://../../../../../../../../x.stl", "no such file"),
    ],
)
def test_what_is_no_mesh_is_not_opened(name: str, why: str, workspace: Path) -> None:
    file, how = MeshFinder(workspace / "robot/urdf/r.urdf").find(name)
    assert file is None
    assert why in how


def test_of_two_files_in_other_case_none_is_guessed(workspace: Path) -> None:
    meshes = workspace / "robot" / "meshes"
    shutil.copy(meshes / "Ball.STL", meshes / "BALL.stl")
    assert MeshFinder(workspace / "robot/urdf/r.urdf").find("../meshes/ball.stl")[0] is None


# --- on the stage ---
def _tower(folder: Path, size: float, up: float) -> Robot:
    """A robot of this height (metres), `up` of it above the base; a slide lifts its head."""
    box = (
        f'<visual><origin xyz="0 0 {(up - (size - up)) / 2}"/><geometry>'
        f'<box size="{size / 4} {size / 3} {size}"/></geometry></visual>'
    )
    slide = JOINT.replace("revolute", "prismatic").replace("0 0 1", f"0 0 {up}", 1)
    return _load(
        folder, f'<robot name="r"><link name="base">{box}</link><link name="arm"/>{slide}</robot>'
    )


@pytest.mark.parametrize(("size", "up"), [(0.1, 0.1), (1.2, 0.7), (4.0, 1.0), (40.0, 0.0)])
def test_every_robot_stands_on_the_floor_and_is_well_to_be_seen(
    size: float, up: float, tmp_path: Path
) -> None:
    robot = _tower(tmp_path, size, up)
    shown = staged(robot)
    scale = 1 if AS_IT_IS[0] <= size <= AS_IT_IS[1] else SHOWN_SIZE / size
    low, high = extent(shown)
    assert low[2] == pytest.approx(0, abs=1e-9)
    assert high[2] == pytest.approx(scale * size)
    # What hangs on it goes with it, however far the joint has moved.
    positions = np.array([[0.0], [0.5]])
    for link in ("base", "arm"):
        there = link_poses(robot, ("j1",), positions, (link,))[:, 0, :3, 3]
        here = link_poses(shown, ("j1",), positions, (link,))[:, 0, :3, 3]
        np.testing.assert_allclose(here, scale * there + [0, 0, scale * (size - up)], atol=1e-9)


def test_a_robot_as_large_as_pepper_is_shown_as_it_is() -> None:
    pepper = load_robot("pepper")
    np.testing.assert_allclose(extent(staged(pepper)), extent(pepper), atol=1e-6)
    assert staged(pepper).limits == pepper.limits
