"""The map between motors and the joints a robot thinks in: at a pose, over a rectangle, as C."""
