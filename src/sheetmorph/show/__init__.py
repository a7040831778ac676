"""Pictures, plots, films and reports of results."""
