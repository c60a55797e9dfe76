"""The worker layer: results and jobs in Redis, and the RQ worker processes that compute them."""
