"""Files of other kinds of motion: named, with what would be right instead."""

from __future__ import annotations

_TABLE = "a table with one column a joint (CSV) would be right"
# How a file begins -> what it is, and what would be right.
_BEGINNINGS: tuple[tuple[bytes, str, str], ...] = (
    (b"HIERARCHY", "motion capture (BVH): positions of a skeleton, not of a robot's joints",
     "retarget it to the robot, then " + _TABLE),
    (b"PAR1", "a Parquet file, as LeRobot's data sets have", "read it with pandas and save "
     "observation.state with a column a joint as CSV"),
    (b"\x93NUMPY", "a binary array of numpy", "numpy.savetxt with the joints' names as its header"),
    (b"#ROSBAG", "a ROS bag", "rostopic echo -p /joint_states, saved to a file"),
    (b"\x89MCAP", "a ROS 2 recording", "ros2 topic echo --csv /joint_states, saved to a file"),
    (b"\x89HDF", "an HDF5 file", _TABLE),
    (b"%PDF", "a PDF", _TABLE),
)  # fmt: skip
_ZIPPED = (
    (b"data.pkl", "a model, not a motion", "give it as --ckpt"),
    (b".npy", "arrays of numpy (npz), as AMASS has of human bodies",
     "retarget it to the robot where it is a human body, then " + _TABLE),
    (b"xl/", "an Excel workbook", "save the sheet as CSV"),
)  # fmt: skip
_XML = (
    ("<ChoregrapheProject", "a Choregraphe behaviour (.xar)",
     "export its timeline as a Python script or an animation (.qianim)"),
    ("<Package", "a Choregraphe project (.pml)",
     "export a timeline of it as a Python script or an animation (.qianim)"),
    ("<robot", "a robot description, not a motion", "give it as --robot"),
)  # fmt: skip


def foreign(content: bytes) -> str:
    """What a file seems to be that is no motion for here, and what would be right; or ""."""
    for beginning, what, right in _BEGINNINGS:
        if content.lstrip(b"\xef\xbb\xbf \r\n").startswith(beginning):
            return f"seems to be {what}; {right}"
    if content.startswith(b"PK\x03\x04"):
        for inside, what, right in _ZIPPED:
            if inside in content[:4096] or inside in content[-4096:]:
                return f"seems to be {what}; {right}"
        return f"is a ZIP archive; unpack it: {_TABLE}"
    head = content[:4096].decode("latin-1").replace("\0", "")
    if head.lstrip("\xef\xbb\xbf\xff\xfe ").startswith("<?xml"):
        for mark, what, right in _XML:
            if mark in head:
                return f"seems to be {what}; {right}"
    return ""


def foreign_json(data: object) -> str:
    """The same of what a JSON file holds."""
    keys = set(data) if isinstance(data, dict) else set()
    if {"joint_names", "points"} <= keys:
        return (
            "seems to be a ROS joint trajectory; a table of what the robot did (rostopic echo -p "
            "/joint_states) would be right, or its points as CSV with a column a joint"
        )
    if {"framerate", "positions"} <= keys:
        return f"seems to be a move recorded on a Poppy robot, in degrees; {_TABLE}"
    return ""
