"""Zhou 2023, Table 3: steps and energy until ten targets are found, slopes up to beta."""

from __future__ import annotations

from uavbridge.experiments.zhou import setting

EXPERIMENT = setting.table(
    3, "zhou-table3", "steps and energy to find ten targets, no slope above beta", __file__
)
