"""HTTP itself: connections, framing, and what every request and response has."""
