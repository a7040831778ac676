"""The studio: a local web page on which a sheet is designed by eye."""
