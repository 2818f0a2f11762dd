"""What an episode is: everything needed to play it again, and nothing else."""

from collections.abc import Sequence
from dataclasses import replace

from contracts.base import Message
from contracts.geometry import Pose2D
from sim.home import Home
from sim.home.rearrange import with_thing, without

FORM = 1


class Asked(Message):
    """One thing a command asks for; `colour` None = any."""

    kind: str
    colour: str | None = None
    there: bool = True
    """Whether the home holds one when it is asked for."""

    @property
    def words(self) -> str:
        return f"{self.colour} {self.kind}" if self.colour else self.kind


class Command(Message):
    text: str
    asked: tuple[Asked, ...]


class Carried(Message):
    """A thing is carried to a place (its base's centre), or out of the home."""

    thing_id: str
    x_m: float = 0.0
    y_m: float = 0.0
    z_m: float = 0.0
    yaw: float = 0.0
    support: str = "floor"
    gone: bool = False

    def done_to(self, home: Home) -> Home:
        if self.gone:
            return without(home, self.thing_id)
        thing = next(one for one in home.things if one.id == self.thing_id)
        moved = replace(
            thing, x_m=self.x_m, y_m=self.y_m, z_m=self.z_m, yaw=self.yaw, support=self.support
        )  # fmt: skip
        return with_thing(home, moved)


class Between(Message):
    """Somebody carries a thing before the command of this number is said."""

    before_command: int
    carried: Carried


class Episode(Message):
    """`seed` is of every sensor's noise. `since_tour` was done to the home before the robot comes."""

    form: int = FORM
    set_name: str
    number: int
    seed: int
    home_seed: int
    tour: bool
    since_tour: tuple[Carried, ...] = ()
    between: tuple[Between, ...] = ()
    start: Pose2D
    light: float = 1.0
    grain: float = 0.0
    commands: tuple[Command, ...]
    policy: str = "belief"
    changes: tuple[str, ...] = ()
    """Settings of the coordinator beside the policy's, as NAME=VALUE."""
    detector: str = "sim"

    @property
    def variant(self) -> str:
        return variant_of(self.policy, self.changes, self.detector)

    @property
    def name(self) -> str:
        return f"{self.variant}/{self.set_name}/{self.number:04d}"


def variant_of(policy: str, changes: Sequence[str], detector: str) -> str:
    """Who searches, as reports name it: the policy, and what differs from the usual."""
    return "+".join((policy, *changes, *((f"detector={detector}",) if detector != "sim" else ())))
