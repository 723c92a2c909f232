"""What the server says, as typed records. SI units, in the names; arrays have one row a ball, in order of names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cbor2
import numpy as np
from numpy.typing import NDArray

from ballroom.errors import FrameError

FRAME_VERSION = 1
"""The version of binary frames that this package reads."""

_DTYPES = {86: "<f8", 85: "<f4"}  # tags of RFC 8746: 64 and 32 bits, little endian
_COLUMNS = {"uv": 2, "center_m": 3, "velocity_m_per_s": 3, "omega_rad_per_s": 3, "orientation_xyzw": 4}


@dataclass(frozen=True)
class Roster:
    """Who the balls are: what does not change between ticks."""

    names: tuple[str, ...]
    radius_m: NDArray[np.float64]
    mass_kg: NDArray[np.float64]
    inertia_factor: NDArray[np.float64]
    """Moments of inertia over m r^2."""
    color_rgb: NDArray[np.uint8]
    player: NDArray[np.bool_]
    tags: Mapping[str, tuple[int, ...]]
    """The rows of the balls that have a tag."""
    spawned: tuple[int, ...]
    """The rows of those that were spawned."""

    @cached_property
    def rows(self) -> dict[str, int]:
        """The row of each name."""
        return {name: row for row, name in enumerate(self.names)}

    def row(self, name: str) -> int:
        """The row of a ball; a KeyError names those that are there."""
        row = self.rows.get(name)
        if row is None:
            raise KeyError(f"no ball is named {name!r}; the first of {len(self.names)} are {self.names[:8]}")
        return row

    @property
    def players(self) -> tuple[str, ...]:
        """The balls that may be steered."""
        return tuple(name for name, player in zip(self.names, self.player, strict=True) if player)


@dataclass(frozen=True)
class Ball:
    """One ball at one tick."""

    name: str
    radius_m: float
    mass_kg: float
    player: bool
    tags: tuple[str, ...]
    spawned: bool
    uv: NDArray[np.float64]
    center_m: NDArray[np.float64]
    velocity_m_per_s: NDArray[np.float64]
    omega_rad_per_s: NDArray[np.float64]
    orientation_xyzw: NDArray[np.float64]


@dataclass(frozen=True)
class State:
    """All balls at one tick. The arrays are read-only; `state["red"]` is one ball.

    Asked for, everything has 64 bits. On the stream velocities, spins and orientations were sent with 32.
    """

    epoch: int
    """Changes with every start and reset, and when balls or the scene were changed from outside."""
    tick: int
    time_s: float
    """Simulated time."""
    wall_ns: int
    """Wall time at the server when the tick was done, since 1970."""
    paused: bool
    energy_j: float
    steering_work_j: float
    """Energy put in from outside; energy less this is constant while hits are elastic."""
    ball_ball_hits: int
    ball_wall_hits: int
    state_hash: int
    """Of everything that influences the future, 64 bits."""
    roster: Roster
    uv: NDArray[np.float64]
    """Parameters of the touching point."""
    center_m: NDArray[np.float64]
    velocity_m_per_s: NDArray[np.float64]
    omega_rad_per_s: NDArray[np.float64]
    orientation_xyzw: NDArray[np.float64]
    """Unit quaternions, ball to world."""

    @property
    def names(self) -> tuple[str, ...]:
        """The balls by row, in byte order."""
        return self.roster.names

    @property
    def hits(self) -> int:
        """Hits since tick 0."""
        return self.ball_ball_hits + self.ball_wall_hits

    def __len__(self) -> int:
        """How many balls."""
        return len(self.roster.names)

    def __contains__(self, name: object) -> bool:
        """Whether there is a ball of this name."""
        return name in self.roster.rows

    def __getitem__(self, name: str) -> Ball:
        """One ball by name."""
        row = self.roster.row(name)
        return Ball(
            name=name,
            radius_m=float(self.roster.radius_m[row]),
            mass_kg=float(self.roster.mass_kg[row]),
            player=bool(self.roster.player[row]),
            tags=tuple(sorted(tag for tag, rows in self.roster.tags.items() if row in rows)),
            spawned=row in self.roster.spawned,
            uv=self.uv[row],
            center_m=self.center_m[row],
            velocity_m_per_s=self.velocity_m_per_s[row],
            omega_rad_per_s=self.omega_rad_per_s[row],
            orientation_xyzw=self.orientation_xyzw[row],
        )


@dataclass(frozen=True)
class World:
    """Everything a late joiner needs."""

    scene: dict[str, Any]
    tick_rate_hz: int
    state: State


@dataclass(frozen=True)
class Hit:
    """One hit; `other` is a ball's name or a wall's number."""

    epoch: int
    sequence: int
    """Number of the hit since the epoch began."""
    time_s: float
    ball: str
    other: str | int
    point_m: tuple[float, float, float]
    impulse_n_s: float


@dataclass(frozen=True)
class Player:
    """Who drives which ball. Messages are those of the present claim."""

    player: str
    ball: str
    claim: int
    """Number of the claim."""
    ball_ball_hits: int
    """Of the ball since it was claimed."""
    ball_wall_hits: int
    rank: int
    """By hits with other balls, most first, from 1 on."""
    commands: int
    refused: int
    waiting: int
    """Commands that wait for their ticks."""
    messages: int
    lost: int
    repeated: int
    latency_ms: float | None
    """From a command to its acknowledgement, as the player measured last."""
    silent_s: float
    """Since the last message."""


@dataclass(frozen=True)
class Parameter:
    """A number or a word of the scene."""

    name: str
    value: float | list[float] | str
    unit: str
    settable: bool
    """Whether it may be set while the scene runs."""
    meaning: str
    range: tuple[float, float] | None
    """The least and the largest that it may be set to."""


@dataclass(frozen=True)
class Reply:
    """Where a command acted."""

    tick: int
    epoch: int


def load(frame: bytes) -> dict[str, Any]:
    """A CBOR map of the version that is read here."""
    try:
        fields = cbor2.loads(frame)
        version = fields["v"]
    except (cbor2.CBORDecodeError, KeyError, TypeError) as why:
        raise FrameError(f"no frame of Ballroom: {why}") from why
    if version != FRAME_VERSION:
        raise FrameError(f"frame version {version}, this package reads {FRAME_VERSION}: use one release")
    return dict(fields)


def roster(fields: Mapping[str, Any]) -> Roster:
    """The balls' constants."""
    return Roster(
        names=tuple(fields["names"]),
        radius_m=_constant(np.array(fields["radius_m"], np.float64)),
        mass_kg=_constant(np.array(fields["mass_kg"], np.float64)),
        inertia_factor=_constant(np.array(fields["inertia_factor"], np.float64)),
        color_rgb=_constant(np.array(fields["color_rgb"], np.uint8).reshape(-1, 3)),
        player=_constant(np.array(fields["player"], np.bool_)),
        tags={tag: tuple(rows) for tag, rows in fields.get("tags", {}).items()},
        spawned=tuple(fields.get("spawned", ())),
    )


