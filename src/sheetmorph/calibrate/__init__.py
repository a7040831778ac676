"""Parameters of a design found from scans and measured curves."""
