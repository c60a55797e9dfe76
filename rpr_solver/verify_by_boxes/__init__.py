"""A second, independent checker of documents: all that they list is found anew, on boxes."""
