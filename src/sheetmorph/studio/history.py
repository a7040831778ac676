"""The texts that a design has had, for undo and redo."""

from __future__ import annotations

from dataclasses import dataclass, replace

MAX_BYTES = 20_000_000
"""Older texts are forgotten beyond this."""


@dataclass(frozen=True)
class History:
    """Texts in order, and which of them is the present one.

    Attributes:
        texts: of the design; at least one.
        at: index of the present one.
    """

    texts: tuple[str, ...]
    at: int = 0

    @property
    def text(self) -> str:
        """The present text."""
        return self.texts[self.at]

    @property
    def can_undo(self) -> bool:
        """True where there is an earlier text."""
        return self.at > 0

    @property
    def can_redo(self) -> bool:
        """True where there is a later one."""
        return self.at < len(self.texts) - 1

    def with_text(self, text: str) -> History:
        """The history with a new present text; what was undone is forgotten."""
        if text == self.text:
            return self
        texts = [*self.texts[: self.at + 1], text]
        while len(texts) > 2 and sum(map(len, texts)) > MAX_BYTES:
            del texts[0]
        return History(tuple(texts), len(texts) - 1)

    def undone(self) -> History:
        """One step back; itself where there is none."""
        return replace(self, at=max(0, self.at - 1))

    def redone(self) -> History:
        """One step forward; itself where there is none."""
        return replace(self, at=min(len(self.texts) - 1, self.at + 1))
