"""Where the target can be, and where to look for it next: one belief, updated by every look (pure)."""
