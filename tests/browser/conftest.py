"""A real browser, and a real service for it: Debian's Chromium, an embedded Valkey and a worker.

One of each is shared by all tests of this package. The fixtures end with the package, not with the session,
since Playwright's event loop would otherwise be in the way of other tests of the process.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, until
from tests.support.service_server import serving
from tests.support.template import starts_forked
from worker.process.pool import WorkerPool

CHROMIUM = next(
    filter(None, map(shutil.which, (os.environ.get("CHROMIUM", "chromium-headless-shell"), "chromium"))), None
)
OPTIONS = (
    "--no-sandbox",  # which root cannot have
    "--disable-gpu",
    "--disable-3d-apis",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-extensions",
    "--disable-site-isolation-trials",  # fewer processes
    "--renderer-process-limit=1",
    "--no-first-run",
)
AXE = (Path(__file__).parent / "axe" / "axe.min.js").read_text(encoding="utf-8")
RULES = {"type": "tag", "values": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]}


WEBGL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""In place of what disables it: WebGL without a graphics processor."""


@pytest.fixture(scope="package")
def playwright() -> Iterator[Any]:
    if CHROMIUM is None:
        pytest.skip("no Chromium: apt-get install chromium-headless-shell, or name it in CHROMIUM")
    sync_api = pytest.importorskip("playwright.sync_api", reason="no Playwright: pip install -e '.[test]'")
    sync_api.expect.set_options(timeout=1000 * PATIENCE)
    with sync_api.sync_playwright() as playwright:
        yield playwright


@contextmanager
def _launched(playwright: Any, options: tuple[str, ...]) -> Iterator[Any]:
    chromium = playwright.chromium.launch(
        executable_path=CHROMIUM, args=list(options), timeout=1000 * PATIENCE
    )
    yield chromium
    chromium.close()


@pytest.fixture(scope="package")
def browser(playwright: Any) -> Iterator[Any]:
    """It has no WebGL."""
    with _launched(playwright, OPTIONS) as chromium:
        yield chromium


@pytest.fixture(scope="package")
def webgl_browser(playwright: Any) -> Iterator[Any]:
    """Another one, with WebGL by software."""
    options = tuple(option for option in OPTIONS if option not in {"--disable-gpu", "--disable-3d-apis"})
    with _launched(playwright, (*options, *WEBGL)) as chromium:
        yield chromium


@pytest.fixture(scope="package")
def valkey(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmbeddedValkey]:
    with EmbeddedValkey(tmp_path_factory.mktemp("valkey")) as server:
        yield server


@pytest.fixture(scope="package")
def base_url(valkey: EmbeddedValkey, browser: Any) -> Iterator[str]:  # noqa: ARG001
    """A service with a worker."""
    pool = WorkerPool(1, valkey.url)
    with starts_forked():
        pool.start()
    try:
        until(pool.is_ready)
        with serving(Settings(redis_url=valkey.url, require_keys="never")) as url:
            yield url
    finally:
        pool.stop()


@pytest.fixture
def idle_url(valkey: EmbeddedValkey, browser: Any) -> Iterator[str]:  # noqa: ARG001
    """A service whose queue nobody works on."""
    with serving(Settings(redis_url=f"{valkey.url}?db=1")) as url:
        yield url


@pytest.fixture(scope="package")
def profile(browser: Any) -> Iterator[Any]:
    """A profile of the browser that tests share, with its cache."""
    with _profile(browser) as context:
        yield context


@contextmanager
def _profile(browser: Any, **options: Any) -> Iterator[Any]:
    """A profile where nothing plays by itself, at sixty pictures a second, unless it is asked for."""
    usual = {"viewport": {"width": 1280, "height": 900}, "reduced_motion": "reduce"}
    context = browser.new_context(**{**usual, **options})
    context.set_default_timeout(1000 * PATIENCE)
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    yield context
    context.close()


@pytest.fixture(scope="package")
def shared_page(profile: Any) -> Any:
    """A page that tests share: each new one is a new process."""
    return profile.new_page()


@pytest.fixture
def open_page(browser: Any, shared_page: Any, request: pytest.FixtureRequest) -> Iterator[Callable[..., Any]]:
    """Opens a page, in a profile of its own if it has options or is to have WebGL.

    Whatever it complains of fails the test, unless it contains what is `expected`.
    """
    complaints: list[str] = []
    with ExitStack() as opened:

        def open_it(url: str, *, expected: str = "", has_webgl: bool = False, **options: Any) -> Any:
            if options or has_webgl:
                own = request.getfixturevalue("webgl_browser") if has_webgl else browser
                page = opened.enter_context(_profile(own, **options)).new_page()
                opened.callback(page.close)
            else:
                page = shared_page
                opened.callback(page.goto, "about:blank")
                opened.callback(page.unroute_all)

            def complain(text: str) -> None:
                if not expected or expected not in text:
                    complaints.append(text)

            listeners = {
                "console": lambda message: message.type == "error" and complain(message.text),
                "pageerror": lambda error: complain(str(error)),
            }
            for event, listener in listeners.items():
                page.on(event, listener)
                opened.callback(page.remove_listener, event, listener)
            answer = page.goto(url)
            assert answer is None or answer.ok, answer.text()  # rather than wait for what cannot come
            return page

        yield open_it
    assert complaints == []


@pytest.fixture
def photograph() -> Callable[[Any, str], None]:
    """Keeps a screenshot of a whole page in the folder that SCREENSHOTS names, if it does."""
    if "SCREENSHOTS" not in os.environ:
        return lambda *_: None
    folder = Path(os.environ["SCREENSHOTS"])
    folder.mkdir(parents=True, exist_ok=True)
    return lambda page, name: page.screenshot(path=folder / f"{name}.png", full_page=True)


EACH_TIME = {"api-dark", "bad-input", "first-visit", "loop", "merging", "path", "phone", "refuted", "space"}
"""The states of the page that axe inspects each time; all others with `--long`."""


@pytest.fixture
def inspect(
    photograph: Callable[[Any, str], None], pytestconfig: pytest.Config
) -> Callable[[Any, str], None]:
    """Keeps a screenshot of a page, if asked for, and asserts that axe finds no fault with it."""

    def inspected(page: Any, name: str) -> None:
        photograph(page, name)
        if name not in EACH_TIME and not pytestconfig.getoption("--long"):
            return
        page.evaluate(AXE)
        found = page.evaluate(
            "rules => axe.run(document, {runOnly: rules, resultTypes: ['violations']})", RULES
        )
        faults = [
            (rule["id"], rule["help"], [node["html"][:200] for node in rule["nodes"]])
            for rule in found["violations"]
        ]
        assert faults == [], faults
        assert found["passes"]

    return inspected
