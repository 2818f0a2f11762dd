"""Every call a service's own clients can make, made once: what each service asks of each other."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import aclosing
from typing import Any, Final

import numpy as np

from atom_cli.services import Services
from contracts.actions import CountAction, ExploreAction, StopAction
from contracts.geometry import Pose2D, Twist2D
from contracts.language import ReasonRequest
from contracts.measuring import LocalizeRequest
from contracts.memory import LookBatch, RecallRequest
from contracts.motion import RotateRequest
from contracts.robot import CandidatePose, EmergencyStopRequest, GoalRequest, PathRequest
from contracts.speech import RATE_HZ
from contracts.vision import ParseTaskRequest, Target, ValidateRequest
from coordinator.adapters.inference import InferenceClient
from coordinator.adapters.memory import MemoryClient
from coordinator.adapters.robot_bridge import RobotBridgeClient
from coordinator.settings import Settings
from inference.adapters.bridge_camera import BridgeCamera
from memory.adapters.robot_bridge import MAP_AGE_S_MAX, RobotBridge
from speech.sound import to_wav
from support.consumer_link import InThread, Line
from support.fake_clock import FakeClock
from support.observations import look
from support.waiting import until
from ui.adapters.coordinator import CoordinatorClient
from ui.adapters.memory import MemoryClient as PageMemory
from ui.adapters.robot_bridge import RobotBridgeClient as PageBridge
from ui.settings import Settings as PageSettings

CUP: Final = Target(label="cup", description="red cup")
NEAR: Final = Pose2D(x=1.35, y=2.0, yaw=0.0)
OFF_THE_MAP: Final = Pose2D(x=400.0, y=2.0, yaw=0.0)
SOUND: Final = to_wav(np.full(RATE_HZ // 4, 0.3, np.float32), RATE_HZ)
BOXES: Final = LocalizeRequest(boxes_xyxy=((105.0, 105.0, 145.0, 145.0),), image_width_px=250, image_height_px=250)


async def coordinator_of_inference(line: Line) -> None:
    async with aclosing(InferenceClient(Settings(), transport=line)) as inference:
        await line.ask(inference.parse_task(ParseTaskRequest(command="find the red bottle, then the book")))
        judged = await line.ask(inference.validate(ValidateRequest(target=CUP), timeout_s=5.0))
        await line.ask(inference.evidence(judged.id))
        asked = ReasonRequest(question="How many cups are there?", facts=("There are 3 cups.",))
        await line.ask(inference.reason(asked))


async def coordinator_of_memory(line: Line) -> None:
    async with aclosing(MemoryClient(Settings(), transport=line)) as memory:
        await line.ask(memory.labels())
        await line.ask(memory.recall(RecallRequest(target=CUP)))
        await line.ask(memory.views("cup", 10))
        await line.ask(memory.objects("cup", 10))
        await line.ask(memory.objects(None, 10))
        await line.ask(memory.objects("cup", 10, 3))
        await line.ask(memory.rooms())
        await line.ask(memory.room_grid())
        await line.ask(memory.looks(LookBatch(looks=(look(),))))


async def coordinator_of_robot_bridge(line: Line) -> None:
    async with _held(line) as robot:
        await line.ask(robot.map())
        await line.ask(robot.state())
        await line.ask(robot.scan())
        await line.ask(robot.obstacles())
        await line.ask(robot.dock(timeout_s=5.0))
        await line.ask(robot.undock(timeout_s=5.0))
        await line.ask(robot.rotate(0.1, speed_rad_s=1.0, timeout_s=5.0, epoch=0))
        await line.ask(robot.drive(0.03, speed_m_s=0.2, timeout_s=5.0, epoch=0))
        await line.ask(robot.velocity(Twist2D(angular_z=0.1), duration_s=0.2, epoch=0))
        await line.ask(robot.end_motion())
        await line.ask(robot.navigate(_goal(OFF_THE_MAP)))
        goal = await line.ask(robot.navigate(_goal(NEAR)))
        await line.ask(robot.goal(goal.id))
        await line.ask(robot.cancel_goal(goal.id))
        await line.ask(robot.celebrate())
        await line.ask(robot.celebrate())
        await line.ask(robot.halt())
        await line.ask(robot.emergency_stop("operator"))


@contextlib.asynccontextmanager
async def _held(line: Line) -> AsyncIterator[RobotBridgeClient]:
    async with aclosing(RobotBridgeClient(Settings(), transport=line, open_socket=line.socket)) as robot:
        holding = asyncio.create_task(robot.hold_session())
        try:
            await until(lambda: robot.session_held)
            yield robot
        finally:
            holding.cancel()
            await asyncio.gather(holding, return_exceptions=True)


async def ui_of_coordinator(line: Line) -> None:
    async with aclosing(CoordinatorClient(PageSettings(), transport=line)) as missions:
        under_way, found = await line.ask(missions.newest(10))
        await line.ask(missions.events(found.id))
        await line.ask(missions.picture(found.id, 0))
        await line.ask(missions.belief(under_way.id))
        await line.ask(missions.belief(found.id))
        await line.ask(missions.pause(under_way.id))
        await line.ask(missions.resume(under_way.id))
        await line.ask(missions.cancel(under_way.id))
        await line.ask(missions.start("find the red bottle", key="k-1"))
        await line.ask(missions.start("stop", key="k-2"))
        await line.ask(missions.ask("where is the cup?"))
        await line.ask(missions.do(ExploreAction(duration_s=120.0)))
        await line.ask(missions.understand(("find the red bottle", "Find the bread bottle.")))
        await line.ask(missions.status())


async def ui_of_memory(line: Line) -> None:
    async with aclosing(PageMemory(PageSettings(), transport=line)) as memory:
        await line.ask(memory.labels())
        (cup, *_) = await line.ask(memory.objects())
        await line.ask(memory.views())
        first, *_ = (await line.ask(memory.rooms())).rooms
        await line.ask(memory.room_grid())
        await line.ask(memory.name_room(first.id, "den"))
        exported = await line.ask(memory.export())
        await line.ask(memory.forget_object(cup.id))
        await line.ask(memory.forget_label("book"))
        await line.ask(memory.import_(exported))


async def ui_of_robot_bridge(line: Line) -> None:
    asked = EmergencyStopRequest(reason="STOP pressed on the page", by="10.0.0.2")
    async with aclosing(PageBridge(PageSettings(), transport=line)) as robot:
        await line.ask(robot.stop_state())
        await line.ask(robot.stop_answers())
        await line.ask(robot.state())
        await line.ask(robot.map())
        await line.ask(robot.scan())
        await line.ask(robot.frame(after_s=None, wait_s=1.0))
        await line.ask(robot.frame(after_s=1.0, wait_s=1.0))
        await line.ask(robot.dock())
        await line.ask(robot.undock())
        await line.ask(robot.rotate(RotateRequest(angle_rad=0.1, speed_rad_s=1.0, timeout_s=5.0, epoch=0)))
        await line.ask(robot.end_motion())
        await line.ask(robot.path(PathRequest(goal=NEAR)))
        goal = await line.ask(robot.go(_goal(NEAR)))
        await line.ask(robot.cancel_goal(goal.id))
        await line.ask(robot.celebrate())
        await line.ask(robot.emergency_stop(asked))
        await line.ask(robot.reset(asked))


async def inference_of_robot_bridge(line: Line) -> None:
    async with aclosing(BridgeCamera("http://robot_bridge", transport=line)) as camera:
        await line.ask(camera.newest(after_s=None, wait_s=1.0))
        await line.ask(camera.localize(BOXES))


async def memory_of_robot_bridge(line: Line) -> None:
    clock = FakeClock()
    async with aclosing(RobotBridge("http://robot_bridge", clock, timeout_s=5.0, transport=line)) as bridge:
        await line.ask(bridge.localize(BOXES))
        await line.ask(bridge.ground())
        await clock.advance(2 * MAP_AGE_S_MAX)
        await line.ask(bridge.home())


async def cli_of_coordinator(line: Line) -> None:
    with _terminal(line) as services:
        started = await line.ask_in_thread(services.start, "find the red bottle")
        await line.ask_in_thread(services.mission, started.id)  # type: ignore[union-attr]
        await line.ask_in_thread(services.events, started.id, after=-1)  # type: ignore[union-attr]
        await line.ask_in_thread(services.ask, "where is the cup?")
        await line.ask_in_thread(services.missions, 2)
        await line.ask_in_thread(services.do, StopAction())
        await line.ask_in_thread(services.do, CountAction(thing="cup"))
        await line.ask_in_thread(services.status)
        await line.ask_in_thread(services.understand, ("find the cup", "find the cap"))
        await line.ask_in_thread(services.start, "stop")


async def cli_of_memory(line: Line) -> None:
    with _terminal(line) as services:
        await line.ask_in_thread(services.labels)
        await line.ask_in_thread(services.objects, "cup")


async def cli_of_robot_bridge(line: Line) -> None:
    with _terminal(line) as services:
        await line.ask_in_thread(services.ready, "robot_bridge")
        await line.ask_in_thread(services.robot)
        await line.ask_in_thread(services.stop)
        await line.ask_in_thread(services.resume)


async def cli_of_speech(line: Line) -> None:
    with _terminal(line) as services:
        await line.ask_in_thread(services.transcribe, SOUND, ["tea pot"])


def _terminal(line: Line) -> Services:
    return Services("robot", 8000, transport=InThread(line))


def _goal(pose: Pose2D) -> GoalRequest:
    return GoalRequest(candidates=(CandidatePose(pose=pose),), epoch=0)


Script = Callable[[Line], Awaitable[None]]

SCRIPTS: Final[dict[tuple[str, str], Script]] = {
    ("coordinator", "inference"): coordinator_of_inference,
    ("coordinator", "memory"): coordinator_of_memory,
    ("coordinator", "robot_bridge"): coordinator_of_robot_bridge,
    ("ui", "coordinator"): ui_of_coordinator,
    ("ui", "memory"): ui_of_memory,
    ("ui", "robot_bridge"): ui_of_robot_bridge,
    ("inference", "robot_bridge"): inference_of_robot_bridge,
    ("memory", "robot_bridge"): memory_of_robot_bridge,
    ("cli", "coordinator"): cli_of_coordinator,
    ("cli", "memory"): cli_of_memory,
    ("cli", "robot_bridge"): cli_of_robot_bridge,
    ("cli", "speech"): cli_of_speech,
}

CLIENTS: Final[dict[type[Any], tuple[tuple[str, str], ...]]] = {
    InferenceClient: (("coordinator", "inference"),),
    MemoryClient: (("coordinator", "memory"),),
    RobotBridgeClient: (("coordinator", "robot_bridge"),),
    CoordinatorClient: (("ui", "coordinator"),),
    PageMemory: (("ui", "memory"),),
    PageBridge: (("ui", "robot_bridge"),),
    BridgeCamera: (("inference", "robot_bridge"),),
    RobotBridge: (("memory", "robot_bridge"),),
    Services: (("cli", "coordinator"), ("cli", "memory"), ("cli", "robot_bridge"), ("cli", "speech")),
}
"""Whose calls the scripts of these pairs make."""
