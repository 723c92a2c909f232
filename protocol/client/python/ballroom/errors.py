"""Why something could not be done. All are `BallroomError`; each says what to do."""


class BallroomError(Exception):
    """Anything this package complains about."""


class NoServerError(BallroomError, ConnectionError):
    """Nobody listens there, nobody serves that arena, or the server went away."""


class NoAnswerError(BallroomError, TimeoutError):
    """Somebody is there, but nothing came in time."""


class RefusedError(BallroomError):
    """The server refused, and says why in `reason`; `code` is its result code where it gives one."""

    def __init__(self, what: str, reason: str, code: int | None = None) -> None:
        super().__init__(f"{what} was refused: {reason}")
        self.reason = reason
        self.code = code


class OutOfStepError(BallroomError):
    """The clock was moved by someone else between a step and the look at its result."""


class FrameError(BallroomError, ValueError):
    """What came is of another version or shape than this package reads."""
