"""Clients of services that more than one program calls. What one program alone calls has its client beside it."""
