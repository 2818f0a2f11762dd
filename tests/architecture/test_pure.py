"""The modules that decide: they compute, and touch neither clock nor network nor file, nor anything that does."""

import sys
from functools import cache

import pytest

from support.source import Module, all_modules

PURE = {
    "coordinator": (
        "belief",
        "commands.abilities",
        "commands.readings",
        "commands.where_to_look",
        "core",
        "coverage.areas",
        "coverage.coverage_tracker",
        "coverage.lawnmower",
        "coverage.viewpoints",
        "coverage.visibility",
        "execution.mission_messages",
        "exploration",
        "manipulation",
        "questions.rooms_meant",
        "questions.tallies",
        "queue.parse_validation",
    ),
    "ear": ("choices", "core", "messages", "quiet_hours", "sayings", "tones", "words"),
    "geometry": ("boxes", "grids", "places", "poses", "probability_grids", "regions", "room_grids", "rooms"),
    "grasping": ("candidates", "hands", "planning", "reachability", "things"),
    "home_assistant": ("discovery", "states"),
    "inference": (
        "boxes",
        "colours",
        "language.answers",
        "language.breaker",
        "parsing.describing",
        "parsing.lexicon",
        "parsing.mentions",
        "parsing.needs",
        "parsing.parser",
        "parsing.splitting",
        "perception.classes",
        "perception.raw_boxes",
        "validation.votes",
    ),
    "memory": (
        "belief",
        "class_priors",
        "exchange",
        "frames",
        "naming",
        "negative_evidence",
        "object_association",
        "objects",
        "picture",
        "recall",
        "views",
    ),
    "robot_bridge": (
        "arm.joint_states",
        "arm.models",
        "arm.trajectories",
        "motion.arbiter",
        "motion.motions",
        "navigation.candidate_poses",
        "navigation.goal_states",
        "navigation.initial_pose",
        "safety.base_stop",
        "safety.collision_monitor",
        "safety.gaps",
        "safety.obstacles",
        "sensing.blindness",
        "sensing.depth",
        "sensing.endpoints",
        "sensing.reception",
        "sensing.stamps",
        "sensing.transforms",
    ),
    "speech": ("end_of_speech", "readings", "sound"),
    "sim": (
        "nav",
        "home.catalog",
        "home.furnish",
        "home.layout",
        "home.placement",
        "world.arm.controller",
        "world.arm.trajectory",
        "world.base",
        "world.sensors",
    ),
    "vocabulary": (
        "actions",
        "folding",
        "groups",
        "hot_words",
        "labels",
        "languages",
        "looks",
        "moods",
        "orders",
        "restrictions",
        "rooms",
        "sounding",
        "spelling",
    ),
    "ui": ("latest_facts", "notifications", "overlay", "page_model", "suggestions", "teleoperation", "timeline_lines"),
}
"""The one table. A name stands for the module or for everything in the package."""

LIBRARIES = frozenset({
    "numpy", "scipy",
    "pydantic",  # the contracts are made of it
    "jellyfish",  # how words sound
    "rapidfuzz",  # distances between words
    "pytransform3d", "simple_pid", "skimage",  # arithmetic on arrays, and a PID that is told how much time has passed
})  # fmt: skip

SHARED = frozenset({"contracts", "geometry", "vocabulary"})
"""Pure themselves."""

WORLDLY = frozenset({
    "asyncio", "concurrent", "http", "logging", "multiprocessing", "os", "pathlib", "random", "secrets", "selectors",
    "shutil", "signal", "socket", "sqlite3", "subprocess", "tempfile", "threading", "time", "urllib", "uuid",
})  # fmt: skip
"""Of the standard library, what reaches outside: a pure module is given the time and its random numbers."""


DATA_OF_OTHERS = {"mesh", "mesh.latest_value", "store", "store.copies"}
"""Types that ports name beside those of pure modules: a reading (of asyncio alone), a copy of a database."""


@cache
def by_name() -> dict[str, Module]:
    return {one.name: one for one in all_modules()}


def pure_modules() -> list[str]:
    entries = [f"{package}.{entry}" for package, names in PURE.items() for entry in names]
    return sorted({name for entry in entries for name in by_name() if name == entry or name.startswith(f"{entry}.")})


def needed_by(name: str) -> set[str]:
    """The module and every module of ours that importing it brings along, packages on the way included."""
    known = by_name()
    found: set[str] = set()
    waiting = [name]
    while waiting:
        current = waiting.pop()
        if current in found or current not in known:
            continue
        found.add(current)
        parts = current.split(".")
        waiting += [".".join(parts[:k]) for k in range(1, len(parts))]
        waiting += known[current].imports
    return found


def test_every_name_in_the_table_stands_for_a_module() -> None:
    entries = {f"{package}.{entry}" for package, names in PURE.items() for entry in names}
    assert entries - by_name().keys() == set()


@pytest.mark.parametrize("name", pure_modules())
def test_a_pure_module_imports_only_arithmetic_data_and_its_own_package(name: str) -> None:
    module = by_name()[name]
    allowed = LIBRARIES | {*SHARED, name.partition(".")[0]} | (sys.stdlib_module_names - WORLDLY)
    assert module.roots - allowed == set()


@pytest.mark.parametrize("name", [name for name in pure_modules() if not name.startswith("sim.")])
def test_what_a_pure_module_brings_along_needs_no_other_library_either(name: str) -> None:
    """Not asked of the simulator: its packages open with the whole world, physics and all."""
    own = {*SHARED, name.partition(".")[0]}
    brought = {one: by_name()[one] for one in needed_by(name)}
    foreign = {one: module.third_party - LIBRARIES for one, module in brought.items() if module.third_party - LIBRARIES}
    assert foreign == {}
    others = {one for one in brought if one.partition(".")[0] not in own}
    assert others <= DATA_OF_OTHERS
