"""Proofs: cases whose answer is known, computed anew and judged."""
