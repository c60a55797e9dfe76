"""Who may do what: names of the service, keys and their scopes, and the caller of each request."""
