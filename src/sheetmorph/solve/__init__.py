"""Linear algebra, Newton's method and path following on callables x → E, g, H."""
