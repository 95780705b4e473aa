"""Words: what is known, as plain data, tables and text."""
