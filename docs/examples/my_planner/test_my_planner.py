import pytest
from my_planner import KIND

from planners import conformance


@pytest.mark.parametrize("name", conformance.CHECKS)
def test_conforms(name: str) -> None:
    assert conformance.CHECKS[name](conformance.Trial(KIND)) == []
