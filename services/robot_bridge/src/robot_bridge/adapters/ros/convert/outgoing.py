"""What is sent to the base: sounds, lights, durations."""

from typing import Any

from irobot_create_msgs.msg import AudioNote, AudioNoteVector, LedColor, LightringLeds

from robot_bridge.ports import Celebration, Note


def notes(celebration: Celebration) -> AudioNoteVector:
    return AudioNoteVector(append=False, notes=[_note(each) for each in celebration.notes])


def _note(note: Note) -> AudioNote:
    message = AudioNote(frequency=note.frequency_hz)
    set_duration(message.max_runtime, note.duration_s)
    return message


def lights(celebration: Celebration) -> LightringLeds:
    red, green, blue = celebration.led_rgb
    return LightringLeds(leds=[LedColor(red=red, green=green, blue=blue) for _ in range(6)], override_system=True)


def set_duration(message: Any, seconds: float) -> None:
    """Fills a builtin_interfaces/Duration."""
    message.sec, message.nanosec = divmod(round(seconds * 1e9), 1_000_000_000)
