"""Which command made the wheels turn: the first velocity sent for it, told on its span. Asked of the ticks that were
sent; the tick itself knows of no trace.
"""

from opentelemetry.trace import Span

from mesh.latest_value import Reading
from mesh.tasks import Tasks
from robot_bridge.motion.arbiter import ZERO, ArbitratedCommand
from robot_bridge.motion.velocity_mux import VelocityMux


def tell_first_twist(
    tasks: Tasks, wheels: VelocityMux, span: Span, *, source: str, since_s: float, within_s: float
) -> None:
    """Returns at once. `source` is whose lease it is, `since_s` when the command was taken."""
    if span.is_recording():
        tasks.start("first-twist", _tell(wheels, span, source, since_s, within_s), forever=False)


async def _tell(wheels: VelocityMux, span: Span, source: str, since_s: float, within_s: float) -> None:
    def begun_or_over(tick: Reading[ArbitratedCommand]) -> bool:
        return (tick.received_s >= since_s and _moves(tick, source)) or not span.is_recording()

    tick = await wheels.commanded.wait_for(begun_or_over, within_s)
    if tick is not None:
        add_twist(span, tick, source=source)


def add_twist(span: Span, tick: Reading[ArbitratedCommand], *, source: str) -> None:
    """Where this source's lease moved the wheels. Of a span that has ended nothing is told any more."""
    if span.is_recording() and _moves(tick, source):
        twist = tick.value.twist
        sent = {"source": tick.value.source, "linear_x": twist.linear_x, "angular_z": twist.angular_z}
        span.add_event("twist", sent, timestamp=int(tick.received_s * 1e9))


def _moves(tick: Reading[ArbitratedCommand], source: str) -> bool:
    return tick.value.source == source and tick.value.twist != ZERO
