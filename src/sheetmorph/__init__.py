"""sheetmorph: the 3D shape into which a flat, patterned, layered sheet morphs."""

__version__ = "0.1.0"
