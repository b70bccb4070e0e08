"""Zhou 2023, Table 4: steps and energy until ten targets are found, slopes up to alpha."""

from __future__ import annotations

from uavbridge.experiments.zhou import setting

EXPERIMENT = setting.table(
    4, "zhou-table4", "steps and energy to find ten targets, slopes above beta in places", __file__
)
