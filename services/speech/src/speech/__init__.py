"""ATOM's ear and voice."""
