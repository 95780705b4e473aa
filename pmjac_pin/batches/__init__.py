"""Many poses of one mechanism at once."""
