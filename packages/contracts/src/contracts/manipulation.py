"""What a fetch goes through, why it could not take a thing, how it ended: types, with sentences for people."""

from enum import StrEnum


class ManipulationState(StrEnum):
    """What each means and what may follow which stands in `coordinator.manipulation.transitions`."""

    IDLE = "idle"
    HOME = "home"
    BASE_ALIGN = "base_align"
    LOOK = "look"
    PRE_GRASP = "pre_grasp"
    GRASP = "grasp"
    LIFT = "lift"
    CHECK = "check"
    CARRY = "carry"
    DELIVER = "deliver"
    PLACE = "place"
    RECOVER = "recover"


class GraspKind(StrEnum):
    """From where a thing is taken hold of."""

    TOP = "top"
    SIDE = "side"


class FetchCause(StrEnum):
    """Why something of a fetch did not work."""

    NO_STANCE = "no_stance"
    """Nowhere that the robot can stand does the arm reach it."""
    NOT_NEAR = "not_near"
    """The robot did not get to a place from which the arm reaches it."""
    NOT_SEEN = "not_seen"
    """From there it is not to be seen."""
    OUT_OF_REACH = "out_of_reach"
    TOO_WIDE = "too_wide"
    """Wider than the jaw opens."""
    NO_ROOM = "no_room"
    """The arm or the jaw would touch something on the way to it."""
    ARM_REFUSED = "arm_refused"
    """The arm's controller, or a check before it, did not take the motion."""
    ARM_HELD_UP = "arm_held_up"
    """A joint was kept off its path, or did not arrive."""
    JAW_JAMMED = "jaw_jammed"
    """The jaw did not open."""
    MISSED = "missed"
    """The jaw closed on nothing."""
    SLIPPED = "slipped"
    """It was not in the jaw after lifting."""
    DROPPED = "dropped"
    """It was lost on the way."""
    UNSURE = "unsure"
    """Whether it is in the jaw could not be told."""
    NOT_THERE = "not_there"
    """The robot did not get to where the thing is to be brought."""
    NO_SPOT = "no_spot"
    """There is no free spot to put it down on."""
    NOBODY_TOOK_IT = "nobody_took_it"
    TAKEN_OVER = "taken_over"
    """Somebody else ended the arm's motion."""
    NO_ANSWER = "no_answer"
    """A service did not answer, or failed."""
    TIME_UP = "time_up"

    @property
    def sentence(self) -> str:
        return _CAUSES[self]


class FetchEnd(StrEnum):
    """Every way a fetch can end."""

    DELIVERED = "delivered"
    PLACED = "placed"
    NOT_TAKEN = "not_taken"
    """It is not in the jaw; the cause says why."""
    NOT_BROUGHT = "not_brought"
    """It is in the jaw, and did not come to where it was wanted; the cause says why."""
    STOPPED = "stopped"
    """The emergency stop."""
    CANCELED = "canceled"

    @property
    def completed(self) -> bool:
        return self in {FetchEnd.DELIVERED, FetchEnd.PLACED}


class Holding(StrEnum):
    """Whether the thing is in the jaw."""

    HELD = "held"
    EMPTY = "empty"
    UNKNOWN = "unknown"


_CAUSES: dict[FetchCause, str] = {
    FetchCause.NO_STANCE: "there is nowhere to stand from which my arm reaches it",
    FetchCause.NOT_NEAR: "I cannot get to where my arm would reach it",
    FetchCause.NOT_SEEN: "from close by I do not see it",
    FetchCause.OUT_OF_REACH: "it is out of my arm's reach",
    FetchCause.TOO_WIDE: "it is wider than my jaw opens",
    FetchCause.NO_ROOM: "there is no room for my arm round it",
    FetchCause.ARM_REFUSED: "my arm refused the motion",
    FetchCause.ARM_HELD_UP: "my arm was held up on its way",
    FetchCause.JAW_JAMMED: "my jaw does not open",
    FetchCause.MISSED: "my jaw closed beside it",
    FetchCause.SLIPPED: "it slipped out of my jaw",
    FetchCause.DROPPED: "I lost it on the way",
    FetchCause.UNSURE: "I cannot tell whether I hold it",
    FetchCause.NOT_THERE: "I cannot get to where you want it",
    FetchCause.NO_SPOT: "there is no free spot to put it down",
    FetchCause.NOBODY_TOOK_IT: "nobody took it",
    FetchCause.TAKEN_OVER: "somebody else moves my arm",
    FetchCause.NO_ANSWER: "a part of me does not answer",
    FetchCause.TIME_UP: "my time was up",
}
