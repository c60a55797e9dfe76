"""The singular curves of a slice: their topology, proved; their course; assembly modes; aspects."""
