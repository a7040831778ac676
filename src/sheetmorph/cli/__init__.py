"""The command line. Commands import what they need when they run, so that --help is fast."""

from __future__ import annotations

from sheetmorph.cli.entry import main, script

__all__ = ["main", "script"]
