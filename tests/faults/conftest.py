from tests.support.valkey import redis, valkey, workers

__all__ = ["redis", "valkey", "workers"]
