"""Machines made of points and lengths, where no file describes them."""
