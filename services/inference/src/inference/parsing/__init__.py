"""From a command to the things it asks for: rules first and last, a language model checked between."""
