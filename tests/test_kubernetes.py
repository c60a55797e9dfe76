"""The kustomization of docker/kubernetes: valid, contained, and in step with the code."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import pytest
import yaml
from redis import Redis

from service.cli.environment import unknown_settings
from worker.jobs.chunks import ChunkQueue
from worker.settings import WorkerSettings

FOLDER = Path(__file__).parents[1] / "docker" / "kubernetes"
VERSION = "1.31"
"""The oldest version of Kubernetes that gets fixes; what is valid there is valid in later ones."""

MISSING = "needs `pip install kubernetes-validate`"

Resource = dict[str, Any]
KUSTOMIZATION: Resource = yaml.safe_load((FOLDER / "kustomization.yaml").read_text())
RESOURCES: list[Resource] = [
    resource
    for name in KUSTOMIZATION["resources"]
    for resource in yaml.safe_load_all((FOLDER / name).read_text())
]
OF_KUBERNETES = [r for r in RESOURCES if not r["apiVersion"].startswith("keda.sh/")]
TEMPLATES = {
    r["metadata"]["name"]: r["spec"]["template"] for r in RESOURCES if "template" in r.get("spec", {})
}


def name(resource: Resource) -> str:
    return f"{resource['kind']}-{resource['metadata']['name']}"


def get(kind: str, called: str) -> Resource:
    [found] = [r for r in RESOURCES if (r["kind"], r["metadata"]["name"]) == (kind, called)]
    return found


def test_every_file_is_part_of_it() -> None:
    assert {*KUSTOMIZATION["resources"], "kustomization.yaml"} == {path.name for path in FOLDER.iterdir()}


@pytest.mark.parametrize("resource", OF_KUBERNETES, ids=name)
def test_the_schemas_of_kubernetes_hold(resource: Resource) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the package's own imports
        validator = pytest.importorskip("kubernetes_validate", reason=MISSING)
        validator.validate(resource, VERSION, strict=True)


def test_the_schemas_find_faults() -> None:
    validator = pytest.importorskip("kubernetes_validate", reason=MISSING)
    broken = {**get("Deployment", "api"), "spec": {"replicas": "two"}}
    with pytest.raises(validator.ValidationError):
        validator.validate(broken, VERSION, strict=True)


@pytest.mark.parametrize("called", ["api", "worker", "redis"])
def test_pods_are_contained(called: str) -> None:
    spec = TEMPLATES[called]["spec"]
    assert spec["securityContext"]["runAsNonRoot"] is True
    assert spec["automountServiceAccountToken"] is False
    for container in spec["containers"]:
        assert container["securityContext"] == {
            "allowPrivilegeEscalation": False,
            "readOnlyRootFilesystem": True,
            "capabilities": {"drop": ["ALL"]},
        }
        assert {"cpu", "memory"} == container["resources"]["limits"].keys()
        assert "livenessProbe" in container
        mounted = {volume["name"] for volume in container["volumeMounts"]}
        claims = {c["metadata"]["name"] for c in get("StatefulSet", "redis")["spec"]["volumeClaimTemplates"]}
        assert mounted <= {volume["name"] for volume in spec["volumes"]} | claims


def test_no_secret_is_in_a_file() -> None:
    assert not [r for r in RESOURCES if r["kind"] == "Secret"]
    for template in TEMPLATES.values():
        [secret] = [v["secret"]["secretName"] for v in template["spec"]["volumes"] if "secret" in v]
        assert secret == "rpr-cusps-redis"
    assert not list(unknown_settings(get("ConfigMap", "settings")["data"]))


def test_what_is_selected_exists() -> None:
    labels = [template["metadata"]["labels"] for template in TEMPLATES.values()]
    for resource in RESOURCES:
        if selector := resource.get("spec", {}).get("selector"):
            assert selector.get("matchLabels", selector) in labels
    assert {r["metadata"]["name"] for r in RESOURCES if r["kind"] == "NetworkPolicy"} == TEMPLATES.keys()
    budgets = {r["metadata"]["name"] for r in RESOURCES if r["kind"] == "PodDisruptionBudget"}
    assert budgets == {"api", "worker"}


def test_the_workers_scale_with_the_lists_of_the_queue() -> None:
    triggers = get("ScaledObject", "worker")["spec"]["triggers"]
    lanes = [queue.key for queue in ChunkQueue(Redis(), WorkerSettings()).queues.values()]
    assert [trigger["metadata"]["listName"] for trigger in triggers] == lanes
    assert {t["authenticationRef"]["name"] for t in triggers} == {"redis"}
    assert get("TriggerAuthentication", "redis")["spec"]["secretTargetRef"][0]["name"] == "rpr-cusps-redis"
    assert get("ScaledObject", "worker")["spec"]["scaleTargetRef"]["name"] == "worker"
    assert "replicas" not in get("Deployment", "worker")["spec"], "KEDA sets it"
