"""An arena in lock-step, in the shape that Gymnasium's users expect; Gymnasium itself is not needed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ballroom.frames import State, World
from ballroom.server import Server
from ballroom.spaces import box

Observation: TypeAlias = NDArray[np.float64]
Info: TypeAlias = dict[str, Any]
Step: TypeAlias = tuple[Observation, float, bool, bool, Info]

_FORCE_LASTS_S = 0.5


class Env:
    """One ball of one arena, driven step by step. No wall clock: the same actions give the same bits.

    An action is x and y; what is longer than 1 is shortened to it. As a `force` it acts during the whole step, as an
    `impulse` once at its beginning. `info` holds the `state`, and with it tick, time, energy and hash.
    """

    def __init__(  # noqa: PLR0913
        self,
        server: Server,
        ball: str | None = None,
        ticks_per_step: int = 6,
        *,
        observe: Callable[[State], Observation] | None = None,
        reward: Callable[[State, State], float] = lambda before, after: 0.0,
        is_terminal: Callable[[State], bool] = lambda state: False,
        max_steps: int | None = None,
        mode: Literal["impulse", "force"] = "force",
    ) -> None:
        """Takes over the clock of `server`.

        `observe` makes the observation (by default centre, velocity and spin of the ball, nine numbers), `reward`
        judges a step by the states before and after it, `is_terminal` ends an episode, `max_steps` truncates it.
        """
        server.pause()
        world = server.world()
        self.ball = ball or _first_player(world)
        world.state.roster.row(self.ball)
        if ticks_per_step < 1:
            raise ValueError(f"ticks_per_step is {ticks_per_step}: use 1 or more")
        if mode == "force" and ticks_per_step > _FORCE_LASTS_S * world.tick_rate_hz:
            raise ValueError(f"a force lasts {_FORCE_LASTS_S} s, a step of {ticks_per_step} ticks is longer")
        self.server = server
        self.ticks_per_step = ticks_per_step
        self.max_steps = max_steps
        self._observe = observe or self._look
        self._reward = reward
        self._is_terminal = is_terminal
        self._mode: Literal["impulse", "force"] = mode
        self._steps = 0
        self._state = world.state

    @property
    def state(self) -> State:
        """The state after the last step."""
        return self._state

    @property
    def action_space(self) -> Any:  # noqa: ANN401
        """Two numbers between -1 and 1; Gymnasium's box where it is installed."""
        return box(-1.0, 1.0, (2,))

    @property
    def observation_space(self) -> Any:  # noqa: ANN401
        """Numbers in the shape of an observation; Gymnasium's box where it is installed."""
        return box(-np.inf, np.inf, np.shape(self._observe(self._state)))

    def reset(self, seed: int | None = None) -> tuple[Observation, Info]:
        """Back to the scene's first state; a seed places its clouds of balls anew."""
        self.server.pause()
        self.server.reset(seed)
        self._steps = 0
        self._state = self.server.state()
        return self._observe(self._state), self._info()

    def step(self, action: ArrayLike) -> Step:
        """Acts for `ticks_per_step` ticks: observation, reward, terminated, truncated, info."""
        self._act(np.asarray(action, np.float64))
        before, self._state = self._state, self.server.step(self.ticks_per_step)
        self._steps += 1
        truncated = self.max_steps is not None and self._steps >= self.max_steps
        observation = self._observe(self._state)
        reward = float(self._reward(before, self._state))
        return observation, reward, self._is_terminal(self._state), truncated, self._info()

    def close(self) -> None:
        """Nothing is left open: the server belongs to whoever made it."""

    def _act(self, action: NDArray[np.float64]) -> None:
        if action.shape != (2,) or not np.isfinite(action).all():
            raise ValueError(f"an action is two finite numbers, x and y, not {action}")
        x, y = (float(part) for part in action / max(1.0, float(np.hypot(*action))))
        if x == y == 0.0:
            # As an impulse it is nothing; as a force it lets go.
            self.server.steer(self.ball, "stop", self._mode)
        else:
            self.server.steer(self.ball, (x, y), self._mode)

    def _look(self, state: State) -> Observation:
        ball = state[self.ball]
        return np.concatenate([ball.center_m, ball.velocity_m_per_s, ball.omega_rad_per_s])

    def _info(self) -> Info:
        return {"state": self._state, "tick": self._state.tick, "state_hash": self._state.state_hash}


