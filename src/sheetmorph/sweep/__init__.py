"""Many designs at once: what is varied, who computes it, the table and shapes that come of it."""
