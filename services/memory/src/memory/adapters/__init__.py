"""The ports' real twins."""
