"""Language models: who is asked, with which prompt, and what of the answer is kept."""
