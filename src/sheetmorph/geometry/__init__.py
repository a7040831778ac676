"""Meshes: making, reading, checking and measuring them."""
