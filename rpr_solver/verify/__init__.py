"""A second, independent checker of documents: SymPy, exact integers, intervals, nothing of the solver."""
