"""The laser scan, for drawing."""

import pytest

from contracts.laser import LaserScan
from support.bridge_behaviour import Rig
from support.waiting import until_true


async def test_the_newest_scan_comes_with_where_it_was_taken(rig: Rig) -> None:
    scan = LaserScan.model_validate_json((await rig.client.get("/scan")).content)
    assert scan.pose is not None
    assert len(scan.points_m) == 144
    thinned = LaserScan.model_validate_json((await rig.client.get("/scan", params={"points_max": 50})).content)
    assert 40 <= len(thinned.points_m) <= 50


@pytest.mark.parametrize("route", ["/scan", "/obstacles"])
async def test_a_silent_laser_is_named_not_repeated(rig: Rig, route: str) -> None:
    rig.toy.silent.add("scan")
    await until_true(lambda: _status(rig, 503))
    assert "scan" in (await rig.client.get(route)).json()["detail"]


async def _status(rig: Rig, wanted: int) -> bool:
    return (await rig.client.get("/scan")).status_code == wanted
