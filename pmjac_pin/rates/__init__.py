"""Rates: linear algebra on arrays. Nothing of Pinocchio is known here."""
