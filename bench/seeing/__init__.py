"""What the benches of the eyes share: questions, counting, plots."""
