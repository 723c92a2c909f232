"""Drive and watch a Ballroom server.

with ballroom.connect() as server:
    server.pause()
    server.steer("player", "up")
    state = server.step(60)
    print(state.time_s, state["player"].center_m)
"""

from ballroom.env import Env, VectorEnv
from ballroom.errors import (
    BallroomError,
    FrameError,
    NoAnswerError,
    NoServerError,
    OutOfStepError,
    RefusedError,
)
from ballroom.feeds import Hits, States
from ballroom.frames import Ball, Hit, Reply, Roster, State, World
from ballroom.launch import launch
from ballroom.server import BallSetting, Direction, RunState, Scope, Server, connect

__all__ = [
    "Ball",
    "BallSetting",
    "BallroomError",
    "Direction",
    "Env",
    "FrameError",
    "Hit",
    "Hits",
    "NoAnswerError",
    "NoServerError",
    "OutOfStepError",
    "RefusedError",
    "Reply",
    "Roster",
    "RunState",
    "Scope",
    "Server",
    "State",
    "States",
    "VectorEnv",
    "World",
    "connect",
    "launch",
]
