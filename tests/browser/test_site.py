"""The site of the pages in a browser: a search leads to its page, and everybody can read it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

import pytest

from docs import build_site
from tests.browser.test_explorer import expect

pytestmark = pytest.mark.long

SEARCHES = {
    "tolerance": "margins",
    "equilateral": "symmetric-machines",
    "MATLAB": "matlab",
    "all solutions": "poses-along-a-leg",
    "batch": "batches",
    "workspace": "workspace",
    "ROS 2": "ros2",
}
"""What people type, and the page that it is about."""


class Handler(SimpleHTTPRequestHandler):
    """Sends files, and writes no log."""

    def log_message(self, format: str, *args: object) -> None: ...


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of the site, which a server of this process sends."""
    pytest.importorskip("sphinx", reason="needs the extra `docs`")
    folder = tmp_path_factory.mktemp("site")
    assert build_site.main([str(folder)]) == 0
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=folder)) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.mark.parametrize("typed", SEARCHES)
def test_a_search_leads_to_its_page_first(site: str, open_page: Callable[..., Any], typed: str) -> None:
    page = open_page(f"{site}/search.html?q={typed.replace(' ', '+')}")
    expect(page.locator("#search-results p.search-summary")).to_contain_text("Search finished")
    first = page.locator("#search-results ul.search li > a").first
    assert (first.get_attribute("href") or "").startswith(f"{SEARCHES[typed]}.html")


@pytest.mark.parametrize("name", ["index", "first-table", "paths", "mathematics", "reference"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_have_no_barrier(
    site: str, open_page: Callable[..., Any], inspect: Callable[[Any, str], None], name: str, scheme: str
) -> None:
    page = open_page(f"{site}/{name}.html", color_scheme=scheme)
    inspect(page, f"{name}, {scheme}")
