"""What robot_bridge makes of every field of every message it believes: one cell of docs/sensors.md, one test.

Each cell sends messages through the bridge's own subscriptions and says what the senses tell afterwards. The tables of
docs/sensors.md are written from it: `PYTHONPATH=tests .venv/bin/python -m support.sensor_tables`.
"""

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from dataclasses import field as default
from pathlib import Path
from typing import Any

from contracts.robot import SensorState
from robot_bridge.adapters.ros.sensing import Sensing
from robot_bridge.sensing.sensor_readings import SensorReadings
from robot_bridge.sensing.snapshot import take_snapshot
from robot_bridge.settings import Settings
from support.ros_messages import correction, mount, stamp, still_odometry

NAN, INF = math.nan, math.inf
START_S = 1_700_000_000.0
PERIOD_S = 0.1
PAGE = Path(__file__).resolve().parents[2] / "docs/sensors.md"
MARK = "<!-- the tables: from tests/support/sensor_rules.py -->"


class HandClock:
    """Shows what it is set to."""

    now = START_S

    def now_s(self) -> float:
        return self.now

    async def sleep(self, seconds: float) -> None:
        self.now += seconds


class Ears:
    """As much of a node as `Sensing` needs: what it subscribes to can be told by hand."""

    def __init__(self) -> None:
        self.heard: dict[str, Callable[[Any], None]] = {}

    def create_subscription(self, _: type, name: str, heard: Callable[[Any], None], __: Any) -> None:
        self.heard[name] = heard

    def resolve_topic_name(self, name: str) -> str:
        return name


def _unheard(*_: object) -> None:
    """What this table says nothing of."""


class Bench:
    """The bridge's senses behind its subscriptions, on a clock set by hand."""

    def __init__(self, **settings: Any) -> None:
        self.settings = Settings(**settings)
        self.clock = HandClock()
        self.senses = SensorReadings()
        ears = Ears()
        Sensing(ears, self.settings, self.senses, self.clock, navigation_velocity=_unheard, wheels=_unheard)  # type: ignore[arg-type]
        self._heard = ears.heard

    def send(self, topic: str, message: Any) -> None:
        """`topic` is its name in the settings."""
        self._heard[getattr(self.settings.ros, topic).name](message)

    def body(self, *, but: str) -> None:
        """The frames of the robot's body, and where it is; all but what is looked at."""
        now_s = self.clock.now_s()
        for topic, message in (
            ("tf_static", mount("laser")),
            ("tf_static", mount("optical")),
            ("odom", still_odometry(now_s)),
            ("tf", correction(now_s)),
        ):
            if topic != but:
                self.send(topic, message)


@dataclass(frozen=True)
class Cell:
    """What comes in a field, and what is said of it then."""

    field: str
    case: str
    told: str
    change: Callable[[Any], None] = lambda _: None
    settings: dict[str, Any] = default(default_factory=dict)
    stamps_s: tuple[float, ...] = (0.0,)
    """Of the messages, `PERIOD_S` apart, in seconds since the first came; none for a stamp of zero."""


@dataclass(frozen=True)
class Table:
    message: str
    topic: str
    sensor: str
    healthy: Callable[[], Any]
    show: Callable[[SensorReadings], str]
    cells: tuple[Cell, ...]

    def see(self, cell: Cell) -> str:
        """What the senses tell once the messages of the cell have come."""
        bench = Bench(**cell.settings)
        bench.body(but=self.topic)
        first_s = bench.clock.now_s() + 0.3
        for number, stamp_s in enumerate(cell.stamps_s):
            bench.clock.now = first_s + number * PERIOD_S
            message = self.healthy()
            for stamped_part in getattr(message, "transforms", [message]):
                if hasattr(stamped_part, "header"):
                    stamped_part.header.stamp = stamp(0.0 if math.isinf(stamp_s) else first_s + stamp_s)
            cell.change(message)
            bench.send(self.topic, message)
        status = take_snapshot(bench.senses, bench.settings, bench.clock.now_s()).sensors[self.sensor]
        match status.state:
            case SensorState.NOT_UNDERSTOOD:
                return f"not understood: {status.detail}"
            case SensorState.FRESH:
                return f"{self.show(bench.senses)}{f'; said: {status.detail}' if status.detail else ''}"
            case _:
                return f"{status.state.value}, {status.age_s:.1f} s old" if status.age_s else status.state.value


