"""What success sounds and looks like (requirement A16), as data."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Note:
    frequency_hz: int
    duration_s: float


@dataclass(frozen=True, slots=True)
class Celebration:
    """Notes one after the other, and all six LEDs in one colour, spinning."""

    notes: tuple[Note, ...]
    led_rgb: tuple[int, int, int]
    led_animation_type: int
    led_duration_s: float


SUCCESS = Celebration(
    notes=(Note(262, 0.3), Note(330, 0.3), Note(392, 0.3), Note(523, 0.4), Note(659, 0.4), Note(784, 0.6)),
    led_rgb=(0, 255, 0),
    led_animation_type=2,  # irobot_create_msgs LedAnimation.SPIN_LIGHTS
    led_duration_s=3.0,
)
RETRIGGER_S = 4.0
"""A second celebration within this time is refused."""
