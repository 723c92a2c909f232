"""Servers as processes of one's own."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from ballroom.errors import BallroomError, NoServerError
from ballroom.server import Server, connect

_LOOK_AGAIN_S = 0.01
_STOP_S = 10.0


@contextmanager
def launch(  # noqa: PLR0913
    scene: str | os.PathLike[str] = "original",
    *,
    arena: str = "main",
    paused: bool = False,
    tick_rate_hz: int | None = None,
    balls: int | None = None,
    binary: str | os.PathLike[str] | None = None,
    timeout_s: float = 20.0,
) -> Iterator[Server]:
    """Runs `ballroom serve` on a free loopback port, gives a session with it, and stops it at the end.

    The program is `binary`, else the environment's BALLROOM_BIN, else `ballroom` on the PATH, else
    target/release/ballroom. Others connect to the same arena with `connect(server.endpoint)`.
    """
    command = [find_binary(binary), "serve", os.fspath(scene), "-l", "tcp/127.0.0.1:0", "--arena", arena]
    command += ["--paused"] if paused else []
    command += [] if tick_rate_hz is None else ["--rate", str(tick_rate_hz)]
    command += [] if balls is None else ["--balls", str(balls)]
    # Files, not pipes: nobody has to read along, and a full pipe would stop the server.
    with tempfile.TemporaryFile("w+") as said, tempfile.TemporaryFile("w+") as log:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=said, stderr=log)
        try:
            endpoint = _endpoint(process, said, log, timeout_s)
            with connect(endpoint, arena, timeout_s) as server:
                yield server
        finally:
            _stop(process)


def find_binary(binary: str | os.PathLike[str] | None = None) -> str:
    """The program `ballroom`, or what to do without one."""
    named = binary or os.environ.get("BALLROOM_BIN")
    candidates = [os.fspath(named)] if named else ["ballroom", str(Path("target/release/ballroom").absolute())]
    for candidate in candidates:
        if found := shutil.which(candidate):
            return found
    raise BallroomError(
        f"no program at {' or '.join(candidates)}: `cargo build --release -p server`, then set BALLROOM_BIN to it"
    )


def _endpoint(process: subprocess.Popen[bytes], said: IO[str], log: IO[str], timeout_s: float) -> str:
    """The first line that the server writes: where it listens."""
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        ended = process.poll() is not None
        said.seek(0)
        line = said.readline()
        if line.endswith("\n"):
            return line.strip()
        if ended:
            raise NoServerError(f"ballroom serve ended with code {process.returncode}: {_text(log)}")
        time.sleep(_LOOK_AGAIN_S)
    raise NoServerError(f"ballroom serve did not listen within {timeout_s:g} s: {_text(log)}")


def _text(log: IO[str]) -> str:
    log.seek(0)
    return log.read().strip()


def _stop(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(_STOP_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
