"""Sweeps: many poses, of many machines, into a store that outlives the process."""
