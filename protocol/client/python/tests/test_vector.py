"""Many arenas of one server as one environment."""

from __future__ import annotations

import numpy as np
import pytest

import ballroom
from ballroom.spaces import Box


def test_arenas_of_one_server_are_stepped_together_and_end_with_it(plane: ballroom.Server) -> None:
    with ballroom.VectorEnv.start(plane, 3, "plane", ticks_per_step=3) as envs:
        assert sorted(plane.arenas()) == ["env-0", "env-1", "env-2", "main"]
        assert envs.action_space.shape == (3, 2)
        assert envs.observation_space.shape == (3, 9)
        first, _ = envs.reset()
        assert first.shape == (3, 9)
        moved, _, _, _, infos = envs.step([[0.0, 1.0], [0.0, -1.0], [0.0, 1.0]])
        assert infos[0]["state_hash"] == infos[2]["state_hash"] != infos[1]["state_hash"]
        assert moved[0, 1] > first[0, 1] > moved[1, 1]
        assert [info["tick"] for info in infos] == [3, 3, 3]
        assert plane.state().tick == 0
    assert sorted(plane.arenas()) == ["main"]


def test_an_episode_that_ends_begins_anew_in_the_same_step(plane: ballroom.Server) -> None:
    with ballroom.VectorEnv.start(plane, 2, "plane", ticks_per_step=2, max_steps=2) as envs:
        first, _ = envs.reset()
        actions = np.array([[1.0, 0.0], [0.0, 1.0]])
        assert not envs.step(actions)[3].any()
        observations, _, _, truncated, infos = envs.step(actions)
        assert truncated.all()
        assert observations.tolist() == first.tolist()
        assert all(info["tick"] == 0 and info["final_info"]["tick"] == 4 for info in infos)
        assert infos[0]["final_observation"].tolist() != first[0].tolist()
        assert not envs.step(actions)[3].any()


def test_what_cannot_be_started_leaves_no_arena_behind(plane: ballroom.Server) -> None:
    with pytest.raises(ballroom.RefusedError, match="runs already"), plane.start_arena("env-1", "plane"):
        ballroom.VectorEnv.start(plane, 2, "plane")
    assert sorted(plane.arenas()) == ["env-1", "main"]


def test_a_box_holds_what_it_samples_and_repeats_it_by_seed() -> None:
    low, high = np.array([-1.0, -np.inf, 0.0]), np.array([1.0, np.inf, np.inf])
    space = Box(low, high)
    space.seed(3)
    samples = [space.sample() for _ in range(50)]
    assert all(space.contains(sample) for sample in samples)
    space.seed(3)
    assert space.sample().tolist() == samples[0].tolist()
    assert not space.contains([2.0, 0.0, 0.0])
    assert not space.contains([0.0, 0.0])
    assert space.shape == (3,)
    assert space.dtype == np.dtype(np.float64)
