"""Lock-step in Gymnasium's shape."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from conftest import Serve

import ballroom

ACTIONS = np.random.default_rng(7).uniform(-1.0, 1.0, (40, 2))


def ride(env: ballroom.Env, actions: np.ndarray = ACTIONS) -> tuple[list[bytes], list[int]]:
    """The bytes of all observations of a run, and its hashes."""
    observation, info = env.reset()
    seen, hashes = [observation.tobytes()], [info["state_hash"]]
    for action in actions:
        observation, _, _, _, info = env.step(action)
        seen.append(observation.tobytes())
        hashes.append(info["state_hash"])
    return seen, hashes


def test_same_actions_give_the_same_bits_here_and_in_another_process(serve: Serve) -> None:
    one, two = ballroom.Env(serve("original")), ballroom.Env(serve("original", arena="second"))
    first = ride(one)
    assert ride(one) == first
    assert ride(two) == first
    assert len(set(first[1])) == len(ACTIONS) + 1
    assert ride(one, ACTIONS[::-1])[1] != first[1]


def test_a_step_is_as_many_ticks_as_asked_for_and_starts_from_the_scene(serve: Serve) -> None:
    env = ballroom.Env(serve("bowl"), ticks_per_step=5)
    observation, info = env.reset()
    ball = info["state"]["player"]
    assert info["tick"] == 0
    assert observation.tolist() == [*ball.center_m, *ball.velocity_m_per_s, *ball.omega_rad_per_s]
    for step in range(1, 4):
        *_, info = env.step((1.0, 0.0))
        assert info["tick"] == 5 * step
        assert info["state"] is env.state


def test_an_impulse_acts_once_and_a_force_all_the_time(serve: Serve) -> None:
    server = serve("plane")
    scene = server.scene()["steering"]
    impulse, force = (ballroom.Env(server, ticks_per_step=30, mode=mode) for mode in ("impulse", "force"))
    impulse.reset()
    impulse.step((0.0, 1.0))
    assert impulse.state["cue"].velocity_m_per_s[1] == scene["impulse_m_per_s"]
    force.reset()
    force.step((0.0, 1.0))
    assert force.state["cue"].velocity_m_per_s[1] == pytest.approx(0.5 * scene["acceleration_m_per_s2"], abs=1e-12)
    coasting = force.state["cue"].velocity_m_per_s.tolist()
    force.reset()
    force.step((0.0, 1.0))
    force.server.steer("cue", "stop", "force")
    assert force.server.step(3)["cue"].velocity_m_per_s.tolist() == coasting


def test_what_is_longer_than_one_is_shortened_to_it(serve: Serve) -> None:
    env = ballroom.Env(serve("bowl"))
    runs = []
    for action in [(3.0, 4.0), (0.6, 0.8)]:
        env.reset()
        env.step(action)
        runs.append(env.state.state_hash)
    assert runs[0] == runs[1]


def test_reward_end_and_truncation_are_what_the_user_says(serve: Serve) -> None:
    def progress(before: ballroom.State, after: ballroom.State) -> float:
        return float(after["player"].center_m[0] - before["player"].center_m[0])

    env = ballroom.Env(
        serve("bowl"),
        observe=lambda state: state.center_m.ravel(),
        reward=progress,
        is_terminal=lambda state: bool(state["player"].center_m[0] > 0.05),
        max_steps=100,
    )
    observation, _ = env.reset()
    assert observation.shape == (15,)
    total, steps, terminated = 0.0, 0, False
    while not terminated:
        _, reward, terminated, truncated, _ = env.step((1.0, 0.0))
        total, steps = total + reward, steps + 1
        assert not truncated
    assert total == pytest.approx(env.state["player"].center_m[0], abs=1e-12)
    assert total > 0.05
    env.max_steps = steps
    env.reset()
    assert [env.step((0.0, 0.0))[3] for _ in range(steps)] == [False] * (steps - 1) + [True]


def test_what_makes_no_sense_is_refused(serve: Serve) -> None:
    server = serve("bowl")
    with pytest.raises(ValueError, match="a step of 31 ticks is longer"):
        ballroom.Env(server, ticks_per_step=31)
    with pytest.raises(ValueError, match="use 1 or more"):
        ballroom.Env(server, ticks_per_step=0)
    with pytest.raises(KeyError, match="no ball is named 'eight'"):
        ballroom.Env(server, ball="eight")
    env = ballroom.Env(server)
    for action in [np.array([1.0, 0.0, 0.0]), np.array([np.nan, 0.0]), np.array(1.0)]:
        with pytest.raises(ValueError, match="two finite numbers"):
            env.step(action)


def test_a_seed_gives_another_beginning_and_the_same_ride_each_time(serve: Serve) -> None:
    envs = [
        ballroom.Env(serve("thousand", balls=30, arena=arena), observe=lambda state: state.center_m.ravel())
        for arena in ("a", "b")
    ]
    with ballroom.VectorEnv(envs) as both:
        observations, _ = both.reset([3, 4])
        assert (observations[0] != observations[1]).any()
        observations, infos = both.reset([3, 3])
        assert (observations[0] == observations[1]).all()
        for action in ACTIONS[:10]:
            *_, infos = both.step([action, action])
            assert infos[0]["state_hash"] == infos[1]["state_hash"]
        with pytest.raises(ValueError, match="1 seeds for 2 arenas"):
            both.reset([3])


def test_a_scene_without_a_players_ball_is_refused(serve: Serve, tmp_path: Path) -> None:
    scene = tmp_path / "lonely.toml"
    scene.write_text(
        'version = 1\nname = "lonely"\nfloor.polynomial = { x_m = [-1.0, 1.0], y_m = [-1.0, 1.0] }\n'
        'ball = [{ name = "one", radius_m = 0.1, mass_kg = 1.0, center_m = [0.0, 0.0] }]\n'
    )
    with pytest.raises(ValueError, match="no player's ball"):
        ballroom.Env(serve(scene))


def test_many_arenas_at_once_do_what_each_does_alone() -> None:
    actions = ACTIONS[:20].reshape(10, 2, 2)
    with ExitStack() as stack:
        envs = [ballroom.Env(stack.enter_context(ballroom.launch(scene))) for scene in ("bowl", "original")]
        alone = [ride(env, actions[:, row]) for row, env in enumerate(envs)]
        together = stack.enter_context(ballroom.VectorEnv(envs))
        observations, infos = together.reset()
        seen, hashes = [observations], [[info["state_hash"] for info in infos]]
        for action in actions:
            observations, rewards, terminated, truncated, infos = together.step(action)
            assert rewards.shape == terminated.shape == truncated.shape == (2,)
            seen.append(observations)
            hashes.append([info["state_hash"] for info in infos])
        for row in range(2):
            assert [observations[row].tobytes() for observations in seen] == alone[row][0]
            assert [pair[row] for pair in hashes] == alone[row][1]
        with pytest.raises(ValueError, match="shape"):
            together.step(actions[0][:1])