def _end(arena: Server) -> None:
    """Ends an arena and the session with it."""
    with arena:
        arena.stop_arena(arena.arena)


def _first_player(world: World) -> str:
    """In the scene's own order, which is not that of the rows."""
    for ball in world.scene.get("ball", []):
        if ball.get("player"):
            return str(ball["name"])
    raise ValueError("the scene has no player's ball to steer")


class VectorEnv:
    """Several arenas stepped at once, a thread each; arrays with one row an arena. Close it, or use it with `with`.

    With `autoreset` an arena whose episode has ended begins anew in the same step: its row is then the first
    observation of the next episode, and its info holds `final_observation` and `final_info`. Else nothing is reset by
    itself: an arena whose episode has ended is `envs[i].reset()`.
    """

    def __init__(self, envs: Sequence[Env], *, autoreset: bool = False) -> None:
        self.envs = list(envs)
        self.autoreset = autoreset
        self._threads = ThreadPoolExecutor(max(1, len(self.envs)), "ballroom-env")
        self._begun: list[Server] = []

    @classmethod
    def start(  # noqa: PLR0913
        cls,
        server: Server,
        count: int,
        scene: str = "original",
        *,
        balls: int | None = None,
        autoreset: bool = True,
        prefix: str = "env-",
        **options: Any,  # noqa: ANN401
    ) -> VectorEnv:
        """Starts `count` arenas named `prefix` and a number in the process of `server`, which end with `close`.

        `options` are those of each `Env`.
        """
        with ExitStack() as undo:
            begun = []
            for i in range(count):
                begun.append(server.start_arena(f"{prefix}{i}", scene, balls=balls, paused=True))
                undo.callback(_end, begun[-1])
            envs = cls([Env(arena, **options) for arena in begun], autoreset=autoreset)
            undo.pop_all()
        envs._begun = begun
        return envs

    @property
    def action_space(self) -> Any:  # noqa: ANN401
        """A row of two numbers an arena."""
        return box(-1.0, 1.0, (len(self.envs), 2))

    @property
    def observation_space(self) -> Any:  # noqa: ANN401
        """A row an arena."""
        return box(-np.inf, np.inf, (len(self.envs), *self.envs[0].observation_space.shape))

    def reset(self, seeds: Sequence[int | None] | None = None) -> tuple[Observation, list[Info]]:
        """Resets all, each with its own seed if there are any."""
        seeds = [None] * len(self.envs) if seeds is None else seeds
        if len(seeds) != len(self.envs):
            raise ValueError(f"{len(seeds)} seeds for {len(self.envs)} arenas")
        observations, infos = zip(*self._threads.map(Env.reset, self.envs, seeds), strict=True)
        return np.stack(observations), list(infos)

    def step(
        self, actions: ArrayLike
    ) -> tuple[Observation, Observation, NDArray[np.bool_], NDArray[np.bool_], list[Info]]:
        """Steps all, with one row of actions each."""
        rows = np.asarray(actions, np.float64)
        if rows.shape != (len(self.envs), 2):
            raise ValueError(f"actions have the shape {rows.shape}, not {(len(self.envs), 2)}")
        steps = list(self._threads.map(self._step, self.envs, rows))
        observations, rewards, terminated, truncated, infos = zip(*steps, strict=True)
        return (
            np.stack(observations),
            np.array(rewards),
            np.array(terminated),
            np.array(truncated),
            list(infos),
        )

    def _step(self, env: Env, action: NDArray[np.float64]) -> Step:
        observation, reward, terminated, truncated, info = env.step(action)
        if self.autoreset and (terminated or truncated):
            first, begun = env.reset()
            info = {**begun, "final_observation": observation, "final_info": info}
            observation = first
        return observation, reward, terminated, truncated, info

    def close(self) -> None:
        """Ends the threads, and the arenas that `start` started."""
        self._threads.shutdown()
        while self._begun:
            _end(self._begun.pop())

    def __enter__(self) -> VectorEnv:
        """Itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Closes."""
        self.close()
