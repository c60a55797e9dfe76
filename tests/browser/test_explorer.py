"""The explorer in a browser, as its users meet it."""

from __future__ import annotations

import importlib
import json
import re
import sys
import time
from collections.abc import Callable
from math import dist
from typing import Any

import httpx
import pytest

from rpr_solver import EXAMPLES
from service.api.keys import KeyStore, make_key
from service.api.routes.pages import FIRST_SLICES
from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.processes import PATIENCE, completed, environment
from tests.support.proxies import proxied
from tests.support.sampling import long
from tests.support.service_server import serving
from worker.connection import connect

INNOCENTI = "g=15.91,0,10,17.04,16.54,20.84,ccw"
SMALL = "g=2,0,1,3,2,4,ccw"
"""Of few digits, so that it is soon computed."""
Open = Callable[..., Any]
Inspect = Callable[[Any, str], None]


def expect(what: Any) -> Any:
    """Playwright's, which takes a second to load: not while tests are collected."""
    return importlib.import_module("playwright.sync_api").expect(what)


def count_is(page: Any, text: str) -> None:
    """Waits for a slice that is up to date."""
    expect(page.locator("#count")).to_have_text(text)
    expect(page.locator("#slice")).not_to_have_class(re.compile("stale"))


def open_tab(page: Any, name: str) -> None:
    page.get_by_role("tab", name=name, exact=True).click()


def middle(locator: Any) -> tuple[float, float]:
    box = locator.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_the_first_visit_shows_a_picture(base_url: str, open_page: Open, inspect: Inspect) -> None:
    page = open_page(base_url)
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#cusp-rows tr")).to_have_count(8)
    expect(page.get_by_role("listbox", name="Cusps").get_by_role("option")).to_have_count(8)
    expect(page.locator("#census-strip rect.bar")).to_have_count(23)
    expect(page.locator("#l1-slider")).to_have_attribute(
        "aria-valuetext", re.compile("^L1 = 27, 8 cusps, window 26.7")
    )
    assert page.url.endswith(f"#{INNOCENTI}&l1=27&c=A&v=joint")
    inspect(page, "first-visit")


def in_view(page: Any, *selectors: str) -> dict[str, dict[str, float]]:
    """The places of elements, all of which are seen whole."""
    size = page.viewport_size
    boxes = {selector: page.locator(selector).bounding_box() for selector in selectors}
    for selector, box in boxes.items():
        assert box, f"{selector} is not shown"
        assert min(box["x"], box["y"]) >= 0, (selector, box)
        assert box["x"] + box["width"] <= size["width"], (selector, box)
        assert box["y"] + box["height"] <= size["height"], (selector, box)
        assert page.locator(selector).evaluate(
            "node => { const {x, y, width, height} = node.getBoundingClientRect();"
            " return node.contains(document.elementFromPoint(x + width / 2, y + height / 2)); }"
        ), f"{selector} is covered"
    return boxes


def test_what_is_operated_and_the_boards_that_it_moves_are_in_view_together(
    base_url: str, open_page: Open
) -> None:
    """At a desk and on a phone, whatever tab is open and wherever it is scrolled to."""
    page = open_page(base_url, viewport={"width": 1440, "height": 900})
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#play")).to_be_enabled()
    controls = ("#l1-slider", "#census-strip", "#l1", "#play", "#scrubber")
    boards = {"mechanism": "#mechanism-board", "slice": "#slice-board"}
    for width, height, least in ((1440, 900, 450), (390, 844, 120)):
        page.set_viewport_size({"width": width, "height": height})
        places = in_view(page, *controls, *boards.values())
        assert all(min(places[board].values()) >= 0 for board in boards.values())
        assert all(places[board]["height"] >= least for board in boards.values())
        tabs = page.locator("#tabs [role=tab]").all()
        for tab in tabs if width < 640 else (tabs[0], tabs[-1]):
            tab.click()
            panel = page.locator(f"#{tab.get_attribute('aria-controls')}")
            assert panel.evaluate("node => (node.scrollTop = node.scrollHeight, node.clientHeight)") > 60
            assert in_view(page, *controls, *boards.values()) == places
        for name, other in (("mechanism", "slice"), ("slice", "mechanism")):
            if width > 640:
                continue  # where there is room for both, there is no choice
            page.locator(f"input[name=shown][value={name}]").check()
            in_view(page, *controls, boards[name])
            expect(page.locator(boards[other])).to_be_hidden()
    page.set_viewport_size({"width": 320, "height": 480})
    assert page.evaluate("document.documentElement.scrollWidth") <= 320
    rightmost = "nodes => Math.max(...nodes.map(node => node.getBoundingClientRect().right))"
    assert page.locator("#operate :is(button, input, label)").evaluate_all(rightmost) <= 320
    page.set_viewport_size({"width": 390, "height": 844})
    page.locator("input[name=shown][value=mechanism]").check()
    open_tab(page, "Limits")
    page.get_by_role("button", name="Draw in the picture").click()
    in_view(page, *controls, *boards.values())  # it asks for a drag there


def test_a_board_whose_room_changes_as_it_draws_fits_it(base_url: str, open_page: Open) -> None:
    """Drawing measures the room, so that a change of it is no news any more when the page is told of it."""
    page = open_page(base_url)
    count_is(page, "L1 = 27: 8 cusps")
    page.evaluate("""() => {
        document.getElementById("operate").style.paddingBottom = "60px";
        for (const id of ["mechanism-all", "zoom-all"]) document.getElementById(id).click();
    }""")
    for board in page.locator("#boards .board").all():
        height = board.evaluate("node => node.clientHeight")
        assert height < 900
        expect(board.locator("svg").first).to_have_js_property("clientHeight", height)


def test_numbers_of_outlines_keep_clear_of_the_names_of_joints(base_url: str, open_page: Open) -> None:
    """On a phone, where the outlines are small."""
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=28.1&c=A&v=joint", viewport={"width": 390, "height": 844})
    count_is(page, "L1 = 28.1: 10 cusps")
    numbers = page.locator("#mechanism-board .over text").filter(has_text=re.compile(r"^[12]$"))
    expect(numbers).to_have_count(2)
    names = page.locator("#mechanism-board .over text.name")
    places = "nodes => nodes.map(node => [node.x.baseVal[0].value, node.y.baseVal[0].value])"
    for number in numbers.evaluate_all(places):
        assert all(dist(number, name) > 15 for name in names.evaluate_all(places))


@pytest.mark.parametrize("names", [("zein-flat",), long(tuple(EXAMPLES))], ids=["one", "all"])
def test_each_example(base_url: str, open_page: Open, photograph: Inspect, names: tuple[str, ...]) -> None:
    assert FIRST_SLICES.keys() == EXAMPLES.keys()
    page = open_page(base_url)
    counts = {"zein-flat": 8, "twelve-cusps": 12, "fourteen-cusps": 14, "sixteen-cusps": 16}
    counts |= {"eighteen-cusps": 18, "innocenti": 8}
    for name in names:
        page.get_by_label("Example").select_option(name)
        count_is(page, f"L1 = {FIRST_SLICES[name]}: {counts[name]} cusps")
        expect(page.locator("#play")).to_be_enabled()
        photograph(page, name)


NAMES = """nodes => nodes.map(node => {
    const {left, right, top, bottom} = node.getBoundingClientRect();
    return {text: node.textContent, left, right, top, bottom};
})"""
RANDOM_NAMES = """async () => {
    const {namesOf} = await import("/static/explorer/axes.js");
    let seed = 1;
    const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
    return Array.from({length: 200}, () => {
        const count = 2 + Math.floor(17 * random());
        const middle = [random(), random()];
        const places = Array.from({length: count}, () => {
            const spread = random() < 0.5 ? 0.05 : 1;
            const at = (k) => middle[k] + spread * (random() - middle[k]);
            return {x: 60 + 360 * at(0), y: 15 + 400 * at(1)};
        });
        const letters = places.map((_, k) => String.fromCharCode(65 + k));
        const names = namesOf(places, letters, {left: 50, right: 430, top: 5, bottom: 425});
        return {count, names: names.map(({at, text, members}) => {
            const half = text.length * (text.length > 2 ? 3.8 : 4.75);
            const [x, y] = at;
            return {text, members, left: x - half, right: x + half, top: y - 7.5, bottom: y + 7.5};
        })};
    });
}"""


def apart(names: list[dict[str, Any]]) -> bool:
    """Whether no text lies on another one; those of lines have no room between them."""
    return not any(
        one["left"] < other["right"] - 1
        and other["left"] < one["right"] - 1
        and one["top"] + 3 < other["bottom"]
        and other["top"] + 3 < one["bottom"]
        for k, one in enumerate(names)
        for other in names[:k]
    )


