"""Settings that all tests share."""

import compileall
import gc
import os
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from _pytest.assertion import rewrite
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

from worker.process.processes import usable_cores

# Hundreds of processes would otherwise compile the project anew, each for itself.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Tests trust no authority but their own. To read all of them takes 30 ms for each client of HTTP.
os.environ["SSL_CERT_DIR"] = str(Path(__file__).parent)
os.environ.pop("SSL_CERT_FILE", None)

EXPENSIVE = {
    *("curves", "transitions", "article", "paths", "margins", "figures", "cli", "api", "test_design"),
    *("test_golden", "test_docs", "test_client", "test_documents", "test_constraints", "test_properties"),
    *("test_degenerate", "test_aspects", "test_eliminant", "test_classify", "test_cusp_table", "test_scan"),
    *("test_forgeries", "test_censuses", "test_checks", "test_cusps", "test_events", "test_tables"),
    *("test_curves", "test_chains", "test_biform", "test_pose_table", "test_questions", "test_logs"),
    *("test_start", "test_toy", "test_public_api", "test_exclusion", "test_regions", "test_paths"),
    *("test_singular_curves", "test_shapes", "test_modes", "test_allowed", "test_frames", "test_verdicts"),
    *("test_shared_joints", "test_irrational_exports", "test_irrational_start", "test_irrational_curves"),
    *("test_figure", "test_figures", "test_connections", "test_extremes", "test_designs", "test_orders"),
    *("test_finding", "test_equations", "test_programs", "test_leg_poses", "test_notebook", "test_margins"),
    *("test_fold_boxes", "test_learning", "test_cut_texts", "test_inventory", "test_workspace"),
    "test_thresholds",
}
"""Directories and files that the quick run leaves out: those that cost a second of processor time or more."""

CHEAP = {"test_strands", "test_words"}
"""Files in such directories that it has all the same, as it has tests marked `quick`, also of real
processes."""

NIGHTLY = {
    *(
        "test_docker",
        "test_kubernetes",
        "test_monitoring",
        "test_glossary",
        "test_wheel",
        "test_dependencies",
    ),
    *("test_examples", "test_release", "containers"),
}
"""Files and directories about packaging and operation: they run with `--long`, each night."""

SLOW = [HealthCheck.too_slow]
settings.register_profile("ci", deadline=None, max_examples=25, derandomize=True, suppress_health_check=SLOW)
settings.register_profile("more", settings.get_profile("ci"), max_examples=100)
settings.register_profile(
    "long", deadline=None, max_examples=1000, suppress_health_check=SLOW, print_blob=True
)
settings.load_profile("ci")

# Hypothesis would draw from the numbers in all our modules. To read them takes five seconds a process, and
# a new number anywhere would change the examples of every test.
providers._get_local_constants = providers.Constants


def pytest_configure(config: pytest.Config) -> None:
    gc.disable()  # what is collected is no garbage; searching it again and again is a tenth of the collection
    if config.getoption("--long") and config.getoption("--hypothesis-profile") is None:
        settings.load_profile("more")
    if config.getoption("--processor-time"):
        config.pluginmanager.register(import_module("tests.support.processor_time"))
    if not hasattr(config, "workerinput"):  # once, before the processes that run the tests
        for package in ("rpr_solver", "worker", "service"):
            compileall.compile_dir(Path(__file__).parents[1] / package, quiet=1)
        if config.getoption("numprocesses", None) and config.getoption("assertmode") == "rewrite":
            rewrite_tests(config)


def rewrite_tests(config: pytest.Config) -> None:
    """Rewrites the assertions of all tests, a share on each core.

    In a fresh checkout each process that runs tests would do all of it, at the same time as the others.
    """
    tests = sorted({*Path(__file__).parent.rglob("test_*.py"), *Path(__file__).parent.rglob("conftest.py")})
    share = usable_cores()
    children = []
    for first in range(share):
        if child := os.fork():
            children.append(child)
            continue
        try:
            for path in tests[first::share]:
                folder = rewrite.get_cache_dir(path)
                rewritten = folder / f"{path.stem}{rewrite.PYC_TAIL}"
                if not rewritten.exists() or rewritten.stat().st_mtime <= path.stat().st_mtime:
                    rewrite.try_makedirs(folder)
                    source_hash, code = rewrite._rewrite_test(path, config)
                    rewrite._write_pyc(config.stash[rewrite.assertstate_key], code, source_hash, rewritten)
        finally:
            os._exit(0)  # what failed fails again where the test is collected, and says so
    for child in children:
        os.waitpid(child, 0)


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.set_threshold(20_000)  # from 700: a syntax tree, for one, takes less than half the time
    gc.enable()


def pytest_report_header(config: pytest.Config) -> str | None:
    return None if config.getoption("--long") else "tests marked long are left out; --long runs them, too"


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Two processes a core for `-n auto`, since many tests wait for other processes; four at most."""
    return min(2 * usable_cores(), 4)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """A process without work takes some from another; `--dist` names another way."""
    if config.getoption("dist") != "load":
        return None
    from xdist.scheduler import WorkStealingScheduling

    return WorkStealingScheduling(config, log)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--long", action="store_true", help="run the tests marked long too")
    parser.addoption("--processor-time", action="store_true", help="say what each test and file costs")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        if not NIGHTLY.isdisjoint({*item.path.parts, item.path.stem}):
            item.add_marker(pytest.mark.long)
    if not config.getoption("--long"):  # left out, rather than skipped, which costs 4 ms each
        config.hook.pytest_deselected(items=[item for item in items if item.get_closest_marker("long")])
        items[:] = [item for item in items if not item.get_closest_marker("long")]
    for item in items:
        if item.get_closest_marker("long") and item.get_closest_marker("timeout") is None:
            item.add_marker(pytest.mark.timeout(0))
        is_expensive = item.path.stem not in CHEAP and not EXPENSIVE.isdisjoint(
            {*item.path.parts, item.path.stem}
        )
        if (is_expensive or uses_processes(item)) and item.get_closest_marker("quick") is None:
            item.add_marker(pytest.mark.slow)


def uses_processes(item: pytest.Item) -> bool:
    """Whether a test depends on when the system lets other processes run."""
    return not {"faults", "integration", "stack", "process", "browser"}.isdisjoint(item.path.parts) or (
        "valkey" in getattr(item, "fixturenames", ())
    )
