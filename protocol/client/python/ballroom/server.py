"""A session with the server of one arena."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

import numpy as np
import zenoh
from numpy.typing import NDArray

from ballroom import frames
from ballroom.driver import Driver
from ballroom.errors import (
    BallroomError,
    FrameError,
    NoAnswerError,
    NoServerError,
    OutOfStepError,
    RefusedError,
)
from ballroom.feeds import Hits, States
from ballroom.frames import Ball, Parameter, Player, Reply, State, World

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
"""Where `ballroom serve` listens first."""

DirectionName: TypeAlias = Literal["up", "down", "left", "right", "stop"]
Direction: TypeAlias = DirectionName | Sequence[float]
"""A name (up is +y), or x and y of length at most 1."""

Rectangle: TypeAlias = tuple[float, float, float, float]
"""x0, y0, x1, y1 in metres, low before high."""
RunState: TypeAlias = Literal["stopped", "playing", "paused", "quitting"]
"""What the clock of an arena does, in the words of ROS `simulation_interfaces`."""

Scope: TypeAlias = Literal["all", "time", "state", "spawned"]
"""What a reset takes back."""


class BallSetting(TypedDict, total=False):
    """A ball as it shall be; what is not given stays."""

    center_m: Sequence[float] | NDArray[np.float64]
    """x and y."""
    velocity_m_per_s: Sequence[float] | NDArray[np.float64]
    """Projected to the tangent plane."""
    spin_rad_per_s: float
    """About the floor's normal."""


class Selection(TypedDict, total=False):
    """Balls that meet every condition that is given, at least one."""

    names: Sequence[str]
    """Any of these."""
    player: bool
    """Whether a player may steer it."""
    tag: str
    spawned: bool
    """Whether it was spawned, and is not of the scene."""
    within_m: Rectangle
    """Where the centre is."""


class _Body(TypedDict):
    radius_m: float
    mass_kg: float


class NewBall(_Body, total=False):
    """A ball as a scene file has it: radius, mass and exactly one place, the rest may be left out."""

    inertia: Literal["solid", "hollow"] | float
    """Over m r^2; solid when absent."""
    center_m: Sequence[float] | NDArray[np.float64]
    """x and y of the centre."""
    contact_m: Sequence[float] | NDArray[np.float64]
    """x and y of the point where it touches the floor."""
    uv: Sequence[float] | NDArray[np.float64]
    """Parameters of that point."""
    velocity_m_per_s: Sequence[float] | NDArray[np.float64]
    """Projected to the tangent plane."""
    spin_rad_per_s: float
    """About the floor's normal."""
    color: str
    """`#rrggbb`."""
    player: bool
    """Whether a player may steer it."""
    tags: Sequence[str]
    """What to select it by."""


_LOOK_AGAIN_S = 0.05
_AS_LONG_AS_IT_LIVES_S = 1e6
_TOO_MANY = 101
_ARENA_COMMAND = "ballroom/v1/@arenas/command"
_ARENA_LIST = "ballroom/v1/@arenas/list"


