"""The coordinator: turns a person's command into a mission, and decides every step of it."""
