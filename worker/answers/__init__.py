"""What is computed and kept: slices and documents."""
