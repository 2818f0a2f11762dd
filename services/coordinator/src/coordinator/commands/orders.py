"""What is said beside askings: stop, wait, go on, never mind. Acts at once; asks no parser, model or memory."""

import asyncio

import structlog

from contracts.mission import Heard, MissionState
from contracts.reading import Mood
from contracts.robot import EmergencyStop
from coordinator.commands.dispatcher import Dispatcher
from coordinator.core import events as ev
from coordinator.execution.mission_runner import MissionRunner
from coordinator.ports import Robot
from mesh.errors import ConflictError, MeshError, UnavailableError, UnprocessableError
from vocabulary.folding import joined, words_of
from vocabulary.labels import label_in
from vocabulary.moods import Reading

log = structlog.get_logger()

STILL_S = 1.0
"""A bridge that has not said within this time that the robot stands still is asked for its emergency stop."""
ASKS_FOR_NOTHING = {
    Mood.DENIED: "you asked not to search: nothing was started",
    Mood.STATEMENT: "that is not a request: nothing was started",
    Mood.THANKS: "you are welcome; nothing was started",
    Mood.QUESTION: "that is a question: ask it (Ask on the page, `atom ask`, POST /ask)",
    Mood.COUNT: "that is a question: ask it (Ask on the page, `atom ask`, POST /ask)",
    Mood.CONDITION: "I cannot wait for a condition: ask again when it is true",
    Mood.LATER: "I cannot schedule missions: ask again then",
    Mood.UNKNOWN: "I did not understand. I find objects, and I understand English",
}
"""What a person is told whose words start nothing; the `code` of the refusal is the mood."""


class Orders:
    def __init__(self, *, runner: MissionRunner, dispatcher: Dispatcher, robot: Robot) -> None:
        self._runner = runner
        self._dispatcher = dispatcher
        self._robot = robot

    async def obey(self, mood: Mood) -> Heard:
        """Raises `ConflictError` where nothing is paused that could go on, and `UnavailableError` where no emergency
        stop could be set.
        """
        match mood:
            case Mood.EMERGENCY:
                return await self._emergency()
            case Mood.PAUSE if self._runner.mission.running:
                return self._pause()
            case Mood.RESUME:
                return self._resume()
            case _:
                return await self._stop(mood)

    def take_back(self, reading: Reading) -> Heard:
        """Ends what a denial, or word that the thing is found, is about. Raises `UnprocessableError` where it is about
        nothing that runs or waits, and for every other saying that asks for nothing.
        """
        over = reading.mood is Mood.DENIED or (reading.found and reading.mood in {Mood.STATEMENT, Mood.THANKS})
        label = label_in(joined(words_of(reading.about)))
        ended = self._dispatcher.end_those_for(label, f"a person said: {reading.about[:200]}") if over else ()
        if not ended:
            raise UnprocessableError(ASKS_FOR_NOTHING[reading.mood], code=reading.mood.value)
        return Heard(mood=reading.mood, text=f"{_ended(len(ended))}.", ended=ended)

    async def _stop(self, mood: Mood) -> Heard:
        halting = asyncio.ensure_future(self._robot.halt())
        ended = self._dispatcher.end_all("a person said stop")
        stop = await self._still(halting)
        if stop is None:
            text = f"{_ended(len(ended))}, but robot_bridge does not answer: press the robot's own stop button."
        elif stop.latched:
            text = f"{_ended(len(ended))}; the emergency stop is set: reset it to go on."
        else:
            text = f"{_ended(len(ended))}; nothing moves the robot."
        return Heard(mood=mood, text=text, ended=ended, still=stop is not None)

    async def _emergency(self) -> Heard:
        stopping = asyncio.ensure_future(self._robot.emergency_stop("a person said emergency"))
        ended = self._dispatcher.end_all("a person said emergency")
        stop = await _answered(stopping)
        if stop is None:
            raise UnavailableError("robot_bridge", "it does not answer: press the robot's own stop button")
        self._take(stop)
        text = f"{_ended(len(ended))}; the emergency stop is set: reset it to go on."
        return Heard(mood=Mood.EMERGENCY, text=text, ended=ended, still=True)

    async def _still(self, halting: "asyncio.Future[EmergencyStop]") -> EmergencyStop | None:
        """How the robot was made to stand still; None where the bridge answers neither halt nor emergency stop."""
        stop = await _answered(halting)
        if stop is None:
            stop = await _answered(asyncio.ensure_future(self._robot.emergency_stop("a halt was not answered")))
        if stop is not None:
            self._take(stop)
        return stop

    def _take(self, stop: EmergencyStop) -> None:
        """The answer is as good as the bus's message, and here already: what begins next needs its epoch."""
        self._runner.feed(ev.StopLatched(stop.epoch, stop.reason) if stop.latched else ev.StopReset(stop.epoch))

    def _pause(self) -> Heard:
        self._runner.feed(ev.PauseRequested())  # where it only stands to listen, it stands until a person says now
        return Heard(mood=Mood.PAUSE, text="Paused: say 'go on' or 'stop'.")

    def _resume(self) -> Heard:
        if self._runner.mission.state is MissionState.EMERGENCY_STOP:
            raise ConflictError("the emergency stop is latched: reset it first", code=Mood.RESUME.value)
        if not self._runner.mission.paused:
            raise ConflictError("nothing is paused", code=Mood.RESUME.value)
        self._runner.feed(ev.ResumeRequested())
        return Heard(mood=Mood.RESUME, text="Going on.")


async def _answered(call: "asyncio.Future[EmergencyStop]") -> EmergencyStop | None:
    try:
        async with asyncio.timeout(STILL_S):
            return await call
    except (MeshError, TimeoutError) as error:
        log.error("the bridge does not confirm that the robot stands", error=str(error))  # noqa: TRY400 - it is told
        return None


def _ended(count: int) -> str:
    return {0: "Stopped: no mission ran", 1: "Stopped: the mission is over"}.get(
        count, f"Stopped: {count} missions are over"
    )
