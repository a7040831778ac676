"""What every other part leans on: errors, units, events, whole-file writing."""
