"""What a person's words were taken for: an asking, its opposite, an order to stop, and what narrows the thing."""

from enum import StrEnum

from pydantic import Field

from contracts.base import Message


class Mood(StrEnum):
    """What kind of saying it is. Only FIND starts a search."""

    FIND = "find"
    """Asks for a thing: 'find the cup', 'where is my phone?'."""
    DENIED = "denied"
    """Asks not to: "don't find the cup", 'never mind', 'not now'."""
    STATEMENT = "statement"
    """Tells something: 'I already have the scissors', 'she said find the cup'."""
    THANKS = "thanks"
    QUESTION = "question"
    """'what changed?', 'anything to drink?'"""
    COUNT = "count"
    """'how many bottles have you seen?'"""
    CONDITION = "condition"
    """'if you see the cup, tell me': nothing waits for a condition."""
    LATER = "later"
    """'find the cup in ten minutes': nothing keeps appointments."""
    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    EMERGENCY = "emergency"
    """'emergency stop': latches the robot's emergency stop."""
    UNKNOWN = "unknown"
    """None of these: another language, another errand, nonsense."""


class RestrictionKind(StrEnum):
    """What narrows the thing down. Only NOT_COLOUR is held to; of the others the person is told."""

    NOT_COLOUR = "not_colour"
    """'not the blue one', 'except the red cup'"""
    PLACE = "place"
    """'on the table': a hint where to look first, no condition."""
    NOT_PLACE = "not_place"
    """'not in the bedroom'"""
    OWNER = "owner"
    """"the dog's ball", 'her cup'"""
    WHICH = "which"
    """'the smallest', 'the second from the left', 'the nearest'"""
    OTHER = "other"
    """'another spoon', 'the other one'"""
    DETAIL = "detail"
    """'without a label', 'with the broken handle', 'clean'"""
    ANY = "any"
    """'anything red': no thing is named."""
    NUMBER = "number"
    """'two cups', 'all the books': one is looked for."""


class Restriction(Message):
    kind: RestrictionKind
    said: str = Field(min_length=1, max_length=120, description="the words of it")
    value: str = Field(default="", max_length=24, description="the colour, or the number: '2', 'all', 'several'")
