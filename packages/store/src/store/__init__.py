"""The kit under every database of ours: a file made ready, migrations, a writer and readers in threads."""
