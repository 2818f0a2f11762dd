"""The ports' real twins: HTTP, WebSocket and memory."""