def test_cusps_that_lie_together_have_one_name_and_part_under_the_glass(
    base_url: str, open_page: Open
) -> None:
    page = open_page(f"{base_url}/#g=10,16.73912,7.39002,23.66811,24.59925,5.45049,ccw&l1=14.46845")
    count_is(page, "L1 = 14.46845: 16 cusps")
    expect(page.locator("#play")).to_be_enabled()  # names are written anew with the loop
    names = page.locator("#slice-board .name").evaluate_all(NAMES)
    board = page.locator("#slice-board").bounding_box()
    assert apart(names)
    assert sum(len(name["text"].split(", ")) for name in names) == 16
    assert all(name["right"] <= board["x"] + board["width"] for name in names)
    group = page.get_by_role("button", name="Zoom in on cusps A, B, C")
    group.click()
    expect(group).to_have_count(0)
    boxes = [page.get_by_role("option", name=re.compile(f"^Cusp {letter}:")) for letter in "ABC"]
    heights = sorted(middle(box)[1] for box in boxes)
    assert heights[1] - heights[0] > 20
    assert heights[2] - heights[1] > 20
    for drawn in page.evaluate(RANDOM_NAMES):
        assert apart(drawn["names"])
        assert sorted(k for name in drawn["names"] for k in name["members"]) == list(range(drawn["count"]))


EIGHTEEN = "g=10,9.6358,2.6742,25.4175,50.2854,25.4175,ccw&l1=15.6431"
SPOTS = """nodes => Object.fromEntries(nodes.map(node => {
    const {left, right, top, bottom} = node.getBoundingClientRect();
    return [node.ariaLabel.slice(5).split(":")[0], [(left + right) / 2, (top + bottom) / 2]];
}))"""


