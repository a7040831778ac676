"""From a design to a result."""
