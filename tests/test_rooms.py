"""The plan of the house: which room may import which, and what the solver may not know."""

import ast
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]

SOLVER = "rpr_solver"
MAY_IMPORT = {
    # rpr_solver: pure mathematics
    "rpr_solver.errors": "",
    "rpr_solver.notebook": "errors",
    "rpr_solver.contract": "errors",
    "rpr_solver.boxes": "errors",
    "rpr_solver.verify": "errors contract boxes",
    "rpr_solver.exact": "errors contract",
    "rpr_solver.triangles": "errors contract exact",
    "rpr_solver.legs": "exact",
    "rpr_solver.model": "errors contract notebook exact triangles legs",
    "rpr_solver.slices": "errors contract notebook boxes exact triangles legs model",
    "rpr_solver.transitions": "errors contract notebook exact triangles model slices singular",
    "rpr_solver.singular": "errors contract notebook exact triangles model slices",
    "rpr_solver.margins": "errors contract notebook boxes exact triangles legs model slices transitions",
    "rpr_solver.article": "errors contract notebook exact triangles model slices",
    "rpr_solver.curves": "errors contract notebook boxes exact triangles model slices transitions",
    "rpr_solver.paths": "errors contract notebook boxes exact triangles legs model slices "
    "transitions singular",
    "rpr_solver.designs": "errors contract notebook exact triangles model slices transitions margins paths",
    "rpr_solver.modes": "errors contract notebook boxes exact triangles legs model slices "
    "transitions singular margins paths",
    "rpr_solver.along": "errors contract notebook exact triangles model slices singular paths modes",
    "rpr_solver.workspaces": "errors contract notebook exact triangles model",
    "rpr_solver.sensed": "errors contract notebook exact triangles model workspaces",
    "rpr_solver.exports": "contract errors notebook exact triangles model slices paths",
    "rpr_solver.figures": "errors contract notebook triangles",
    "rpr_solver": "errors contract notebook figures exact triangles model slices transitions "
    "margins article curves paths modes along workspaces sensed designs singular verify exports",
    # worker: jobs in Redis, and the processes that compute
    "worker.logs": "",
    "worker.tracing": "",
    "worker.limits": "",
    "worker.settings": "rpr_solver worker.limits worker.logs",
    "worker.connection": "worker.settings",
    "worker.lua": "",
    "worker.jobs": "rpr_solver worker.settings worker.connection worker.logs worker.tracing worker.lua "
    "worker.answers",
    "worker.answers": "rpr_solver worker.settings worker.lua",
    "worker.process": "rpr_solver worker.settings worker.connection worker.logs worker.tracing worker.jobs "
    "worker.answers",
    "worker.__main__": "rpr_solver worker.settings worker.logs worker.jobs worker.process",
    "worker": "",
    # service: faces people and programs
    "service.errors": "",
    "service.commit": "",
    "service.schemas": "rpr_solver worker.limits worker.settings worker.answers",
    "service.webhooks": "rpr_solver worker service",
    "service.api": "rpr_solver worker service service.commit service.schemas service.webhooks",
    "service.openapi_yaml": "service.api service.schemas",
    "service.stack": "rpr_solver worker service service.errors service.schemas service.api service.webhooks",
    "service.client": "rpr_solver service.errors service.schemas",
    "service.cli": "rpr_solver worker service service.errors service.commit service.schemas service.client "
    "service.stack service.api service.webhooks",
    "service.__main__": "service.cli",
    "service": "rpr_solver",
}
"""Room → the rooms it may import; inside ``rpr_solver`` without the prefix."""

FORBIDDEN = {
    "redis",
    "rq",
    "fastapi",
    "starlette",
    "uvicorn",
    "httpx",
    "pydantic",
    "time",
    "datetime",
    "socket",
}
"""What ``rpr_solver`` never imports: no Redis, no web, no clock."""


def modules() -> Iterator[tuple[str, Path]]:
    for package in ("rpr_solver", "worker", "service"):
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), path


FILES = dict(modules())


def room_of(module: str) -> str:
    """The room in which a module stands: the longest name in the plan that holds it."""
    parts = module.split(".")
    return next(name for n in (2, 1) if (name := ".".join(parts[:n])) in MAY_IMPORT)


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def statements(tree: ast.AST) -> Iterator[ast.stmt]:
    """All statements of a module; most of a tree are expressions, which hold none."""
    for part in ast.iter_child_nodes(tree):
        if isinstance(part, ast.stmt):
            yield part
        if isinstance(part, (ast.stmt, ast.ExceptHandler, ast.match_case)):
            yield from statements(part)


@cache
def imported(path: Path) -> frozenset[str]:
    """Every module that a file names, those inside functions too."""
    named: set[str] = set()
    for node in statements(tree_of(path)):
        if isinstance(node, ast.Import):
            named |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            submodules = {f"{base}.{alias.name}" for alias in node.names} & FILES.keys()
            named |= submodules or {base}
    return frozenset(named)


def test_a_module_imports_only_what_its_room_may() -> None:
    trespasses = []
    for module, path in FILES.items():
        room = room_of(module)
        names = MAY_IMPORT[room].split()
        allowed = {f"{SOLVER}.{name}" for name in names} if room.startswith(SOLVER) else set(names)
        allowed |= {room}
        wider = {name for name in allowed if name in ("rpr_solver", "worker")} - {room.split(".")[0]}
        for name in sorted(imported(path)):
            if name.split(".")[0] in ("rpr_solver", "worker", "service"):
                other = room_of(name)
                if other not in allowed and other.split(".")[0] not in wider:
                    trespasses.append(f"{module} imports {name}")
    assert trespasses == []


def test_no_circles() -> None:
    arrows = {
        module: {name for name in imported(path) if name in FILES and name != module}
        for module, path in FILES.items()
    }
    done: set[str] = set()

    def visit(module: str, way: tuple[str, ...]) -> None:
        assert module not in way, " → ".join((*way[way.index(module) :], module))
        if module not in done:
            for other in arrows[module]:
                visit(other, (*way, module))
            done.add(module)

    for module in arrows:
        visit(module, ())


def packages_of(room: str) -> dict[str, set[str]]:
    """Module of a room → the packages that it imports."""
    modules = {module: path for module, path in FILES.items() if module.startswith(room)}
    assert modules
    return {module: {name.split(".")[0] for name in imported(path)} for module, path in modules.items()}


def test_the_solver_knows_no_redis_no_web_and_no_clock() -> None:
    known = {module: packages & FORBIDDEN for module, packages in packages_of(SOLVER).items()}
    assert {module: names for module, names in known.items() if names} == {}


def test_the_verifier_uses_balls_and_the_standard_library_alone() -> None:
    own = {SOLVER, "flint", "numpy"} | sys.stdlib_module_names
    others = {module: packages - own for module, packages in packages_of(f"{SOLVER}.verify.").items()}
    assert {module: names for module, names in others.items() if names} == {}
