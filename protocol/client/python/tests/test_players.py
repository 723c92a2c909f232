"""Balls of one's own."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import Serve

import ballroom

TWO = """
version = 1
name = "two"
floor.polynomial = { x_m = [-9.0, 9.0], y_m = [-9.0, 9.0] }
ball = [
  { name = "red", radius_m = 0.5, mass_kg = 1.0, center_m = [3.0, 0.0], player = true },
  { name = "blue", radius_m = 0.5, mass_kg = 1.0, center_m = [-3.0, 0.0], player = true },
]
"""


@pytest.fixture
def two(serve: Serve, tmp_path: Path) -> ballroom.Server:
    """A level table with two players' balls, whose clock stands."""
    file = tmp_path / "two.toml"
    file.write_text(TWO)
    return serve(file, paused=True)


def test_a_claimed_ball_goes_where_its_player_drives_it_and_nobody_else(two: ballroom.Server) -> None:
    with two.claim("red", player="ann") as red:
        red.drive("up")
        red.drive([0.6, 0.8], "force")
        acted = red.settle()
        assert [(a.seq, a.tick, a.done) for a in acted] == [(1, 0, True), (2, 0, True)]
        assert two.step(10)["red"].velocity_m_per_s[1] > 0.5
        with pytest.raises(ballroom.RefusedError, match="driven by ann") as refused:
            two.steer("red", "down")
        assert refused.value.code == 4
        with pytest.raises(ballroom.RefusedError, match="driven by ann"):
            two.claim("red", player="bob")
        two.steer("blue", "down")
        row = two.players()["ann"]
        assert (row.ball, row.commands, row.refused, row.rank) == ("red", 2, 0, 1)
    assert two.players() == {}
    two.steer("red", "down")
    with pytest.raises(ballroom.LostBallError, match="released"):
        red.drive("up")


def test_commands_act_at_the_ticks_they_are_wanted_at(two: ballroom.Server) -> None:
    state = two.state()
    with two.claim(player="ann") as red:
        assert red.ball == "red"
        for tick in (10, 20, 30):
            red.drive("right", tick=tick, epoch=state.epoch)
        deadline = time.monotonic() + two.timeout_s
        while two.players()["ann"].waiting < 3:
            assert time.monotonic() < deadline
        two.step(40)
        assert [(a.seq, a.tick, a.epoch) for a in red.settle()] == [(i, 10 * i, state.epoch) for i in (1, 2, 3)]
        red.drive("right", tick=10**9)
        (refused,) = red.settle()
        assert not refused.done
        assert "too far ahead" in refused.error


def test_a_forged_token_drives_nothing(two: ballroom.Server) -> None:
    with two.claim("red", player="ann") as red:
        forged = {"token": "0" * 32, "number": 1, "sent": [{"seq": 1, "direction": "up"}]}
        two.session.put("ballroom/v1/main/drive/ann", json.dumps(forged))
        with pytest.raises(ballroom.RefusedError, match="by this token"):
            two.release("ann", "0" * 32)
        assert two.step(5)["red"].velocity_m_per_s.tolist() == [0.0, 0.0, 0.0]
        assert red.lost is None


def test_a_player_that_is_killed_frees_its_ball(two: ballroom.Server) -> None:
    player = "import ballroom, time; d = ballroom.connect(ENDPOINT).claim('red', 'ann'); print(d.ball, flush=True); "
    program = player.replace("ENDPOINT", repr(two.endpoint)) + "time.sleep(1000)"
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "red\n"
        with pytest.raises(ballroom.RefusedError, match="driven by ann"):
            two.claim("red", player="bob")
        process.kill()
    deadline = time.monotonic() + 4 * two.timeout_s
    while "ann" in two.players():
        assert time.monotonic() < deadline
    two.claim("red", player="bob").release()
