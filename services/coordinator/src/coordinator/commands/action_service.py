"""`POST /actions`: each declared action done (`contracts.actions`). What moves becomes a mission in the one queue."""

import re
from dataclasses import replace
from typing import Final, assert_never

from contracts.access import Principal, Role
from contracts.actions import (
    SPECS,
    Action,
    ActionName,
    ActionReply,
    AskAction,
    CancelAction,
    CelebrateAction,
    CountAction,
    DescribeViewAction,
    DockAction,
    DriveAction,
    ExploreAction,
    FindAction,
    GoToAction,
    LookAroundAction,
    PatrolAction,
    PauseAction,
    ResumeAction,
    RotateAction,
    StopAction,
    UndockAction,
    WhereIsAction,
)
from contracts.asking import About, Answer
from contracts.mission import CommandRefusal
from contracts.reading import Mood
from coordinator.commands.mission_service import MissionService
from coordinator.commands.plain_motions import Moving, motion_of
from coordinator.execution.newest_view import NewestView
from coordinator.ports import Robot
from coordinator.questions.question_service import QuestionService
from coordinator.questions.view_words import view_in_words
from coordinator.queue.mission_queue import Work
from mesh.errors import ConflictError, ForbiddenError, UnprocessableError
from vocabulary.folding import words_of
from vocabulary.moods import read
from vocabulary.orders import order_in

SEVERAL: Final = frozenset({"and", "then", "or"})
ARTICLE: Final = re.compile(r"(?:the|an?)\s+", re.IGNORECASE)


class ActionService:
    """Everything raises as `MissionService` does; `ForbiddenError` where the role is too low."""

    def __init__(self, *, missions: MissionService, questions: QuestionService, view: NewestView, robot: Robot) -> None:
        self.missions = missions
        self._questions = questions
        self._view = view
        self._robot = robot

    async def do(self, action: Action, who: Principal | None) -> ActionReply:  # noqa: PLR0911 - one per action
        """Answers at once, also where the mission it began goes on. `who` none: nobody was asked, and only stops."""
        check_role(action.action, who)
        ended_before = self.missions.orders_to_end  # a stop from here on ends what is asked for, read or not
        match action:
            case StopAction():
                return await self._stop()
            case PauseAction() | ResumeAction() | CancelAction():
                return await self._order(action)
            case FindAction(thing=thing):
                return await self._search(action.action, thing, ended_before)
            case GoToAction(thing=str() as thing):
                return await self._search(action.action, thing, ended_before)
            case (
                GoToAction()
                | LookAroundAction()
                | RotateAction()
                | DriveAction()
                | ExploreAction()
                | PatrolAction()
                | UndockAction()
            ):
                return await self._move(action, ended_before)
            case DockAction():
                return await self._begin(action.action, "dock", None, ended_before)
            case CelebrateAction():
                await self._robot.celebrate()
                return ActionReply(action=action.action, text="Celebrated.")
            case AskAction(question=question):
                return _answered(action.action, await self.answer(question, who))
            case WhereIsAction(thing=thing):
                return _answered(action.action, await self._questions.ask(f"where is the {_plain(thing)}?"))
            case CountAction(thing=thing):
                return _answered(action.action, await self._questions.ask(f"how many {_plain(thing)} are there?"))
            case DescribeViewAction():
                return ActionReply(action=action.action, text=view_in_words(self._view.now()))
            case _:
                assert_never(action)

    async def answer(self, question: str, who: Principal | None) -> Answer:
        """A question's answer; an order in it is obeyed, 'go on' from an operator only."""
        order = order_in(question)
        if order is None:
            return await self._questions.ask(question)
        if order.mood is Mood.RESUME and (who is None or not who.role.may(Role.OPERATOR)):
            raise ForbiddenError("to let the mission go on needs an operator")
        heard = await self.missions.orders.obey(order.mood)
        return Answer(answer=heard.text, about=About.DOING, phrased_by="template")

    async def _stop(self) -> ActionReply:
        heard = await self.missions.orders.obey(Mood.STOP)
        return ActionReply(action=ActionName.STOP, text=heard.text, heard=heard)

    async def _order(self, action: PauseAction | ResumeAction | CancelAction) -> ActionReply:
        mission_id = action.mission_id or self._running()
        match action:
            case PauseAction():
                mission, done = await self.missions.pause(mission_id), "Paused"
            case ResumeAction():
                mission, done = await self.missions.resume(mission_id), "Going on"
            case CancelAction():
                mission, done = await self.missions.cancel(mission_id), "Cancelled"
            case _:
                assert_never(action)
        return ActionReply(action=action.action, text=f"{done}: {mission.command}", mission=mission)

    def _running(self) -> str:
        mission = self.missions.runner.mission
        if not mission.running:
            raise ConflictError("no mission runs")
        return mission.id

    async def _search(self, name: ActionName, thing: str, ended_before: int) -> ActionReply:
        """One known thing, and nothing else that words may ask for: a model's argument is no command."""
        command = f"{'go to' if name is ActionName.GO_TO else 'find'} the {_plain(thing)}"
        reading = read(command)
        if SEVERAL & {word.text for word in words_of(thing)}:
            raise UnprocessableError(f"'{thing}' names several things", code=CommandRefusal.WHICH_THING.value)
        if order_in(thing) is not None or order_in(command) is not None or reading.mood is not Mood.FIND:
            raise UnprocessableError(f"'{thing}' names no thing", code=CommandRefusal.NAMES_NOTHING.value)
        self.missions.refuse_now(ended_before, by_its_body=True)
        tasks = await self.missions.reader.things(reading, self.missions.last_target)
        if len(tasks) != 1:
            raise UnprocessableError(f"'{thing}' names several things", code=CommandRefusal.WHICH_THING.value)
        return await self._begin(name, command, tasks[0], ended_before)

    async def _move(self, action: Moving, ended_before: int) -> ActionReply:
        names_rooms = isinstance(action, PatrolAction) or (isinstance(action, GoToAction) and action.room is not None)
        rooms = await self.missions.reader.rooms(needed=names_rooms)
        motion = replace(motion_of(action, rooms), map_id=rooms.map_id)
        command = f"{action.action.value.replace('_', ' ')}: {motion.what}"
        return await self._begin(action.action, command, motion, ended_before)

    async def _begin(self, name: ActionName, command: str, work: Work, ended_before: int) -> ActionReply:
        mission = await self.missions.begin(command, work, ended_before)
        waits = (
            f"waiting in the queue, {mission.queue_position} before it" if mission.queue_position is not None else ""
        )
        return ActionReply(action=name, text=f"{command}; {waits or 'begun'}", mission=mission)


def check_role(name: ActionName, who: Principal | None) -> None:
    """Raises `ForbiddenError`."""
    role = SPECS[name].role
    if role is not None and (who is None or not who.role.may(role)):
        asking = f"{who.name} is {who.role}" if who is not None else "nobody said who asks"
        raise ForbiddenError(f"{asking}; {name.value} needs {role}")


def _plain(thing: str) -> str:
    return ARTICLE.sub("", thing, count=1) if ARTICLE.match(thing) else thing


def _answered(name: ActionName, answer: Answer) -> ActionReply:
    return ActionReply(action=name, text=answer.answer, answer=answer)
