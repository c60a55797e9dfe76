"""A second, independent checker of documents, which finds all that they list anew (verify.md)."""
