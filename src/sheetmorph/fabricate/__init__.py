"""From a design to parts on a bench: files to cut and to print, a template, instructions."""
