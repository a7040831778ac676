"""Processes beside this one: started afresh, one thread each, deaf to Ctrl-C."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Variables that say how many threads the numerical libraries use."""


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Processes that start inside compute with one thread."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def processes(
    count: int, begin: Callable[..., object] | None = None, *arguments: Any
) -> ProcessPoolExecutor:
    """Processes that share no state with this one and leave it to decide about Ctrl-C.

    They start with the first task; start that inside `one_thread_each`.

    Args:
        count: how many.
        begin: what each does first.
        arguments: of `begin`.
    """
    from multiprocessing import get_context

    return ProcessPoolExecutor(
        count, get_context("spawn"), initializer=_begun, initargs=(begin, arguments)
    )


def _begun(begin: Callable[..., object] | None, arguments: tuple[Any, ...]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if begin is not None:
        begin(*arguments)
