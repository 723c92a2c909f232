"""Why something could not be done. All are `BallroomError`; each says what to do."""


class BallroomError(Exception):
    """Anything this package complains about."""


class NoServerError(BallroomError, ConnectionError):
    """Nobody listens there, nobody serves that arena, or the server went away."""


class NoAnswerError(BallroomError, TimeoutError):
    """Somebody is there, but nothing came in time."""


class RefusedError(BallroomError):
    """The server refused, and says why in `reason`.

    Commands carry a `code` too, up to 5 those of ROS `simulation_interfaces`: 2 unsupported, 3 not found, 4 not in this
    state of the clock, 5 failed; of its own 100 malformed, 102 too long, 103 interrupted, 104 the server ends, 105 a
    scene that cannot be run.
    """

    def __init__(self, what: str, reason: str, code: int | None = None) -> None:
        super().__init__(f"{what} was refused: {reason}")
        self.reason = reason
        self.code = code


class LostBallError(BallroomError):
    """A claimed ball is another's, or nobody's: released, its player silent for too long, or the ball gone."""

    def __init__(self, ball: str, reason: str) -> None:
        super().__init__(f"{ball} is lost: {reason}")
        self.reason = reason


class OutOfStepError(BallroomError):
    """The clock was moved by someone else between a step and the look at its result."""


class FrameError(BallroomError, ValueError):
    """What came is of another version or shape than this package reads."""
