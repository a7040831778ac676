"""From a wanted shape to the design that takes it."""
