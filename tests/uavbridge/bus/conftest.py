from collections.abc import Iterator

import pytest

from uavbridge.bus.zenoh_bus import Router


@pytest.fixture(scope="session")
def router() -> Iterator[Router]:
    with Router() as router:
        yield router
