"""What a computation tells while it runs. Progress bars, logs and pages listen to these."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Event:
    """Base of all events."""


@dataclass(frozen=True)
class Started(Event):
    """A computation begins.

    Attributes:
        title: what it is, for people.
    """

    title: str


@dataclass(frozen=True)
class Progress(Event):
    """Part of the work is done.

    Attributes:
        fraction: 0 to 1.
        text: what is being done, for people.
    """

    fraction: float
    text: str


@dataclass(frozen=True)
class StateReached(Event):
    """An equilibrium was found.

    Attributes:
        index: number of the state, 0 for the flat sheet.
        ramp: fraction of the actuation.
        load: fraction of the perturbation load.
        residual: largest residual force [N].
        iterations: Newton iterations it took.
        factorisations: factorisations it took.
    """

    index: int
    ramp: float
    load: float
    residual: float
    iterations: int
    factorisations: int


@dataclass(frozen=True)
class StepRejected(Event):
    """A step did not converge and is tried again, shorter.

    Attributes:
        ramp: fraction of the actuation where it was tried.
        load: fraction of the perturbation load.
        reason: why, for people.
    """

    ramp: float
    load: float
    reason: str


@dataclass(frozen=True)
class MomentReached(Event):
    """A step through time was made.

    Attributes:
        index: number of the step, from 1.
        time: where it ended [s].
        step: its length [s].
        residual: largest imbalance of the forces [N].
        iterations: Newton iterations it took.
        factorisations: factorisations it took.
    """

    index: int
    time: float
    step: float
    residual: float
    iterations: int
    factorisations: int


@dataclass(frozen=True)
class TimeStepRejected(Event):
    """A step through time is tried again, shorter.

    Attributes:
        time: where it would have ended [s].
        step: its length [s].
        reason: why, for people.
    """

    time: float
    step: float
    reason: str


@dataclass(frozen=True)
class Notice(Event):
    """Something people should know.

    Attributes:
        text: one line.
    """

    text: str


Listener = Callable[[Event], None]


def silent(event: Event) -> None:
    """Listen to nothing."""
    del event
