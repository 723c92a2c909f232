"""Servers as processes."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import children

import ballroom


def test_a_launched_server_is_one_ones_own_and_ends_with_the_block() -> None:
    with ballroom.launch("gas", balls=50, tick_rate_hz=120, arena="lab", paused=True) as server:
        state, endpoint = server.state(), server.endpoint
        assert (len(state), state.tick, state.paused, server.world().tick_rate_hz) == (50, 0, True, 120)
        assert endpoint.startswith("tcp/127.0.0.1:")
        assert len(children()) == 1
        with ballroom.connect(endpoint, "lab") as second:
            assert second.state().state_hash == state.state_hash
    assert children() == []
    with pytest.raises(ballroom.NoServerError):
        ballroom.connect(endpoint, "lab", timeout_s=0.2)


def test_an_error_in_the_block_ends_the_server_too() -> None:
    with pytest.raises(ZeroDivisionError), ballroom.launch("plane"):
        raise ZeroDivisionError
    assert children() == []


def test_a_scene_that_is_wrong_is_said_in_the_servers_words(tmp_path: Path) -> None:
    scene = tmp_path / "wrong.toml"
    scene.write_text('version = 1\nname = "wrong"\n[floor.polynomial]\nx_m = [1.0, 0.0]\ny_m = [0.0, 1.0]\n')
    with pytest.raises(ballroom.NoServerError, match=r"ended with code 5: .*wrong\.toml"), ballroom.launch(scene):
        pass
    assert children() == []


def test_a_missing_program_says_how_to_get_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("BALLROOM_BIN", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    for binary in [None, tmp_path / "nothing"]:
        with pytest.raises(ballroom.BallroomError, match="cargo build"), ballroom.launch(binary=binary):
            pass
