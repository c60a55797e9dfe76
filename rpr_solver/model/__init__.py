"""One manipulator and one fixed leg: geometry, the map of a slice, its derivatives, kinds of poses."""
