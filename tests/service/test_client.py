from __future__ import annotations

import pytest

from service.client import ServiceClient
from service.errors import ServiceError


@pytest.mark.parametrize("url", ["ftp://x", "127.0.0.1:8000", "http://", "http://x:y", ""])
def test_the_client_names_the_address_that_is_none(url: str) -> None:
    with pytest.raises(ServiceError) as refused:
        ServiceClient(url)
    assert str(refused.value).startswith(f"{url!r} is not an ")
    assert refused.value.is_input
