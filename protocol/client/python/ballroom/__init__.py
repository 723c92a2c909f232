"""Drive and watch a Ballroom server.

with ballroom.connect() as server:
    server.pause()
    server.steer("player", "up")
    state = server.step(60)
    print(state.time_s, state["player"].center_m)
"""

from ballroom.driver import Acted, Driver
from ballroom.env import Env, VectorEnv
from ballroom.errors import (
    BallroomError,
    FrameError,
    LostBallError,
    NoAnswerError,
    NoServerError,
    OutOfStepError,
    RefusedError,
)
from ballroom.feeds import Hits, States
from ballroom.frames import Ball, Hit, Parameter, Player, Reply, Roster, State, World
from ballroom.launch import launch
from ballroom.server import (
    BallSetting,
    Direction,
    NewBall,
    Rectangle,
    RunState,
    Scope,
    Selection,
    Server,
    connect,
)

__all__ = [
    "Acted",
    "Ball",
    "BallSetting",
    "BallroomError",
    "Direction",
    "Driver",
    "Env",
    "FrameError",
    "Hit",
    "Hits",
    "LostBallError",
    "NewBall",
    "NoAnswerError",
    "NoServerError",
    "OutOfStepError",
    "Parameter",
    "Player",
    "Rectangle",
    "RefusedError",
    "Reply",
    "Roster",
    "RunState",
    "Scope",
    "Selection",
    "Server",
    "State",
    "States",
    "VectorEnv",
    "World",
    "connect",
    "launch",
]
