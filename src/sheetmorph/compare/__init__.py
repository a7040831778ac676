"""Surfaces against each other: scans, alignment, distances, structural similarity."""
