"""Who may import what: the walls between the services, and the few places where a heavy thing is let in."""

import ast
import re
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from support.source import OURS, ROOT, SERVICES, Module, all_modules, imports_of, modules, within

ROS = frozenset({
    "rclpy", "rclcpp", "tf2_ros", "tf2_geometry_msgs", "cv_bridge", "ament_index_python", "launch", "launch_ros",
    "builtin_interfaces", "rcl_interfaces", "unique_identifier_msgs", "rosidl_runtime_py", "std_srvs",
})  # fmt: skip
"""Beside every package whose name ends in `_msgs`."""
ROS_LIVES_IN = ("robot_bridge.adapters", "robot_bridge.doctor.examination", "sim.ros")

MODELS = frozenset({
    "torch", "torchvision", "ultralytics", "open_clip", "openvino", "onnxruntime", "transformers",
    "faster_whisper", "hibari", "pyopen_wakeword",
})  # fmt: skip
MODELS_LIVE_IN = (
    "ear.adapters",
    "inference.adapters",
    "inference.perception.small_clip",
    "inference.perception.torchvision_cpu",
    "sim.training",
    "speech.adapters",
)

PHYSICS = frozenset({"mujoco", "mink"})
PHYSICS_LIVES_IN = ("grasping.kinematics", "sim.world", "sim.training")

DATABASES = frozenset({"sqlalchemy", "sqlite3", "alembic", "asyncpg", "psycopg"})
DATABASES_LIVE_IN = ("coordinator.adapters", "memory.adapters", "store")

TRAINING_MAY_BORROW = ("inference.perception.small_clip", "inference.perception.torchvision_cpu")
"""What is trained must be, to the letter, what later runs."""

CONTRACTS_MAY_IMPORT = frozenset({
    "contracts", "pydantic", "dataclasses", "enum", "typing", "collections", "math", "functools", "re",
    "hashlib", "hmac",
})  # fmt: skip
"""Data only: names to build messages of, and nothing that could do anything with them."""

SHARED = frozenset({"clients", "contracts", "geometry", "grasping", "mesh", "store", "vocabulary"})
"""The packages that a service may import."""

MESH_MAY_KNOW = ("contracts.access", "contracts.base", "contracts.problem", "contracts.topics")
"""Plumbing knows that there are messages and problems, not what they are about."""


def is_ros(root: str) -> bool:
    return root in ROS or root.endswith("_msgs")


def strangers(module: Module, roots: frozenset[str], home: tuple[str, ...]) -> set[str]:
    """What a module imports of `roots` although it does not live in `home`."""
    return set() if within(module.name, home) else set(module.roots & roots)


@pytest.mark.parametrize("service", SERVICES)
def test_a_service_imports_no_other_service_nor_the_simulator(service: str) -> None:
    others = OURS - {service, *SHARED}
    assert {one.name: one.roots & others for one in modules(service) if one.roots & others} == {}


def test_the_ear_is_a_client_that_imports_no_service() -> None:
    others = OURS - {"ear", "clients", "contracts", "mesh", "vocabulary"}
    assert {one.name: one.roots & others for one in modules("ear") if one.roots & others} == {}


def test_the_way_to_home_assistant_is_a_client_that_imports_no_service() -> None:
    others = OURS - {"home_assistant", "clients", "contracts", "mesh", "vocabulary"}
    assert {one.name: one.roots & others for one in modules("home_assistant") if one.roots & others} == {}


def test_only_the_bridges_adapters_and_the_simulated_robot_speak_ros() -> None:
    found = {
        one.name: {root for root in one.roots if is_ros(root)}
        for one in all_modules()
        if not within(one.name, ROS_LIVES_IN)
    }
    assert {name: roots for name, roots in found.items() if roots} == {}


@pytest.mark.parametrize(
    ("libraries", "home"),
    [(MODELS, MODELS_LIVE_IN), (PHYSICS, PHYSICS_LIVES_IN), (DATABASES, DATABASES_LIVE_IN)],
    ids=["models", "physics", "databases"],
)
def test_a_heavy_library_stays_where_it_lives(libraries: frozenset[str], home: tuple[str, ...]) -> None:
    found = {one.name: strangers(one, libraries, home) for one in all_modules()}
    assert {name: roots for name, roots in found.items() if roots} == {}


