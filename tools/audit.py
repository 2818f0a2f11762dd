"""Asks the advisories on Python packages about what is installed here, over the internet.

Exit code: 0 = nothing known, 1 = something is known and listed, 3 = nothing was checked: no advisories were to be had.
"""

import json
import subprocess
import sys

AWAY = 3


def main() -> int:
    asked = [sys.executable, "-m", "pip_audit", "--local", "--skip-editable", "--progress-spinner", "off", "-f", "json"]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    packages = json.loads(done.stdout)["dependencies"] if done.stdout.strip() else []
    checked = [one for one in packages if "vulns" in one]
    for one in checked:
        for known in one["vulns"]:
            print(one["name"], one["version"], known["id"], "mended in", *known["fix_versions"])  # noqa: T201 - a tool
    print(f"{len(checked)} checked, {len(packages) - len(checked)} unknown to the advisories")  # noqa: T201 - a tool
    if not checked:
        sys.stderr.write(f"Nothing was checked: run this where there is internet. {done.stderr[-300:]}\n")
        return AWAY
    return 1 if any(one["vulns"] for one in checked) else 0


if __name__ == "__main__":
    sys.exit(main())
