"""The parts of the page. Each builds its elements once and afterwards only shows what changed."""