def test_contracts_do_no_input_or_output() -> None:
    found = {one.name: one.roots - CONTRACTS_MAY_IMPORT for one in modules("contracts")}
    assert {name: roots for name, roots in found.items() if roots} == {}


def test_the_mesh_knows_no_service_and_no_domain() -> None:
    ours = tuple(OURS - {"mesh"})
    allowed = (*MESH_MAY_KNOW, "mesh")
    found = {n.name: {i for i in n.imports if within(i, ours) and not within(i, allowed)} for n in modules("mesh")}
    assert {name: names for name, names in found.items() if names} == {}


def test_grasps_are_planned_without_any_service() -> None:
    others = OURS - {"grasping", "contracts", "geometry"}
    assert {one.name: one.roots & others for one in modules("grasping") if one.roots & others} == {}


def test_a_shared_client_knows_what_is_said_and_how_it_travels() -> None:
    others = OURS - {"clients", "contracts", "mesh"}
    assert {one.name: one.roots & others for one in modules("clients") if one.roots & others} == {}


def test_the_simulator_imports_no_service_but_the_model_it_trains() -> None:
    found = {
        one.name: {
            name
            for name in one.imports
            if within(name, SERVICES)
            and not (within(one.name, ("sim.training",)) and within(name, ("inference", *TRAINING_MAY_BORROW)))
        }
        for one in modules("sim")
    }
    assert {name: names for name, names in found.items() if names} == {}


def test_training_borrows_of_inference_only_the_model_itself() -> None:
    modules_of_inference = {one.name for one in modules("inference") if one.path.name != "__init__.py"}
    borrowed = {name for one in modules("sim") for name in one.imports} & modules_of_inference
    assert borrowed <= set(TRAINING_MAY_BORROW)


def test_only_the_bridge_names_the_topic_that_moves_the_wheels() -> None:
    others = (one for service in (*SERVICES, "demo", "mesh", "contracts") for one in modules(service))
    naming = {
        one.name
        for one in others
        for node in ast.walk(one.tree)
        if isinstance(node, ast.Constant) and node.value in {"cmd_vel", "/cmd_vel", "cmd_vel_unstamped"}
    }
    assert {name for name in naming if not within(name, ("robot_bridge",))} == set()


@pytest.mark.parametrize("service", SERVICES)
def test_composing_a_service_loads_no_ros_and_no_model(service: str) -> None:
    """So that its tests need none of them, and `--help` answers at once."""
    heavy = sorted(MODELS | PHYSICS | {"rclpy"})
    script = f"import sys, {service}.app; print(*({set(heavy)!r} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=120)
    assert (done.returncode, done.stdout.split()) == (0, []), done.stderr


@pytest.mark.parametrize("service", SERVICES)
def test_a_service_declares_every_library_it_imports(service: str) -> None:
    """Its image holds what is named there and no more. Extras may not be installed; ROS comes from outside."""
    providers = {"hibari": ["hibari-tts"], "piper": ["piper-tts"], **packages_distributions()}
    folders = (f"services/{service}", *(f"packages/{name}" for name in sorted(SHARED)))
    declared = {"starlette"}.union(*(_declared(ROOT / folder) for folder in folders))
    imported = {root for one in modules(service) for root in one.third_party if not is_ros(root)}
    undeclared = {root for root in imported if not {_plain(name) for name in providers.get(root, [root])} & declared}
    assert undeclared == set()


def _declared(folder: Path) -> set[str]:
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = [one for group in project.get("optional-dependencies", {}).values() for one in group]
    return {_plain(re.split(r"[\[<>=!~; @]", one)[0]) for one in (*project["dependencies"], *extras)}


def _plain(distribution: str) -> str:
    return re.sub(r"[-_.]+", "-", distribution).lower()


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("import torch.nn", "torch.nn"),
        ("def f():\n    import rclpy", "rclpy"),
        ("from coordinator import app", "coordinator.app"),
        ("from importlib import import_module\nimport_module('memory.app')", "memory.app"),
        ("import importlib\nimportlib.import_module('memory')", "memory"),
        ("from . import b", "package.b"),
        ("from ..other.c import d", "other.c"),
    ],
)
def test_no_way_of_importing_escapes_the_eye_of_these_tests(source: str, found: str) -> None:
    assert found in imports_of(ast.parse(source), "package.a")
