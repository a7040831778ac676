"""Readings of experiments: films and images of the oven, tables of the bench."""
