"""The robot in Home Assistant, over MQTT."""
