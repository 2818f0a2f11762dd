"""A circuit breaker: what has just failed is left alone for a while, then tried by one caller. Pure."""

from contracts.vision import ModelState


class Breaker:
    """Opened for `retry_after_s` by a failure, or by `wrong_answers_max` answers in a row that made no sense.

    When that time is over one caller is let through; the others wait for what it learns, or for as long again.
    """

    def __init__(self, retry_after_s: float, *, wrong_answers_max: int = 3) -> None:
        self._retry_after_s = retry_after_s
        self._wrong_answers_max = wrong_answers_max
        self._wrong_answers = 0
        self._open_until_s: float | None = None
        self.state = ModelState.READY
        """READY, AWAY, or ANSWERS_WRONG: from the first wrong answer on, unless it was right before."""
        self.was_right = False
        """Whether it ever answered as asked."""
        self.last_error = ""

    def allows(self, now_s: float) -> bool:
        """Whether to try now; asking when a trial is due takes that trial."""
        if self._open_until_s is None:
            return True
        if now_s < self._open_until_s:
            return False
        self._open_until_s = now_s + self._retry_after_s
        return True

    def failed(self, now_s: float, error: str) -> None:
        self._open_until_s = now_s + self._retry_after_s
        self._wrong_answers = 0
        self.state = ModelState.AWAY
        self.last_error = error

    def answered_wrong(self, now_s: float, error: str) -> None:
        """It is there, but of no use this time."""
        self._wrong_answers += 1
        self.last_error = error
        opens = self._open_until_s is not None or self._wrong_answers >= self._wrong_answers_max
        if opens:
            self._open_until_s = now_s + self._retry_after_s
        if opens or not self.was_right:
            self.state = ModelState.ANSWERS_WRONG

    def succeeded(self) -> None:
        self._open_until_s = None
        self._wrong_answers = 0
        self.state = ModelState.READY
        self.was_right = True
        self.last_error = ""
