"""One motion that the core asked for, done by the robot and answered by an event."""

from typing import assert_never

from contracts.motion import BaseReply
from contracts.robot import GoalRequest
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.execution.motion_client import MotionClient
from coordinator.ports import Robot

Motion = do.Undock | do.Dock | do.Navigate | do.Rotate | do.Drive


async def moved(action: Motion, robot: Robot, motion: MotionClient, epoch: int) -> ev.Event:
    """Only inside the work of a `MotionClient.start`. Raises as `Robot` does."""
    match action:
        case do.Undock(call=call, timeout_s=timeout_s):
            reply = await robot.undock(timeout_s=timeout_s)
            return ev.Undocked(call) if reply.end.completed else _base_gave_up(call, reply)
        case do.Dock(call=call, timeout_s=timeout_s):
            reply = await robot.dock(timeout_s=timeout_s)
            return ev.Docked(call) if reply.end.completed else _base_gave_up(call, reply)
        case do.Navigate(call=call):
            request = GoalRequest(
                candidates=action.candidates,
                epoch=epoch,
                timeout_s=action.timeout_s,
                ring_radius_m=action.ring_radius_m,
            )
            goal = await motion.navigate(request)
            return ev.GoalEnded(call, goal.status, goal.error_code, goal.error_msg, goal.cause)
        case do.Rotate(call=call, angle_rad=angle, speed_rad_s=speed, timeout_s=timeout_s):
            reply = await robot.rotate(angle, speed_rad_s=speed, timeout_s=timeout_s, epoch=epoch)
            return ev.MotionEnded(call, reply.end, turned_rad=reply.turned_rad, text=reply.text)
        case do.Drive(call=call, distance_m=distance, speed_m_s=speed, timeout_s=timeout_s):
            reply = await robot.drive(distance, speed_m_s=speed, timeout_s=timeout_s, epoch=epoch)
            return ev.MotionEnded(call, reply.end, driven_m=reply.driven_m, text=reply.text)
        case _:
            assert_never(action)


def _base_gave_up(call: int, reply: BaseReply) -> ev.CallFailed:
    return ev.CallFailed(call, "robot_bridge", reply.text, reply.end)
