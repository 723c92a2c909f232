"""What actions and observations look like: Gymnasium's boxes where it is installed, else boxes of the same shape."""

from __future__ import annotations

import importlib
import importlib.util
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass
class Box:
    """Arrays of a shape with each number between two others, as `gymnasium.spaces.Box` has it."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    _random: np.random.Generator = field(default_factory=np.random.default_rng, repr=False, compare=False)

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of every array."""
        return self.low.shape

    @property
    def dtype(self) -> np.dtype[np.float64]:
        """The type of every number."""
        return self.low.dtype

    def seed(self, seed: int | None = None) -> None:
        """Makes `sample` repeatable."""
        self._random = np.random.default_rng(seed)

    def sample(self) -> NDArray[np.float64]:
        """Any array of it: even between bounds, normal where there is one bound or none."""
        bounded = np.isfinite(self.low) & np.isfinite(self.high)
        low, high = np.where(bounded, self.low, 0.0), np.where(bounded, self.high, 1.0)
        free = np.clip(self._random.normal(size=self.shape), self.low, self.high)
        sampled: NDArray[np.float64] = np.where(bounded, self._random.uniform(low, high), free)
        return sampled

    def contains(self, array: object) -> bool:
        """Whether an array is one of it."""
        numbers = np.asarray(array, np.float64)
        return numbers.shape == self.shape and bool(((self.low <= numbers) & (numbers <= self.high)).all())


def box(low: float, high: float, shape: tuple[int, ...]) -> Any:  # noqa: ANN401
    """A box with the same bounds everywhere: Gymnasium's where it is installed."""
    if importlib.util.find_spec("gymnasium") is not None:
        return importlib.import_module("gymnasium.spaces").Box(low, high, shape, np.float64)
    return Box(np.full(shape, low), np.full(shape, high))