class Server:
    """A running arena. Every method waits for the server's answer and raises a `BallroomError` when there is none."""

    endpoint: str
    arena: str
    timeout_s: float

    def __init__(self, endpoint: str | None, arena: str, timeout_s: float) -> None:
        self.endpoint = endpoint or DEFAULT_ENDPOINT
        self.arena = arena
        self.timeout_s = timeout_s
        self._prefix = f"ballroom/v1/{arena}"
        deadline = time.monotonic() + timeout_s
        self._session = self._open(deadline)
        try:
            self._greet(deadline)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Ends the session; the server goes on."""
        if not self._session.is_closed():
            self._session.close()

    def __enter__(self) -> Server:
        """Itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Closes."""
        self.close()

    def state(self) -> State:
        """The newest state, in full precision."""
        return self.world().state

    def states(self, timeout_s: float | None = None) -> States:
        """The present state and then the newest, for ever, or until none came for `timeout_s`."""
        return States(self._session, self._prefix, timeout_s, self.world)

    def events(self, timeout_s: float | None = None) -> Hits:
        """Hits from now on, for ever, or until none came for `timeout_s`."""
        return Hits(self._session, f"{self._prefix}/event", timeout_s)

    def world(self) -> World:
        """Scene, rate and newest state in one answer."""
        return frames.world(self._ask("snapshot"))

    def scene(self) -> dict[str, Any]:
        """The scene as served, shaped as in its file."""
        return self._ask_json("scene")

    def stats(self) -> dict[str, Any]:
        """What the server says of itself: rates, hits, energy, commands, what was dropped."""
        return self._ask_json("stats")

    def info(self) -> dict[str, Any]:
        """Frames, units, versions."""
        return self._ask_json("info")

    def balls(
        self,
        *names: str,
        player: bool | None = None,
        tag: str | None = None,
        spawned: bool | None = None,
        within_m: Rectangle | None = None,
    ) -> dict[str, Ball]:
        """Some balls as they are now: those that meet every condition that is given."""
        words = [f"name={name}" for name in names]
        words += [] if player is None else [f"player={str(player).lower()}"]
        words += [] if tag is None else [f"tag={tag}"]
        words += [] if spawned is None else [f"spawned={str(spawned).lower()}"]
        words += [] if within_m is None else ["within=" + ",".join(repr(float(x)) for x in within_m)]
        answer = self._ask_json("balls", "?" + ";".join(words))
        if answer["left_out"]:
            raise BallroomError(f"{answer['left_out']} balls more than one answer holds: ask for fewer, or for state()")
        return {row["name"]: frames.ball(row) for row in answer["balls"]}

    def scenes(self) -> dict[str, str]:
        """The scenes that come with the server, by name, and what to look for."""
        return {scene["name"]: scene["description"] for scene in self._ask_json("scenes")["scenes"]}

    def features(self) -> dict[str, Any]:
        """What the server understands, with limits."""
        return self._ask_json("features")

    def pause(self) -> Reply:
        """Stops the clock."""
        return self._command("pause")

    def resume(self) -> Reply:
        """Lets the clock run."""
        return self._command("resume")

    def run_state(self) -> RunState:
        """What the clock does."""
        state: RunState = self._ask_json("state")["state"]
        return state

    def set_state(self, state: RunState) -> Reply:
        """Sets what the clock does: `stopped` pauses and resets everything, `quitting` ends this arena."""
        return self._command("set_state", state=state, timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def arenas(self) -> dict[str, dict[str, Any]]:
        """The arenas of the server's process by name: scene, state, tick, rate, number of balls."""
        return {row["arena"]: row for row in json.loads(self._ask(_ARENA_LIST))["arenas"]}

    def start_arena(  # noqa: PLR0913
        self,
        arena: str,
        scene: str | None = None,
        *,
        toml: str | None = None,
        balls: int | None = None,
        tick_rate_hz: int = 60,
        paused: bool = False,
        record: bool = False,
    ) -> Server:
        """Runs one more arena in the server's process and gives a session with it, to be closed by whoever asked.

        The scene is one of `scenes()` by name, or the text of a scene file. It ends with `stop_arena`, not with the
        session.
        """
        fields = {"arena": arena, "scene": scene, "toml": toml, "balls": balls, "tick_rate_hz": tick_rate_hz}
        self._command("start", _AS_LONG_AS_IT_LIVES_S, _ARENA_COMMAND, **fields, paused=paused, record=record)
        return Server(self.endpoint, arena, self.timeout_s)

    def stop_arena(self, arena: str) -> Reply:
        """Ends an arena of the server's process; with its last the process ends."""
        return self._command("stop", _AS_LONG_AS_IT_LIVES_S, _ARENA_COMMAND, arena=arena)

    def step(self, ticks: int = 1) -> State:
        """Advances a paused arena and gives the state of exactly that tick."""
        return self._state_at(self._command("step", ticks=ticks, timeout_s=_AS_LONG_AS_IT_LIVES_S))

    def run_until(self, time_s: float) -> State:
        """Advances a paused arena to the first tick at or after a simulated time, and gives its state."""
        return self._state_at(self._command("run_until", time_s=time_s, timeout_s=_AS_LONG_AS_IT_LIVES_S))

    def reset(self, seed: int | None = None, scope: Scope = "all") -> Reply:
        """Back to the scene's first state, as a new epoch; a clock that stands goes on standing.

        A seed places the scene's clouds of balls anew; without one they are where the scene's own seeds put them.
        `time` takes back the clock only, `state` only the balls, `spawned` takes away the balls that were spawned.
        """
        return self._command("reset", scope=scope, seed=seed, timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def speed(self, factor: float | Literal["max"]) -> Reply:
        """Simulated seconds per wall second, or `max`: no tick waits."""
        return self._command("speed", factor=factor)

    def set_balls(self, balls: Mapping[str, BallSetting]) -> Reply:
        """Puts balls elsewhere by name, or gives them another velocity or spin: all of them, or none."""
        rows = [{"name": name} | {key: _plain(value) for key, value in ball.items()} for name, ball in balls.items()]
        return self._command("set_balls", balls=rows, timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def set_selected(
        self,
        select: Selection,
        *,
        velocity_m_per_s: Sequence[float] | None = None,
        spin_rad_per_s: float | None = None,
    ) -> Reply:
        """Gives every ball that is selected when it acts the same velocity or spin: all of them, or none."""
        velocity = None if velocity_m_per_s is None else _plain(velocity_m_per_s)
        return self._command(
            "set_balls",
            select=dict(select),
            velocity_m_per_s=velocity,
            spin_rad_per_s=spin_rad_per_s,
            timeout_s=_AS_LONG_AS_IT_LIVES_S,
        )

    def spawn(self, balls: Mapping[str, NewBall]) -> Reply:
        """Adds balls by name while the others roll: all of them, or none. A new epoch; the clock goes on."""
        rows = [{"name": name} | {key: _jsonable(value) for key, value in ball.items()} for name, ball in balls.items()]
        return self._command("spawn", balls=rows, timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def delete(
        self,
        *names: str,
        player: bool | None = None,
        tag: str | None = None,
        spawned: bool | None = None,
        within_m: Rectangle | None = None,
    ) -> Reply:
        """Removes the balls that meet every condition when it acts. A new epoch; the clock goes on."""
        return self._command(
            "delete",
            names=list(names) or None,
            player=player,
            tag=tag,
            spawned=spawned,
            within_m=within_m,
            timeout_s=_AS_LONG_AS_IT_LIVES_S,
        )

    def move_control_points(self, points: Mapping[tuple[int, int], Sequence[float]]) -> Reply:
        """Moves control points of the floor, by row and column: all of them, or none. A new epoch; the clock goes on.

        Balls keep x, y, spin and orientation; the energy that takes counts as steering work.
        """
        rows = [{"row": row, "column": column, "to_m": _plain(to)} for (row, column), to in points.items()]
        return self._command("move_control_points", points=rows, timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def parameters(self) -> dict[str, Parameter]:
        """Numbers of the scene by name, and which of them may be set."""
        rows = self._ask_json("parameters")["parameters"]
        return {row["name"]: frames.parameter(row) for row in rows}

    def set_parameters(self, values: Mapping[str, float | Sequence[float]]) -> Reply:
        """Sets some of them: all, or none. A new epoch; the clock goes on."""
        plain = {name: _plain(value) for name, value in values.items()}
        return self._command("set_parameters", values=plain, timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def load_scene(self, name: str | None = None, *, toml: str | None = None, balls: int | None = None) -> Reply:
        """Goes on with another scene as a new epoch: one of `scenes()` by name, or the text of a scene file.

        `balls` is how many there shall be, for a scene with one cloud.
        """
        return self._command("load_scene", name=name, toml=toml, balls=balls, timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def reload_scene(self) -> Reply:
        """Reads the scene's file that the arena was started with again, and begins with it as a new epoch."""
        return self._command("reload_scene", timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def check(self, toml: str) -> dict[str, Any]:
        """Whether the text of a scene file could be run, without touching what runs.

        `ok` says so; `fault` then names line, column, field and what would be right, or `scene` holds what is proved
        about its floor.
        """
        answer = json.loads(self._ask("check", toml.encode(), _AS_LONG_AS_IT_LIVES_S))
        return dict(answer)

    def clients(self) -> list[dict[str, Any]]:
        """Who reads the states, and how they come: age, jitter, losses, rates."""
        return list(self._ask_json("clients")["clients"])

    def rewind(self, seconds: float | None = None, *, tick: int | None = None, epoch: int | None = None) -> Reply:
        """Goes back along what happened, to the state that was published there, and on from it as a new epoch.

        So many simulated seconds back, through resets and other scenes too; or to a tick of the present count, or of an
        earlier epoch. A clock that stands goes on standing. What came after is forgotten.
        """
        return self._command("rewind", seconds=seconds, tick=tick, epoch=epoch, timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def save_state(self, slot: str) -> Reply:
        """Keeps the present state in the server under a name."""
        return self._command("save_state", slot=slot, timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def load_state(self, slot: str | None = None, *, state: Mapping[str, Any] | None = None) -> Reply:
        """Goes on from a state as a new epoch: from one kept under a name, or from one that `checkpoint` gave.

        A slot brings its scene with it; a given state is refused when it belongs to another scene than the present one.
        """
        return self._command("load_state", slot=slot, state=state, timeout_s=_AS_LONG_AS_IT_LIVES_S)

    def slots(self) -> dict[str, Any]:
        """What can be gone back to: how far the history reaches, and the states kept under names."""
        return self._ask_json("slots")

    def checkpoint(self, slot: str | None = None) -> dict[str, Any]:
        """The present state, or one kept under a name, as `ballroom save FILE` writes it: for `json.dump`."""
        return self._ask_json("checkpoint", "" if slot is None else f"?slot={slot}")

    def steer(self, ball: str | None, direction: Direction, mode: Literal["impulse", "force"] = "impulse") -> Reply:
        """Pushes a player's ball once, or until told otherwise, half a simulated second at most.

        `None` is the scene's first player.
        """
        where = direction if isinstance(direction, str) else [float(x) for x in direction]
        return self._command("steer", ball=ball, direction=where, mode=mode)

    def claim(self, ball: str | None = None, player: str = "python") -> Driver:
        """A ball of one's own, until it is released: `with server.claim("red") as red: red.drive("up")`.

        `None` is the first free one of the players' balls. Who says nothing for two seconds loses it; the driver says
        something on a thread of its own.
        """
        given = {"player": player} if ball is None else {"player": player, "ball": ball}
        answer = json.loads(self._ask("claim", json.dumps(given).encode()))
        if not answer["ok"]:
            raise RefusedError("claim", answer["error"], answer.get("code"))
        return Driver(self, answer)

    def release(self, player: str, token: str) -> Reply:
        """Takes a claimed ball back from its player; `Driver.release` does it."""
        answer = json.loads(self._ask("release", json.dumps({"player": player, "token": token}).encode()))
        if not answer["ok"]:
            raise RefusedError("release", answer["error"], answer.get("code"))
        return Reply(tick=answer["tick"], epoch=answer["epoch"])

    def players(self) -> dict[str, Player]:
        """Who drives which ball."""
        return {row["player"]: frames.player(row) for row in self._ask_json("players")["players"]}

    @property
    def session(self) -> zenoh.Session:
        """The session underneath."""
        return self._session

    def _open(self, deadline: float) -> zenoh.Session:
        config = zenoh.Config()
        config.insert_json5("mode", '"client"')
        config.insert_json5("scouting/multicast/enabled", "false")
        config.insert_json5("connect/endpoints", json.dumps([self.endpoint]))
        while True:
            try:
                return zenoh.open(config)
            except zenoh.ZError as why:
                if time.monotonic() + _LOOK_AGAIN_S > deadline:
                    raise NoServerError(
                        f"nobody listens at {self.endpoint} (waited {self.timeout_s:g} s): "
                        "start `ballroom serve`, or name its endpoint"
                    ) from why
            time.sleep(_LOOK_AGAIN_S)

    def _greet(self, deadline: float) -> None:
        """Waits until the arena answers, for what it has declared may arrive after the session opened."""
        while True:
            try:
                info = self.info()
                break
            except NoServerError:
                if time.monotonic() + _LOOK_AGAIN_S > deadline:
                    raise NoServerError(self._who_is_there()) from None
            time.sleep(_LOOK_AGAIN_S)
        if info["frame_version"] != frames.FRAME_VERSION:
            raise FrameError(
                f"the server writes frames of version {info['frame_version']}, "
                f"this package reads {frames.FRAME_VERSION}: use one release"
            )

    def _who_is_there(self) -> str:
        replies = self._session.get("ballroom/v1/*/srv/info", timeout=self.timeout_s)
        found = sorted(json.loads(reply.ok.payload.to_bytes())["arena"] for reply in replies if reply.ok)
        there = f"but {', '.join(found)}" if found else "nor any other: is it `ballroom serve`?"
        return f"no arena {self.arena} at {self.endpoint}, {there}"

    def _ask(self, question: str, payload: bytes | None = None, timeout_s: float | None = None) -> bytes:
        """The answer to a question, slowing down when the server says that there are too many."""
        deadline = time.monotonic() + self.timeout_s
        while True:
            try:
                return self._ask_once(question, payload, timeout_s or self.timeout_s)
            except RefusedError as refused:
                self._slow_down(refused, deadline)

    def _ask_once(self, question: str, payload: bytes | None, timeout_s: float) -> bytes:
        is_whole_key = question in (_ARENA_COMMAND, _ARENA_LIST)
        question = question if is_whole_key else f"srv/{question}"
        key = question if is_whole_key else f"{self._prefix}/{question}"
        try:
            replies = self._session.get(key, payload=payload, timeout=timeout_s)
        except zenoh.ZError as why:
            raise BallroomError(f"{question} cannot be asked: {why}") from why
        for reply in replies:
            if reply.ok is not None:
                answer: bytes = reply.ok.payload.to_bytes()
                return answer
            why_not = reply.err.payload.to_string() if reply.err is not None else "no reason given"
            if why_not == "Timeout":
                raise NoAnswerError(f"{self.endpoint} did not answer {question} within {timeout_s:g} s")
            raise _refusal(question, why_not)
        raise NoServerError(
            f"{question} stays unanswered: the server at {self.endpoint} went away, or has more to answer "
            "than it can hold; whether it was obeyed is unknown"
        )

    def _ask_json(self, question: str, words: str = "") -> dict[str, Any]:
        answer = json.loads(self._ask(question + words))
        if not isinstance(answer, dict):
            raise FrameError(f"srv/{question} answered no JSON object")
        return answer

    def _command(self, verb: str, timeout_s: float | None = None, question: str = "command", **fields: object) -> Reply:
        given = {name: value for name, value in fields.items() if value is not None}
        line = json.dumps({"cmd": verb, **given}).encode()
        deadline = time.monotonic() + self.timeout_s
        while True:
            reply = json.loads(self._ask(question, line, timeout_s))
            if reply["ok"]:
                return Reply(tick=reply["tick"], epoch=reply["epoch"])
            self._slow_down(RefusedError(verb, reply["error"], reply.get("code")), deadline)

    @staticmethod
    def _slow_down(refused: RefusedError, deadline: float) -> None:
        """Sleeps when it was only too fast, for then nothing was done; raises any other refusal."""
        if refused.code != _TOO_MANY or time.monotonic() > deadline:
            raise refused
        time.sleep(_LOOK_AGAIN_S)

    def _state_at(self, reply: Reply) -> State:
        state = self.state()
        if (state.epoch, state.tick) != (reply.epoch, reply.tick):
            raise OutOfStepError(
                f"done at tick {reply.tick} of epoch {reply.epoch}, but now it is tick {state.tick} of "
                f"epoch {state.epoch}: somebody else moves the clock of arena {self.arena}"
            )
        return state


def connect(endpoint: str | None = None, arena: str = "main", timeout_s: float = 5.0) -> Server:
    """A session with a running server, waiting at most `timeout_s` for it, and as long for each answer."""
    return Server(endpoint, arena, timeout_s)


def _jsonable(value: object) -> object:
    """Words and lists of words as they are, numbers as JSON takes them."""
    is_words = isinstance(value, Sequence) and all(isinstance(item, str) for item in value)
    return value if isinstance(value, str | bool) or is_words else _plain(value)


def _refusal(question: str, why_not: str) -> RefusedError:
    """Why a question was not answered; what Zenoh itself says is no reply of the server."""
    try:
        reply = json.loads(why_not)
        return RefusedError(question, reply["error"], reply["code"])
    except (ValueError, TypeError, KeyError):
        return RefusedError(question, why_not)


def _plain(value: object) -> object:
    """Numbers as JSON takes them."""
    return np.asarray(value, np.float64).tolist()
