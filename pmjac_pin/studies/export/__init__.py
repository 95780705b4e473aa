"""Export: a closed machine as a file for the programs that people simulate and control with."""
