"""Assembly modes: all closed poses at given motor values, and what the answer rests on."""
