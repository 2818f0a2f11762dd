"""Exploring an unknown home: who leads, what may be asked, and what is done when nobody answers. Pure."""
