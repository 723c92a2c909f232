"""A ball of one's own: commands go out again and again until the server has acknowledged them."""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import zenoh

from ballroom.errors import BallroomError, LostBallError, NoAnswerError

if TYPE_CHECKING:
    from ballroom.server import Direction, Server

MAX_UNACKNOWLEDGED = 64
"""Commands that may wait for their acknowledgement."""

_DIRECTIONS = ("up", "down", "left", "right", "stop")
_SEND_AGAIN_S = 0.05
_HEARTBEAT_S = 0.2
_SPACING_S = 0.005
_MAX_OUTCOMES = 1024


@dataclass(frozen=True)
class Acted:
    """What became of one command."""

    seq: int
    tick: int
    """At which it acted; 0 when it was refused before it came to one."""
    epoch: int
    code: int
    """1 when it was done."""
    error: str = ""
    """Why not."""

    @property
    def done(self) -> bool:
        """Whether it was done."""
        return self.code == 1


class Driver:
    """A ball that is driven from here, until `release` or the end of its `with`. From `Server.claim`."""

    player: str
    ball: str
    claim: int
    latency_s: float | None
    """From the last acknowledged command to its acknowledgement."""

    def __init__(self, server: Server, grant: dict[str, Any]) -> None:
        self.player = grant["player"]
        self.ball = grant["ball"]
        self.claim = grant["claim"]
        self.latency_s = None
        self._server = server
        self._token = grant["token"]
        self._most_rounds = round(grant["lease_s"] / _SEND_AGAIN_S)
        self._changed = threading.Condition()
        self._sent: deque[tuple[dict[str, Any], float]] = deque()
        self._early: dict[int, Acted] = {}
        self._outcomes: deque[Acted] = deque(maxlen=_MAX_OUTCOMES)
        self._acked = 0
        self._number = 0
        self._rounds = 0
        self._fresh = True
        self._lost: str | None = None
        self._ended = False
        session, prefix = server.session, f"ballroom/v1/{server.arena}"
        self._acks = session.declare_subscriber(f"{prefix}/ack/{self.player}", self._take)
        self._presence = session.liveliness().declare_token(f"{prefix}/alive/player/{self.player}")
        self._publisher = session.declare_publisher(
            f"{prefix}/drive/{self.player}",
            encoding=zenoh.Encoding.APPLICATION_JSON,
            priority=zenoh.Priority.INTERACTIVE_HIGH,
            congestion_control=zenoh.CongestionControl.DROP,
            express=True,
        )
        self._thread = threading.Thread(target=self._send, name="drive", daemon=True)
        self._thread.start()

    def drive(
        self,
        direction: Direction,
        mode: Literal["impulse", "force"] = "impulse",
        *,
        tick: int | None = None,
        epoch: int | None = None,
    ) -> int:
        """Pushes the ball once, or until told otherwise, half a simulated second at most; gives the command's number.

        It acts at the wanted tick of the wanted epoch (the present one without), or at the next tick boundary.
        """
        where = direction if isinstance(direction, str) else [float(x) for x in direction]
        if isinstance(where, str) and where not in _DIRECTIONS:
            raise ValueError(f"direction {where!r}: use one of {', '.join(_DIRECTIONS)}, or x and y")
        command = {"direction": where, "mode": mode, "tick": tick, "epoch": epoch}
        with self._changed:
            if self._lost is not None:
                raise LostBallError(self.ball, self._lost)
            if len(self._sent) >= MAX_UNACKNOWLEDGED:
                raise BallroomError(f"{MAX_UNACKNOWLEDGED} commands wait for their acknowledgement: send fewer")
            seq = self._acked + len(self._sent) + 1
            given = {name: value for name, value in command.items() if value is not None}
            self._sent.append(({"seq": seq, **given}, time.monotonic()))
            self._fresh = True
            self._changed.notify_all()
        return seq

    def acked(self) -> list[Acted]:
        """What became of commands since this was asked last, in order; of the last 1024 at most."""
        with self._changed:
            outcomes = list(self._outcomes)
            self._outcomes.clear()
        return outcomes

    def settle(self, timeout_s: float = 10.0) -> list[Acted]:
        """Waits until every command is acknowledged, and says what became of those not told of yet."""
        with self._changed:
            if not self._changed.wait_for(lambda: not self._sent or self._lost is not None, timeout_s):
                raise NoAnswerError(f"{len(self._sent)} commands were not acknowledged within {timeout_s:g} s")
            if self._sent and self._lost is not None:
                raise LostBallError(self.ball, self._lost)
        return self.acked()

    @property
    def waiting(self) -> int:
        """Commands that are not acknowledged yet."""
        return len(self._sent)

    @property
    def lost(self) -> str | None:
        """Why the ball is lost, if it is."""
        return self._lost

    def release(self) -> None:
        """Gives the ball back, and waits until it is free."""
        if self._ended:
            return
        try:
            if self._lost is None:
                self._server.release(self.player, self._token)
        finally:
            with self._changed:
                self._ended = True
                self._lost = self._lost or "released"
                self._changed.notify_all()
            self._thread.join()
            if not self._server.session.is_closed():
                self._acks.undeclare()
                self._presence.undeclare()
                self._publisher.undeclare()

    def __enter__(self) -> Driver:
        """Itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Releases."""
        self.release()

    def _take(self, sample: zenoh.Sample) -> None:
        ack = json.loads(sample.payload.to_bytes())
        if ack["claim"] != self.claim:
            return
        now = time.monotonic()
        with self._changed:
            self._rounds = 0
            last = self._acked + len(self._sent)
            news = (Acted(**fields) for fields in ack["acted"])
            self._early.update({acted.seq: acted for acted in news if self._acked < acted.seq <= last})
            while self._acked + 1 in self._early:
                self._acked += 1
                _, since = self._sent.popleft()
                self._outcomes.append(self._early.pop(self._acked))
                self.latency_s = now - since
            self._lost = self._lost or ack.get("ended")
            self._changed.notify_all()

    def _message(self) -> bytes:
        self._number += 1
        message = {"token": self._token, "number": self._number, "acked": self._acked}
        if self.latency_s is not None:
            message["latency_ms"] = 1e3 * self.latency_s
        return json.dumps({**message, "sent": [command for command, _ in self._sent]}).encode()

    def _send(self) -> None:
        """Everything at a fixed rate until acknowledged, and signs of life otherwise, until the ball is lost.

        Rounds are counted, not time: a process that was held up does not take that for the server's silence.
        """
        sent = began = float("-inf")
        while True:
            with self._changed:
                if self._ended or self._lost is not None:
                    return
                pause = _SPACING_S if self._fresh else _SEND_AGAIN_S if self._sent or self._rounds else _HEARTBEAT_S
                now = time.monotonic()
                if now < sent + pause:
                    self._changed.wait(sent + pause - now)
                    continue
                if self._rounds >= self._most_rounds:
                    self._lost = "the server does not answer"
                    self._changed.notify_all()
                    return
                if now >= began + _SEND_AGAIN_S:
                    began = now
                    self._rounds += 1
                self._fresh = False
                message, sent = self._message(), now
            try:
                self._publisher.put(message)
            except zenoh.ZError as why:
                self._lose(f"the session is over: {why}")

    def _lose(self, why: str) -> None:
        with self._changed:
            self._lost = self._lost or why
            self._changed.notify_all()
