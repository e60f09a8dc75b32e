"""The objects of deploy/kubernetes and the Jobs that the engine makes are held against the schemas of Kubernetes. Run by the
python that has kubernetes-validate."""

import json
from pathlib import Path

import kubernetes_validate
import yaml

CLOUD = Path(__file__).resolve().parents[1]
OBJECTS = json.loads((CLOUD / "engine/tests/kubernetes-jobs.json").read_text())
OBJECTS += list(yaml.safe_load_all((CLOUD / "deploy/kubernetes/mercury.yaml").read_text()))
VERSIONS = ["1.28", "1.31", kubernetes_validate.latest_version()]
for version in VERSIONS:
    for one in OBJECTS:
        kubernetes_validate.validate(one, version, strict=True)
print(f"    {len(OBJECTS)} objects hold against the schemas of {', '.join(VERSIONS)}")
