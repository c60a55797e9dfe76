"""The workspace at one orientation: the places that joint limits allow, and the singular conic in it."""
