"""One line of progress on standard error, with the time of day."""

import sys
import time


def say(part: str, text: str) -> None:
    """Write the line at once, so that a log file can be followed."""
    sys.stderr.write(f"{time.strftime('%H:%M:%S')} {part}: {text}\n")
    sys.stderr.flush()
