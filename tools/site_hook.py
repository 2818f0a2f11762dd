"""What MkDocs is told when it builds the site: which files are its pages, and what it makes of the OpenAPI documents.

The pages lie all over the repository and link to each other as GitHub wants it. So they are laid out in a folder as
they lie here, and no link has to be written again.
"""

import json
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from importlib.resources import files as files_of
from pathlib import Path
from typing import Any, Final

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT: Final = Path(__file__).parents[1]
PAGES: Final = ("*.md", "docs", ".env.example", "bench/results/*.png")
"""As git names them: every Markdown file, and what they link to."""
DIAGRAMS: Final = """import { mermaid } from "./mermaid/index.js";
mermaid.initialize({ startOnLoad: false, theme: document.body.dataset.mdColorScheme === "slate" ? "dark" : "default" });
await mermaid.run({ querySelector: ".diagram" });
"""
FETCHED: Final = re.compile(r"<(?:script|img|link|iframe)[^>]+(?:src|href)=\"?(?:https?:)?//[^>]*>")
_laid_out: list[Path] = []


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Lays the pages out as they lie in the repository."""
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--deduplicate", "--", *PAGES]
    named = subprocess.run(listed, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    folder = Path(tempfile.mkdtemp(prefix="atom-site-"))
    _laid_out.append(folder)
    for name in named:
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).symlink_to(ROOT / name)
    config.docs_dir = str(folder)
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds a page for each OpenAPI document, and what the pages need to be drawn without the internet."""
    for document in sorted((ROOT / "docs/api").glob("*.openapi.json")):
        service = document.name.partition(".")[0]
        text = "\n".join(routes_page(service, json.loads(document.read_text(encoding="utf-8"))))
        files.append(File.generated(config, f"docs/api/{service}.md", content=text))
    files.append(File.generated(config, "site/diagrams.js", content=DIAGRAMS))
    icon = ROOT / "services/ui/src/ui/assets/icon.svg"
    files.append(File.generated(config, "site/icon.svg", content=icon.read_text(encoding="utf-8")))
    for script in Path(str(files_of("nicegui"))).glob("elements/mermaid/dist/*.js"):
        files.append(File.generated(config, f"site/mermaid/{script.name}", abs_src_path=str(script)))
    return files


def on_post_page(output: str, page: Page, config: MkDocsConfig) -> str:
    """Refuses a page that would fetch something from elsewhere when it is read."""
    if fetched := FETCHED.search(output):
        raise PluginError(f"{page.file.src_uri} fetches from elsewhere: {fetched.group()}")
    return output


def on_shutdown() -> None:
    for folder in _laid_out:
        shutil.rmtree(folder, ignore_errors=True)


def routes_page(service: str, document: dict[str, Any]) -> Iterator[str]:
    """Every route of a service, one after another, and what its bodies are made of."""
    yield f"# {service}\n\n{document['info'].get('description', '')}\n"
    yield f"Made from [{service}.openapi.json]({service}.openapi.json); who may: [access](access.md).\n"
    for path, methods in document["paths"].items():
        for method, route in methods.items():
            yield f"## {method.upper()} `{path}`\n\n{route.get('description') or route.get('summary', '')}\n"
            for one in route.get("parameters", []):
                need = "needed" if one.get("required") else "may be left out"
                yield f"- `{one['name']}` ({one['in']}, {_kind(one['schema'])}, {need}) {one.get('description', '')}"
            if body := route.get("requestBody"):
                yield f"- body: {_content(body)}"
            for status, answer in route.get("responses", {}).items():
                yield f"- answers {status}: {answer.get('description', '')} {_content(answer)}"
            yield ""
    yield "## What they carry\n"
    for name, schema in document.get("components", {}).get("schemas", {}).items():
        yield f"### {name}\n\n{schema.get('description', '')}\n"
        if names := schema.get("enum"):
            yield f"One of {', '.join(f'`{one}`' for one in names)}.\n"
        for field, kind in schema.get("properties", {}).items():
            need = "" if field in schema.get("required", []) else ", may be left out"
            yield f"- `{field}` ({_kind(kind)}{need}) {kind.get('description', '')}"
        yield ""


def _content(part: dict[str, Any]) -> str:
    return ", ".join(_kind(one.get("schema", {})) or kind for kind, one in part.get("content", {}).items())


def _kind(schema: dict[str, Any]) -> str:
    """The type of a field, with a link to where it stands on the page."""
    if "$ref" in schema:
        name = str(schema["$ref"]).rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if several := schema.get("anyOf", schema.get("oneOf")):
        return " or ".join(_kind(one) for one in several)
    if schema.get("type") == "array":
        return f"list of {_kind(schema.get('items', {})) or 'anything'}"
    return f"`{schema['const']}`" if "const" in schema else str(schema.get("type", ""))
