from pathlib import Path

import pytest

from uavbridge.recording.topics import OUTCOMES, TOPICS

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "recording.md"


@pytest.mark.parametrize("name", TOPICS)
def test_the_page_names_every_topic(name: str) -> None:
    assert any(start in PAGE.read_text() for start in (f"| `{name}`", f"| `{name}/<"))


def test_the_page_names_every_outcome() -> None:
    listed = ", ".join(f"{code} {name}" for code, name in enumerate(OUTCOMES))
    assert listed in " ".join(PAGE.read_text().split())


def test_the_page_names_the_fields_of_every_record() -> None:
    text = PAGE.read_text()
    for topic in TOPICS.values():
        if topic.struct is not None and topic.package == "uavbridge" and topic.name != "mission":
            assert all(f"`{field}`" in text for field in topic.struct.__struct_fields__)
