"""Checking a deck for Abaqus by the grammar of its keywords, without Abaqus."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from sheetmorph.twin.abaqus import ITEMS

LONGEST_LINE, LONGEST_NAME = 256, 80
_NAME = re.compile(r"[A-Z_][A-Z0-9_\-]*")


@dataclass(frozen=True)
class Card:
    """What a keyword allows.

    Attributes:
        needs: parameters it must have.
        may: parameters it may have besides.
        step: True within steps, False outside, None in both.
        least: fewest entries of a data line.
        most: most entries of a data line; 0 where it has no data.
        text: entries, counted from 0, that are words and no numbers.
        flags: parameters without a value.
    """

    needs: tuple[str, ...] = ()
    may: tuple[str, ...] = ()
    step: bool | None = None
    least: int = 0
    most: int = 0
    text: tuple[int, ...] = ()
    flags: tuple[str, ...] = ()


CARDS: Mapping[str, Card] = {
    "HEADING": Card(step=False, most=ITEMS, text=tuple(range(ITEMS))),
    "NODE": Card(may=("NSET", "SYSTEM"), step=False, least=3, most=7),
    "NSET": Card(needs=("NSET",), may=("GENERATE",), least=1, most=ITEMS, flags=("GENERATE",)),
    "ELEMENT": Card(needs=("TYPE",), may=("ELSET",), step=False, least=2, most=ITEMS),
    "SHELL SECTION": Card(
        needs=("ELSET", "MATERIAL"), may=("OFFSET", "POISSON"), step=False, least=1, most=2
    ),
    "MATERIAL": Card(needs=("NAME",), step=False),
    "DENSITY": Card(step=False, least=1, most=2),
    "DAMPING": Card(may=("ALPHA", "BETA"), step=False),
    "HYPERELASTIC": Card(
        may=("MOONEY-RIVLIN",), step=False, least=3, most=4, flags=("MOONEY-RIVLIN",)
    ),
    "EXPANSION": Card(may=("ZERO", "TYPE"), step=False, least=1, most=3),
    "SURFACE": Card(needs=("NAME",), may=("TYPE",), step=False, least=1, most=2, text=(0, 1)),
    "TIE": Card(
        needs=("NAME",),
        may=("ADJUST", "POSITION TOLERANCE"),
        step=False,
        least=2,
        most=2,
        text=(0, 1),
    ),
    "INITIAL CONDITIONS": Card(needs=("TYPE",), step=False, least=2, most=ITEMS, text=(0,)),
    "AMPLITUDE": Card(needs=("NAME",), may=("DEFINITION", "TIME"), least=2, most=8),
    "BOUNDARY": Card(may=("AMPLITUDE", "TYPE"), least=2, most=4, text=(0,)),
    "STEP": Card(may=("NLGEOM", "INC", "NAME"), step=False),
    "DYNAMIC": Card(needs=("EXPLICIT",), step=True, least=2, most=4, flags=("EXPLICIT",)),
    "BULK VISCOSITY": Card(step=True, least=1, most=2),
    "TEMPERATURE": Card(may=("AMPLITUDE",), step=True, least=2, most=ITEMS, text=(0,)),
    "CLOAD": Card(may=("AMPLITUDE",), step=True, least=3, most=3, text=(0,)),
    "OUTPUT": Card(
        may=("FIELD", "HISTORY", "NUMBER INTERVAL"), step=True, flags=("FIELD", "HISTORY")
    ),
    "NODE OUTPUT": Card(may=("NSET",), step=True, least=1, most=ITEMS, text=tuple(range(ITEMS))),
    "ELEMENT OUTPUT": Card(
        may=("ELSET",), step=True, least=1, most=ITEMS, text=tuple(range(ITEMS))
    ),
    "ENERGY OUTPUT": Card(step=True, least=1, most=ITEMS, text=tuple(range(ITEMS))),
    "END STEP": Card(step=True),
}
"""The keywords that our decks use, as the Abaqus keywords reference describes them."""


@dataclass
class _Seen:
    """What a deck has defined so far."""

    nodes: set[int] = field(default_factory=set)
    elements: set[int] = field(default_factory=set)
    names: dict[str, set[str]] = field(default_factory=dict)
    in_step: bool = False
    steps: int = 0


_DEFINES = {
    ("NODE", "NSET"): "node set",
    ("NSET", "NSET"): "node set",
    ("ELEMENT", "ELSET"): "element set",
    ("MATERIAL", "NAME"): "material",
    ("SURFACE", "NAME"): "surface",
    ("AMPLITUDE", "NAME"): "amplitude",
}
_USES = {
    ("SHELL SECTION", "ELSET"): "element set",
    ("TEMPERATURE", "AMPLITUDE"): "amplitude",
    ("CLOAD", "AMPLITUDE"): "amplitude",
}
_WORDS_USE = {
    "SURFACE": ((0, "element set"),),
    "TIE": ((0, "surface"), (1, "surface")),
    "INITIAL CONDITIONS": ((0, "node set"),),
}


def check_deck(lines: Iterable[str]) -> list[str]:
    """What is wrong with a deck, a line each; nothing when all is well.

    Checks keywords, parameters, where they stand, the number and kind of entries of data
    lines, the length of lines and names, and that nodes, sets, materials, surfaces and
    amplitudes are defined before the end.
    """
    wrong: list[str] = []
    seen = _Seen()
    wanted: list[tuple[int, str, str]] = []
    card, name = None, ""
    for number, line in enumerate(lines, 1):
        text = line.rstrip("\n")
        if len(text) > LONGEST_LINE:
            wrong.append(f"line {number}: longer than {LONGEST_LINE} characters")
        if text.startswith("**") or not text.strip():
            continue
        if text.startswith("*"):
            name, given = _keyword(text)
            card = CARDS.get(name)
            if card is None:
                wrong.append(f"line {number}: unknown keyword *{name}")
                continue
            wrong += [f"line {number}: *{name}: {fault}" for fault in _faults(card, given, seen)]
            _note(name, given, seen, wanted, number)
        elif card is not None:
            wrong += [
                f"line {number}: *{name}: {fault}"
                for fault in _data_faults(name, card, text, seen, wanted, number)
            ]
    if seen.in_step:
        wrong.append("the last step has no *END STEP")
    if not seen.steps:
        wrong.append("there is no step")
    for number, kind, word in wanted:
        if word not in seen.names.get(kind, set()):
            wrong.append(f"line {number}: there is no {kind} {word}")
    return wrong


def _keyword(text: str) -> tuple[str, dict[str, str]]:
    head, *rest = [part.strip() for part in text[1:].split(",")]
    given = {}
    for part in rest:
        key, _, value = part.partition("=")
        given[" ".join(key.upper().split())] = value.strip().upper()
    return " ".join(head.upper().split()), given


def _faults(card: Card, given: Mapping[str, str], seen: _Seen) -> list[str]:
    found = [f"wants {key}" for key in card.needs if key not in given]
    for key, value in given.items():
        if key not in (*card.needs, *card.may):
            found.append(f"does not know {key}")
        elif key in card.flags:
            found += [f"{key} takes no value"] if value else []
        elif not value:
            found.append(f"{key} wants a value")
        elif key in ("NAME", "NSET", "ELSET") and (
            len(value) > LONGEST_NAME or not _NAME.fullmatch(value)
        ):
            found.append(f"{value} is no name")
    if card.step is not None and card.step != seen.in_step:
        found.append("stands outside of a step" if card.step else "stands within a step")
    return found


def _note(
    name: str,
    given: Mapping[str, str],
    seen: _Seen,
    wanted: list[tuple[int, str, str]],
    number: int,
) -> None:
    if name == "STEP":
        seen.in_step = True
        seen.steps += 1
    elif name == "END STEP":
        seen.in_step = False
    for key, value in given.items():
        if (name, key) in _DEFINES:
            seen.names.setdefault(_DEFINES[name, key], set()).add(value)
        if (name, key) in _USES:
            wanted.append((number, _USES[name, key], value))
    if name == "SHELL SECTION" and "MATERIAL" in given:
        wanted.append((number, "material", given["MATERIAL"]))


def _data_faults(
    name: str,
    card: Card,
    text: str,
    seen: _Seen,
    wanted: list[tuple[int, str, str]],
    number: int,
) -> list[str]:
    entries = [part.strip() for part in text.split(",")]
    if not card.most:
        return ["takes no data"]
    found = []
    if not card.least <= len(entries) <= card.most:
        found.append(f"{len(entries)} entries, not {card.least} to {card.most}")
    for place, entry in enumerate(entries):
        if place not in card.text and entry and not _is_number(entry):
            found.append(f"{entry} is no number")
    if name == "NODE" and entries[0].isdigit():
        found += [f"node {entries[0]} is there twice"] if int(entries[0]) in seen.nodes else []
        seen.nodes.add(int(entries[0]))
    elif name == "ELEMENT" and all(entry.isdigit() for entry in entries):
        own, *corners = (int(entry) for entry in entries)
        found += [f"element {own} is there twice"] if own in seen.elements else []
        seen.elements.add(own)
        found += [f"there is no node {node}" for node in corners if node not in seen.nodes]
    elif name in ("BOUNDARY", "TEMPERATURE", "CLOAD") and entries[0].isdigit():
        found += [] if int(entries[0]) in seen.nodes else [f"there is no node {entries[0]}"]
    for place, kind in _WORDS_USE.get(name, ()):
        if place < len(entries):
            wanted.append((number, kind, entries[place].upper()))
    return found


def _is_number(entry: str) -> bool:
    try:
        float(entry)
    except ValueError:
        return False
    return True
