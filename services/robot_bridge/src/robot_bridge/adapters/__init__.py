"""Where the bridge meets the outside."""
