"""Colours of CSS as six hexadecimal digits."""

from __future__ import annotations

from functools import lru_cache


@lru_cache(maxsize=1024)
def colour_hex(text: str) -> str | None:
    """A colour as "#rrggbb", empty when it is fully transparent, None when it is no colour.

    Understands what CSS does in sRGB: "#rgb", "#rrggbb" (with or without opacity), names,
    rgb(), rgba(), hsl(), hsla() and hwb().
    """
    from tinycss2.color4 import parse_color

    try:
        colour = parse_color(text[:100].strip())
        if colour is None or isinstance(colour, str):
            return None
        channels = colour.to("srgb")[:3]
    except (ValueError, TypeError, AttributeError, ArithmeticError, NotImplementedError):
        # Other spaces than sRGB, and functions without arguments, which tinycss2 trips over.
        return None
    if colour.alpha <= 0.0:
        return ""
    return "#" + "".join(f"{round(255.0 * min(max(c, 0.0), 1.0)):02x}" for c in channels)
