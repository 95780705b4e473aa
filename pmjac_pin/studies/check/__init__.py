"""Check: what a model is, and what is wrong with it."""
