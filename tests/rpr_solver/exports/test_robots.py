"""Paths for ROS 2 and models of SDFormat, read back by other libraries."""

from __future__ import annotations

import json
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from rpr_solver import EXAMPLES, InputError, Manipulator, cusp_loop, export, joint_path, pose_path, poses

INNOCENTI = EXAMPLES["innocenti"]
LIMITS = {"speed": 10, "acceleration": {"l1": 20, "l2": 30, "l3": 20}}


@cache
def moving(which: str) -> dict[str, Any]:
    """Paths within limits of motion, with many samples."""
    start, stop = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}, {"l1": 30, "l2": 21, "l3": 19, "pose": 1}
    options: dict[str, Any] = {"motion": LIMITS, "samples": 301}
    found = {
        "loop": lambda: cusp_loop(INNOCENTI, 27, "B", **options),
        "loop of leg 2": lambda: cusp_loop(INNOCENTI, 20, 1, fixed_leg=2, **options),
        "smooth": lambda: cusp_loop(INNOCENTI, 27, "B", motion={**LIMITS, "jerk": 200}, samples=301),
        "arcs": lambda: joint_path(INNOCENTI, 27, "25.7", "9.2", 2, 4, between=(27, 30), **options),
        "other lengths": lambda: pose_path(INNOCENTI, start, stop, **options),
    }[which]()
    return found.to_json()


def columns(message: Mapping[str, Any]) -> dict[str, np.ndarray]:
    points = message["points"]
    names = [name for name in points[0] if name != "time_from_start"]
    times = [(point["time_from_start"]["sec"], point["time_from_start"]["nanosec"]) for point in points]
    return {
        "times": np.array([sec + nanosec * 1e-9 for sec, nanosec in times]),
        **{name: np.array([point[name] for point in points]) for name in names},
    }


@pytest.mark.parametrize("which", ["loop", "loop of leg 2", "smooth", "arcs", "other lengths"])
def test_velocities_and_accelerations_are_those_of_the_positions(which: str) -> None:
    found = columns(json.loads(export(moving(which), "ros2-json", unit="mm")))
    times = found["times"][:, None]
    step = times[1, 0]
    assert found["positions"].shape == (301, 3)
    slopes = (found["positions"][2:] - found["positions"][:-2]) / (times[2:] - times[:-2])
    assert abs(slopes - found["velocities"][1:-1]).max() < 0.03 * step
    slopes = (found["velocities"][2:] - found["velocities"][:-2]) / (times[2:] - times[:-2])
    # the acceleration jumps at the ends of ticks, unless jerk is limited
    assert np.median(abs(slopes - found["accelerations"][1:-1])) < 1e-3 * step
    assert not found["velocities"][[0, -1]].any()
    assert abs(found["velocities"]).max() <= 0.010 * (1 + 1e-12)
    assert (abs(found["accelerations"]).max(axis=0) <= np.array([0.020, 0.030, 0.020]) * (1 + 1e-12)).all()


@pytest.mark.parametrize(
    ("unit", "metres"),
    [("m", 1), ("cm", Fraction(1, 100)), ("mm", Fraction(1, 1000)), ("in", Fraction(254, 10**4))],
)
def test_a_message_in_yaml_is_that_in_json(unit: str, metres: Fraction) -> None:
    document = moving("loop")
    message = json.loads(export(document, "ros2-json", unit=unit))
    assert yaml.safe_load(export(document, "ros2-yaml", unit=unit)) == message
    assert message["joint_names"] == ["leg1", "leg2", "leg3"]
    assert list(message["points"][0]) == ["positions", "velocities", "accelerations", "time_from_start"]
    for sample, point in zip(document["samples"], message["points"], strict=True):
        lengths = [float(Fraction(sample[leg]) * metres) for leg in ("l1", "l2", "l3")]
        assert point["positions"] == lengths
        time = point["time_from_start"]
        exact = time["sec"] + Fraction(time["nanosec"], 10**9)
        assert abs(exact - Fraction(sample["time"])) <= Fraction(1, 2 * 10**9)
        assert 0 <= time["nanosec"] < 10**9


def matrix(pose: str | None) -> np.ndarray:
    """A planar pose of SDFormat, x y z roll pitch yaw, as a matrix."""
    x, y, z, roll, pitch, yaw = map(float, (pose or "0 0 0 0 0 0").split())
    assert (z, roll, pitch) == (0, 0, 0)
    return np.array([[np.cos(yaw), -np.sin(yaw), x], [np.sin(yaw), np.cos(yaw), y], [0, 0, 1]])


def text_of(element: ElementTree.Element, name: str) -> str:
    found = element.findtext(name)
    assert found is not None
    return found


def moved(kind: str, position: float) -> np.ndarray:
    """What a joint does to its child, in the frame of the joint."""
    return matrix(f"{position} 0 0 0 0 0" if kind == "prismatic" else f"0 0 0 0 0 {position}")


