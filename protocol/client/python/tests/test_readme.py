"""The README's programs, as they stand there."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

README = Path(__file__).parents[4] / "README.md"
PLOT, ENV = re.findall(r"^```python\n(.*?)^```$", README.read_text(), re.MULTILINE | re.DOTALL)


def test_the_plotted_path_is_the_balls(monkeypatch: pytest.MonkeyPatch) -> None:
    plotted: list[tuple[np.ndarray, np.ndarray]] = []
    # The plot is the one thing that needs a package more.
    pyplot = ModuleType("matplotlib.pyplot")
    vars(pyplot).update(plot=lambda x, y: plotted.append((x, y)), axis=lambda _: None, show=lambda: None)
    matplotlib = ModuleType("matplotlib")
    vars(matplotlib)["pyplot"] = pyplot
    monkeypatch.setitem(sys.modules, "matplotlib", matplotlib)
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", pyplot)
    exec(PLOT, {})
    ((x, y),) = plotted
    assert x.shape == y.shape == (200,)
    # It starts north from rest, and stays in its walls.
    assert abs(x[0]) < 1e-12
    assert 0.0 < y[0] < 0.2
    assert max(abs(x).max(), abs(y).max()) < 4.7
    assert np.ptp(x) > 0.5


def test_the_lock_step_example_prints_the_same_each_time(capsys: pytest.CaptureFixture[str]) -> None:
    exec(ENV, {})
    first = capsys.readouterr().out
    exec(ENV, {})
    assert capsys.readouterr().out == first
    assert re.fullmatch(r"-?[\d.]+ [0-9a-f]{16}\n", first)