def state(fields: Mapping[str, Any], balls: Roster) -> State:
    """A state from the map of its frame."""
    try:
        return State(
            epoch=fields["epoch"],
            tick=fields["tick"],
            time_s=fields["time_s"],
            wall_ns=fields["wall_ns"],
            paused=fields["paused"],
            energy_j=fields["energy_j"],
            steering_work_j=fields["steering_work_j"],
            ball_ball_hits=fields["collisions"]["ball_ball"],
            ball_wall_hits=fields["collisions"]["ball_wall"],
            state_hash=fields["state_hash"],
            roster=balls,
            **{name: _rows(fields[name], columns, len(balls.names)) for name, columns in _COLUMNS.items()},
        )
    except (KeyError, TypeError, AttributeError, ValueError) as why:
        raise FrameError(f"a state that cannot be read: {why!r}") from why


def world(frame: bytes) -> World:
    """A world from its frame."""
    fields = load(frame)
    try:
        balls = roster(fields["roster"])
        return World(fields["scene"], fields["tick_rate_hz"], state(fields["snapshot"], balls))
    except (KeyError, TypeError, ValueError) as why:
        raise FrameError(f"a world that cannot be read: {why!r}") from why


def ball(fields: Mapping[str, Any]) -> Ball:
    """A ball from its JSON."""
    arrays = {name: _constant(np.array(fields[name], np.float64)) for name in _COLUMNS}
    plain = {name: fields[name] for name in ("name", "radius_m", "mass_kg", "player")}
    return Ball(**{**plain, **arrays, "tags": tuple(fields.get("tags", ())), "spawned": fields.get("spawned", False)})


def parameter(fields: Mapping[str, Any]) -> Parameter:
    """A parameter from its JSON."""
    low_high = fields.get("range")
    return Parameter(**{**fields, "range": None if low_high is None else tuple(low_high)})


def hit(fields: Mapping[str, Any]) -> Hit:
    """A hit from its JSON."""
    x, y, z = fields["point_m"]
    ((_, other),) = fields["other"].items()
    return Hit(**{**fields, "other": other, "point_m": (x, y, z)})


def player(fields: Mapping[str, Any]) -> Player:
    """Who drives, from its JSON."""
    plain = {name: value for name, value in fields.items() if name != "hits"}
    hits = fields["hits"]
    return Player(**plain, ball_ball_hits=hits["ball_ball"], ball_wall_hits=hits["ball_wall"])


def _rows(array: cbor2.CBORTag, columns: int, balls: int) -> NDArray[np.float64]:
    rows = np.frombuffer(array.value, _DTYPES[array.tag]).reshape(balls, columns)
    return _constant(rows.astype(np.float64, copy=False))


def _constant(array: NDArray[Any]) -> NDArray[Any]:
    array.flags.writeable = False
    return array
