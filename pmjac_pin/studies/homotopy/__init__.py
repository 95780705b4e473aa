"""Homotopy: all complex solutions of the loop equations, by path tracking."""
