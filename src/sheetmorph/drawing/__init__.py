"""Flat drawings of makers: reading them as areas and lines, and writing them."""
