"""What the faults' report rests on: that every route is flooded, and that driving on is told from standing still."""

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from bench.faulting.campaign import Campaign
from bench.faulting.flood import routes
from robot_bridge.app import create_app
from robot_bridge.settings import Settings
from support.mesh_run import MeshRun


def test_every_route_is_flooded_but_the_one_whose_answer_has_no_end(tmp_path: Path) -> None:
    document: dict[str, Any] = create_app(Settings(state_dir=tmp_path)).openapi()["paths"]
    promised = {f"{method.upper()} {path}" for path, methods in document.items() for method in methods}
    flooded = [route.partition("?")[0] for route in routes(1, {})]
    left_out = {
        each for each in promised if not any(re.fullmatch(re.sub(r"{\w+}", "[^/]+", each), one) for one in flooded)
    }
    assert left_out == {"GET /camera/stream"}


@dataclass
class Driven(MeshRun):
    """A simulation in which each look takes half a second, and the robot's pace changes as it is told."""

    paces_m_s: list[float] = field(default_factory=list)
    time_s: float = 0.0
    path_m: float = 0.0

    def truth(self) -> dict[str, Any]:
        pace_m_s = self.paces_m_s.pop(0) if len(self.paces_m_s) > 1 else self.paces_m_s[0]
        self.time_s, self.path_m = self.time_s + 0.5, self.path_m + 0.5 * pace_m_s
        return {"time_s": self.time_s, "path_length_m": self.path_m}

    def until(self, condition: Any, *, timeout_s: float, what: str) -> None:
        if not any(condition() for _ in range(100)):
            raise AssertionError(what)


def campaign(*paces_m_s: float) -> Campaign:
    made = Campaign.__new__(Campaign)
    made.mesh = Driven(list(paces_m_s))
    return made


def test_a_robot_that_drives_as_before_drives_on() -> None:
    on = campaign(0.1)
    before_m = on.drives(3.0)
    assert on.drives_on(3.0, before_m=before_m) >= before_m / 2.0


def test_a_robot_that_falters_for_a_moment_and_goes_on_drives_on() -> None:
    assert campaign(*[0.0] * 20, 0.1).drives_on(3.0, before_m=0.3) >= 0.15


@pytest.mark.parametrize("pace_m_s", [0.0, 0.03])
def test_a_robot_that_stands_or_creeps_does_not(pace_m_s: float) -> None:
    with pytest.raises(AssertionError, match=r"half of the 0\.3 m"):
        campaign(pace_m_s).drives_on(3.0, before_m=0.3)
