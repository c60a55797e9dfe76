"""What is asked and answered, as data: no HTTP and no terminal."""
