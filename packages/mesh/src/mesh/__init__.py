"""Plumbing the services share: bus, clock, tasks, health, logging, HTTP. No domain knowledge."""
