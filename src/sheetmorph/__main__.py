"""`python -m sheetmorph` is the command line."""

from sheetmorph.cli import script

script()
