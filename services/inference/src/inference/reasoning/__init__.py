"""Facts put into words by a language model, and the check that it adds nothing."""
