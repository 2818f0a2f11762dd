"""Every service is the same house: whoever knows one finds their way in all."""

import ast
import re
import tomllib
from pathlib import Path

import pytest
import yaml

from support.source import ROOT, SERVICES, all_modules, modules

FOLDERS = {name: ROOT / "services" / name for name in SERVICES}
LINES_MAX = 350
OFF_THE_BUS = {"speech"}


def source(service: str) -> Path:
    return FOLDERS[service] / "src" / service


def tree(service: str, module: str) -> ast.Module:
    return ast.parse((source(service) / module).read_text(encoding="utf-8"))


@pytest.mark.parametrize("service", SERVICES)
@pytest.mark.parametrize(
    "room", ["app.py", "settings.py", "ports.py", "adapters/__init__.py", "__main__.py", "__init__.py"]
)
def test_every_service_has_the_same_rooms(service: str, room: str) -> None:
    assert (source(service) / room).is_file()


@pytest.mark.parametrize("service", SERVICES)
def test_every_service_keeps_its_routes_in_one_module_or_one_package(service: str) -> None:
    one, many = source(service) / "routes.py", source(service) / "routes" / "__init__.py"
    assert one.is_file() != many.is_file()


@pytest.mark.parametrize("service", SERVICES)
@pytest.mark.parametrize("paper", ["Dockerfile", "README.md", "pyproject.toml"])
def test_every_service_has_its_papers(service: str, paper: str) -> None:
    assert (FOLDERS[service] / paper).is_file()


@pytest.mark.parametrize("service", SERVICES)
def test_every_service_is_composed_by_create_app_of_settings_and_named_parts(service: str) -> None:
    """Whatever is real can be replaced by name, and nothing has to be."""
    (create,) = [
        node for node in tree(service, "app.py").body if isinstance(node, ast.FunctionDef) and node.name == "create_app"
    ]
    arguments = create.args
    assert [one.arg for one in (*arguments.posonlyargs, *arguments.args)] == ["settings"]
    assert ("bus" in [one.arg for one in arguments.kwonlyargs]) == (service not in OFF_THE_BUS)
    assert all(default is not None for default in arguments.kw_defaults)


@pytest.mark.parametrize("service", SERVICES)
def test_every_service_reads_its_environment_under_one_prefix(service: str) -> None:
    prefixes = {
        node.value.value
        for node in ast.walk(tree(service, "settings.py"))
        if isinstance(node, ast.keyword) and node.arg == "env_prefix" and isinstance(node.value, ast.Constant)
    }
    assert prefixes == {f"{service.upper()}_"}


@pytest.mark.parametrize("service", SERVICES)
def test_every_image_runs_as_nobody_special_and_says_how_it_is(service: str) -> None:
    lines = (FOLDERS[service] / "Dockerfile").read_text(encoding="utf-8").splitlines()
    users = [line.split()[1] for line in lines if line.startswith("USER ")]
    assert users
    assert users[-1] not in {"root", "0"}
    assert any(line.startswith("HEALTHCHECK ") for line in lines)
    assert not any(line.replace(" ", "").startswith("#syntax=") for line in lines)
    assert any("/opt/venv" in line for line in lines)


@pytest.mark.parametrize("project", [*(f"services/{name}" for name in SERVICES), "sim"])
def test_every_image_installs_the_packages_of_ours_that_its_project_needs(project: str) -> None:
    def needed_by(name: str) -> set[str]:
        file = (ROOT / name / "pyproject.toml").read_text(encoding="utf-8")
        needs = {
            one.removeprefix("atom-")
            for one in tomllib.loads(file)["project"]["dependencies"]
            if one.startswith("atom-")
        }
        return needs.union(*(needed_by(f"packages/{one}") for one in needs))

    image = (ROOT / project / "Dockerfile").read_text(encoding="utf-8")
    runs = re.findall(r"packages/(\w+)", " ".join(re.findall(r"-m pip (?:\S+ )*install(?:[^\n]|(?<=\\)\n)+", image)))
    assert needed_by(project) <= set(runs)


def test_compose_builds_every_service_from_its_own_dockerfile() -> None:
    compose = yaml.safe_load((ROOT / "compose.yaml").read_text(encoding="utf-8"))["services"]
    built = {name: compose[name]["build"]["dockerfile"] for name in SERVICES}
    assert built == {name: f"services/{name}/Dockerfile" for name in SERVICES}


def test_every_module_opens_with_one_sentence() -> None:
    assert [one.name for one in all_modules() if not ast.get_docstring(one.tree)] == []


def test_no_module_outgrows_what_a_reader_can_hold() -> None:
    """About 300 lines ask to be two; this is where asking ends."""
    lengths = {one.name: len(one.path.read_text(encoding="utf-8").splitlines()) for one in all_modules()}
    assert {name: length for name, length in lengths.items() if length > LINES_MAX} == {}


@pytest.mark.parametrize("service", SERVICES)
def test_every_service_has_modules_to_look_at(service: str) -> None:
    """A scan that finds nothing would find nothing wrong."""
    assert len(modules(service)) > 5
