"""`python -m sim`: the simulated robot as a process. To everyone else on ROS 2 it is the robot."""

import logging
import math
import signal
import sys
from types import FrameType
from typing import TYPE_CHECKING

import structlog
from pydantic import ValidationError

from mesh.logging import configure_logging
from sim.settings import SimSettings

if TYPE_CHECKING:
    from sim.home import Home, Wanted
    from sim.world import World

log = structlog.get_logger()

UNDOCKED_M = 0.5


def main() -> int:
    """0 after SIGINT or SIGTERM; 1 when the simulation died; 2 when it cannot be started as asked."""
    try:
        settings = SimSettings(_cli_parse_args=True)  # pyright: ignore[reportCallIssue]
    except ValidationError as error:
        configure_logging("sim")
        for wrong in error.errors(include_url=False):
            log.error("wrong setting", name=".".join(map(str, wrong["loc"])), reason=wrong["msg"])  # noqa: TRY400
        return 2
    configure_logging("sim", level=settings.log_level)
    logging.getLogger("OpenGL").setLevel(logging.ERROR)  # it tells of every library it does without
    signal.signal(signal.SIGTERM, _end)

    from mesh.server import serve
    from mesh.tasks import end_this_process
    from sim.ros.node import SimulatedRobot
    from sim.truth_api import create_app

    try:
        home = make_home(settings)
    except (OSError, ValueError) as error:
        log.error("there is no such home", reason=str(error))  # noqa: TRY400 - said to a person
        return 2
    robot = SimulatedRobot(settings, lambda: make_world(home, settings))
    log.info("starting", seed=home.seed, rooms=len(home.rooms), things=len(home.things), port=settings.port)
    code = 0
    try:
        serve(create_app(robot, home, on_death=end_this_process), host=settings.host, port=settings.port)
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else 1
    log.info("stopped", real_time_factor=round(robot.realtime.pace.factor, 3))
    if robot.died:
        log.error("the simulation ended by an error", reason=str(robot.reason))
        return 1
    return code


def make_home(settings: SimSettings) -> "Home":
    """Loads or generates the home. Raises OSError or ValueError with a sentence on what is wrong."""
    from sim.home import Home

    if settings.home is not None:
        home = Home.load(settings.home)
    else:
        home = Home.generate(settings.seed, wanted=parse_wanted(settings.want))
    if settings.save_home is not None:
        home.save(settings.save_home)
    return home


def parse_wanted(phrase: str) -> "Wanted | None":
    """'red bottle' -> a bottle that is red; 'potted plant' -> one of any colour; '' -> none."""
    from sim.home import Wanted
    from sim.home.catalog import ALL_COLOURS

    words = phrase.lower().split()
    if not words:
        return None
    if words[0] in ALL_COLOURS and len(words) > 1:
        return Wanted(" ".join(words[1:]), words[0])
    return Wanted(" ".join(words))


def make_world(home: "Home", settings: SimSettings) -> "World":
    """The robot stands in front of the dock with its back to it, or in it."""
    from contracts.geometry import Pose2D
    from geometry.poses import compose
    from sim.world import World, WorldOptions
    from sim.world.arm.models import ARMS
    from sim.world.scenes import scene_of

    scene = scene_of(home)
    start = None if settings.start_docked else compose(scene.dock, Pose2D(x=-UNDOCKED_M, y=0.0, yaw=math.pi))
    options = WorldOptions(base_timeout_s=settings.base_timeout_s, arm=ARMS.get(settings.arm))
    return World(scene, seed=settings.seed, start=start, options=options)


def _end(_: int, __: FrameType | None) -> None:
    """uvicorn passes SIGTERM on to here once it has closed everything."""
    raise SystemExit(0)


if __name__ == "__main__":
    sys.exit(main())