def as_of(senses: SensorReadings, sensor: str) -> str:
    """Which moment the newest value of a stamped sensor is put at."""
    newest = getattr(senses, {"odom": "odometry"}.get(sensor, sensor)).newest
    off_s = newest.received_s - newest.value.stamp_s
    return "taken as of its arrival" if abs(off_s) < 1e-6 else f"taken as of {off_s:.1f} s before its arrival"


def stamped(*, old_s: float) -> tuple[Cell, ...]:
    """The cells of header.stamp: one rule for every stream. `old_s` is when it counts as stale."""
    return (
        *_stamps(old_s),
        _off("of a clock 1 h behind", _other_clock("3600.0 s behind"), 3600.0),
        _off("of a clock 1 h ahead", _other_clock("3600.0 s ahead of"), -3600.0),
        _off("since boot", _other_clock("53.9 years behind"), START_S - 500.0),
        _stepped("stepped back by 3 s", _other_clock("3.0 s behind"), 3.0),
        _stepped("stepped back by 1 h", _other_clock("3600.0 s behind"), 3600.0),
    )


def stamped_base(*, old_s: float) -> tuple[Cell, ...]:
    """The same of odometry, whose clock is the robot's: the bridge puts it on its own."""
    return (
        *_stamps(old_s),
        _off("of a clock 1 h behind", "taken as of its arrival", 3600.0),
        _off("of a clock 1 h ahead", "taken as of its arrival", -3600.0),
        _off("since boot", "taken as of its arrival", START_S - 500.0),
        _stepped("stepped back by 3 s", "taken as of its arrival", 3.0),
        _stepped("stepped back by 1 h", "taken as of its arrival", 3600.0),
    )


NOW = tuple(number * PERIOD_S for number in range(20))
AFTER_S = 20 * PERIOD_S
ARRIVAL = "the time of arrival is taken"


def _stamps(old_s: float) -> tuple[Cell, ...]:
    frozen = round(old_s / PERIOD_S) + 2
    return (
        _off("right", "taken as of its arrival", 0.0),
        Cell("header.stamp", "absent (0)", f"taken as of its arrival; said: it carries no time: {ARRIVAL}",
             stamps_s=(-INF,) * 20),
        Cell("header.stamp", "repeated", f"stale, {(frozen - 1) * PERIOD_S:.1f} s old", stamps_s=(0.0,) * frozen),
        _off("late, 0.3 s", "taken as of 0.3 s before its arrival", 0.3),
        _off("early, 0.3 s", "taken as of -0.3 s before its arrival", -0.3),
        _odd_one("one from next year", "365.0 days ahead of", -365.0 * 86_400.0),
        _odd_one("one an hour late", "3600.0 s behind", 3600.0),
        _stepped("stepped back by 0.3 s", "taken as of 0.3 s before its arrival", 0.3),
    )  # fmt: skip


def _off(case: str, told: str, behind_s: float) -> Cell:
    """All of them as far behind."""
    return Cell("header.stamp", case, told, stamps_s=tuple(one - behind_s for one in NOW))


def _odd_one(case: str, size: str, behind_s: float) -> Cell:
    told = f"taken as of its arrival; said: a stamp was {size} its arrival: {ARRIVAL}"
    return Cell("header.stamp", case, told, stamps_s=(*NOW, AFTER_S - behind_s))


def _stepped(case: str, told: str, back_s: float) -> Cell:
    return Cell("header.stamp", case, told, stamps_s=(*NOW, *(AFTER_S + one - back_s for one in NOW)))


def _other_clock(size: str) -> str:
    return f"taken as of its arrival; said: its clock is {size} the robot's: {ARRIVAL}"


def lines(tables: tuple[Table, ...]) -> Iterator[str]:
    """The page's part that is made of the cells."""
    for table in tables:
        yield f"\n## {table.message} (`{table.topic}`)\n"
        yield "| field | what comes | what the bridge makes of it |"
        yield "|---|---|---|"
        for cell in table.cells:
            setting = "".join(
                f"; {name.upper()}={value if isinstance(value, str) else json.dumps(value)}"
                for name, value in cell.settings.items()
            )
            yield f"| {cell.field} | {cell.case}{setting} | {cell.told} |"


def page(text: str, tables: tuple[Table, ...]) -> str:
    """The page with its tables as they should be."""
    head = text.partition(MARK)[0]
    return f"{head}{MARK}\n" + "\n".join(lines(tables)) + "\n"
