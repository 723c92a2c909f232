"""What the server publishes, as iterators that never make it wait: the newest overtakes, and is counted."""

from __future__ import annotations

import itertools
import json
import struct
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import zenoh

from ballroom import frames
from ballroom.errors import NoAnswerError
from ballroom.frames import Hit, State, World

T = TypeVar("T")
F = TypeVar("F", bound="Feed[Any]")

_LOOK_AGAIN_S = 0.002
_HIT_MESSAGES = 256
_REPORT_EVERY_S = 1.0
_STAMP = struct.Struct("<QQ")  # number of the message, wall time in ns since 1970


class Feed(Generic[T]):
    """An iterator over one kind of message; also a context manager. It ends when it or its server is closed."""

    def __init__(self, session: zenoh.Session, key: str, depth: int, timeout_s: float | None) -> None:
        # A ring drops the oldest; a full queue of the other kind would stall the whole session.
        self._subscriber = session.declare_subscriber(key, zenoh.handlers.RingChannel(depth))
        self._session = session
        self._key = key
        self._timeout_s = timeout_s
        self._closed = False

    def close(self) -> None:
        """Listens no more."""
        if not self._closed:
            self._closed = True
            if not self._session.is_closed():
                self._subscriber.undeclare()

    def poll(self) -> T | None:
        """The next one if it is already here."""
        raise NotImplementedError

    def __enter__(self: F) -> F:
        """Itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Closes."""
        self.close()

    def __iter__(self: F) -> F:
        """Itself."""
        return self

    def __next__(self) -> T:
        """The next one, waiting as long as the feed was told to."""
        began = time.monotonic()
        while not self._is_over():
            item = self.poll()
            if item is not None:
                return item
            if self._timeout_s is not None and time.monotonic() > began + self._timeout_s:
                raise NoAnswerError(f"nothing on {self._key} within {self._timeout_s} s: does the clock stand?")
            time.sleep(_LOOK_AGAIN_S)
        raise StopIteration

    def _is_over(self) -> bool:
        return self._closed or self._session.is_closed()

    def _sample(self) -> zenoh.Sample | None:
        try:
            return self._subscriber.try_recv()
        except zenoh.ZError:
            # Closed, here or on another thread.
            self._closed = True
            return None

    def _payload(self) -> bytes | None:
        sample = self._sample()
        return None if sample is None else sample.payload.to_bytes()


class States(Feed[State]):
    """The present state, and then the newest whenever there is a new one."""

    missed_ticks: int
    """Ticks that passed without their state being handed out: overtaken, lost, or stepped over."""

    def __init__(self, session: zenoh.Session, prefix: str, timeout_s: float | None, ask: Callable[[], World]) -> None:
        super().__init__(session, f"{prefix}/state", 1, timeout_s)
        self.missed_ticks = 0
        self._meter = Meter(session, f"{prefix}/report/script/{session.zid()}")
        self._ask = ask
        self._newest: State | None = None

    def poll(self) -> State | None:
        """The newest state, if it was not handed out before."""
        before = self._newest
        self._meter.report()
        if before is None:
            return self._hand_out(self._ask().state)
        sample = self._sample()
        if sample is None:
            return None
        frame = sample.payload.to_bytes()
        self._meter.read(sample, len(frame))
        fields = frames.load(frame)
        if fields["epoch"] == before.epoch:
            state = frames.state(fields, before.roster)
        else:
            # Another epoch may have other balls; the answer is at least as new as this frame.
            state = self._ask().state
        return self._hand_out(state) if _is_news(state, before) else None

    def _hand_out(self, state: State) -> State:
        before = self._newest
        if before is not None and before.epoch == state.epoch:
            self.missed_ticks += max(0, state.tick - before.tick - 1)
        self._newest = state
        return state


class Meter:
    """How states come, told to the server once a second while they are read.

    Ages are taken where a state is read, by the clocks of both machines. What did not arrive and what was overtaken
    before it was read cannot be told apart here.
    """

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._session = session
        self._key = key
        self._since = time.monotonic()
        self._stamp: bytes | None = None
        self._received = 0
        self._missed = 0
        self._bytes = 0
        self._ages_ms: list[float] = []

    def read(self, sample: zenoh.Sample, length: int) -> None:
        """Takes in a state that was read."""
        stamp = b"" if sample.attachment is None else sample.attachment.to_bytes()
        if stamp and stamp == self._stamp:
            return  # the last one once more
        self._received += 1
        self._bytes += length
        if len(stamp) != _STAMP.size:
            return
        sequence, wall_ns = _STAMP.unpack(stamp)
        # A number that is not larger is that of a server begun anew.
        if self._stamp is not None and (before := _STAMP.unpack(self._stamp)[0]) < sequence:
            self._missed += sequence - before - 1
        self._stamp = stamp
        self._ages_ms.append((time.time_ns() - wall_ns) / 1e6)

    def report(self) -> None:
        """Tells the server, if it is time."""
        over_s = time.monotonic() - self._since
        if over_s < _REPORT_EVERY_S or self._session.is_closed():
            return
        ages, steps = sorted(self._ages_ms), [abs(b - a) for a, b in itertools.pairwise(self._ages_ms)]
        report = {
            "states_per_s": len(ages) / over_s,
            "bytes_per_s": self._bytes / over_s,
            "age_ms": [ages[len(ages) // 2], ages[-1]] if ages else None,
            "jitter_ms": sum(steps) / len(steps) if steps else None,
            "received": self._received,
            "lost": None,
            "overtaken": self._missed,
        }
        self._session.put(self._key, json.dumps(report), congestion_control=zenoh.CongestionControl.DROP)
        self._since = time.monotonic()
        self._bytes = 0
        self._ages_ms.clear()


def _is_news(state: State, before: State) -> bool:
    """Whether it is no frame from before the answer; while the clock stands, the same tick may change."""
    if state.epoch != before.epoch or state.tick > before.tick:
        return True
    return state.tick == before.tick and state.wall_ns != before.wall_ns


class Hits(Feed[Hit]):
    """Hits in order, from now on. They travel beside the states: those of a tick may come after its state."""

    missed: int
    """Hits whose numbers were left out, because this reader or the server had no room for them."""

    def __init__(self, session: zenoh.Session, key: str, timeout_s: float | None) -> None:
        super().__init__(session, key, _HIT_MESSAGES, timeout_s)
        self.missed = 0
        self._waiting: deque[Hit] = deque()
        self._newest: Hit | None = None

    def poll(self) -> Hit | None:
        """The next hit if it is already here."""
        if not self._waiting:
            message = self._payload()
            if message is None:
                return None
            self._waiting.extend(frames.hit(fields) for fields in json.loads(message)["events"])
        if not self._waiting:
            return None
        hit, before = self._waiting.popleft(), self._newest
        if before is not None and before.epoch == hit.epoch:
            self.missed += hit.sequence - before.sequence - 1
        self._newest = hit
        return hit
