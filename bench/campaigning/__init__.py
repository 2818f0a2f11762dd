"""Faulted missions through the whole mesh in one process: episodes of `bench.search` on `bench.world`, with its faults.

The eyes are the real models, so that what they get wrong is their own; what is injected are the faults of
`bench.world.faults.KINDS`, each at the port where it would come from.
"""
