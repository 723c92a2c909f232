"""What the tests stand on: real servers, and the program itself."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

import ballroom
from ballroom.launch import find_binary

BUILT = Path(__file__).parents[4] / "target/release/ballroom"
os.environ.setdefault("BALLROOM_BIN", str(BUILT))

Serve = Callable[..., ballroom.Server]


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Starts servers that end with the test."""
    with ExitStack() as stack:
        yield lambda *args, **options: stack.enter_context(ballroom.launch(*args, **options))


@pytest.fixture
def plane(serve: Serve) -> ballroom.Server:
    """A level table whose clock stands."""
    return serve("plane", paused=True)


def children() -> list[str]:
    """The processes that this one has started and that have not been waited for."""
    return Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()


def simulated(scene: str, until_s: int) -> dict[str, Any]:
    """The last state of an undisturbed run without any network."""
    command = [find_binary(), "simulate", scene, "--until", str(until_s), "--every", str(until_s), "--json"]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    last: dict[str, Any] = json.loads(lines[-1])
    return last
