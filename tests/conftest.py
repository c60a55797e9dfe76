"""Settings that all tests share."""

from hypothesis import HealthCheck, settings

SLOW = [HealthCheck.too_slow]
settings.register_profile("ci", deadline=None, derandomize=True, suppress_health_check=SLOW)
settings.register_profile(
    "long", deadline=None, max_examples=1000, suppress_health_check=SLOW, print_blob=True
)
settings.load_profile("ci")
