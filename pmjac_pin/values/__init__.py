"""Values: numbers and names that a caller gave, checked, and arrays that cannot be written to."""
