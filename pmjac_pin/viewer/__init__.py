"""The viewer: a mechanism and its ellipsoids, in meshcat."""
