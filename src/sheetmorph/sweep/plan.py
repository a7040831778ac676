"""The sweep file: which design, which of its keys take which values, in which order."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from pathlib import Path
from typing import Any

from sheetmorph import __version__
from sheetmorph.core.errors import InputError, nearest
from sheetmorph.design.files import parse_design_text, path_inside, read_design_text
from sheetmorph.design.spec import Design
from sheetmorph.sweep.axes import MOST, Axis, read_axis, sampled_axis
from sheetmorph.sweep.families import check_arguments, family_design

STATES = ("final", "all", "none")
METHODS = ("sobol", "latin_hypercube")
MOST_VALUES = 20_000_000
"""Most sampled numbers: designs times keys."""
TRIED = 8
"""Designs that are made before any is computed."""

_TABLES = ("design", "family", "states", "list", "grid", "samples")
_FAMILY = "family."


@dataclass(frozen=True, eq=False)
class Task:
    """One design of a sweep, as it goes to a worker.

    Attributes:
        index: number of the design, from 0.
        inputs: from key to value, in SI units: what the row of the table says.
        values: from dotted key to value, as for `Design.with_values`.
        family: name of the family and its arguments in SI units; None with a design file.
        design: text of the design file; None with a family.
        folder: where its mesh and curve files lie, on every worker.
        content: SHA-256 of the design file's content; empty with a family.
        states: which states are kept: "final", "all" or "none".
    """

    index: int
    inputs: Mapping[str, Any]
    values: Mapping[str, object]
    family: tuple[str, Mapping[str, object]] | None
    design: str | None
    folder: Path | None
    content: str
    states: str

    @property
    def id(self) -> str:
        """Hash of what the design is made of and of its number: the same wherever it is made."""
        parts = [self.index, self.content, self.family, dict(self.values)]
        text = json.dumps(parts, sort_keys=True, default=str)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def make(self) -> Design:
        """The design.

        Raises:
            InputError: it is not allowed.
        """
        if self.family is not None:
            base = family_design(*self.family)
        else:
            assert self.design is not None  # noqa: S101  a task has one of the two
            base = Design.from_toml(self.design, self.folder)
        return base.with_values(self.values) if self.values else base


@dataclass(frozen=True, eq=False)
class Plan:
    """A checked sweep file.

    Attributes:
        name: of the sweep: that of its file.
        text: of the file.
        base: the design of which keys are set; None with a family.
        family: name of the family and the arguments that all designs share; or None.
        fixed: keys that are set in all designs, as for `Design.with_values`.
        blocks: axes of equal length are side by side in a block; the blocks are combined,
            the last one the fastest.
        states: which states are kept.
    """

    name: str
    text: str
    base: Design | None
    family: tuple[str, Mapping[str, object]] | None
    fixed: Mapping[str, object]
    blocks: tuple[tuple[Axis, ...], ...]
    states: str

    @classmethod
    def load(cls, path: str | Path, fixed: Mapping[str, object] | None = None) -> Plan:
        """Read a sweep file.

        Args:
            path: the file.
            fixed: keys of the design to set in all designs.

        Raises:
            InputError: the file cannot be read, or says what is not allowed; or none of the
                first designs can be made.
        """
        file = Path(path)
        try:
            text = read_design_text(file)
            data = parse_design_text(text)
            plan = _read(data, text, file, dict(fixed or {}))
        except InputError as error:
            raise error.located(file) from None
        plan.try_designs(file)
        return plan

    def __len__(self) -> int:
        return prod(len(block[0].values) for block in self.blocks)

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The axes, in the order in which the file names them."""
        return tuple(axis for block in self.blocks for axis in block)

    def task(self, index: int) -> Task:
        """One design, from 0."""
        inputs: dict[str, Any] = {}
        values: dict[str, object] = dict(self.fixed)
        arguments: dict[str, object] = dict(self.family[1]) if self.family else {}
        rest = index
        for block in reversed(self.blocks):
            rest, place = divmod(rest, len(block[0].values))
            for axis in block:
                value = axis.values[place]
                inputs[axis.key] = value
                if axis.key.startswith(_FAMILY):
                    arguments[axis.key.removeprefix(_FAMILY)] = value
                else:
                    values[axis.key] = axis.written(value)
        return Task(
            index=index,
            inputs={axis.key: inputs[axis.key] for axis in self.axes},
            values=values,
            family=(self.family[0], arguments) if self.family else None,
            design=self.base.source if self.base else None,
            folder=self.base.folder.resolve() if self.base and self.base.folder else None,
            content=self.base.hash if self.base else "",
            states=self.states,
        )

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of all that decides the table: designs, order, version."""
        axes = [[[a.key, a.unit, a.values] for a in block] for block in self.blocks]
        content = {
            "base": self.base.hash if self.base else self.family,
            "fixed": dict(self.fixed),
            "axes": axes,
            "states": self.states,
            "version": __version__,
        }
        text = json.dumps(content, sort_keys=True, default=str)
        return hashlib.sha256(text.encode()).hexdigest()

    def try_designs(self, file: Path) -> None:
        """Make some designs, so that a wrong key is told before anything is computed.

        Raises:
            InputError: none of them can be made; that of the first.
        """
        count = min(TRIED, len(self))
        first: InputError | None = None
        for number in range(count):
            try:
                self.task(number * (len(self) - 1) // max(1, count - 1)).make()
            except InputError as error:
                first = first or error
            else:
                return
        assert first is not None  # noqa: S101  a sweep has a design
        raise InputError(
            f"none of {count} designs can be made: {first.message}",
            file=file,
            key=first.key,
            value=first.value,
            allowed=first.allowed,
        )


def _read(data: Mapping[str, Any], text: str, file: Path, fixed: dict[str, object]) -> Plan:
    if not {"design", "family"} & data.keys() and {"layers", "actuation"} & data.keys():
        raise InputError(
            f"this is a design; a sweep is a file of its own that names it, as in "
            f'design = "{file.name}", and says which keys vary (see docs/sweeps.md)'
        )
    _known(data, _TABLES, "")
    states = data.get("states", "final")
    if states not in STATES:
        raise InputError("no such choice", key="states", value=states, allowed=", ".join(STATES))
    blocks = [*_lists(_mapping(data, "list")), *_grid(_mapping(data, "grid"))]
    blocks += _samples(_mapping(data, "samples"))
    axes = [axis for block in blocks for axis in block]
    if not axes:
        raise InputError("nothing varies", allowed='keys in "list", "grid" or "samples.bounds"')
    plain = [_flat(key) for key in [axis.key for axis in axes] + list(fixed)]
    for number, key in enumerate(plain):
        if key in plain[:number]:
            raise InputError("is set twice", key=key)
    count = prod(len(block[0].values) for block in blocks)
    if count > MOST:
        raise InputError(f"{count} designs are too many", allowed=f"≤ {MOST}")
    family = _family(data, axes)
    base = None
    if family is None:
        name = data["design"]
        if not isinstance(name, str):
            raise InputError("wants the name of a design file", key="design", value=name)
        base = Design.load(path_inside(file.parent, name, "design"))
    return Plan(file.stem, text, base, family, fixed, tuple(blocks), states)


def _family(
    data: Mapping[str, Any], axes: Sequence[Axis]
) -> tuple[str, Mapping[str, object]] | None:
    varied = {
        axis.key.removeprefix(_FAMILY): axis.key for axis in axes if axis.key.startswith(_FAMILY)
    }
    if ("design" in data) == ("family" in data):
        raise InputError(
            "the sweep wants either a design file or a family",
            key="design",
            allowed='design = "petals.toml", or a table [family]',
        )
    if "family" not in data:
        if varied:
            raise InputError("there is no family", key=next(iter(varied.values())))
        return None
    table = _mapping(data, "family")
    shared = {name: value for name, value in table.items() if name != "kind"}
    for name in shared:
        if name in varied:
            raise InputError("is set twice", key=varied[name])
    kind = check_arguments(
        table.get("kind"), {**{name: f"family.{name}" for name in shared}, **varied}
    )
    return kind, {
        name: read_axis(f"family.{name}", [value]).values[0] for name, value in shared.items()
    }


def _lists(table: Mapping[str, Any]) -> list[tuple[Axis, ...]]:
    axes = tuple(read_axis(key, entry) for key, entry in table.items())
    for axis in axes:
        if len(axis.values) != len(axes[0].values):
            raise InputError(
                f"has {len(axis.values)} values, {axes[0].key} has {len(axes[0].values)}; "
                "values in list go side by side (grid combines all with all)",
                key=f"list.{axis.key}",
            )
    return [axes] if axes else []


def _grid(table: Mapping[str, Any]) -> list[tuple[Axis, ...]]:
    return [(read_axis(key, entry),) for key, entry in table.items()]


def _samples(table: Mapping[str, Any]) -> list[tuple[Axis, ...]]:
    if not table:
        return []
    from scipy.stats import qmc

    _known(table, ("method", "count", "seed", "bounds"), "samples.")
    bounds = _mapping(table, "bounds")
    if not bounds:
        raise InputError(
            "no bounds",
            key="samples.bounds",
            allowed='"actuation.eps_pre" = { from = -0.5, to = -0.2 }',
        )
    count = _whole(table, "count", 1, MOST)
    seed = _whole({"seed": 0, **table}, "seed", 0, 2**32 - 1)
    method = table.get("method", METHODS[0])
    if method not in METHODS:
        raise InputError(
            "no such method", key="samples.method", value=method, allowed=", ".join(METHODS)
        )
    if count * len(bounds) > MOST_VALUES:
        raise InputError(
            "too many samples",
            key="samples.count",
            value=count,
            allowed=f"≤ {MOST_VALUES // len(bounds)}",
        )
    if method == "sobol":
        # A Sobol sequence is even in powers of two; what is beyond the count is left out.
        power = (count - 1).bit_length()
        shares = qmc.Sobol(len(bounds), rng=seed).random_base2(power)[:count]
    else:
        shares = qmc.LatinHypercube(len(bounds), rng=seed).random(count)
    return [
        tuple(
            sampled_axis(key, entry, shares[:, column].tolist())
            for column, (key, entry) in enumerate(bounds.items())
        )
    ]


def _whole(table: Mapping[str, Any], name: str, low: int, high: int) -> int:
    value = table.get(name)
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise InputError(
            "must be a whole number", key=f"samples.{name}", value=value, allowed=f"{low} to {high}"
        )
    return value


def _mapping(data: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    table = data.get(name, {})
    if not isinstance(table, Mapping):
        raise InputError("must be a table", key=name, value=table)
    if name in ("list", "grid", "bounds"):
        return _dotted(table)
    return table


def _dotted(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Keys written as tables (`actuation.eps_pre = …`) as quoted keys (`"actuation.eps_pre"`)."""
    flat: dict[str, Any] = {}
    for key, entry in table.items():
        if isinstance(entry, Mapping) and not ("from" in entry or "to" in entry):
            flat |= _dotted(entry, f"{prefix}{key}.")
        else:
            flat[prefix + key] = entry
    return flat


def _known(table: Mapping[str, Any], names: Sequence[str], prefix: str) -> None:
    for name in table:
        if name not in names:
            guess = nearest(name, names)
            raise InputError(
                "is not known" + (f"; did you mean {guess}?" if guess else ""),
                key=prefix + name,
                allowed=", ".join(names),
            )


def _flat(key: str) -> str:
    return key.replace("[", ".").replace("]", "")
