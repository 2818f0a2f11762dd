"""Actions of the library (`contracts.actions`) that a button of the page begins; each is a mission."""

from contracts.access import Role
from contracts.actions import SPECS, Action
from mesh.errors import ConflictError
from mesh.tracing import Tracer
from ui.desk import Desk
from ui.i18n import _
from ui.operator_actions import ActionResult, OperatorActions, result_of

TRACER = Tracer(__name__)


class LibraryActions:
    def __init__(self, desk: Desk, actions: OperatorActions) -> None:
        """`actions` knows who asks."""
        self._desk = desk
        self._actions = actions

    async def begin(self, action: Action) -> ActionResult:
        """Refused to whom has not the role that the library names, and while anything else has the robot: a button is
        pressed for now, and not for when a mission has ended."""
        role = SPECS[action.action].role or Role.VIEWER
        if (refused := self._actions.refused(role)) is not None:
            return refused

        async def do() -> str:
            if why := why_not_now(self._desk):
                raise ConflictError(why)
            with TRACER.command("button", {"action": action.action.value}):
                reply = await self._desk.missions.do(action)
            if reply.mission is not None and reply.mission.queue_position is not None:
                return _("Queued: {what}", what=reply.mission.command)
            return _("Begun: {what}", what=reply.mission.command if reply.mission is not None else reply.text)

        return await result_of(do())


def why_not_now(desk: Desk) -> str:
    """'' where nothing that the page knows of keeps a mission from beginning."""
    facts = desk.facts
    if facts.stop is not None and facts.stop.latched:
        return _("The robot is stopped. Resume first.")
    status = facts.mission
    if status is not None and (status.queue or (status.mission is not None and status.mission.outcome is None)):
        return _("A mission is running or waits. Cancel it first, or wait for its end.")
    if desk.driver is not None:
        return _("Somebody drives the robot by hand. Wait until they have let go.")
    return ""
