"""A stop that is spoken: how long it takes, how often it is missed, and how often one is heard that nobody said."""
