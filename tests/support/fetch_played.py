"""A fetch played on a simulated clock: each command is answered as it was written down, else as if all went well."""

from collections.abc import Callable
from dataclasses import dataclass, field

from contracts.arm import ArmEnd
from contracts.geometry import Pose2D
from contracts.manipulation import Holding, ManipulationState
from coordinator.manipulation import commands as do
from coordinator.manipulation import events as ev
from coordinator.manipulation.fetch import Fetch
from coordinator.manipulation.step import step

GOAL = Pose2D(x=4.0, y=1.0, yaw=0.0)
STANCE = Pose2D(x=1.0, y=1.0, yaw=0.0)
Answers = Callable[[do.Command, int], ev.Answer]


def all_well(command: do.Command, call: int) -> ev.Answer:  # noqa: PLR0911 - one line a command
    """As the robot answers when everything works."""
    match command:
        case do.MoveJaw(open=False):
            return ev.ArmMoved(call, ArmEnd.STALLED)
        case do.FoldArm() | do.MoveArm() | do.MoveJaw():
            return ev.ArmMoved(call, ArmEnd.COMPLETED)
        case do.DriveBase():
            return ev.BaseMoved(call, reached=True)
        case do.PlanStance(tried=tried):
            return ev.StancePlanned(call, STANCE.model_copy(update={"x": 1.0 + len(tried)}))
        case do.LookAtThing():
            return ev.ThingLooked(call, seen=True)
        case do.PlanGrasps():
            return ev.GraspsPlanned(call, 3)
        case do.PlanSpot():
            return ev.SpotPlanned(call, found=True)
        case do.CheckHold():
            return ev.HoldChecked(call, Holding.HELD)
        case do.AwaitHand():
            return ev.HandWaited(call, taken=True)
        case _:
            raise AssertionError(f"nobody answers {command}")


@dataclass
class FetchPlayed:
    """`answers`: how a command is answered; `all_well` unless told otherwise."""

    answers: Answers = all_well
    fetch: Fetch = field(default_factory=Fetch)
    now_s: float = 0.0
    told: list[do.Command] = field(default_factory=list[do.Command])
    waiting: list[do.MOTION | do.ASKING] = field(default_factory=list[do.MOTION | do.ASKING])
    """Commands that are not answered yet."""
    answers_given: list[ev.Answer] = field(default_factory=list[ev.Answer])

    def feed(self, event: ev.Event) -> tuple[do.Command, ...]:
        self.fetch, commands = step(self.fetch, event, self.now_s)
        self.told += commands
        self.waiting += [one for one in commands if isinstance(one, do.MOTION | do.ASKING)]
        return commands

    def begin(self, *, hand_over: bool = True) -> "FetchPlayed":
        self.feed(ev.FetchBegun(GOAL, hand_over))
        return self

    def answer_one(self) -> None:
        command = self.waiting.pop(0)
        self.now_s += 1.0
        answer = self.answers(command, command.call)
        self.answers_given.append(answer)
        self.feed(answer)

    def play(self, *, until: ManipulationState | None = None, most: int = 200) -> "FetchPlayed":
        """Answers until the fetch is over, or in a state."""
        while self.fetch.running and self.fetch.state is not until:
            most -= 1
            assert most > 0, "it does not end"
            self.answer_one()
        return self

    @property
    def states(self) -> list[ManipulationState]:
        return [one.state for one in self.told if isinstance(one, do.TellFetchState)]

    @property
    def finish(self) -> do.FinishFetch:
        (one,) = [each for each in self.told if isinstance(each, do.FinishFetch)]
        return one
