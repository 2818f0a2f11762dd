"""Where the ear touches the world: microphone, loudspeaker, wake word, services."""
