"""The life of a job in Redis."""
