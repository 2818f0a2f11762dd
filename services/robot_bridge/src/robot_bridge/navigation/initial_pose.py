"""When the localiser is told where the robot is: on the dock, whose place is remembered, and not localised. Pure.

AMCL of a TurtleBot 4 starts without a pose and waits for one; a robot that stands on its dock knows where it stands.
"""

import math

TRIES_MAX = 5
AGAIN_S = 5.0


class InitialPose:
    """Asked once a second."""

    def __init__(self) -> None:
        self._tries = 0
        self._tried_s = -math.inf

    def due(self, now_s: float, *, wanted: bool, listens: bool, laser_turns: bool) -> bool:
        """`wanted`: docked, never localised, and the dock's place is known; `listens`: somebody takes initial poses.

        Told once at first, for the laser may be off on the dock; again only while the laser turns and the localiser has
        taken no pose, also none that a person gave it.
        """
        if not wanted:
            self._tries = 0
            return False
        if not listens or self._tries >= TRIES_MAX or now_s - self._tried_s < AGAIN_S:
            return False
        if self._tries > 0 and not laser_turns:
            return False
        self._tries, self._tried_s = self._tries + 1, now_s
        return True
