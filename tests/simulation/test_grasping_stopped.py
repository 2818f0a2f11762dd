"""The emergency stop in each state of a fetch, by physics: the arm stands, what it holds is held, nothing resumes."""

import pytest

from bench.fetch.play import world_of
from bench.fetch.scene import Setting
from bench.fetch.shell import FetchShell
from contracts.manipulation import FetchEnd, ManipulationState

S = ManipulationState
BOTTLE = Setting("bottle", "floor", ahead_m=0.27, left_m=0.03)
AFTER_S, STANDS_S = 0.3, 1.0
NOISE_RAD = 0.02
MOVING = (S.HOME, S.PRE_GRASP, S.GRASP, S.LIFT, S.CHECK, S.CARRY, S.DELIVER, S.RECOVER)
"""States in which the simulated robot does something that takes time."""


class StopIn:
    """Presses the stop in a state, once it has lasted a while, and looks at the joints from then on."""

    def __init__(self, state: ManipulationState, after_s: float) -> None:
        self.state, self.after_s = state, after_s
        self.since_s: float | None = None
        self.stopped_s: float | None = None
        self.stood: tuple[float, ...] | None = None
        self.moved_rad = 0.0

    def __call__(self, shell: FetchShell) -> None:
        now_s = shell.world.time_s
        if self.stopped_s is None:
            inside = shell.fetch.state is self.state
            self.since_s = (self.since_s if self.since_s is not None else now_s) if inside else None
            if self.since_s is not None and now_s >= self.since_s + self.after_s:
                self.stopped_s = now_s
                shell.stop()
            return
        joints = (*shell.arm.joints, shell.arm.jaw_rad)
        if self.stood is None and now_s >= self.stopped_s + AFTER_S:
            self.stood = joints
        if self.stood is not None:
            moved = max(abs(one - other) for one, other in zip(joints, self.stood, strict=True))
            self.moved_rad = max(self.moved_rad, moved)


@pytest.mark.parametrize("state", MOVING)
def test_a_stop_in_each_state_stands_within_0_3_s_and_nothing_moves_after_it(state: ManipulationState) -> None:
    watch = StopIn(state, after_s=0.15)
    with world_of(BOTTLE) as world:
        if state is S.RECOVER:
            model = world._body.model
            model.geom_friction[model.body("thing").geomadr[0]] = 0.0
        shell = FetchShell(world, BOTTLE, seed=1, watch=watch)
        finish = shell.run()
        shell.arm.wait(AFTER_S)
        held = shell.thing_at()[2]
        shell.arm.wait(STANDS_S)
        assert watch.stood is not None, f"it never was in {state}"
        assert finish.end is FetchEnd.STOPPED
        assert watch.moved_rad < NOISE_RAD
        assert abs(shell.thing_at()[2] - held) < 0.01, "what it holds is held, and what stands stands"
        assert shell.fetch.state is S.IDLE
