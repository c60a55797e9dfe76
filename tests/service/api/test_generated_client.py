"""Clients that others generate from openapi.yaml."""

from __future__ import annotations

import importlib
import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from service.api.app import create_app
from service.openapi_yaml import FILE
from tests.support.contract import parts
from tests.support.processes import ROOT, completed, environment
from tests.support.service_server import GEOMETRY

NAMES = {"post_cusp_table", "post_census", "post_cusp_curves", "post_check", "post_poses", "get_job"}


def test_every_alternative_in_a_schema_has_a_type() -> None:
    schemas = create_app().openapi()["components"]["schemas"]
    alternatives = [
        choice
        for part in parts(schemas)
        for name in ("oneOf", "anyOf", "allOf")
        for choice in part.get(name, ())
    ]
    assert len(alternatives) > 20
    known = {
        "type",
        "$ref",
        "required",
        "if",
        "properties",
    }  # or conditions on members
    assert [choice for choice in alternatives if not known & choice.keys()] == []
    assert [part for part in parts(schemas) if "not" in part] == []


def test_a_key_is_optional_in_the_contract() -> None:
    """It is said once: what an operation says itself, generators take for a key that it needs."""
    contract = create_app().openapi()
    assert contract["security"] == [{}, {"key": []}]
    own = {
        str(operation.get("security")) for path in contract["paths"].values() for operation in path.values()
    }
    assert own == {"None", "[]"}


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder = tmp_path_factory.mktemp("generated")
    made = subprocess.run(
        [
            *(sys.executable, "-m", "openapi_python_client", "generate", "--meta", "none"),
            *("--path", str(FILE), "--output-path", str(folder / "rpr_cusps_generated")),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert made.returncode == 0, made.stdout + made.stderr
    assert "will not be generated" not in made.stdout + made.stderr
    sys.path.insert(0, str(folder))
    try:
        yield "rpr_cusps_generated"
    finally:
        sys.path.remove(str(folder))


@pytest.mark.long
def test_a_generated_client_gets_a_table(generated: str, base_url: str) -> None:
    def of(name: str) -> Any:
        return importlib.import_module(f"{generated}.{name}")

    made = {path.stem for path in Path(of("api").__file__).parent.glob("*/*.py")}
    assert made >= NAMES
    models = of("models")
    question = models.CuspTableRequest.from_dict({"geometry": GEOMETRY, "l1": 14.98, "digits": 15})
    with of("client").Client(base_url=base_url) as client:
        post = of("api.questions.post_cusp_table")
        table = post.sync(client=client, body=question, prefer="wait=30")
        assert isinstance(table, models.CuspTable)
        assert [found.count for found in table.slices] == [6]
        triangles = {
            "base": {"points": [[0, 0], [15.91, 0], [0, 10]]},
            "platform": {"sides": [17.04, "16.54", "10.42*sqrt(4)"]},
        }
        by_triangles = models.CuspTableRequest.from_dict({**question.to_dict(), "geometry": triangles})
        assert isinstance(by_triangles.geometry, models.TwoTriangles)
        same = post.sync(client=client, body=by_triangles, prefer="wait=30")
        assert same == table
        assert isinstance(same.geometry, models.GeometryText)
        question.digits = 5
        problem = post.sync(client=client, body=question)
        assert isinstance(problem, models.Problem)
        assert [error.field for error in problem.errors] == ["digits"]
        question.digits = 15
        items = [models.BatchItem.from_dict({"kind": "cusp-table", "request": question.to_dict()})]
        batch = of("api.batches.post_batch").sync(client=client, body=models.BatchRequest(items=items))
        get = of("api.batches.get_results")
        [line] = get.sync(batch.id, client=client, format_=models.Format.JSON, prefer="wait=60")
        assert isinstance(line, models.BatchResult)
        assert (line.index, line.kind, line.status) == (0, "cusp-table", "succeeded")
        assert of("api.batches.get_batch").sync(batch.id, client=client).succeeded == 1


@pytest.fixture(scope="module")
def typescript(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the generator and its types of the contract; skips where it cannot be installed."""
    npm = shutil.which("npm")
    if npm is None or shutil.which("node") is None:
        pytest.skip("Node.js and npm are not installed here")
    folder = tmp_path_factory.mktemp("typescript") / "client"
    shutil.copytree(ROOT / "tests" / "data" / "typescript", folder)
    quick = ("--fetch-retries=1", "--fetch-timeout=20000", "--no-audit", "--no-fund")
    try:
        installed = ran(folder, npm, "ci", *quick)
    except subprocess.TimeoutExpired:
        pytest.skip("npm installs nothing here: no answer in time")
    if installed.returncode:
        pytest.skip(f"npm installs nothing here: {installed.stderr.strip()[-300:]}")
    made = ran(
        *(folder, str(folder / "node_modules/.bin/openapi-typescript"), str(FILE)),
        *("--default-non-nullable=false", "--output=contract.d.ts"),
    )
    assert made.returncode == 0, made.stdout + made.stderr
    return folder


def ran(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    """Returns the outcome of a command in a folder."""
    return completed(command, environment(), cwd=folder, patience=150)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_generated_client_in_typescript_gets_a_table(typescript: Path, base_url: str) -> None:
    compiled = ran(typescript, str(typescript / "node_modules/.bin/tsc"), "--project", ".")
    assert compiled.returncode == 0, compiled.stdout
    done = ran(typescript, "node", "out/table.js", base_url)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"counts": [6], "first": "0.845282018280357", "fields": ["digits"]}
