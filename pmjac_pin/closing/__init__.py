"""Closing: from an open pose to a closed one, and along a path of closed ones."""
