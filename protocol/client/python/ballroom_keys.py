#!/usr/bin/env python3
"""Press keys and read states of a running Ballroom server, with stock packages only.

    pip install eclipse-zenoh==1.10.2 cbor2 numpy
    ballroom serve
    python ballroom_keys.py up up left

Each word is one press of that key, half a second apart; states are printed in between.
"""

import argparse
import json
import sys
import time

try:
    import cbor2
    import numpy as np
    import zenoh
except ImportError as missing:
    sys.exit(f"{missing}: pip install eclipse-zenoh==1.10.2 cbor2 numpy")

DTYPES = {86: "<f8", 85: "<f4"}  # RFC 8746: 64 and 32 bits, little endian
COLUMNS = {"uv": 2, "center_m": 3, "velocity_m_per_s": 3, "omega_rad_per_s": 3, "orientation_xyzw": 4}


def read_frame(frame: dict) -> dict:
    """A decoded frame with NumPy views, one row a ball, in place of its typed arrays."""
    if frame["v"] != 1:
        raise ValueError(f"frame version {frame['v']}, this program reads version 1")
    for name, columns in COLUMNS.items():
        array = frame[name]
        frame[name] = np.frombuffer(array.value, DTYPES[array.tag]).reshape(-1, columns)
    return frame


def ask(session: zenoh.Session, key: str, payload: bytes | None = None) -> bytes:
    """The one answer to a question."""
    for reply in session.get(key, payload=payload, timeout=5.0):
        if reply.ok:
            return reply.ok.payload.to_bytes()
        sys.exit(f"{key}: {reply.err.payload.to_string()}")
    sys.exit(f"{key}: no server answers")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("keys", nargs="*", default=["up"], choices=["up", "down", "left", "right", "stop"])
    parser.add_argument("-e", "--endpoint", default="tcp/127.0.0.1:7447", help="endpoint of the server")
    parser.add_argument("--arena", default="main")
    parser.add_argument("--player", default="python")
    args = parser.parse_args()

    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("connect/endpoints", json.dumps([args.endpoint]))
    prefix = f"ballroom/v1/{args.arena}"
    with zenoh.open(config) as session:
        # Newest state only: a reader that is too slow misses states and never gets old ones.
        states = session.declare_subscriber(f"{prefix}/state", zenoh.handlers.RingChannel(1))
        keys = session.declare_publisher(
            f"{prefix}/cmd/{args.player}", encoding=zenoh.Encoding.APPLICATION_JSON, express=True
        )
        token = session.liveliness().declare_token(f"{prefix}/alive/player/{args.player}")

        world = cbor2.loads(ask(session, f"{prefix}/srv/snapshot"))
        first = read_frame(world["snapshot"])
        names = world["roster"]["names"]
        player = world["roster"]["player"].index(True)
        print(f"{len(names)} balls in {world['scene']['name']!r}, steering {names[player]!r}")

        epoch, tick, heard = first["epoch"], first["tick"], time.monotonic()
        for key in args.keys:
            keys.put(json.dumps({"key": key}))
            pressed = time.monotonic()
            while time.monotonic() < pressed + 0.5:
                sample = states.try_recv()
                if sample is None:
                    if time.monotonic() > heard + 5.0:
                        sys.exit("no state for five seconds: is the arena paused?")
                    time.sleep(0.005)
                    continue
                heard = time.monotonic()
                state = read_frame(cbor2.loads(sample.payload.to_bytes()))
                if state["epoch"] == epoch and state["tick"] <= tick:
                    continue
                epoch, tick = state["epoch"], state["tick"]
            x, y, z = state["center_m"][player]
            fastest = np.linalg.norm(state["velocity_m_per_s"], axis=1).max()
            print(
                f"{key:>5}: tick {tick}, {names[player]} at ({x:.3f}, {y:.3f}, {z:.3f}) m, "
                f"fastest ball {fastest:.3f} m/s, energy {state['energy_j']:.6f} J"
            )

        # The same command as a question: the reply says when it was done, or why not.
        reply = json.loads(ask(session, f"{prefix}/srv/command", b'{"cmd":"steer","direction":"stop"}'))
        print(f"stop: done at tick {reply['tick']}" if reply["ok"] else f"stop: {reply['error']}")
        token.undeclare()


if __name__ == "__main__":
    main()
