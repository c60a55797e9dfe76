"""The fast way for many slices of one manipulator; what it does not decide is left to the reference."""
