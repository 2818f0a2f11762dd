"""The processes that `bench.stop` measures, and what one of them hears of the robot's velocity."""

import contextlib
import os
import socket
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import httpx

from bench.processes import Processes, bridge_environment, until
from contracts.access import CredentialFile, Principal, Role, sha256_of
from contracts.robot import SensorState

START_S_MAX = 90.0
HEAR_S_MAX = 10.0
KEY = "a key of this bench"


@dataclass(frozen=True)
class Heard:
    at_ns: int
    linear_x: float
    angular_z: float

    @property
    def zero(self) -> bool:
        return (self.linear_x, self.angular_z) == (0.0, 0.0)


class Listener:
    """What the listening process has heard, newest last."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        self.process = process
        self.heard: deque[Heard] = deque(maxlen=100_000)
        self._some = threading.Condition()
        self._reading = threading.Thread(target=self._read, daemon=True)
        self._reading.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            at_ns, linear_x, angular_z = line.split()
            with self._some:
                self.heard.append(Heard(int(at_ns), float(linear_x), float(angular_z)))
                self._some.notify_all()

    def first(self, wanted: Callable[[Heard], bool], *, since_ns: int, timeout_s: float) -> Heard:
        """The first message after `since_ns` that is `wanted`. Raises TimeoutError."""
        deadline = time.monotonic() + timeout_s
        with self._some:
            while True:
                for each in self.heard:
                    if each.at_ns >= since_ns and wanted(each):
                        return each
                if (left_s := deadline - time.monotonic()) <= 0.0:
                    raise TimeoutError("the listener did not hear it")
                self._some.wait(left_s)

    def forget(self) -> None:
        with self._some:
            self.heard.clear()


@dataclass(frozen=True)
class Rig:
    """The processes under measurement: Redis, the bridge, a robot and the listener."""

    port: int
    processes: Processes
    bridge: "subprocess.Popen[bytes]"
    listener: Listener
    http: httpx.Client

    def drive(self) -> None:
        """Returns when the listener hears that the robot is told to move."""
        epoch = self.http.post("/emergency-stop/reset").json()["state"]["epoch"]
        since_ns = time.monotonic_ns()
        lease = {"twist": {"linear_x": 0.2}, "source": "bench", "epoch": epoch, "duration_s": 2.0, "priority": 3}
        self.http.post("/velocity", json=lease).raise_for_status()
        self.listener.first(lambda heard: not heard.zero, since_ns=since_ns, timeout_s=HEAR_S_MAX)

    def stop_by_curl(self) -> tuple[float, float]:
        """ms from before curl is started to the first zero heard, and to curl's end."""
        command = ["curl", "-s", "-o", "/dev/null", "-X", "POST", f"http://127.0.0.1:{self.port}/emergency-stop"]
        began_ns = time.monotonic_ns()
        done = subprocess.run(command, check=True, env=self._curl_environment, close_fds=False)
        ended_ns = time.monotonic_ns()
        assert done.returncode == 0
        zero = self.listener.first(lambda heard: heard.zero, since_ns=began_ns, timeout_s=HEAR_S_MAX)
        return (zero.at_ns - began_ns) / 1e6, (ended_ns - began_ns) / 1e6

    def floor_by_curl(self) -> float:
        """ms from before curl is started to its request's arrival in a process that does nothing but wait for it."""
        with socket.create_server(("127.0.0.1", 0)) as server:
            url = f"http://127.0.0.1:{server.getsockname()[1]}/"
            began_ns = time.monotonic_ns()
            curl = subprocess.Popen(["curl", "-s", "-X", "POST", url], env=self._curl_environment, close_fds=False)
            connection, _ = server.accept()
            with connection:
                connection.recv(1000)
                arrived_ns = time.monotonic_ns()
                connection.sendall(b"HTTP/1.1 204 No Content\r\nConnection: close\r\n\r\n")
            curl.wait(20.0)
        return (arrived_ns - began_ns) / 1e6

    @property
    def _curl_environment(self) -> dict[str, str]:
        return {"PATH": os.environ.get("PATH", "/usr/bin:/bin")}


@contextlib.contextmanager
def rigged(folder: Path, port: int, domain: int, camera_hz: float, *, secured: bool) -> Iterator[Rig]:
    """Yields once the bridge senses its robot and the listener hears it. Raises `TimeoutError`.

    `secured`: the bridge has keys and writes its traces; all but the stop is asked with a key.
    """
    environment = bridge_environment(folder, port=port, redis_port=port + 1, domain=domain)
    environment |= _secured(folder) if secured else {}
    with (
        Processes(environment | {"ROBOT_BRIDGE_LOG_LEVEL": "ERROR"}) as processes,
        httpx.Client(
            base_url=f"http://127.0.0.1:{port}",
            headers={"Authorization": f"Bearer {KEY}"} if secured else {},
            timeout=30.0,
            trust_env=False,
        ) as http,
    ):
        processes.redis(port + 1)
        bridge = processes.python("-m", "robot_bridge")
        processes.python("-m", "bench.stopping.robot", "--camera-hz", str(camera_hz))
        listener = Listener(processes.python("-m", "bench.stopping.listener", stdout=subprocess.PIPE, text=True))
        until(lambda: _senses(http), "a bridge with scan and odometry", timeout_s=START_S_MAX)
        listener.first(lambda _: True, since_ns=0, timeout_s=START_S_MAX)
        yield Rig(port, processes, bridge, listener, http)


def _secured(folder: Path) -> dict[str, str]:
    bench = Principal(name="bench", role=Role.ADMIN, key_sha256=sha256_of(KEY))
    (folder / "keys.json").write_text(CredentialFile(principals=(bench,)).model_dump_json())
    return {
        "ROBOT_BRIDGE_KEYS_FILE": str(folder / "keys.json"),
        "ROBOT_BRIDGE_KEY": "the bridge's own key",
        "ATOM_TRACES": str(folder / "traces"),
    }


def _senses(http: httpx.Client) -> bool:
    with contextlib.suppress(httpx.TransportError):
        sensors = http.get("/state").json()["sensors"]
        return all(sensors[name]["state"] == SensorState.FRESH for name in ("scan", "odom"))
    return False
