"""URDF: read, checked, moved by parameters, and with loops."""
