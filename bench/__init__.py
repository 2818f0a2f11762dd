"""Measurements: each module is one bench, run as `python -m bench.<name>`, with `--help`."""
