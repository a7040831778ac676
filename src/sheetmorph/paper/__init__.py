"""The results of the paper, redone and judged row by row."""
