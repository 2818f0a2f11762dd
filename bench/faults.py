"""Does to the running mesh what will happen to it one day, and tells what the robot did. See docs/faults.md.

The whole mesh with the simulated robot runs under supervisord; between the robot and robot_bridge lies a wire that can
be cut, frozen or spoilt, and between Nav2 and it a relay that can be killed. Speeds are the simulator's truth.
"""

import argparse
import contextlib
import json
import os
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import httpx

from bench.faulting.campaign import Campaign, Observed
from bench.faulting.catalog import FAULTS, Fault
from bench.results import save
from demo.stack import Ports, Stack
from sim.home import Home, Wanted

WIRED = {
    "SCAN": {"name": "wire/scan"},
    "ODOM": {"name": "wire/odom"},
    "RGB": {"name": "wire/oakd/rgb/preview/image_raw", "depth": 1},
    "RGB_INFO": {"name": "wire/oakd/rgb/preview/camera_info", "depth": 1},
    "DEPTH": {"name": "wire/oakd/stereo/image_raw", "depth": 1},
    "DEPTH_INFO": {"name": "wire/oakd/stereo/camera_info", "depth": 1},
    "CMD_VEL_NAV": {"name": "wire/cmd_vel_nav", "reliability": "reliable", "depth": 1},
    "NAVIGATE_ACTION": "relay/navigate_to_pose",
    "NAV2_LIFECYCLE_NODES": ["relay"],
}


def faketime() -> Path | None:
    """libfaketime's library, where `pip install libfaketime` has put it."""
    spec = find_spec("libfaketime")
    if spec is None or spec.origin is None:
        return None
    return next(Path(spec.origin).parent.rglob("libfaketime.so.1"), None)


def environment(folder: Path, *, steppable: bool) -> dict[str, str]:
    """What the processes of the mesh are told beyond what the demo tells them; `steppable`: their clock too."""
    told = {
        f"ROBOT_BRIDGE_ROS__{name}": value if isinstance(value, str) else json.dumps(value)
        for name, value in WIRED.items()
    }
    if steppable and (library := faketime()) is not None:
        clock = folder / "clock"
        clock.write_text("+0\n")
        told |= {
            "LD_PRELOAD": str(library),
            "FAKETIME_TIMESTAMP_FILE": str(clock),
            "FAKETIME_NO_CACHE": "1",
            "FAKETIME_DONT_FAKE_MONOTONIC": "1",
        }
    return told


@contextlib.contextmanager
def running(port_base: int, *, light: bool) -> Iterator[Campaign]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        stack = Stack(Ports(port_base), folder, folder / "home.json", seed=3, speech=not light)
        Home.generate(3, wanted=Wanted("bottle", "red")).save(stack.home)
        told = environment(folder, steppable=light)
        os.environ.update(told)
        process = stack.start()
        for variable in told:
            del os.environ[variable]
        try:
            with Campaign(stack, folder, light=light) as campaign:
                campaign.begin()
                yield campaign
        finally:
            stack.stop(process)


def attempt(fault: Fault, campaign: Campaign) -> tuple[bool, Observed]:
    """Whether it went as designed, and what was seen."""
    began_s = time.monotonic()
    try:
        try:
            campaign.rested()
            seen = fault.happen(campaign)
        finally:
            campaign.mend()
    except (AssertionError, httpx.HTTPError, KeyError) as error:
        return False, {"failed": f"{type(error).__name__}: {error}"[:500]}
    return True, seen | {"seconds": round(time.monotonic() - began_s, 1)}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="FAULT", help=f"all of {', '.join(f.name for f in FAULTS)}")
    parser.add_argument("--port-base", type=int, default=18500)
    parser.add_argument("--out", type=Path, default=Path("out/bench/faults.json"))
    parser.add_argument("--quick", action="store_true", help="robot and bridge only: the faults that need no mission")
    arguments = parser.parse_args()
    chosen = [fault for fault in FAULTS if not arguments.names or fault.name in arguments.names]
    if arguments.quick:
        chosen = [fault for fault in chosen if not fault.needs_mission]
    else:  # what inference computes with does not run under libfaketime
        chosen = [fault for fault in chosen if not fault.needs_clock]
    if unknown := set(arguments.names) - {fault.name for fault in FAULTS}:
        parser.error(f"no such fault: {', '.join(unknown)}")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    results: dict[str, Observed] = {}
    failed = 0
    with running(arguments.port_base, light=arguments.quick) as campaign:
        for fault in chosen:
            well, seen = attempt(fault, campaign)
            failed += not well
            results[fault.name] = {"as_designed": well, "designed": fault.designed, **seen}
            told = "  ".join(f"{key} {value}" for key, value in seen.items())
            sys.stdout.write(f"{'as designed' if well else 'NOT SO':<12} {fault.name:<24} {told}\n")
            sys.stdout.flush()
    save(arguments.out, results)
    sys.stdout.write(f"{len(chosen) - failed} of {len(chosen)} as designed; {arguments.out}\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
