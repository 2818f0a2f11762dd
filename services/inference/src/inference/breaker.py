"""A circuit breaker: what has just failed is left alone for a while. Pure; time is passed in."""


class Breaker:
    """Closed at first; a failure opens it for `retry_after_s`, a success closes it."""

    def __init__(self, retry_after_s: float) -> None:
        self._retry_after_s = retry_after_s
        self._open_until_s: float | None = None
        self.last_error = ""

    def allows(self, now_s: float) -> bool:
        return self._open_until_s is None or now_s >= self._open_until_s

    def failed(self, now_s: float, error: str) -> None:
        self._open_until_s = now_s + self._retry_after_s
        self.last_error = error

    def succeeded(self) -> None:
        self._open_until_s = None
        self.last_error = ""