def in_motion(model: ElementTree.Element, positions: Mapping[str, float]) -> dict[str, np.ndarray]:
    """The frames of the links that the joints carry, one after the other, at positions of the joints; a link
    that has its place already is left where it is."""
    at_rest = {link.get("name"): matrix(link.findtext("pose")) for link in model.findall("link")}
    placed = {"base": at_rest["base"]}
    for joint in model.findall("joint"):
        parent, child, name = text_of(joint, "parent"), text_of(joint, "child"), joint.get("name") or ""
        if child in placed or parent == "world":
            continue
        frame = at_rest[child] @ matrix(joint.findtext("pose"))
        move = frame @ moved(joint.get("type") or "", positions.get(name, 0.0)) @ np.linalg.inv(frame)
        placed[child] = placed[parent] @ np.linalg.inv(at_rest[parent]) @ move @ at_rest[child]
    return placed


MACHINES = {
    "innocenti": (INNOCENTI, (27, 20, 20)),
    "clockwise": (
        Manipulator("16.1", "6.8", "12.5", "19.5", "15.1", "18.4", "cw"),
        ("22.2", "30.2", "24.88"),
    ),
    "equilateral": (Manipulator(base={"equilateral": 10}, platform={"equilateral": "sqrt(3)"}), (5, 6, 7)),
    "shared joints": (Manipulator(base={"sides": [0, 3, 3]}, platform={"sides": [3, 4, 5]}), (4, 3, 4)),
}


@pytest.mark.parametrize("name", MACHINES)
def test_the_kinematics_of_a_model_are_those_of_the_pose(name: str) -> None:
    m, lengths = MACHINES[name]
    document = poses(m, *lengths, digits=20).to_json()
    assert document["count"]
    for number, pose in enumerate(document["poses"], 1):
        [model] = ElementTree.fromstring(export(document, "sdf", unit="cm", pose=number))
        links = in_motion(model, {})
        x, y, yaw = (float(pose[name]) for name in ("b1_x", "b1_y", "alpha_deg"))
        expected = matrix(f"{x / 100} {y / 100} 0 0 0 {np.deg2rad(yaw)}")
        assert np.allclose(links["platform"], expected, atol=1e-14)
        # where the legs end, the platform has its joints, and each leg has its length
        for leg, length in enumerate(lengths, 1):
            joint = model.find(f"joint[@name='leg{leg}_platform']")
            assert joint is not None
            corner = links["platform"] @ matrix(joint.findtext("pose")) @ (0, 0, 1)
            assert np.allclose(corner, links[f"leg{leg}_rod"] @ (0, 0, 1), atol=1e-14)
            reach = corner - links[f"leg{leg}_cylinder"] @ (0, 0, 1)
            assert np.hypot(*reach[:2]) == pytest.approx(float(Fraction(length)) / 100, rel=1e-13)
            theta = np.deg2rad(float(pose[f"theta{leg}_deg"]))
            assert np.allclose(links[f"leg{leg}_rod"][:2, 0], [np.cos(theta), np.sin(theta)], atol=1e-13)


def test_moving_all_joints_leads_from_one_pose_to_another() -> None:
    """Leg 1 carries the platform; the others, moved by their lengths and angles, still end at its joints."""
    document = poses(INNOCENTI, 27, 20, 20, digits=20).to_json()
    goal = poses(INNOCENTI, 28, 21, "19.5", digits=20).to_json()["poses"][1]
    pose = document["poses"][1]
    [model] = ElementTree.fromstring(export(document, "sdf", unit="mm", pose=2))
    turned = {
        name: np.deg2rad(float(goal[name]) - float(pose[name])) for name in pose if name.endswith("_deg")
    }
    positions = {"leg1": 0.001, "leg2": 0.001, "leg3": -0.0005}
    positions |= {f"leg{leg}_base": turned[f"theta{leg}_deg"] for leg in (1, 2, 3)}
    positions["leg1_platform"] = turned["alpha_deg"] - turned["theta1_deg"]
    links = in_motion(model, positions)
    x, y, yaw = float(goal["b1_x"]), float(goal["b1_y"]), np.deg2rad(float(goal["alpha_deg"]))
    assert np.allclose(links["platform"], matrix(f"{x / 1000} {y / 1000} 0 0 0 {yaw}"), atol=1e-14)
    for leg in (2, 3):
        joint = model.find(f"joint[@name='leg{leg}_platform']")
        assert joint is not None
        corner = links["platform"] @ matrix(joint.findtext("pose")) @ (0, 0, 1)
        assert np.allclose(corner, links[f"leg{leg}_rod"] @ (0, 0, 1), atol=1e-14)


