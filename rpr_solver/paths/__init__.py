"""Paths that meet no singularity: loops round cusps, and paths between poses, with their proofs."""
