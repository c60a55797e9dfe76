"""Whether the assembly mode can change without a singularity."""
