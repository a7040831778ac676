"""One job at a time in a folder: a lock of the operating system, gone with its process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from sheetmorph.core.errors import InputError, OutputError

FILE = ".sheetmorph.lock"


@contextmanager
def sole_user(folder: str | Path) -> Iterator[None]:
    """Keep other jobs of sheetmorph out of a folder while the block lasts.

    The lock ends with the process, however that ends: a killed job locks nobody out. The file
    that bears it is removed at the end.

    Args:
        folder: made when absent, with those around it, and removed again where the job left
            nothing in it.

    Raises:
        InputError: another job is at work there.
        OutputError: nothing can be written there.
    """
    from filelock import FileLock, Timeout

    place = Path(folder)
    made = [one for one in (place, *place.parents) if not one.exists()]
    lock = FileLock(place / FILE, thread_local=False)
    try:
        place.mkdir(parents=True, exist_ok=True)
        lock.acquire(timeout=0)
    except Timeout:
        raise InputError(
            "another job of sheetmorph is at work in this folder; wait for it, or choose another "
            "with -o",
            file=place,
        ) from None
    except (OSError, NotImplementedError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise OutputError(
            f"{place}: nothing can be written here ({reason}); choose another folder with -o"
        ) from error
    try:
        yield
    finally:
        with suppress(PermissionError):  # Windows removes no open file; an empty one stays
            (place / FILE).unlink(missing_ok=True)
        lock.release()
        with suppress(OSError):  # not empty: the job wrote something
            for one in made:
                one.rmdir()
