"""Undo and redo."""

from __future__ import annotations

from sheetmorph.studio import history
from sheetmorph.studio.history import History


def test_steps_back_and_forward() -> None:
    path = History(("a",)).with_text("b").with_text("c")
    assert path.text == "c"
    assert path.undone().undone().undone().text == "a"
    assert path.undone().undone().redone().text == "b"
    assert path.redone().text == "c"
    assert (path.can_undo, path.can_redo) == (True, False)
    assert (path.undone().undone().can_undo, path.undone().can_redo) == (False, True)


def test_a_new_text_forgets_what_was_undone() -> None:
    path = History(("a",)).with_text("b").undone().with_text("c")
    assert path.texts == ("a", "c")


def test_the_same_text_is_no_step() -> None:
    assert History(("a",)).with_text("a").texts == ("a",)


def test_old_texts_are_forgotten(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(history, "MAX_BYTES", 10)
    path = History(("aaaa",)).with_text("bbbb").with_text("cccc")
    assert (path.texts, path.text) == (("bbbb", "cccc"), "cccc")
