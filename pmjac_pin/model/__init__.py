"""Model: what a machine is, and the equations of its loops."""
