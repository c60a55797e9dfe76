"""The kustomizations of docker/kubernetes: valid, contained, and in step with the code."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import warnings
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml
from redis import Redis

from rpr_solver import SOLVER_VERSION
from service.cli.serve import unknown_settings
from worker.jobs.chunks import ChunkQueue
from worker.settings import WorkerSettings

FOLDER = Path(__file__).parents[1] / "docker" / "kubernetes"
DOCS = Path(__file__).parents[1] / "docs"
VERSION = "1.31"
"""The oldest version of Kubernetes that gets fixes; what is valid there is valid in later ones."""

MISSING = "needs the extra `dev`"

Resource = dict[str, Any]


def listed(folder: Path) -> list[Path]:
    """What a kustomization names as its resources."""
    kustomization = yaml.safe_load((folder / "kustomization.yaml").read_text())
    return [(folder / name).resolve() for name in kustomization["resources"]]


def resources(folder: Path) -> Iterator[Resource]:
    """The resources as they are in the files."""
    for path in listed(folder):
        yield from resources(path) if path.is_dir() else yaml.safe_load_all(path.read_text())


RESOURCES = list(resources(FOLDER))
KUSTOMIZED = (".", "overlays/cluster", "overlays/two-versions")
COMPONENTS = sorted(path.name for path in (FOLDER / "components").iterdir())
needs_kubectl = pytest.mark.skipif(shutil.which("kubectl") is None, reason="needs kubectl")
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


@cache
def built(name: str) -> list[Resource]:
    """What `kubectl apply -k` sends; kubectl refuses members of a kustomization that it does not know."""
    command = ["kubectl", "kustomize", str(FOLDER / name)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return list(yaml.safe_load_all(done.stdout))


def validate(resource: Resource) -> None:
    """Against the schema of its kind, in which no other members are allowed."""
    _validate(json.dumps(resource))


@cache
def _validate(text: str) -> None:
    resource = json.loads(text)
    if resource["apiVersion"].startswith(("keda.sh/", "monitoring.coreos.com/")):
        keda = pytest.importorskip("cloudcoil.models.keda.v1alpha1", reason=MISSING)
        operator = pytest.importorskip("cloudcoil.models.prometheus_operator.v1", reason=MISSING)
        kind = getattr(keda, resource["kind"], None) or getattr(operator, resource["kind"])
        known = kind.model_validate(resource).model_dump(mode="json", by_alias=True, exclude_unset=True)
        assert known == resource
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the package's own imports
        validator = pytest.importorskip("kubernetes_validate", reason=MISSING)
        validator.validate(resource, VERSION, strict=True)


@pytest.mark.slow
@needs_kubectl
@pytest.mark.parametrize("name", KUSTOMIZED)
def test_all_that_is_applied_is_valid(name: str) -> None:
    resources = built(name)
    assert len({(r["kind"], r["metadata"]["name"]) for r in resources}) == len(resources) > 10
    for resource in resources:
        validate(resource)


@pytest.mark.slow
@needs_kubectl
def test_each_component_adds_what_it_says_to_the_rest(tmp_path: Path) -> None:
    found: dict[str, set[tuple[str, str]]] = {}
    for component in COMPONENTS:
        shutil.copytree(FOLDER, tmp_path / component)
        overlay = tmp_path / component / "overlays" / "one"
        overlay.mkdir()
        words = {"resources": ["../../base"], "components": [f"../../components/{component}"]}
        (overlay / "kustomization.yaml").write_text(yaml.safe_dump(words))
        resources = built(str(overlay))
        for resource in resources:
            validate(resource)
        before = {(r["kind"], r["metadata"]["name"]) for r in RESOURCES}
        found[component] = {(r["kind"], r["metadata"]["name"]) for r in resources} - before
        [settings] = [r["data"] for r in resources if r["kind"] == "ConfigMap"]
        assert not list(unknown_settings(settings))
        [api] = [r for r in resources if (r["kind"], r["metadata"]["name"]) == ("Deployment", "api")]
        assert ("replicas" in api["spec"]) is (component != "api-scaling")
        if component == "webhooks":
            assert settings["RPR_CUSPS_WEBHOOK_SECRET_FILE"] == "/run/secrets/webhooks/secrets"
            [container] = api["spec"]["template"]["spec"]["containers"]
            assert "/run/secrets/webhooks" in [mount["mountPath"] for mount in container["volumeMounts"]]
        if component == "scaling-by-age":
            [scaled] = [r for r in resources if r["kind"] == "ScaledObject"]
            assert [t["type"] for t in scaled["spec"]["triggers"]][-1] == "metrics-api"
            location = scaled["spec"]["triggers"][-1]["metadata"]["valueLocation"]
            assert location == 'rpr_cusps_queue_age_seconds{lane="small"}'
    assert found == {
        "api-scaling": {("HorizontalPodAutoscaler", "api")},
        "ingress": {("Ingress", "api")},
        "monitoring": {("ServiceMonitor", "api"), ("PrometheusRule", "rpr-cusps")},
        "scaling-by-age": {("TriggerAuthentication", "metrics")},
        "webhooks": {("NetworkPolicy", "api-webhooks")},
    }


def test_the_rules_of_the_operator_are_those_of_prometheus() -> None:
    rule = yaml.safe_load((FOLDER / "components" / "monitoring" / "rules.yaml").read_text())
    rules = yaml.safe_load((FOLDER.parent / "monitoring" / "rules.yaml").read_text())
    assert rule["spec"] == rules


@needs_kubectl
def test_the_workers_of_two_versions_stand_beside_each_other() -> None:
    """The old ones are the new ones with another version and image; nothing else is there twice."""
    once, twice = built("overlays/cluster"), built("overlays/two-versions")
    old = [r for r in twice if r not in once]
    assert {r["kind"] for r in old} == {kind for kind, _ in OF_VERSION}
    [image] = [
        r["spec"]["template"]["spec"]["containers"][0]["image"] for r in old if "template" in r["spec"]
    ]
    [version] = {r["metadata"]["name"].removeprefix("worker-") for r in old}
    assert version != SOLVER_VERSION
    for resource in built("."):
        if (resource["kind"], resource["metadata"]["name"]) in OF_VERSION:
            [other] = [r for r in old if r["kind"] == resource["kind"]]
            text = yaml.safe_dump({**other, "metadata": {"name": other["metadata"]["name"]}})
            for words in ("worker-{}", "rpr-cusps/solver-version: '{}'", "rq:queue:cusps-{}"):
                assert words.format(SOLVER_VERSION) not in text
                text = text.replace(words.format(version), words.format(SOLVER_VERSION))
            text = text.replace(image, "rpr-cusps:0.1.0")
            assert yaml.safe_load(text)["spec"] == resource["spec"]


@pytest.mark.slow
@pytest.mark.parametrize("resource", RESOURCES, ids=name)
def test_the_schemas_hold(resource: Resource) -> None:
    validate(resource)


def test_the_schemas_find_faults() -> None:
    validator = pytest.importorskip("kubernetes_validate", reason=MISSING)
    broken = {**get("Deployment", "api"), "spec": {"replicas": "two"}}
    with pytest.raises(validator.ValidationError):
        validate(broken)
    scaled = get("ScaledObject", WORKER)
    with pytest.raises(AssertionError):
        validate({**scaled, "spec": {**scaled["spec"], "maxReplicas": 3}})


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
    base = yaml.safe_load((FOLDER / "base" / "kustomization.yaml").read_text())
    assert not any(labels.get("includeSelectors") for labels in base["labels"])
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
