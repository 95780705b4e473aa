"""Following: a machine along a path of its motors, with all that happens on the way."""
