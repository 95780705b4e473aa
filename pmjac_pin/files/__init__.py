"""Files: from a text to what a machine is, and back to a file."""
