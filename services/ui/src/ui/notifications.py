"""What a person should hear of at once: a mission that ended, a robot that stopped or needs somebody. Pure."""

from dataclasses import dataclass, field

from contracts.mission import Mission, MissionState, MissionStatus, Outcome
from contracts.robot import EmergencyStop
from ui.i18n import _
from ui.page_model import OUTCOMES, Tone

KEPT = 20
NEEDS_A_PERSON = frozenset({Outcome.UNSURE, Outcome.ABORTED, Outcome.INTERRUPTED})


@dataclass(frozen=True, slots=True)
class Notification:
    number: int
    tone: Tone
    text: str


@dataclass(slots=True)
class Notifications:
    """Each page shows the items whose number is higher than the last it has shown."""

    items: tuple[Notification, ...] = ()
    _told: set[tuple[str, str]] = field(default_factory=set[tuple[str, str]])
    _waited: dict[tuple[str, str], str] = field(default_factory=dict[tuple[str, str], str])
    _open: set[str] = field(default_factory=set[str])
    _latched: bool | None = None

    @property
    def newest(self) -> int:
        return self.items[-1].number if self.items else 0

    def after(self, number: int) -> tuple[Notification, ...]:
        return tuple(item for item in self.items if item.number > number)

    def take_mission(self, status: MissionStatus) -> None:
        """Endings of missions that were seen running, but for a stop, which tells itself; what is waited for, once, and
        when its second try failed too: the first is over before anybody has read of it.
        """
        mission = status.mission
        if mission is None:
            return
        if mission.outcome is None:
            self._open.add(mission.id)
            if status.waiting_for:
                self._take_waiting(mission.id, status.waiting_for)
        elif mission.id in self._open:
            self._open.discard(mission.id)
            if status.state is not MissionState.EMERGENCY_STOP:
                self._add(*ending(mission))

    def _take_waiting(self, mission_id: str, waiting_for: str) -> None:
        """`waiting_for` reads "memory: again in 2 s (1 of 6 tries)"; the seconds count down."""
        service = waiting_for.partition(":")[0]
        tries = waiting_for.partition("(")[2]
        first = self._waited.setdefault((mission_id, service), tries)
        if tries != first and (mission_id, service) not in self._told:
            self._told.add((mission_id, service))
            self._add(Tone.WARN, _("Waiting for {what}", what=service))

    def take_stop(self, stop: EmergencyStop) -> None:
        """A stop is told once it has said why, which is at most half a second after the robot stands."""
        if stop.latched and not stop.reason:
            return
        if stop.latched and self._latched is False:
            by = f" ({stop.by})" if stop.by else ""
            self._add(Tone.BAD, _("The robot was stopped: {why}. It needs you.", why=f"{stop.reason}{by}"))
        self._latched = stop.latched

    def _add(self, tone: Tone, text: str) -> None:
        self.items = (*self.items[-(KEPT - 1) :], Notification(self.newest + 1, tone, text))


def ending(mission: Mission) -> tuple[Tone, str]:
    assert mission.outcome is not None, "only an ended mission has an ending"
    word, tone = OUTCOMES[mission.outcome]
    needed = f" {_('It needs you.')}" if mission.outcome in NEEDS_A_PERSON else ""
    return tone, f"{_(word)}: “{mission.command}”. {mission.reason}.{needed}"
