"""The explorer in a real browser: how soon the first picture is there, how many there are while one drags.

    python -m benchmarks.explorer

Starts the real stack with a worker per core, and Chromium without a screen on the same computer, which draws
by software. A picture is a whole slice: singular curves, regions, aspects and cusps of a geometry that nobody
has asked for before, or of a known geometry at a new length, or at a length whose answer the service has.

The slides are of a manipulator that the service has not seen before, after a second in which the page asks
ahead. Of how many pictures the slice is the one that the slider names while it is drawn is told, and how much
later the others come than their length was named.

While the joint vector is dragged, a picture is one of all its poses, which the page computes by itself.

The joint space in three dimensions is opened and turned in a window of 1024 × 640 pixels, drawn by WebGL
without a graphics processor: of the first example, and of a manipulator that the service has not seen before.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import shutil
import statistics
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

from benchmarks.stack import GEOMETRY, Stack, serving

OPENINGS = 5
SECONDS = 4.0
RATE = 60.0
"""How often something moves in a second, as a screen shows it."""
PREPARATION = 1.0
"""Seconds between the focus on the slider and its first move."""
FRESH = "#g=15.93,0.01,10.02,17.05,16.55,20.81,ccw&l1=27"
WATCH = """() => {
  [window.named, window.drawn] = [[], []];
  const slider = document.getElementById("l1-slider");
  const named = () => slider.getAttribute("aria-valuetext").split(",")[0].slice(5);
  slider.addEventListener("input", () => window.named.push([named(), performance.now()]));
  const shown = () => document.querySelector("#count span").textContent.slice(5, -2);
  new MutationObserver(() => window.drawn.push([shown(), performance.now(), shown() === named()]))
    .observe(document.body, { attributeFilter: ["data-pictures"] });
}"""
"""Notes each length that the slider names, and each that is drawn, and whether that is the one it names."""
FOLLOW = """() => {
  window.drawn = [];
  const outlines = document.querySelector("#mechanism-board .ghost");
  const note = () => window.drawn.push(outlines.getAttribute("d"));
  new MutationObserver(note).observe(outlines, { attributeFilter: ["d"] });
}"""
"""Notes the outlines of all poses but one, each time that they are drawn."""
OPTIONS = ("--no-sandbox", "--disable-dev-shm-usage", "--disable-background-networking")
FLAT, WEBGL = ("--disable-gpu",), ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
UNSEEN = "#g=15.95,0.02,10.05,17.06,16.57,20.83,ccw&l1=27"


@contextmanager
def browser(graphics: tuple[str, ...] = FLAT) -> Iterator[Any]:
    """Chromium, or the end of the program with a word."""
    from playwright.sync_api import sync_playwright

    path = shutil.which(os.environ.get("CHROMIUM", "chromium"))
    if path is None:
        raise SystemExit("no Chromium: apt-get install chromium, or name it in CHROMIUM")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=[*OPTIONS, *graphics])
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


def views(page: Any) -> int:
    """Returns how often a page has drawn the joint space in three dimensions."""
    return int(page.locator("#space-board").get_attribute("data-pictures"))


def drawn(
    page: Any, stack: Stack, move: Callable[[float], None], pictures: Callable[[Any], int] = pictures
) -> str:
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


def posing(page: Any) -> str:
    """Returns how the joint vector is dragged through regions with two and with four poses."""
    point = page.get_by_label("Joint vector")
    box = point.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.evaluate(FOLLOW)
    page.mouse.move(x, y)
    page.mouse.down()
    start = time.perf_counter()
    moves = 0
    while (seconds := time.perf_counter() - start) < SECONDS:
        page.mouse.move(x + 60 * math.sin(3 * seconds), y + 60 * (math.cos(3 * seconds) - 1))
        moves += 1
        time.sleep(max(0.0, start + moves / RATE - time.perf_counter()))
    page.mouse.up()
    return f"{len(set(page.evaluate('window.drawn'))) / seconds:.1f} pictures a second"


def sliding(page: Any, stack: Stack, key: str) -> tuple[str, Iterable[str]]:
    """Returns how the slider is moved by a key, and the lengths that it names."""
    page.wait_for_selector("#l1-slider:not([disabled])")
    page.locator("#l1-slider").focus()
    time.sleep(PREPARATION)
    page.evaluate(WATCH)
    found = drawn(page, stack, lambda _: page.keyboard.press(key))
    named, shown = dict(page.evaluate("window.named")), page.evaluate("window.drawn")
    late = [moment - named[length] for length, moment, is_now in shown if not is_now and length in named]
    lag = f", the others {statistics.median(late):.0f} ms late" if late else ""
    exact = sum(is_now for *_, is_now in shown)
    return f"{found}; {exact} of {len(shown)} of the slice that is named{lag}", named


def rehearsed(stack: Stack, lengths: Iterable[str]) -> None:
    """Lets the service answer what the page asks in the next slide."""
    geometry = dict(zip((*GEOMETRY, "orientation"), FRESH[3:].partition("&")[0].split(","), strict=True))

    def ask(length: str) -> None:
        question = {"geometry": geometry, "l1": length, "digits": 15, "tolerance": "0.003"}
        headers = {"Content-Type": "application/json", "Prefer": "wait=10"}
        body = json.dumps(question).encode()
        urlopen(Request(f"{stack.url}/v1/singular-curves", body, headers)).close()

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(ask, lengths))


def space(chromium: Any, stack: Stack, state: str) -> str:
    """Returns how soon the joint space is there after a click, and how it is turned."""
    page = chromium.new_context(viewport={"width": 1024, "height": 640}).new_page()
    page.set_default_timeout(120_000)  # ms: others may use the computer, too
    page.goto(f"{stack.url}/{state}")
    page.wait_for_selector("#play:not([disabled])")
    start = time.perf_counter()
    page.locator("#view-space").check(force=True)
    page.wait_for_selector("#space-board[data-pictures]")
    first = time.perf_counter() - start
    page.wait_for_selector("#space-board[data-edges]:not([data-edges='0'])")
    whole = time.perf_counter() - start
    time.sleep(PREPARATION)
    box = page.locator("#space-board").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()

    def move(seconds: float) -> None:
        page.mouse.move(x + 100 * math.sin(2 * seconds), y + 30 * math.sin(3 * seconds))

    soon = f"first picture {first:.2f} s, cusp curves {whole:.2f} s after the click"
    return f"{soon}; {drawn(page, stack, move, views)}"


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
        fresh = f"{stack.url}/{FRESH}"
        page, _ = opened(chromium, fresh)
        found, lengths = sliding(page, stack, "ArrowLeft")
        print(f"L1 slides: {found}")
        rehearsed(stack, lengths)
        page, _ = opened(chromium, fresh)
        print(f"L1 slides, answers known to the service: {sliding(page, stack, 'ArrowLeft')[0]}")
        print(f"L1 slides back, answers known to the page: {sliding(page, stack, 'ArrowRight')[0]}")
        page, _ = opened(chromium, stack.url)
        print(f"L2 and L3 are dragged, all poses follow: {posing(page)}")
        page.locator("#mode-design").check()
        print(f"A3 is dragged, each time a new geometry: {dragging(page, stack)}")
    with serving() as stack, browser(WEBGL) as chromium:
        print(f"joint space of the first example: {space(chromium, stack, '')}")
        print(f"joint space of a manipulator not seen before: {space(chromium, stack, UNSEEN)}")


if __name__ == "__main__":
    main()
