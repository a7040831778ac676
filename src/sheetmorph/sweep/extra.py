"""Libraries that only sweeps need, with the words for where they are missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from sheetmorph.core.errors import InputError

INSTALL = 'pip install "sheetmorph[sweep]"'


@contextmanager
def needed() -> Iterator[None]:
    """Import inside what is installed with `sheetmorph[sweep]`.

    Raises:
        InputError: it is not there; the message says what to install.
    """
    try:
        yield
    except ImportError as error:
        raise InputError(
            f"sweeps need {error.name or 'more libraries'}; install it by {INSTALL}"
        ) from None
