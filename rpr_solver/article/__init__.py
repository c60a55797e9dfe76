"""The article's own algorithm, as an audit of the solver's method."""
