"""Where the tool gets: regions of a slice, their borders and areas."""