_VECTOR, _POSE = 3, 6
FORM: dict[str, Any] = {
    "sdf": ({"version"}, {"model": 1}),
    "model": ({"name"}, {"link": None, "joint": None}),
    "link": ({"name"}, {"pose": 1, "inertial": 1, "visual": None}),
    "visual": ({"name"}, {"pose": 1, "geometry": 1}),
    "geometry": (set(), {"box": 1}),
    "box": (set(), {"size": 1}),
    "inertial": (set(), {"mass": 1, "inertia": 1}),
    "inertia": (set(), dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1)),
    "joint": ({"name", "type"}, {"pose": None, "parent": 1, "child": 1, "axis": None}),
    "axis": (set(), {"xyz": 1, "limit": 1}),
    "limit": (set(), {"lower": 1, "upper": 1}),
    **dict.fromkeys(("size", "xyz"), _VECTOR),
    "pose": _POSE,
    **dict.fromkeys(("mass", "ixx", "ixy", "ixz", "iyy", "iyz", "izz", "lower", "upper"), 1),
}
"""What the description of SDFormat 1.9 (joint.sdf, link.sdf, …) says of the elements of a model: attributes
and elements within, with how many there must be; or how many numbers."""


def is_formed(element: ElementTree.Element) -> None:
    form = FORM.get(element.tag)
    if isinstance(form, int):
        assert len(list(map(float, (element.text or "").split()))) == form
    elif form is not None:
        attributes, inner = form
        assert set(element.attrib) == attributes
        tags = [part.tag for part in element]
        assert set(tags) <= set(inner)
        assert all(number is None or tags.count(tag) == number for tag, number in inner.items())
        for part in element:
            is_formed(part)


@pytest.mark.parametrize("name", MACHINES)
def test_a_model_has_the_form_of_sdformat(name: str) -> None:
    m, lengths = MACHINES[name]
    root = ElementTree.fromstring(export(poses(m, *lengths, digits=15).to_json(), "sdf", unit="in"))
    is_formed(root)
    [model] = root
    names = [part.get("name") for part in model]
    assert len(set(names)) == len(names)
    links = {link.get("name") for link in model.findall("link")}
    joints = model.findall("joint")
    for joint in joints:
        assert {text_of(joint, "child")} <= links
        assert {text_of(joint, "parent")} <= {*links, "world"}
    kinds = [joint.get("type") for joint in joints]
    assert (kinds.count("prismatic"), kinds.count("revolute"), kinds.count("fixed")) == (3, 6, 1)
    # a tree has as many joints as links: two of these close loops
    assert len(joints) == len(links) + 2
    for inertia in model.iter("inertia"):
        ixx, iyy, izz = (float(text_of(inertia, name)) for name in ("ixx", "iyy", "izz"))
        assert 0 < izz < ixx + iyy


@pytest.mark.parametrize("name", ['"/><plugin name="x" filename="y">', "a & b", "'<!--", "]]>", "café ☃"])
def test_a_hostile_name_is_a_name(name: str) -> None:
    document = poses(INNOCENTI, 27, 20, 20, digits=15).to_json()
    root = ElementTree.fromstring(export(document, "sdf", unit="mm", name=name))
    is_formed(root)
    assert root[0].get("name") == name


@pytest.mark.parametrize(
    ("kind", "system", "options", "field"),
    [
        ("poses", "sdf", {}, "unit"),
        ("poses", "sdf", {"unit": "ft"}, "unit"),
        ("poses", "sdf", {"unit": "mm", "pose": 5}, "pose"),
        ("poses", "sdf", {"unit": "mm", "pose": 0}, "pose"),
        ("poses", "sdf", {"unit": "mm", "name": "a::b"}, "name"),
        ("poses", "sdf", {"unit": "mm", "name": "__model__"}, "name"),
        ("poses", "sdf", {"unit": "mm", "name": "a\nb"}, "name"),
        ("poses", "sdf", {"unit": "mm", "relative": True}, "relative"),
        ("poses", "ros2-yaml", {"unit": "mm"}, "document"),
        ("path", "sdf", {"unit": "mm"}, "document"),
        ("path", "ros2-yaml", {}, "unit"),
        ("path", "ros2-json", {"unit": "mm", "pose": 1}, "pose"),
        ("path", "pari", {"unit": "mm"}, "unit"),
        ("none", "ros2-json", {"unit": "mm"}, "document"),
        ("quick", "ros2-json", {"unit": "mm"}, "document"),
    ],
)
def test_what_cannot_be_exported_is_named(
    kind: str, system: str, options: dict[str, Any], field: str
) -> None:
    document = {
        "poses": lambda: poses(INNOCENTI, 27, 20, 20, digits=15).to_json(),
        "path": lambda: moving("loop"),
        "none": lambda: joint_path(INNOCENTI, 27, 20, 20, 1, 3).to_json(),
        "quick": lambda: cusp_loop(INNOCENTI, 27, "B", samples=101, duration="1e-8").to_json(),
    }[kind]()
    with pytest.raises(InputError) as caught:
        export(document, system, **options)
    assert [p.field for p in caught.value.problems] == [field]
