"""What is sent to the base: sounds, lights, durations."""

from typing import Any

from irobot_create_msgs.msg import AudioNote, AudioNoteVector, LedColor, LightringLeds

from robot_bridge.ports import Celebration


def notes(celebration: Celebration) -> AudioNoteVector:
    message = AudioNoteVector(append=False)
    for note in celebration.notes:
        each = AudioNote(frequency=note.frequency_hz)
        each.max_runtime.sec, each.max_runtime.nanosec = _split(note.duration_s)
        message.notes.append(each)
    return message


def lights(celebration: Celebration) -> LightringLeds:
    red, green, blue = celebration.led_rgb
    return LightringLeds(leds=[LedColor(red=red, green=green, blue=blue) for _ in range(6)], override_system=True)


def set_duration(message: Any, seconds: float) -> None:
    """Fills a builtin_interfaces/Duration."""
    message.sec, message.nanosec = _split(seconds)


def _split(seconds: float) -> tuple[int, int]:
    nanoseconds = round(seconds * 1e9)
    return nanoseconds // 1_000_000_000, nanoseconds % 1_000_000_000
