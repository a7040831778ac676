"""The table `solver.dynamic` of the design file: steps, damping, and the course in time."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from sheetmorph.design.fields import Number, Quantity, Section, problem

MOST_TIMES = 10_000
FRAMES = 100
"""Moments of the course that are kept where the design names no interval."""

Time = Annotated[float, Quantity("time", "0 s", "1000 h")]
Share = Annotated[Number, Field(ge=0, le=1)]
Factor = Annotated[Number, Field(ge=-1000, le=1000)]


class Course(Section):
    """What acts when: fractions at times, linear between, held after the last.

    Attributes:
        times: increasing from 0 [s].
        actuation: fraction of the actuation at each, 0 to 1.
        loads: factor on the loads of the design; as the actuation by default.
        perturbation: factor on the perturbation load; by default 1, and 0 at the last time.
    """

    times: Annotated[tuple[Time, ...], Field(min_length=1, max_length=MOST_TIMES)]
    actuation: tuple[Share, ...]
    loads: tuple[Factor, ...] | None = None
    perturbation: tuple[Factor, ...] | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.times[0] != 0.0 or any(b <= a for a, b in pairwise(self.times)):
            raise problem(
                "times must increase, and the first be 0",
                key="times",
                value=[f"{time:g} s" for time in self.times[:6]],
                allowed='such as ["0 s", "10 s"]',
            )
        for key in ("actuation", "loads", "perturbation"):
            values = getattr(self, key)
            if values is not None and len(values) != len(self.times):
                raise problem(
                    f"has {len(values)} values for {len(self.times)} times",
                    key=key,
                    allowed="a value for each time",
                )
        return self

    def at(self, time: float) -> tuple[float, float, float]:
        """Factors on actuation, loads and perturbation load at a time [s]."""
        faded = [1.0] * (len(self.times) - 1) + [0.0]
        rows = (self.actuation, self.loads or self.actuation, self.perturbation or faded)
        a, b, c = (float(np.interp(time, self.times, row)) for row in rows)
        return a, b, c

    @property
    def duration(self) -> float:
        """The last time [s]; the forces change no more after it."""
        return self.times[-1]


class DynamicOptions(Section):
    """How the equation of motion is solved, and what damps the motion.

    Attributes:
        course: what acts when.
        time_step: longest step [s].
        integrator: "implicit_euler" (of first order, as published) or "trapezoidal" (of second
            order, without dissipation of its own).
        step_error: estimated error of position that a step may make [m]; none: steps are as
            long as `time_step`, shorter only where they do not converge.
        start: "flat": at rest, unloaded; "equilibrium": at rest in the equilibrium under what
            the course begins with, to which the quasi-static path leads.
        damping: drag on all that moves, over its mass [1/s].
        retardation: time by which strain lags behind stress in the material [s].
        end_time: when to stop, at rest or not [s]; none: at rest.
        rest: the sheet rests when this fraction of its largest energy is left to lose.
        output_interval: time between moments that are kept [s].
    """

    course: Course
    time_step: Annotated[float, Quantity("time", "1 ns", "1 h")]
    integrator: Literal["implicit_euler", "trapezoidal"] = "implicit_euler"
    step_error: Annotated[float, Quantity("length", "1 nm", "1 m")] | None = None
    start: Literal["flat", "equilibrium"] = "flat"
    damping: Annotated[float, Quantity("rate", "0 1/s", "1000000000 1/s")] = 0.0
    retardation: Annotated[float, Quantity("time", "0 s", "1 h")] = 0.0
    end_time: Annotated[float, Quantity("time", "0 s", "1000 h", above=True)] | None = None
    rest: Annotated[Number, Field(ge=1e-12, le=1e-2)] = 1e-6
    output_interval: Annotated[float, Quantity("time", "1 ns", "1000 h")] | None = None

    @model_validator(mode="after")
    def _comes_to_an_end(self) -> Self:
        undamped = self.damping == 0.0 and self.retardation == 0.0
        if undamped and self.integrator == "trapezoidal" and self.end_time is None:
            raise problem(
                "nothing damps this motion, so it never rests; say when to stop",
                key="end_time",
                allowed="end_time, damping or retardation",
            )
        return self

    @property
    def interval(self) -> float:
        """Time between moments that are kept [s]."""
        if self.output_interval is not None:
            return self.output_interval
        return max(self.time_step, (self.end_time or self.course.duration) / FRAMES)
