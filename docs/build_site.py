"""Builds the site of these pages with Sphinx, warnings being errors, and checks every link in it.

python docs/build_site.py           into build/site
python docs/build_site.py FOLDER    into another folder
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

DOCS = Path(__file__).parent
SPHINX = [sys.executable, "-m", "sphinx", "--fail-on-warning", "--keep-going", "--quiet", "--fresh-env"]


@dataclass
class Page(HTMLParser):
    """What a page has that others can point to, and what it points to itself."""

    path: Path
    anchors: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)
    assets: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()
        self.feed(self.path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the anchors and addresses of one tag."""
        given = {name: value for name, value in attrs if value}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        elif tag == "link" and "href" in given and given.get("rel") != "canonical":
            self.assets.append(given["href"])
        elif "src" in given:
            self.assets.append(given["src"])


OPENED = {'<p class="caption" role="heading">': '<p class="caption" role="heading" aria-level="2">'}
OPENED |= {"<pre>": '<pre tabindex="0">'}
OPENED |= {'<aside class="sidebar-drawer">': '<aside class="sidebar-drawer" aria-label="Pages">'}
"""What the theme leaves out for those who use no mouse: levels of headings, names, blocks that scroll."""


def build(site: Path) -> None:
    """Build the site; every warning is an error."""
    subprocess.run([*SPHINX, "-b", "html", "-d", str(site) + ".doctrees", str(DOCS), str(site)], check=True)
    for path in site.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        for tag, complete in OPENED.items():
            text = text.replace(tag, complete)
        path.write_text(text, encoding="utf-8")


def faults(site: Path) -> Iterator[str]:
    """Yields every link that leads nowhere, and every asset that is not in the site."""
    pages = {path: Page(path) for path in sorted(site.resolve().rglob("*.html"))}
    for path, page in pages.items():
        for address in page.assets:
            if urlsplit(address).scheme or address.startswith("//"):
                yield f"{path.name}: {address} is loaded from outside"
        for address in page.links + page.assets:
            parts = urlsplit(address)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchors = pages[target].anchors if target in pages else set()
            if not target.is_file():
                yield f"{path.name}: {address} leads nowhere"
            elif parts.fragment and unquote(parts.fragment) not in anchors:
                yield f"{path.name}: {address} has no such anchor"


def main(argv: list[str] | None = None) -> int:
    """Build the site and check its links; exit 1 with what is wrong."""
    parser = argparse.ArgumentParser(prog="python docs/build_site.py", description=main.__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=DOCS.parent / "build" / "site")
    site = parser.parse_args(argv).folder
    try:
        build(site)
    except subprocess.CalledProcessError as error:
        return int(error.returncode)
    wrong = list(faults(site))
    print(*wrong, sep="\n", file=sys.stderr, end="\n" if wrong else "")
    print(f"{site / 'index.html'}: {len(wrong)} broken links")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
