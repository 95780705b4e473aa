"""Model: what a machine is. Nothing is computed here."""
