"""The explorer in a real browser: how soon the first picture is there, how many there are while one drags.

    python -m benchmarks.explorer

Starts the real stack with a worker per core, and Chromium without a screen on the same computer, which draws
by software. A picture is a whole slice: singular curves, regions, aspects and cusps of a geometry that nobody
has asked for before, or of a known geometry at a new length, or at a length whose answer the service has.
"""

from __future__ import annotations

import argparse
import math
import os
import shutil
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.stack import Stack, serving

OPENINGS = 5
SECONDS = 4.0
RATE = 60.0
"""How often something moves in a second, as a screen shows it."""
OPTIONS = ("--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-background-networking")


@contextmanager
def browser() -> Iterator[Any]:
    """Chromium, or the end of the program with a word."""
    from playwright.sync_api import sync_playwright

    path = shutil.which(os.environ.get("CHROMIUM", "chromium"))
    if path is None:
        raise SystemExit("no Chromium: apt-get install chromium, or name it in CHROMIUM")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=list(OPTIONS))
        yield chromium
        chromium.close()


def opened(chromium: Any, url: str) -> tuple[Any, float]:
    """Returns a page in a new profile, and the seconds until its picture was there."""
    page = chromium.new_context(viewport={"width": 1280, "height": 900}).new_page()
    start = time.perf_counter()
    page.goto(url)
    page.wait_for_selector("#slice:not(.stale) #legend li")
    page.wait_for_selector("body[data-pictures]")
    return page, time.perf_counter() - start


def pictures(page: Any) -> int:
    """Returns how many slices a page has drawn."""
    return int(page.locator("body").get_attribute("data-pictures"))


def processor_seconds(pid: int) -> float:
    """Returns the processor time of a process and its descendants, the dead ones among them."""
    parents, spent = {}, {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parents[int(path.parent.name)] = int(fields[1])
        spent[int(path.parent.name)] = sum(map(int, fields[11:15]))
    family = {pid}
    while more := {child for child, parent in parents.items() if parent in family} - family:
        family |= more
    return sum(spent.get(member, 0) for member in family) / os.sysconf("SC_CLK_TCK")


def drawn(page: Any, stack: Stack, move: Callable[[float], None]) -> str:
    """Returns what there is to say of the pictures that are drawn while something is moved."""
    metrics = page.context.new_cdp_session(page)
    metrics.send("Performance.enable")

    def busy() -> float:
        names = metrics.send("Performance.getMetrics")["metrics"]
        return next(float(entry["value"]) for entry in names if entry["name"] == "ProcessTime")

    before, in_page, in_service = pictures(page), busy(), processor_seconds(stack.pid)
    start = time.perf_counter()
    moves = 0
    while (seconds := time.perf_counter() - start) < SECONDS:
        move(seconds)
        moves += 1
        time.sleep(max(0.0, start + moves / RATE - time.perf_counter()))
    count = pictures(page) - before
    in_page, in_service = busy() - in_page, processor_seconds(stack.pid) - in_service
    share = f"{1000 * in_service / count:.0f} ms of the service, {1000 * in_page / count:.0f} ms of the page"
    return f"{count / seconds:.1f} pictures a second, each {share}"


def dragging(page: Any, stack: Stack) -> str:
    """Returns how A3 is dragged round a circle."""
    box = page.locator("[aria-label^='Base point A3']").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()

    def move(seconds: float) -> None:
        page.mouse.move(x + 25 * math.sin(3 * seconds), y + 25 * (math.cos(3 * seconds) - 1))

    found = drawn(page, stack, move)
    page.mouse.up()
    return found


def sliding(page: Any, stack: Stack, key: str) -> str:
    """Returns how the slider is moved by a key."""
    page.wait_for_selector("#l1-slider:not([disabled])")
    page.locator("#l1-slider").focus()
    return drawn(page, stack, lambda _: page.keyboard.press(key))


def rehearsed(page: Any) -> None:
    """Lets the service answer each length of the next slide, one after the other."""
    page.wait_for_selector("#l1-slider:not([disabled])")
    page.locator("#l1-slider").focus()
    for _ in range(int(SECONDS * RATE)):
        before = pictures(page)
        page.keyboard.press("ArrowLeft")
        while pictures(page) == before:
            time.sleep(0.005)


def main() -> None:
    """Print the table."""
    form = argparse.RawDescriptionHelpFormatter
    argparse.ArgumentParser(description=__doc__, formatter_class=form).parse_args()
    with serving() as stack, browser() as chromium:
        page, seconds = opened(chromium, stack.url)
        print(f"{os.cpu_count()} cores; first picture of a cold service: {seconds:.2f} s")
        page.wait_for_selector("#census:not(.stale)")
        times = [opened(chromium, stack.url)[1] for _ in range(OPENINGS)]
        print(f"first picture of a warm service, a browser without cache: {statistics.median(times):.2f} s")
        print(f"L1 slides: {sliding(page, stack, 'ArrowLeft')}")
        rehearsed(opened(chromium, stack.url)[0])
        page, _ = opened(chromium, stack.url)
        print(f"L1 slides, answers known to the service: {sliding(page, stack, 'ArrowLeft')}")
        print(f"L1 slides back, answers known to the page: {sliding(page, stack, 'ArrowRight')}")
        page, _ = opened(chromium, stack.url)
        print(f"A3 is dragged, each time a new geometry: {dragging(page, stack)}")


if __name__ == "__main__":
    main()