@pytest.mark.long
def test_each_of_eighteen_cusps_parts_from_all_others_under_the_glass(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{EIGHTEEN}")
    count_is(page, "L1 = 15.6431: 18 cusps")
    groups = page.get_by_role("button", name=re.compile("^Zoom in on cusps"))
    parted: set[str] = set()
    todo: list[tuple[str, ...]] = [()]
    while todo:
        way = todo.pop()
        page.locator("#zoom-all").click()
        for name in way:
            page.get_by_role("button", name=name, exact=True).press("Enter")
        inner = [group.get_attribute("aria-label") for group in groups.all()]
        todo += [(*way, name) for name in inner if not way or len(name) < len(way[-1])]
        assert len(todo) < 20
        spots = page.locator("#slice-board [data-cusp]").evaluate_all(SPOTS)
        for label in page.locator("#slice-board .name").all_text_contents():
            if label in spots:
                assert min(dist(spots[label], spots[other]) for other in spots if other != label) >= 15
                parted.add(label)
    assert len(parted) == 18


def test_what_is_wrong_or_unknown_is_explained(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#g=15,91,0,10,17.04,16.54,20.84,ccw")
    expect(page.locator("#notice")).to_contain_text("has 8 parts")
    expect(page.locator("#notice")).to_contain_text("write points: 15.91, not 15,91")
    count_is(page, "L1 = 27: 8 cusps")
    page.locator("#mode-design").press("Space")
    page.locator("#l1").fill("28,1")
    expect(page.locator("#l1-error")).to_have_text("The comma is read as a decimal point: 28.1")
    count_is(page, "L1 = 28.1: 10 cusps")
    page.get_by_role("option", name=re.compile("^Cusp C")).hover()
    expect(page.locator("#tip")).to_have_text(re.compile("^Cusp C: L2 = "))
    page.locator("#census-strip").hover()
    expect(page.locator("#tip")).to_have_text(re.compile(r"^\d+ cusps for L1 from "))
    page.locator("#l1-slider").focus()
    page.get_by_label(re.compile("^Base point A2")).focus()
    expect(page.locator("#tip")).to_have_text("Base point A2, a2x = 15.91: drag it")
    open_tab(page, "Cusps")
    page.locator("#table").get_by_role("button", name="loop").click()
    expect(page.locator("#definition")).to_contain_text("Loop: ")
    expect(page).to_have_url(re.compile("l1=28.1"))
    page.go_back()
    count_is(page, "L1 = 27: 8 cusps")
    page.go_forward()
    count_is(page, "L1 = 28.1: 10 cusps")


def test_joint_limits_are_drawn_in_the_picture(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27")
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#play")).to_be_enabled()
    open_tab(page, "Limits")
    page.get_by_role("button", name="Draw in the picture").click()
    x, y = middle(page.get_by_role("option", name=re.compile("^Cusp B")))
    page.mouse.move(x - 20, y - 20)
    page.mouse.down()
    page.mouse.move(x + 20, y + 20, steps=3)
    page.mouse.up()
    expect(page.locator("#limits-count")).to_have_text(re.compile("[12] cusps? within the limits, of 8"))
    ends = [page.locator(f"#{end}").input_value() for end in ("l2-min", "l2-max", "l3-min", "l3-max")]
    assert float(ends[0]) < 12.5634 < float(ends[1])
    assert float(ends[2]) < 15.7132 < float(ends[3])
    expect(page).to_have_url(re.compile(re.escape(f"&b={','.join(ends)}")))
    page.get_by_role("button", name="Undo").click()
    expect(page.locator("#l2-min")).to_have_value("")


PLAYED = """() => {
    const line = document.querySelector("#slice-board path.loop").getBoundingClientRect();
    const limits = document.querySelector("#slice-board path.limits").getBoundingClientRect();
    const low = ["left", "top"].map(side => line[side] - limits[side]);
    return [...low, ...["right", "bottom"].map(side => limits[side] - line[side])];
}"""
"""How far the path that is drawn keeps from the sides of the rectangle of joint limits, in pixels."""


@pytest.mark.parametrize("ends", [None, long(("26.9", "27.1"))], ids=["slice", "range"])
def test_the_path_that_proves_a_verdict_is_drawn_and_played(
    base_url: str, open_page: Open, photograph: Inspect, ends: tuple[str, str] | None
) -> None:
    """Within the limits, as each loop is."""
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27&c=B&b=12,13.5,15,17")
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#play")).to_be_enabled()
    assert min(page.evaluate(PLAYED)) > -3, "the loop keeps them"
    page.get_by_role("option", name=re.compile("^Cusp D")).click()
    open_tab(page, "Loop")
    expect(page.locator("#loop-text")).to_contain_text("Cusp D is outside the joint limits")
    expect(page.locator("#play")).to_be_disabled()
    open_tab(page, "Limits")
    if ends:
        for end, text in zip(("min", "max"), ends, strict=True):
            page.locator(f"#l1-{end}").fill(text)
        page.locator("#modes-clearance").fill("0.1")
    expect(page).to_have_url(re.compile(re.escape(f"&b={','.join(('12,13.5,15,17', *(ends or ())))}")))
    page.get_by_role("button", name="Can the assembly mode change here?").click()
    expect(page.locator("#modes-verdict")).to_have_text(
        re.compile(
            f"^Yes: from pose . to pose . of L1 = 2[67].*{'at least 0.1°.*' if ends else ''}Play shows"
        )
    )
    expect(page.locator("#play")).to_be_enabled()
    assert min(page.evaluate(PLAYED)) > -3
    open_tab(page, "Loop")
    expect(page.locator("#loop-text")).to_contain_text("within the joint limits")
    photograph(page, "witness")
    page.get_by_role("option", name=re.compile("^Cusp B")).click()
    expect(page.locator("#loop-text")).to_contain_text("Round cusp B")


def test_a_path_between_poses_is_taken_along(base_url: str, open_page: Open, inspect: Inspect) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27&p=15.5,16.9,2&h=27,13,16.9,1", expected="422")
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#play")).to_be_enabled()
    open_tab(page, "Path")
    expect(page.locator("#path-from")).to_have_text("From pose 2 of L1 = 27, L2 = 15.5, L3 = 16.9.")
    verdict, compute = page.locator("#path-verdict"), page.get_by_role("button", name="Compute")
    compute.click()
    expect(verdict).to_contain_text("No path: J has different signs at the two poses")
    expect(page.get_by_role("button", name="JSON")).to_be_disabled()
    page.locator("#path-to").select_option("pose 3 of the same lengths")
    page.get_by_label("Speed").fill("10")
    compute.click()
    expect(verdict).to_contain_text("acceleration: is missing")
    page.get_by_label("Acceleration").fill("20")
    page.get_by_label("Samples by").select_option("chords within")
    page.get_by_label("Acceleration").press("Enter")
    expect(verdict).to_contain_text("From pose 2 to pose 3 of L1 = 27, L2 = 15.5, L3 = 16.9 without a sing")
    expect(page.locator("#marks")).to_contain_text("path without a singularity")
    with page.expect_download() as download:
        page.get_by_role("button", name="CSV of the samples").click()
    head, *rows = (line.split(",") for line in download.value.path().read_text().splitlines())
    assert head[:4] == ["time", "l1", "l2", "l3"]
    assert head[-1] == "mean_speed_l3"
    assert all(abs(float(row[-1])) <= 10 for row in rows[:-1])
    inspect(page, "path")
    page.get_by_label("Place on the loop").press("End")
    expect(page.locator("#path-from")).to_contain_text("pose 2")  # it is kept
    page.locator("#path-to").select_option("home")
    open_tab(page, "Poses")
    page.get_by_role("button", name="Home", exact=True).click()
    expect(page).to_have_url(re.compile("&p=13,16.9,1&h=27,13,16.9,1"))
    page.locator("#slice-board text.modes", has_text="4").first.click()
    expect(page.locator("#pose-count")).to_have_text(re.compile("4 poses$"))
    page.get_by_role("button", name="Make this pose home").click()
    expect(page).not_to_have_url(re.compile("h=27,13,"))


ON_CIRCLES = """async () => {
    const {arcOf} = await import("/static/tabs/arcs.js");
    const ellipse = {kind: "ellipse", coefficients: [1, 0, 4, 0, 0, -4]};
    const vertices = [[2, 0], [-2, 0]];
    const arc = {from: 1, to: 2, through: {x: "0", y: "1"}};
    const branch = {kind: "hyperbola", coefficients: [0, 1, 0, 0, 0, -1]};
    const lines = [
        [ellipse, arcOf(arc, vertices, null, ellipse)],
        [ellipse, arcOf({from: null, to: null}, [], null, ellipse)],
        [branch, arcOf({from: 1, to: 2, through: {x: "1", y: "1"}}, [[0.1, 10], [10, 0.1]], null, branch)],
    ];
    return lines.flatMap(([{coefficients: [a, b, c, d, e, f]}, points]) => points.map(([x, y]) =>
        Math.abs(a * x * x + b * x * y + c * y * y + d * x + e * y + f)));
}"""


def test_the_workspace_at_an_orientation(base_url: str, open_page: Open, inspect: Inspect) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27")
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#play")).to_be_enabled()
    open_tab(page, "Workspace")
    verdict, place = page.locator("#workspace-verdict"), page.locator("#workspace-place")
    expect(verdict).to_contain_text("No leg has a greatest length")
    page.get_by_role("button", name="Limits within 40 %").click()
    expect(verdict).to_contain_text("Proved.")
    page.get_by_label("φ [°]").fill("30")
    expect(page.locator("#workspace-legend")).to_contain_text("J = 0: hyperbola")
    areas = page.locator("#workspace-picture .area")
    expect(areas).not_to_have_count(0)
    expect(place).not_to_contain_text("outside")
    page.locator("#workspace-picture [tabindex]").focus()
    before = place.inner_text()
    page.keyboard.press("ArrowUp")
    assert place.inner_text() != before
    page.keyboard.press("ArrowDown")
    inspect(page, "workspace")
    length = re.search(r"L1 = ([\d.]+)", place.inner_text())
    page.get_by_role("button", name="Show this pose").click()
    assert length
    expect(page.locator("#l1")).to_have_value(re.compile(f"^{re.escape(length[1][:4])}"))
    open_tab(page, "Poses")
    expect(page.get_by_role("radio", name=re.compile(r"α = (30|29\.99|30\.0)")).first).to_be_checked()
    found = page.evaluate(ON_CIRCLES)
    assert len(found) > 150
    assert max(found) < 1e-9
    page.goto("about:blank")


def test_one_board_in_the_frame_of_another_page(base_url: str, open_page: Open, inspect: Inspect) -> None:
    """It asks for its curves only, and the wheel scrolls the page round it."""
    page = open_page(f"{base_url}/embed#{INNOCENTI}&l1=27&c=B&v=joint&r=26,28")
    asked: list[str] = []
    page.on("request", lambda request: request.method == "POST" and asked.append(request.url))
    expect(page.locator("#count")).to_have_text("L1 = 27: 8 cusps")
    slider = page.get_by_label("Length L1 of the fixed leg")
    for _ in range(2):
        slider.press("PageUp")
    expect(page.locator("#count")).to_have_text(re.compile("^L1 = 27.4"))
    cusp = page.get_by_role("option", name=re.compile("^Cusp B"))
    place = middle(cusp)
    page.mouse.move(*place)
    page.mouse.wheel(0, -240)
    inspect(page, "embed")
    assert dist(middle(cusp), place) < 1
    assert {url.removeprefix(base_url) for url in asked} == {"/v1/singular-curves"}
    page.goto("about:blank")
    page.goto(f"{base_url}/embed#{INNOCENTI}&l1=27&c=B&v=mechanism")
    expect(page.get_by_role("heading")).to_have_text("L1 = 27: loop round cusp B")
    page.get_by_label("Place on the loop").press("End")
    assert page.locator("#mechanism-board .platform").get_attribute("d")
    page.goto("about:blank")
    page.goto(f"{base_url}/embed#l1=27")
    expect(page.locator("#why-text")).to_contain_text("This address has no manipulator")


def test_what_is_degenerate_throughout_is_said(base_url: str, open_page: Open, photograph: Inspect) -> None:
    """Nor does it spoil the pictures: its curves have points at 180 degrees, and no cusp decides the view."""
    page = open_page(f"{base_url}#g=3,0,4,3,5,4,ccw&l1=5&c=A&v=joint")
    expect(page.locator("#census-degenerate li")).to_have_text(
        [
            "Degenerate: a curve of degenerate poses in every slice: alpha = 0 deg",
            "Degenerate: 2 poses of kind node in every slice for L1 from 0 to 10",
        ]
    )
    rows = [re.compile("curve.*alpha = 0 deg"), re.compile("^node"), re.compile("^node")]
    expect(page.locator("#cusp-rows tr.degenerate")).to_have_text(rows)
    photograph(page, "degenerate")
    box = page.locator("#mechanism-board").bounding_box()
    for name in ("Platform point B2", "Platform point B3"):
        x, y = middle(page.get_by_label(name))
        assert box["x"] < x < box["x"] + box["width"]
        assert box["y"] < y < box["y"] + box["height"]
    script = (
        "import('/static/explorer/curves.js').then(({wrapped}) => wrapped([[172, 5], [180, 5], [187, 5]]))"
    )
    assert page.evaluate(script) == [[172, 5], [180, 5], None, [-180, 5], [-173, 5]]


def test_a_tolerance_is_proved_or_refuted_by_a_geometry_that_can_be_opened(
    base_url: str, open_page: Open, inspect: Inspect
) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=28.1")
    count_is(page, "L1 = 28.1: 10 cusps")
    expect(page.locator("#census-strip rect.bar")).to_have_count(23)
    slider, verdict = page.locator("#tolerance-slider"), page.locator("#verdict")
    expect(slider).to_have_attribute("aria-valuetext", "plus or minus 0.001")
    open_tab(page, "Tolerance")
    page.get_by_role("button", name="Check", exact=True).click()
    expect(verdict).to_have_text("Refuted: not 10 cusps at L1 = 28.1 for every geometry within ± 0.001.")
    expect(page.locator("#first-order")).to_contain_text("an estimate: ± 0.0006")
    binding = "beak-to-beak at L1 = 28.0949, which moves most with a3x −2.40, a3y +2.32, d1 +1.96"
    expect(page.locator("#binding li")).to_have_text([binding])
    expect(page.locator("#counterexample-text")).to_contain_text("8 cusps at L1 = 28.1 for a2x")
    inspect(page, "refuted")
    page.get_by_role("button", name="Open the counter-example").click()
    count_is(page, "L1 = 28.1: 8 cusps")
    assert page.locator("#a2x").input_value() != "15.91"
    expect(verdict).to_have_text("")
    page.get_by_role("button", name="Undo").click()
    count_is(page, "L1 = 28.1: 10 cusps")
    assert page.locator("#a2x").input_value() == "15.91"
    expect(page.locator("#counterexample")).to_be_hidden()
    slider.focus()
    slider.press("ArrowLeft")
    slider.press("ArrowLeft")
    expect(verdict).to_have_text("Proved: 10 cusps at L1 = 28.1 for every geometry within ± 0.0002.")
    open_tab(page, "Save")
    open_tab(page, "curl")
    page.get_by_label("What to call").select_option("margin")
    expect(page.locator("#code")).to_contain_text('"tolerance": "0.0002"')
    page.locator("#l1").fill("27")
    expect(verdict).to_have_text("")


def test_a_verdict_about_a_rounded_special_machine_says_what_holds_for_the_exact_one(
    base_url: str, open_page: Open
) -> None:
    page = open_page(f"{base_url}/#g=10,5,8.6603,1.7321,1.7321,1.7321,ccw&l1=5")
    open_tab(page, "Limits")
    page.get_by_role("button", name="Can the assembly mode change here?").click()
    verdict = page.locator("#modes-verdict")
    expect(verdict).to_contain_text("the assembly mode never changes")
    expect(verdict).to_contain_text("This is proved.")


def test_a_slice_that_is_degenerate_has_no_tolerance(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}#g=3,0,4,3,5,4,ccw&l1=5&c=A&v=joint")
    expect(page.locator("#census-degenerate li")).to_have_count(2)
    open_tab(page, "Tolerance")
    page.get_by_role("button", name="Check", exact=True).click()
    expect(page.locator("#verdict")).to_have_text("Open: the slice has degenerate poses (curve, node).")


def test_a_geometry_is_improved_and_undone(base_url: str, open_page: Open, inspect: Inspect) -> None:
    """By keys alone. It takes two CPU-seconds: a search of two censuses, with its proof."""
    page = open_page(f"{base_url}/#{SMALL}&l1=3")
    expect(page.locator("#census-strip rect.bar")).not_to_have_count(0)
    open_tab(page, "Save")
    open_tab(page, "curl")
    page.get_by_label("What to call").select_option("design")
    expect(page.locator("#code")).to_contain_text('"objective": "longest-range"')
    open_tab(page, "Design")
    page.get_by_label("Goal").select_option("more cusps")
    for name, text in {"L1 from": "2", "to": "4", "Censuses": "2"}.items():
        page.get_by_role("tabpanel", name="Design").get_by_label(name, exact=True).fill(text)
    page.get_by_label("Censuses").press("Enter")
    expect(page.locator("#improve-start")).to_be_disabled()
    expect(page.locator("#improve-now")).to_contain_text("Best found of 2 (budget), proved: 8, wish met;")
    expect(page.locator("#improvements li").last).to_have_text("census 1: 8, wish met")
    expect(page.locator("#improvements li")).to_have_count(2)
    assert page.locator("#mechanism-board .candidate").get_attribute("d"), "it is drawn"
    inspect(page, "improved")
    page.get_by_role("button", name="Open the best one found").press("Enter")
    expect(page).not_to_have_url(re.compile(SMALL))
    expect(page.locator("#open-best")).to_be_hidden()
    page.keyboard.press("Control+z")
    expect(page).to_have_url(re.compile(SMALL))
    expect(page.locator("#d1")).to_have_value("3")


@pytest.mark.long
def test_a_search_is_stopped_with_the_best_found_so_far(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{SMALL}&l1=3")
    open_tab(page, "Design")
    page.get_by_label("Goal").select_option("more cusps")
    expect(page.get_by_label("Cusps, at most")).to_be_disabled()
    page.get_by_role("button", name="Search").click()
    expect(page.locator("#improvements li")).not_to_have_count(0)
    page.get_by_role("button", name="Stop, with the best so far").click()
    expect(page.locator("#improve-now")).to_contain_text("(canceled)")
    expect(page.get_by_role("button", name="Search")).to_be_enabled()
    expect(page.get_by_role("button", name="Stop, with the best so far")).to_be_disabled()
    page.get_by_label("L1 from").fill("2")
    page.get_by_label("Goal").select_option("the least change")
    page.get_by_role("button", name="Search").click()
    expect(page.locator("#improve-start")).to_be_disabled()
    open_tab(page, "Geometry")
    page.locator("#d1").fill("3.1")
    expect(page.locator("#improve-start")).to_be_enabled()
    expect(page.locator("#improve-now")).to_have_text("")


def test_points_are_dragged_by_mouse_and_by_keys(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=14.98&m=design")
    count_is(page, "L1 = 14.98: 6 cusps")
    expect(page.locator("#play")).to_be_enabled()
    x, y = middle(page.get_by_label(re.compile("^Base point A3")))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 20, y - 300, steps=5)  # beyond the board: what it moves gets room
    expect(page.locator("#a3x")).not_to_have_value("0")
    board = page.locator("#mechanism-board").bounding_box()
    for point in page.locator("#mechanism-board :is(.joint, .handle:not([aria-label*=A3]))").all():
        left, middle_y = middle(point)
        assert board["x"] < left < board["x"] + board["width"]
        assert board["y"] < middle_y < board["y"] + board["height"]
    page.mouse.move(x + 20, y - 11, steps=2)
    page.mouse.up()
    expect(page).to_have_url(re.compile("g=15.91,(?!0,10,)"))  # it has come to rest
    a3 = [page.locator(f"#{name}").input_value() for name in ("a3x", "a3y")]
    assert all(re.fullmatch(r"\d+(\.\d{1,2})?", text) for text in a3), a3
    assert page.locator("#a2x").input_value() == "15.91"
    expect(page.get_by_label("Example")).to_have_value("")

    page.get_by_label(re.compile("^Base point A2")).focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#a2x")).not_to_have_value("15.91")
    a2x = page.locator("#a2x").input_value()
    assert float(a2x) > 15.91
    expect(page.locator("#slice")).not_to_have_class(re.compile("stale"))
    expect(page).to_have_url(
        re.compile(re.escape(f"#g={a2x},{a3[0]},{a3[1]},17.04,16.54,20.84,ccw&l1=14.98"))
    )
    page.goto("about:blank")  # which withdraws what is being computed


@pytest.mark.long
def test_a_corner_of_the_platform_takes_its_sides_and_its_sense_along(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27&m=design")
    count_is(page, "L1 = 27: 8 cusps")
    boxes = {
        name: page.locator(f"#mechanism-board [aria-label^='Platform point {name}']").bounding_box()
        for name in ("B2", "B3")
    }
    middle = {
        name: (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2) for name, box in boxes.items()
    }
    page.mouse.move(*middle["B3"])
    page.mouse.down()
    page.mouse.move(middle["B2"][0] - 20, middle["B2"][1] + 40, steps=8)
    page.mouse.up()
    expect(page.get_by_label("clockwise", exact=True)).to_be_checked()
    assert page.locator("#d1").input_value() == "17.04"
    assert page.locator("#d2").input_value() != "16.54"
    assert page.locator("#d3").input_value() != "20.84"
    page.goto("about:blank")


def test_fields_and_windows(base_url: str, open_page: Open) -> None:
    page = open_page(base_url)
    page.get_by_label("L1", exact=False).and_(page.locator("#l1")).fill("28.1")
    count_is(page, "L1 = 28.1: 10 cusps")
    expect(page.locator("#window")).to_have_text("10 cusps in the window 28.0948945 to 28.1074306")
    page.locator("#d1").fill("426/25")
    count_is(page, "L1 = 28.1: 10 cusps")
    expect(page.locator("#l1-slider")).to_be_enabled()

    slider = page.locator("#l1-slider")
    slider.press("[")
    expect(page.locator("#count")).to_have_text("L1 = 27: 8 cusps")
    slider.press("]")
    expect(page.locator("#count")).to_have_text("L1 = 28.1: 10 cusps")
    slider.press("PageUp")
    expect(page.locator("#count")).to_have_text(re.compile(r"^L1 = 28\.1\d*: 8 cusps"))
    slider.press("PageDown")
    slider.press("PageDown")
    expect(page.locator("#count")).to_have_text(re.compile(r"^L1 = 28\.0\d*: 8 cusps"))
    page.get_by_role("button", name="Higher window").click()
    count_is(page, "L1 = 28.1: 10 cusps")
    page.get_by_label("clockwise", exact=True).check()
    expect(page).to_have_url(re.compile("g=15.91,0,10,426%2F25,16.54,20.84,cw"))


def test_a_cusp_by_mouse_by_keys_and_in_the_table(base_url: str, open_page: Open) -> None:
    page = open_page(base_url)
    count_is(page, "L1 = 27: 8 cusps")
    cusps = page.get_by_role("listbox", name="Cusps").get_by_role("option")
    open_tab(page, "Cusps")
    cusps.nth(2).click()
    expect(page.get_by_role("button", name="Select cusp C")).to_have_attribute("aria-pressed", "true")
    expect(page.locator("#visited")).to_have_text(re.compile(r"^Cusp C: L2 = 5.92908, L3 = 29.7418"))
    page.keyboard.press("ArrowRight")
    expect(cusps.nth(3)).to_be_focused()
    expect(page.locator("#visited")).to_have_text(re.compile("^Cusp D"))
    expect(cusps.nth(2)).to_have_attribute("aria-selected", "true")
    page.keyboard.press("Enter")
    expect(cusps.nth(3)).to_have_attribute("aria-selected", "true")
    expect(page).to_have_url(re.compile("&c=D"))
    page.keyboard.press("End")
    expect(cusps.nth(7)).to_be_focused()
    open_tab(page, "Cusps")
    page.get_by_role("button", name="Select cusp B").click()
    expect(cusps.nth(1)).to_have_attribute("aria-selected", "true")

    page.get_by_role("button", name="Copy", exact=True).click()
    expect(page.locator("#live")).to_have_text("The table is copied.")
    head, _, copied, *_ = page.evaluate("navigator.clipboard.readText()").splitlines()
    assert head.split("\t") == ["cusp", "l2", "l3", "alpha_deg", "theta1_deg"]
    assert copied.startswith("B\t12.5634317760031727")
    assert len(copied.split("\t")[1]) == 31


@pytest.mark.long
def test_curves_become_finer_under_the_glass(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=28.1&c=H")
    count_is(page, "L1 = 28.1: 10 cusps")
    expect(page.locator("#play")).to_be_enabled()
    cusp = page.get_by_role("option", name=re.compile("^Cusp H"))

    def is_fine(request: Any) -> bool:
        return request.url.endswith("/v1/singular-curves") and '"0.00001"' in (request.post_data or "")

    with page.expect_request(is_fine):
        for _ in range(8):
            page.get_by_role("button", name="Zoom in on the cusp").click()
    board = middle(page.locator("#slice-board"))
    assert all(abs(x - y) < 3 for x, y in zip(middle(cusp), board, strict=True))
    page.get_by_role("button", name="Show all of the slice").click()
    assert middle(cusp)[1] > board[1] + 50


def test_the_poses_of_a_place_in_joint_space(base_url: str, open_page: Open, inspect: Inspect) -> None:
    page = open_page(base_url, expected="422")
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#play")).to_be_enabled()
    poses = page.get_by_role("group", name="Pose", exact=True).get_by_role("radio")
    open_tab(page, "Poses")
    page.locator("#slice-board text.modes", has_text="4").first.click()
    expect(page.locator("#pose-count")).to_have_text(re.compile(r"^L1 = 27, L2 = \d.*: 4 poses$"))
    expect(poses).to_have_count(4)
    poses.first.check()
    b1 = page.get_by_label("Platform point B1")
    before = middle(b1)
    poses.first.focus()
    page.keyboard.press("ArrowDown")
    expect(poses.nth(1)).to_be_checked()
    assert middle(b1) != before
    l2, l3 = (page.locator(f"#{name}").input_value() for name in ("l2", "l3"))
    expect(page).to_have_url(re.compile(re.escape(f"&p={l2},{l3},2")))
    inspect(page, "poses")

    open_tab(page, "Save")
    open_tab(page, "curl")
    page.get_by_label("What to call").select_option("poses")
    body = json.loads(re.search(r"-d '(.*)'$", page.locator("#code").inner_text(), re.DOTALL)[1])  # type: ignore[index]
    answer = httpx.post(f"{base_url}/v1/poses", json=body, headers={"Prefer": "wait=10"}).json()
    assert (answer["l2"], answer["l3"], answer["count"]) == (l2, l3, 4)

    open_tab(page, "Poses")
    page.get_by_label("or a region").select_option(index=1)
    expect(poses).to_have_count(6)
    page.locator("#l3").fill("-1")
    expect(page.locator("#l3-error")).to_contain_text("l3 is -1")
    open_tab(page, "Cusps")
    page.get_by_role("button", name="Select cusp B").click()
    expect(page.locator("#pose-list")).to_be_hidden()
    assert "&p=" not in page.url


OUTLINES = """() => {
    const of = (name) => {
        const line = document.querySelector(`#mechanism-board path.${name}`).getAttribute("d");
        const points = [...line.matchAll(/[ML] ?([-\\d.e]+)[ ,]([-\\d.e]+)/g)];
        return points.map(([, x, y]) => [Number(x), Number(y)]);
    };
    const others = of("ghost");
    return [of("platform"), ...others.flatMap((_, k) => (k % 4 ? [] : [others.slice(k, k + 4)]))];
}"""
"""The corners of the platform and of the outlines of the other poses, in pixels."""


def merged(page: Any) -> int:
    """The most outlines that lie within a pixel of one."""
    outlines = page.evaluate(OUTLINES)
    return max(
        sum(all(dist(*pair) < 1 for pair in zip(one, other, strict=True)) for other in outlines)
        for one in outlines
    )


ON_CURVE = """() => {
    const curve = document.querySelector("#slice-board path.singular");
    const {left, top} = document.getElementById("slice-board").getBoundingClientRect();
    const {x, y} = curve.getPointAtLength(0.7 * curve.getTotalLength());
    return [x + left, y + top];
}"""


def test_poses_merge_where_the_joint_vector_is_dragged(
    base_url: str, open_page: Open, inspect: Inspect
) -> None:
    """Two on a curve, three at a cusp; without a question to the service while it is dragged."""
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27", expected="422")
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#play")).to_be_enabled()
    vector, visited = page.get_by_label(re.compile("^Joint vector")), page.locator("#visited")
    page.wait_for_load_state("networkidle")
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.mouse.move(*middle(vector))
    page.mouse.down()
    x, y = middle(page.get_by_role("option", name=re.compile("^Cusp B")))
    page.mouse.move(x + 30, y + 5, steps=3)
    expect(visited).to_have_text(re.compile("[24] poses$"))
    assert merged(page) == 1
    assert asked == []
    page.mouse.move(x + 2, y + 2)
    expect(visited).to_have_text(re.compile("at cusp B three have merged$"))
    page.wait_for_function(f"({OUTLINES})().length === 4")
    assert merged(page) == 3
    assert page.locator("#mechanism-board path.meeting").get_attribute("d"), "the legs' lines meet"
    x, y = page.evaluate(ON_CURVE)
    page.mouse.move(x + 20, y)
    page.mouse.move(x + 3, y, steps=2)
    expect(visited).to_have_text(re.compile("on the singular curve two have merged$"))
    assert merged(page) == 2
    page.mouse.up()
    expect(page).to_have_url(re.compile(r"&p=\d+\.\d{9,},\d"))
    expect(page.locator("#poses")).not_to_have_class(re.compile("stale"))
    assert merged(page) == 2, "those of the service are at the same place"
    inspect(page, "merging")
    vector.focus()
    page.keyboard.press("ArrowRight")
    expect(visited).to_have_text(re.compile("[24] poses$"))
    assert merged(page) == 1
    page.goto("about:blank")


KINEMATICS = """async ([geometry, curves, table]) => {
    const names = ["geometry", "kinematics"];
    const modules = names.map((name) => import(`/static/explorer/${name}.js`));
    const [{measured}, {apart, besides, posesOf, singularNear, vectorOf}] = await Promise.all(modules);
    const [lengths, l1] = [measured(geometry), Number(curves.l1)];
    const isNear = (pose) => (other) => apart(other, pose) < 0.01;
    const near = (pose, vector) => posesOf(lengths, vector).filter(isNear(pose)).length;
    const strands = curves.components.flatMap((component) => component.strands);
    const folds = strands.flatMap(({alpha_deg, theta1_deg}) => alpha_deg.map((alpha, k) => {
        const pose = singularNear(lengths, {l1, alpha_deg: alpha, theta1_deg: theta1_deg[k]});
        return near(pose, vectorOf(lengths, besides(lengths, pose)));
    }));
    return {
        cusps: table.slices[0].cusps.map((cusp) => near(cusp, [l1, Number(cusp.l2), Number(cusp.l3)])),
        fewest: Math.min(...folds),
        folds: folds.length,
    };
}"""


def test_poses_in_doubles_merge_at_every_fold_and_cusp(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27")
    geometry = dict(zip(("a2x", "a3x", "a3y", "d1", "d2", "d3"), INNOCENTI[2:].split(","), strict=False))
    question = {"geometry": geometry, "l1": "27"}
    headers = {"Prefer": "wait=10"}
    curves, table = (
        httpx.post(f"{base_url}/v1/{path}", json=question, headers=headers).json()
        for path in ("singular-curves", "cusp-tables")
    )
    found = page.evaluate(KINEMATICS, [geometry | {"orientation": "ccw"}, curves, table])
    assert found["cusps"] == [3] * 8
    assert found["folds"] > 100
    assert found["fewest"] >= 2
    page.goto("about:blank")


def test_the_platform_is_moved_with_l1_kept(base_url: str, open_page: Open, photograph: Inspect) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27&p=15.5,16.9,3")
    count_is(page, "L1 = 27: 8 cusps")
    before = page.url
    corners = {name: page.get_by_label(re.compile(f"^Platform point {name}")) for name in ("B1", "B2", "B3")}
    a1 = page.locator("#mechanism-board .joint").first
    x, y = middle(corners["B2"])
    held = middle(corners["B1"])
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 25, y + 15, steps=4)
    expect(page.locator("#visited")).to_have_text(re.compile("poses?$"))
    assert dist(middle(corners["B1"]), held) < 1, "it turns about B1"
    page.mouse.up()
    expect(page).to_have_url(re.compile(f"^{re.escape(base_url)}/#{INNOCENTI}&l1=27&.*&p="))
    expect(page).not_to_have_url(before)
    photograph(page, "moved")
    spots = [middle(corner) for corner in corners.values()]
    held, reach = spots[0], dist(middle(a1), spots[0])
    x, y = (sum(spot[axis] for spot in spots) / 3 for axis in (0, 1))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 30, y - 30, steps=4)
    page.wait_for_timeout(100)  # a picture is drawn
    assert dist(middle(corners["B1"]), held) > 5
    assert abs(dist(middle(a1), middle(corners["B1"])) - reach) < 1, "along its circle"
    page.mouse.up()
    corners["B3"].focus()
    page.keyboard.press("ArrowUp")
    expect(page.locator("#l1")).to_have_value("27")
    page.goto("about:blank")


def test_a_click_on_the_torus_shows_the_pose(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27&c=A&v=torus")
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#play")).to_be_enabled()
    box = page.locator("#slice-board").bounding_box()
    place = [box["x"] + 0.6 * box["width"], box["y"] + 0.6 * box["height"]]
    page.mouse.move(*place)
    expect(page.locator("#tip")).to_have_text(
        re.compile(r"J [<>] 0: \d+ % of all poses, no singularity inside")
    )
    page.mouse.click(*place)
    expect(page).to_have_url(re.compile(r"&v=torus&p=[\d.]+,[\d.]+,\d"))
    spot = page.locator("#slice-board .pose-point.chosen")
    assert dist(middle(spot), place) < 2
    side = page.locator("#slice-board .seam").first.bounding_box()
    page.mouse.move(side["x"] + side["width"] / 2, side["y"] + 40)
    expect(page.locator("#tip")).to_contain_text("180° is −180°")


def test_the_selected_cusp_is_followed_to_its_end(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=26.8&c=G")
    count_is(page, "L1 = 26.8: 8 cusps")
    expect(page.locator("#visited")).to_have_text(re.compile("^Cusp G: L2 = 35.5078"))
    expect(page.locator("#play")).to_be_enabled()
    page.locator("#l1").fill("26.78")
    count_is(page, "L1 = 26.78: 6 cusps")
    expect(page.locator("#visited")).to_have_text(re.compile("^Cusp E: L2 = 35.5009"))
    expect(page).to_have_url(re.compile("l1=26.78&c=E"))
    page.go_back()
    count_is(page, "L1 = 26.8: 8 cusps")
    page.get_by_role("option", name=re.compile("^Cusp F")).click()
    expect(page).to_have_url(re.compile("l1=26.8&c=F"))
    expect(page.locator("#play")).to_be_enabled()
    page.locator("#l1").fill("26")
    ended = "^The selected cusp ended at L1 = 26.7864 .beak-to-beak.. Selected now: Cusp "
    expect(page.locator("#visited")).to_have_text(re.compile(ended))
    page.goto("about:blank")


def test_the_wheel_zooms_about_the_pointer(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27")
    count_is(page, "L1 = 27: 8 cusps")
    one, other = (page.get_by_role("option", name=re.compile(f"^Cusp {letter}")) for letter in "DH")
    place, way = middle(one), dist(middle(one), middle(other))
    page.mouse.move(*place)
    page.mouse.wheel(0, -240)
    page.wait_for_function(
        "way => { const [one, other] = ['D', 'H'].map(letter => document.querySelector("
        "`#slice-board [aria-label^='Cusp ${letter}']`).getBoundingClientRect());"
        " return Math.hypot(one.x - other.x, one.y - other.y) > 1.5 * way; }",
        arg=way,
    )
    assert dist(middle(one), place) < 3


def test_a_loop_round_a_cusp_is_played(base_url: str, open_page: Open, inspect: Inspect) -> None:
    page = open_page(base_url, reduced_motion="no-preference")
    count_is(page, "L1 = 27: 8 cusps")
    play, place = page.locator("#play"), page.locator("#scrubber")
    open_tab(page, "Loop")
    page.get_by_role("option", name=re.compile("^Cusp B")).click()
    expect(play).to_have_text("Pause")  # by itself
    expect(page.locator("#loop-text")).to_have_text(
        "Round cusp B from pose 2 to pose 3 of L1 = 27, L2 = 15.5, L3 = 16.9 without a singularity: "
        "J > 0, and |determinant| ≥ 0.114, proved all the way."
    )
    expect(play).to_have_text("Play")
    expect(place).to_have_value("100")
    expect(page.locator("#loop-now")).to_contain_text(
        "L2 = 15.5, L3 = 16.9, at least 4.01° from a singularity"
    )
    inspect(page, "loop")
    ends = page.evaluate(OUTLINES)
    play.click()  # and back
    expect(play).to_have_text("Pause")
    page.wait_for_function(f"length => ({OUTLINES})().length !== length", arg=len(ends))  # others vanish
    expect(place).not_to_have_value("100")
    play.click()
    expect(play).to_have_text("Play")

    open_tab(page, "Save")
    open_tab(page, "curl")
    page.get_by_label("What to call").select_option("loop")
    body = json.loads(re.search(r"-d '(.*)'$", page.locator("#code").inner_text(), re.DOTALL)[1])  # type: ignore[index]
    answer = httpx.post(f"{base_url}/v1/paths", json=body, headers={"Prefer": "wait=10"}).json()
    assert (answer["cusp"], answer["winding"]) == (2, 1)


def test_nothing_moves_by_itself_for_those_who_want_that(base_url: str, open_page: Open) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27&c=A&v=torus")
    count_is(page, "L1 = 27: 8 cusps")
    open_tab(page, "Cusps")
    page.get_by_role("button", name="Select cusp B").click()
    expect(page.locator("#loop-text")).to_contain_text("Round cusp B")
    expect(page.locator("#play")).to_have_text("Play")
    expect(page.locator("#scrubber")).to_have_value("0")
    page.locator("#scrubber").press("End")
    spoken = re.compile("^100 %: L2 = 15.5, L3 = 16.9")
    expect(page.locator("#scrubber")).to_have_attribute("aria-valuetext", spoken)
    open_tab(page, "Geometry")
    page.locator("#d1").fill("17")
    expect(page.locator("#play")).to_be_disabled()


def test_a_permanent_link(base_url: str, open_page: Open, inspect: Inspect) -> None:
    page = open_page(f"{base_url}/#g=30,11,27,13,9,4,ccw&l1=35&c=F&v=torus")
    count_is(page, "L1 = 35: 8 cusps")
    expect(page.get_by_label("torus", exact=True)).to_be_checked()
    expect(page.get_by_label("Example")).to_have_value("30,11,27,13,9,4,ccw")
    open_tab(page, "Cusps")
    expect(page.get_by_role("button", name="Select cusp F")).to_have_attribute("aria-pressed", "true")
    expect(page.locator("#legend li")).to_have_text(["J > 0 (53 %)", "J < 0 (47 %)"])
    inspect(page, "torus")
    open_tab(page, "Save")
    page.get_by_role("button", name="Copy link").click()
    expect(page.locator("#live")).to_have_text("The link is copied.")
    assert page.evaluate("navigator.clipboard.readText()") == page.url
    page.evaluate(f"location.hash = '{INNOCENTI}&l1=27&p=22.1,19.9,3'")
    count_is(page, "L1 = 27: 8 cusps")
    open_tab(page, "Poses")
    expect(page.get_by_role("radio", name=re.compile("^3: α"))).to_be_checked()


@pytest.mark.long
def test_what_is_shown_is_a_call_of_other_programs(base_url: str, open_page: Open) -> None:
    page = open_page(base_url)
    count_is(page, "L1 = 27: 8 cusps")
    open_tab(page, "Save")
    expect(page.locator("#code")).to_contain_text("import Manipulator")
    done = completed([sys.executable, "-c", page.locator("#code").inner_text()], environment())
    assert done.stdout == "", "a notebook shows its last line by itself"
    open_tab(page, "curl")
    curl = page.locator("#code").inner_text()
    body = json.loads(re.search(r"-d '(.*)'$", curl, re.DOTALL)[1])  # type: ignore[index]
    answer = httpx.post(f"{base_url}/v1/cusp-tables", json=body, headers={"Prefer": "wait=10"})
    assert answer.json()["slices"][0]["count"] == 8

    page.get_by_role("tab", name="curl").press("ArrowRight")
    expect(page.get_by_role("tab", name="Python")).to_be_focused()
    program = page.locator("#code").inner_text()
    done = completed([sys.executable, "-c", program], environment())
    assert len(done.stdout.splitlines()) == 8

    page.get_by_role("tab", name="MATLAB").click()
    expect(page.locator("#code")).to_contain_text("webwrite(")
    with page.expect_download() as download:
        page.get_by_role("button", name="CSV").click()
    assert len(download.value.path().read_text().splitlines()) == 9


def test_bad_input_is_refused_at_its_field(base_url: str, open_page: Open, inspect: Inspect) -> None:
    page = open_page(f"{base_url}/#g=15.91,0,10,17.04,16.54,50,ccw&l1=27", expected="422")
    expect(page.locator("#d3")).to_be_focused()
    expect(page.locator("#d3")).to_have_attribute("aria-invalid", "true")
    expect(page.locator("#d3-error")).to_contain_text("breaks the triangle inequality")
    expect(page.locator("#banner")).to_be_hidden()
    inspect(page, "bad-input")
    page.locator("#d3").fill("20.84")
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#d3")).not_to_have_attribute("aria-invalid", "true")
    page.locator("#l1").fill("-1")
    expect(page.locator("#l1-error")).to_contain_text("is -1; a leg length must be > 0")
    page.goto("about:blank")
    page.goto(f"{base_url}/#{INNOCENTI}&l1=-3")
    expect(page.locator("#l1-error")).to_have_text("l1 is -3; a leg length must be > 0")
    expect(page.locator("#mechanism-board")).to_have_class(re.compile("empty"))  # not as if L1 were 3
    page.locator("#l1").fill("14.98")
    count_is(page, "L1 = 14.98: 6 cusps")
    expect(page.locator("#l1-error")).to_be_hidden()


def test_an_equilateral_machine_is_two_clicks(base_url: str, open_page: Open, photograph: Inspect) -> None:
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=14.98")
    count_is(page, "L1 = 14.98: 6 cusps")
    for triangle in ("Base", "Platform"):
        page.get_by_role("group", name=triangle).get_by_label("equilateral").check()
    count_is(page, "L1 = 14.98: 0 cusps")
    expect(page).to_have_url(re.compile(re.escape("#g=equilateral,15.91;equilateral,17.04&l1=14.98")))
    open_tab(page, "Save")
    open_tab(page, "curl")
    expect(page.locator("#code")).to_contain_text('"base": {"equilateral": "15.91"}')
    open_tab(page, "Geometry")
    photograph(page, "equilateral")
    side = page.get_by_role("textbox", name="side", exact=True).last
    side.fill("sqrt(3)*2")
    expect(page.locator(".error", has_text="a root such as 5*sqrt(3)/2")).to_be_visible()
    side.fill("2*sqrt(3)")
    count_is(page, "L1 = 14.98: 0 cusps")
    page.get_by_role("group", name="Platform").get_by_label("points").check()
    expect(page.get_by_label("B3 x")).to_have_value("sqrt(3)")
    expect(page.get_by_label("B3 y")).to_have_value("3")
    count_is(page, "L1 = 14.98: 0 cusps")


POINTS = "g=points,0,0,40,10,90,-20;points,0,0,12,0,5,6*sqrt(2)"


def test_a_machine_by_points_keeps_its_spelling_and_its_frame(
    base_url: str, open_page: Open, inspect: Inspect
) -> None:
    page = open_page(f"{base_url}/#{POINTS}&l1=30&p=14.9,72,1&m=design", expected="422")
    count_is(page, "L1 = 30: 6 cusps")
    expect(page.get_by_label("A3 y")).to_have_value("-20")
    corners = [page.locator("#mechanism-board .joint").first]
    corners += [page.get_by_label(re.compile(f"^Base point {name}")) for name in ("A2", "A3")]
    heights = [middle(corner)[1] for corner in corners]
    assert heights[1] < heights[0] < heights[2], "as in the drawing, whose y points up"
    open_tab(page, "Poses")
    pose = page.get_by_role(
        "radio", name=re.compile("^1: α = −82.03°, θ1 = 32.549°; x = 20.618, y = 21.792, φ = −67.994°")
    )
    expect(pose).to_be_checked()
    expect(page.locator("#play")).to_be_enabled()
    page.get_by_label("Place on the loop").press("End")
    expect(page.locator("#loop-now")).to_have_text(re.compile(r"; x = .*, y = .*, φ = .*°, at least"))
    page.go_back()
    open_tab(page, "Geometry")
    inspect(page, "points")
    assert page.url.endswith(f"#{POINTS}&l1=30&c=A&v=joint&p=14.9,72,1&m=design")
    page.get_by_label("A2 y").fill("sqrt(7)")
    expect(page.get_by_label("A3 y")).to_have_attribute("aria-invalid", "true")
    expect(page.locator(".error", has_text="-20 is at odds with y of A2 = sqrt(7)")).to_be_visible()
    expect(page.locator("#banner")).to_be_hidden()
    page.get_by_label("A2 y").fill("20")
    page.get_by_label("A2 x").fill("80/2")
    count_is(page, "L1 = 30: 4 cusps")
    expect(page).to_have_url(re.compile(re.escape("g=points,0,0,80%2F2,20,90,-20;points")))
    page.get_by_label(re.compile("^Platform point B2, x = 12, y = 0")).focus()
    page.keyboard.press("ArrowUp")
    expect(page.get_by_label("B2 y")).not_to_have_value("0")
    assert page.get_by_label("B3 y").input_value() == "6*sqrt(2)"
    page.get_by_label(re.compile("^Base point A3, x = 90, y = -20")).focus()
    page.keyboard.press("ArrowRight")
    expect(page.get_by_label("A3 x")).to_have_value(re.compile(r"^9\d\.\d"))
    assert page.get_by_label("A3 y").input_value() == "-20"
    page.goto("about:blank")


def test_a_rounded_special_machine_says_so_and_the_exact_one_is_a_click(
    base_url: str, open_page: Open, photograph: Inspect
) -> None:
    page = open_page(f"{base_url}/#g=10,5,8.6603,1.7321,1.7321,1.7321,ccw&l1=5")
    count_is(page, "L1 = 5: 4 cusps")
    expect(page.locator("#near-text")).to_contain_text("base and platform are similar")
    photograph(page, "near")
    page.get_by_role("button", name="Take the exact shape").click()
    count_is(page, "L1 = 5: 0 cusps")
    expect(page.locator("#near")).to_be_hidden()
    expect(page).to_have_url(re.compile(re.escape("#g=equilateral,10;equilateral,sqrt(3)&l1=5")))


def test_a_server_error_and_another_try(base_url: str, open_page: Open, inspect: Inspect) -> None:
    page = open_page("about:blank", expected="500")
    problem = {
        "type": "/problems/internal-error",
        "title": "Internal error",
        "status": 500,
        "detail": "Oh.",
    }
    page.route(
        "**/v1/cusp-tables",
        lambda route: route.fulfill(
            status=500, content_type="application/problem+json", body=json.dumps(problem)
        ),
    )
    page.goto(base_url)
    expect(page.get_by_role("alert")).to_contain_text("Oh.")
    inspect(page, "server-error")
    page.unroute("**/v1/cusp-tables")
    page.get_by_role("button", name="Try again").click()
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.get_by_role("alert")).to_be_hidden()


@pytest.mark.usefixtures("base_url")
def test_a_service_that_goes_and_comes_back(
    valkey: EmbeddedValkey, open_page: Open, inspect: Inspect
) -> None:
    settings = Settings(redis_url=valkey.url)
    with serving(settings) as url:
        page = open_page(f"{url}/#{INNOCENTI}&l1=27", expected="ERR_CONNECTION")
        count_is(page, "L1 = 27: 8 cusps")
        expect(page.locator("#census")).not_to_have_class(re.compile("stale"))
    page.locator("#l1").fill("14.98")
    expect(page.get_by_role("alert")).to_contain_text("The service cannot be reached. Trying again in")
    expect(page.locator("#slice")).to_have_class(re.compile("stale"))
    inspect(page, "service-gone")
    with serving(settings, port=int(url.rpartition(":")[2])):
        count_is(page, "L1 = 14.98: 6 cusps")  # by itself
        expect(page.get_by_role("alert")).to_be_hidden()
        page.goto("about:blank")


def test_progress_and_cancel(idle_url: str, open_page: Open, inspect: Inspect) -> None:
    page = open_page("about:blank")
    with page.expect_request("**/events"):
        page.goto(idle_url)
    expect(page.locator("#progress-text")).to_have_text("Computing the curves")
    expect(page.locator("#count")).to_have_text("")
    inspect(page, "computing")
    with page.expect_response(lambda response: response.request.method == "DELETE") as response:
        page.get_by_role("button", name="Cancel").click()
    assert httpx.get(response.value.url).json()["status"] == "canceled"
    expect(page.locator("#progress")).to_be_hidden()
    expect(page.get_by_role("alert")).to_contain_text("Cancelled.")


@pytest.mark.usefixtures("base_url")
@pytest.mark.long
def test_a_service_that_asks_for_keys(valkey: EmbeddedValkey, open_page: Open, inspect: Inspect) -> None:
    with connect(valkey.url) as client:
        key, token = make_key("browser", "submit", time.time(), None)
        assert KeyStore(client, "cusps").add(key, time.time())
    with serving(Settings(redis_url=valkey.url, require_keys="always")) as url:
        page = open_page(url, expected="401")
        expect(page.get_by_role("alert")).to_contain_text("key")
        inspect(page, "key-wanted")
        page.get_by_label(re.compile("^API key for this service")).fill(token)
        page.get_by_role("button", name="Use this key").click()
        count_is(page, "L1 = 27: 8 cusps")
        expect(page.get_by_role("alert")).to_be_hidden()
        expect(page.locator("#census-strip rect.bar")).to_have_count(23)
        assert token not in page.url + page.content()
        open_tab(page, "Save")
        open_tab(page, "curl")
        expect(page.locator("#code")).to_contain_text("$RPR_CUSPS_API_KEY")
        with page.expect_download() as download:
            page.get_by_role("button", name="CSV").click()
        assert len(download.value.path().read_text().splitlines()) == 9
        page.goto("about:blank")


@pytest.mark.long
def test_while_something_moves_three_questions_are_asked_at_a_time(base_url: str, open_page: Open) -> None:
    page = open_page(base_url)
    page.locator("#mode-design").check()
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#census")).not_to_have_class(re.compile("stale"))
    asked: list[dict[str, Any]] = []
    flying: list[Any] = []
    most = 0

    def begin(request: Any) -> None:
        nonlocal most
        if request.method == "POST":
            asked.append({"path": request.url.removeprefix(base_url), **request.post_data_json})
        if '"0.003"' in (request.post_data or ""):
            flying.append(request)
            most = max(most, len(flying))

    def end(request: Any) -> None:
        if request in flying:
            flying.remove(request)

    page.on("request", begin)
    page.on("requestfinished", end)
    page.on("requestfailed", end)
    x, y = middle(page.get_by_label(re.compile("^Base point A3")))
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 40):
        page.mouse.move(x + step, y)
    page.mouse.up()
    with page.expect_request("**/v1/censuses"):
        expect(page.locator("#slice")).not_to_have_class(re.compile("stale"))
    page.goto("about:blank")
    moving = [question for question in asked if question.get("tolerance") == "0.003"]
    assert {(question["path"], question["digits"]) for question in moving} == {("/v1/singular-curves", 15)}
    assert most <= 3
    assert len(moving) < 39
    places = [float(question["geometry"]["a3x"]) for question in moving]
    assert places == sorted(places)
    resting = [question for question in asked if question not in moving][-4:]
    paths = ["/v1/cusp-tables", "/v1/singular-curves", "/v1/paths", "/v1/censuses"]
    assert [question["path"] for question in resting] == paths
    assert len({question["geometry"]["a3x"] for question in resting}) == 1


def test_slices_are_known_before_the_slider_comes_to_them(base_url: str, open_page: Open) -> None:
    page = open_page(base_url)
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#census")).not_to_have_class(re.compile("stale"))
    asked: list[str] = []
    page.on(
        "request", lambda request: '"0.003"' in (request.post_data or "") and asked.append(request.post_data)
    )
    page.locator("#l1-slider").focus()
    deadline = time.monotonic() + PATIENCE
    while len(asked) < 28 and time.monotonic() < deadline:
        page.wait_for_timeout(50)
    ahead = {json.loads(body)["l1"] for body in asked}
    assert len(ahead) == len(asked) == 28, "fourteen on each side"
    page.wait_for_load_state("networkidle")
    for _ in range(3):
        page.keyboard.press("ArrowLeft")
        length = page.locator("#l1-slider").evaluate("slider => slider.ariaValueText").split(",")[0]
        if length.removeprefix("L1 = ") in ahead:
            break
    expect(page.locator("#count")).to_have_text(re.compile(f"^{re.escape(length)}: "))
    assert length.removeprefix("L1 = ") not in {json.loads(body)["l1"] for body in asked[28:]}


def test_a_slice_whose_curves_cannot_be_drawn(base_url: str, open_page: Open) -> None:
    """Its table is there at any rate, and the last picture stays with its own cusps."""
    page = open_page(f"{base_url}/#{INNOCENTI}&l1=27", expected="422")
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#play")).to_be_enabled()
    problem = {"type": "/problems/job-solver-error", "status": 422, "detail": "Not this one."}
    answer = {"status": 422, "content_type": "application/problem+json", "body": json.dumps(problem)}
    for path in ("singular-curves", "paths"):
        page.route(f"**/v1/{path}", lambda route: route.fulfill(**answer))
    page.locator("#l1").fill("14.98")
    expect(page.locator("#count")).to_have_text("L1 = 14.98: 6 cusps")
    expect(page.locator("#why-text")).to_contain_text("L1 = 14.98 has no picture.")
    expect(page.locator("#why-detail")).to_have_text("The service says: Not this one.")
    expect(page.locator("#cusp-rows tr")).to_have_count(6)
    expect(page.locator("#slice-board .cusp")).to_have_count(8)
    open_tab(page, "Loop")
    expect(page.locator("#loop-text")).to_have_text("Not this one.")
    expect(page.locator("#play")).to_be_disabled()
    expect(page.locator("#banner")).to_be_hidden()


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("phone", {"viewport": {"width": 360, "height": 740}, "has_touch": True, "is_mobile": True}),
        long("dark", {"color_scheme": "dark"}),
        long("forced-colours", {"forced_colors": "active"}),
    ],
)
def test_other_ways_of_looking(
    base_url: str, open_page: Open, inspect: Inspect, name: str, options: dict[str, Any]
) -> None:
    page = open_page(base_url, **options)
    count_is(page, "L1 = 27: 8 cusps")
    expect(page.locator("#census-strip rect.bar")).to_have_count(23)
    open_tab(page, "Tolerance")
    page.get_by_role("button", name="Check", exact=True).click()
    expect(page.locator("#verdict")).to_contain_text("8 cusps at L1 = 27")
    inspect(page, name)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    if name == "phone":
        page.get_by_role("option", name=re.compile("^Cusp G")).tap()
        open_tab(page, "Cusps")
        expect(page.get_by_role("button", name="Select cusp G")).to_have_attribute("aria-pressed", "true")
    if name == "dark":
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(17, 21, 26)"


@pytest.mark.long  # each time, service/api/test_prefix follows all links without a browser
@pytest.mark.usefixtures("base_url")  # its worker
def test_under_a_path_of_a_proxy(valkey: EmbeddedValkey, open_page: Open) -> None:
    settings = Settings(redis_url=valkey.url, require_keys="never", root_path="/cusps")
    with serving(settings) as url, proxied(url, "/cusps", strips=True) as outside:
        page = open_page("about:blank")
        asked: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        with page.expect_request("**/openapi.json"):  # what it draws then is dear
            page.goto(f"{outside}/docs", wait_until="commit")
        page.goto(f"{outside}/#g=2,0,1,3,2,5,cw&l1=3")
        expect(page.locator("#count")).to_contain_text("cusps")
        expect(page.locator("#census-strip rect.bar")).not_to_have_count(0)
        page.goto("about:blank")
    assert any("/v1/censuses" in address for address in asked)
    assert [address for address in asked if not address.startswith((f"{outside}/", "about:", "data:"))] == []
