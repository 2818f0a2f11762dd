"""The arm: what it may do (pure), and what is under way."""
