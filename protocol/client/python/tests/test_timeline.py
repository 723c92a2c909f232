"""Back along what happened, and on from what was kept."""

from __future__ import annotations

import json

import pytest
from conftest import Serve

import ballroom


def test_a_rewind_gives_the_state_that_was_there_and_goes_on_from_it(serve: Serve) -> None:
    server = serve("original", paused=True)
    server.steer(None, "up")
    then = server.step(130)
    server.steer(None, (0.6, -0.8), "force")
    later = server.step(200)
    reply = server.rewind(tick=130)
    assert (reply.tick, reply.epoch) == (130, then.epoch + 1)
    back = server.state()
    assert (back.paused, back.tick, back.state_hash) == (True, 130, then.state_hash)
    assert back.orientation_xyzw.tolist() == then.orientation_xyzw.tolist()
    server.steer(None, (0.6, -0.8), "force")
    assert server.step(200).state_hash == later.state_hash
    assert server.rewind(200 / 60).tick == 130
    with pytest.raises(ballroom.RefusedError, match="begins") as refused:
        server.rewind(1000.0)
    assert refused.value.code == 5


def test_a_slot_branches_a_run_and_brings_its_scene_with_it(plane: ballroom.Server) -> None:
    then = plane.step(60)
    plane.save_state("fork")
    straight = plane.step(60)
    plane.load_scene("bowl")
    assert plane.load_state("fork").tick == 60
    plane.steer("cue", "left")
    assert plane.step(60).state_hash != straight.state_hash
    plane.load_state("fork")
    assert (plane.state().names, plane.state().state_hash) == (then.names, then.state_hash)
    assert plane.step(60).state_hash == straight.state_hash
    (slot,) = plane.slots()["slots"]
    assert (slot["name"], slot["scene"], slot["tick"]) == ("fork", "plane", 60)
    with pytest.raises(ballroom.RefusedError, match="fork") as refused:
        plane.load_state("spoon")
    assert refused.value.code == 3


def test_a_state_survives_as_json_and_belongs_to_its_scene(plane: ballroom.Server) -> None:
    then = plane.step(90)
    plane.save_state("a")
    text = json.dumps(plane.checkpoint())
    straight = plane.step(30)
    assert plane.checkpoint("a") == json.loads(text)
    plane.load_state(state=json.loads(text))
    assert plane.state().state_hash == then.state_hash
    assert plane.step(30).state_hash == straight.state_hash
    plane.load_scene("bowl")
    with pytest.raises(ballroom.RefusedError, match="another scene"):
        plane.load_state(state=json.loads(text))
