"""Designs to begin with: the three of the paper on meshes made here, random ones, a blank one."""

from __future__ import annotations

import re
from importlib import resources

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.design.fields import MAX_NAME, NAME_ALLOWED, NAME_PATTERN

PRESETS = ("bowl", "canoe", "petals", "kirigami", "blank")


def preset_text(preset: str, name: str | None = None) -> str:
    """TOML text of a preset, with its comments.

    Args:
        preset: one of `PRESETS`.
        name: name for the new design; that of the preset by default.

    Raises:
        InputError: there is no such preset, or the name is not one for a design.
    """
    if preset not in PRESETS:
        guess = nearest(preset, PRESETS)
        hint = f"; did you mean {guess}?" if guess else ""
        message = f"there is no such preset{hint}"
        raise InputError(message, value=preset, allowed=", ".join(PRESETS))
    text = (resources.files(__name__) / f"{preset}.toml").read_text(encoding="utf-8")
    if name is None:
        return text
    if not re.fullmatch(NAME_PATTERN, name) or len(name) > MAX_NAME:
        raise InputError("is not a name for a design", value=name, allowed=NAME_ALLOWED)
    return text.replace(f'name = "{preset}"', f'name = "{name}"', 1)
