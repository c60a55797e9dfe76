"""The kustomization of docker/kubernetes: valid, contained, and in step with the code."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import pytest
import yaml
from redis import Redis

from rpr_solver import SOLVER_VERSION
from service.cli.options import unknown_settings
from worker.jobs.chunks import ChunkQueue
from worker.settings import WorkerSettings

FOLDER = Path(__file__).parents[1] / "docker" / "kubernetes"
DOCS = Path(__file__).parents[1] / "docs"
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
WORKER = f"worker-{SOLVER_VERSION}"
OF_VERSION = {("Deployment", WORKER), ("PodDisruptionBudget", WORKER), ("ScaledObject", WORKER)}
"""What an upgrade to another version of the solver leaves as it is."""


def name(resource: Resource) -> str:
    return f"{resource['kind']}-{resource['metadata']['name']}"


def get(kind: str, called: str) -> Resource:
    [found] = [r for r in RESOURCES if (r["kind"], r["metadata"]["name"]) == (kind, called)]
    return found


def test_every_file_is_part_of_it() -> None:
    assert {*KUSTOMIZATION["resources"], "kustomization.yaml"} == {path.name for path in FOLDER.iterdir()}


@pytest.mark.slow
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


@pytest.mark.parametrize("called", ["api", WORKER, "redis"])
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
        spec = resource.get("spec", {})
        if selector := spec.get("selector", spec.get("podSelector")):
            wanted = selector.get("matchLabels", selector)
            assert any(wanted.items() <= there.items() for there in labels)
    assert {r["metadata"]["name"] for r in RESOURCES if r["kind"] == "NetworkPolicy"} == {
        template["metadata"]["labels"]["app.kubernetes.io/name"] for template in TEMPLATES.values()
    }
    budgets = {r["metadata"]["name"] for r in RESOURCES if r["kind"] == "PodDisruptionBudget"}
    assert budgets == {"api", WORKER}


def test_an_upgrade_leaves_the_workers_of_the_old_version_as_they_are() -> None:
    """To apply the files of another version makes other resources, and so changes none of these; and neither
    version's Deployment, budget or scaling takes the pods of the other."""
    named = {(r["kind"], r["metadata"]["name"]) for r in RESOURCES}
    assert named >= OF_VERSION
    of_version = {"app.kubernetes.io/name": "worker", "rpr-cusps/solver-version": SOLVER_VERSION}
    assert TEMPLATES[WORKER]["metadata"]["labels"] == of_version
    for kind in ("Deployment", "PodDisruptionBudget"):
        assert get(kind, WORKER)["spec"]["selector"]["matchLabels"] == of_version
    shared = [r for r in RESOURCES if (r["kind"], r["metadata"]["name"]) not in OF_VERSION]
    assert not [r for r in shared if "solver-version" in str(r)], (
        "these are replaced by those of a new version"
    )
    for policy in (r for r in RESOURCES if r["kind"] == "NetworkPolicy"):
        assert policy["spec"]["podSelector"]["matchLabels"].keys() == {"app.kubernetes.io/name"}, (
            "of all versions"
        )
    assert not any(labels.get("includeSelectors") for labels in KUSTOMIZATION["labels"])
    said = (DOCS / "operating.md").read_text()
    commands = re.findall(r"kubectl -n rpr-cusps delete (\S+) worker-", said)
    assert [set(words.split(",")) for words in commands] == [{kind.lower() for kind, _ in OF_VERSION}]
    assert f"deploy/{WORKER}" in (FOLDER / "kustomization.yaml").read_text()


def test_the_workers_scale_with_the_lists_of_the_queue() -> None:
    triggers = get("ScaledObject", WORKER)["spec"]["triggers"]
    lanes = [queue.key for queue in ChunkQueue(Redis(), WorkerSettings()).queues.values()]
    assert [trigger["metadata"]["listName"] for trigger in triggers] == lanes
    assert {t["authenticationRef"]["name"] for t in triggers} == {"redis"}
    assert get("TriggerAuthentication", "redis")["spec"]["secretTargetRef"][0]["name"] == "rpr-cusps-redis"
    assert get("ScaledObject", WORKER)["spec"]["scaleTargetRef"]["name"] == WORKER
    assert "replicas" not in get("Deployment", WORKER)["spec"], "KEDA sets it"
