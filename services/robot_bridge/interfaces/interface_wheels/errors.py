"""What can go wrong, each with what to do about it.

InterfaceError
├── MissingToolError      a compiler, a header or pip is not there
├── PartialRosError       ROS is sourced but lacks some of the packages
└── CommandFailedError    a child process failed; carries the end of its output
"""

from collections.abc import Sequence


class InterfaceError(Exception):
    """Any reason why there are no wheels."""


class MissingToolError(InterfaceError):
    """Something that the build needs from the system is missing."""

    def __init__(self, missing: Sequence[str], apt_packages: Sequence[str]) -> None:
        super().__init__(
            f"not found: {', '.join(missing)}. On Debian or Ubuntu: sudo apt-get install -y {' '.join(apt_packages)}"
        )


class PartialRosError(InterfaceError):
    """A sourced ROS installation must bring every package itself: two sets of messages in one process clash."""

    def __init__(self, missing: Sequence[str], distro: str) -> None:
        apt_packages = [f"ros-{distro}-{name.replace('_', '-')}" for name in missing]
        super().__init__(
            f"a ROS installation is sourced but lacks {', '.join(missing)}:"
            f" sudo apt-get install -y {' '.join(apt_packages)}"
        )


class CommandFailedError(InterfaceError):
    """A child process ended with an error."""

    def __init__(self, what: str, output_tail: str) -> None:
        super().__init__(f"{what} failed:\n{output_tail}")
