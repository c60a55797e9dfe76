"""The joint space in three dimensions, in a browser with WebGL by software and in one without."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from PIL import Image

from tests.browser.test_explorer import INNOCENTI, Inspect, Open, count_is, expect, middle, open_tab
from tests.support.processes import PATIENCE

SPACE = f"{INNOCENTI}&l1=27&c=B&v=space"
GEOMETRY = {
    "a2x": "15.91",
    "a3x": "0",
    "a3y": "10",
    "d1": "17.04",
    "d2": "16.54",
    "d3": "20.84",
    "orientation": "ccw",
}
TRIANGLES = """
    const {measured, basePoints, platformPoints} = await import("/static/explorer/geometry.js");
    const lengths = measured(geometry);
    const triangles = {base: basePoints(lengths), platform: platformPoints(lengths, [0, 0], 0)};
"""
CAMERA = """
    const {Camera} = await import("/static/space/camera.js");
    const board = document.getElementById("space-board");
    const {low, high} = JSON.parse(board.dataset.box);
    const camera = new Camera();
    camera.frame(low, high);
    camera.resize(board.clientWidth, board.clientHeight);
    camera.take(board.dataset.eye);
"""
"""The camera of the picture, by the page's own modules."""
SEEN = f"async (places) => {{ {CAMERA} return places.map((place) => camera.project(place)); }}"
FROM_SURFACE = f"""async ([geometry, places]) => {{ {TRIANGLES} {CAMERA}
    const {{surfaceOf}} = await import("/static/space/surface.js");
    const {{positions, index}} = surfaceOf(triangles, 1, high[0]);
    const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    const less = (p, q) => [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    const toSegment = (p, a, b) => {{
        const [way, by] = [less(b, a), less(p, a)];
        const share = Math.min(Math.max(dot(way, by) / (dot(way, way) || 1), 0), 1);
        return Math.hypot(...by.map((x, k) => x - share * way[k]));
    }};
    const toTriangle = (p, a, b, c) => {{
        const [u, v, w] = [less(b, a), less(c, a), less(p, a)];
        const [uu, uv, vv, wu, wv] = [dot(u, u), dot(u, v), dot(v, v), dot(w, u), dot(w, v)];
        const area = uu * vv - uv * uv;
        const [s, t] = [(vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area];
        if (s >= 0 && t >= 0 && s + t <= 1) return Math.hypot(...w.map((x, k) => x - s * u[k] - t * v[k]));
        return Math.min(toSegment(p, a, b), toSegment(p, b, c), toSegment(p, c, a));
    }};
    const corner = (k) => [0, 1, 2].map((i) => positions[3 * index[k] + i]);
    const far = places.map(() => Infinity);
    for (let k = 0; k < index.length; k += 3) {{
        const [a, b, c] = [corner(k), corner(k + 1), corner(k + 2)];
        const least = [0, 1, 2].map((i) => Math.min(a[i], b[i], c[i]));
        const most = [0, 1, 2].map((i) => Math.max(a[i], b[i], c[i]));
        places.forEach((p, n) => {{
            const reach = Math.min(far[n], 1);
            if ([0, 1, 2].some((i) => p[i] < least[i] - reach || p[i] > most[i] + reach)) return;
            far[n] = Math.min(far[n], toTriangle(p, a, b, c));
        }});
    }}
    return far.map((x) => x * camera.unit);
}}"""
"""How many pixels each place is from the surface."""
FROM_EDGES = f"""async ([geometry, document_, lines]) => {{ {TRIANGLES} {CAMERA}
    const {{edgesOf}} = await import("/static/space/edges.js");
    const {{edgeNear}} = await import("/static/space/edge_picking.js");
    const edges = edgesOf(triangles, document_, high[0]);
    return lines.map(({{name, places}}) => {{
        const edge = edges.filter((one) => one.name === name);
        return places.filter((place) => edgeNear(edge, place, 1 / camera.unit) < 0).length;
    }});
}}"""
"""How many places of each line are a pixel or more from the edge of its name."""


@pytest.fixture
def open_space(base_url: str, open_page: Open) -> Iterator[Open]:
    """Opens the joint space, and waits for its cusp curves."""

    def open_it(state: str = SPACE, **options: Any) -> Any:
        page = open_page(f"{base_url}/#{state}", **{"has_webgl": True, **options})
        expect(page.locator("#space-board")).to_have_attribute("data-edges", re.compile("[1-9]"))
        expect(page.locator("#space-board")).to_have_attribute("data-grid", "64,64,48")
        return page

    yield open_it  # noqa: PT022


def told(page: Any, name: str) -> str:
    """What the picture tells of itself."""
    return str(page.locator("#space-board").get_attribute(f"data-{name}"))


def asked(url: str, path: str, **question: Any) -> Any:
    body = {"geometry": GEOMETRY, "digits": 15, **question}
    answer = httpx.post(f"{url}{path}", json=body, headers={"Prefer": "wait=20"}, timeout=PATIENCE)
    assert answer.status_code == 200, answer.text
    return answer.json()


def place_of(point: dict[str, str]) -> list[float]:
    return [float(point[leg]) for leg in ("l1", "l2", "l3")]


def photographed(page: Any) -> Image.Image:
    """The board without its texts."""
    page.locator("#space-board > svg").evaluate("node => { node.style.visibility = 'hidden'; }")
    picture = page.screenshot(clip=page.locator("#space-board").bounding_box())
    page.locator("#space-board > svg").evaluate("node => { node.style.visibility = ''; }")
    return Image.open(io.BytesIO(picture)).convert("RGB")


def clicked(page: Any, place: list[float]) -> None:
    """Clicks at a place (L1, L2, L3)."""
    [[x, y, _]] = page.evaluate(SEEN, [place])
    box = page.locator("#space-board").bounding_box()
    page.mouse.click(box["x"] + x, box["y"] + y)


@pytest.mark.long
def test_the_joint_space_is_turned_and_magnified(
    base_url: str, open_page: Open, open_space: Open, inspect: Inspect
) -> None:
    page = open_page(base_url, has_webgl=True)
    loaded: list[str] = []
    page.on("request", lambda request: loaded.append(request.url))
    count_is(page, "L1 = 27: 8 cusps")
    assert not any("/three/" in url or "/space/" in url for url in loaded), "before it is opened"
    page.get_by_label("space", exact=True).check()
    expect(page.locator("#space-board")).to_have_attribute("data-edges", "24")
    room, board = (page.locator(name).bounding_box() for name in ("#slice", "#space-board"))
    assert board["height"] > 0.6 * room["height"], "the board behind it takes no room"
    page = open_space()
    assert told(page, "drawing") == "webgl"
    expect(page.locator("#space-note")).to_contain_text("64 × 64 × 48")
    expect(page.locator("#space-marks li")).to_contain_text(["surface", "fewer", "cusp curve", "swallowtail"])
    inspect(page, "space")
    before = told(page, "eye")
    board = page.locator("#space-board")
    board.focus()
    for _ in range(3):
        page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowUp")
    expect(board).to_have_attribute("data-eye", "-22,27")
    expect(page).to_have_url(re.compile("&v=space&e=-22,27$"))
    page.keyboard.press("+")
    expect(board).to_have_attribute("data-eye", "-22,27,1.25,0,0,0")
    page.keyboard.press("0")
    expect(board).to_have_attribute("data-eye", before)
    x, y = middle(board)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y + 20, steps=3)
    page.mouse.up()
    expect(board).not_to_have_attribute("data-eye", before)
    page.mouse.wheel(0, -200)
    expect(board).to_have_attribute("data-eye", re.compile(r"^-64,31,1\.3"))
    page.get_by_role("button", name="Show all of the slice").click()
    expect(board).to_have_attribute("data-eye", before)
    page.get_by_label("joint", exact=False).and_(page.locator("#view-joint")).check()
    expect(page.get_by_role("listbox", name="Cusps").get_by_role("option")).to_have_count(8)
    expect(board).to_be_hidden()


def test_what_is_drawn_goes_through_exact_points(base_url: str, open_space: Open) -> None:
    """The surface is within a pixel of a thousand singular points; all cusp curves are on it, and seen."""
    page = open_space()
    places = []
    for length in ("3", "9.2", "14.98", "20", "27", "28.1", "30.9", "34"):
        document = asked(base_url, "/v1/singular-curves", l1=length)
        strands = [strand for component in document["components"] for strand in component["strands"]]
        points = [
            [float(length), *pair]
            for strand in strands
            for pair in zip(strand["l2"], strand["l3"], strict=True)
        ]
        places += points[:: len(points) // 125][:125]
    assert len(places) == 1000
    assert max(page.evaluate(FROM_SURFACE, [GEOMETRY, places])) < 1
    lengths = [str(n / 2) for n in range(1, 70)]
    curves = asked(base_url, "/v1/cusp-curves")
    fine = asked(base_url, "/v1/cusp-curves", l1=lengths)["curves"]
    lines = [{"name": curve["name"], "places": [*map(place_of, curve["points"])]} for curve in fine]
    assert len(lines) == 24
    assert sum(len(line["places"]) for line in lines) > 300
    assert page.evaluate(FROM_EDGES, [GEOMETRY, curves, lines]) == [0] * 24
    picture = photographed(page)
    exact = [place_of(point) for curve in fine for point in curve["points"]]
    red = 0
    for x, y, _ in page.evaluate(SEEN, exact):
        near = [picture.getpixel((round(x) + i, round(y) + j)) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        red += any(pixel[0] > pixel[2] + 10 for pixel in near)
    assert red > 0.8 * len(exact), "marks cover some, and nothing else is red"


def test_a_click_on_an_edge_selects_its_cusp(base_url: str, open_space: Open) -> None:
    page = open_space()
    near = asked(base_url, "/v1/cusp-curves", l1=["10", "27"])["curves"]
    lasting = next(curve for curve in near if curve["name"] == "C2")
    low, high = lasting["points"]
    clicked(page, place_of(low))
    expect(page).to_have_url(re.compile(f"&l1=27&c={chr(64 + high['cusp'])}&"))
    early = asked(base_url, "/v1/cusp-curves", l1=["5"])["curves"]
    passing = next(curve for curve in early if curve["name"] == "C3")
    clicked(page, place_of(passing["points"][0]))
    expect(page).to_have_url(re.compile(r"&l1=(4\.9\d*|5|5\.0\d*)&c="))
    length = re.search("l1=([^&]+)", page.url)[1]  # type: ignore[index]
    there = asked(base_url, "/v1/cusp-curves", l1=[length])["curves"]
    cusp = next(curve for curve in there if curve["name"] == "C3")["points"][0]["cusp"]
    expect(page).to_have_url(re.compile(f"&c={chr(64 + cusp)}&v=space"))
    open_tab(page, "Cusps")
    letter = chr(64 + cusp)
    expect(page.get_by_role("button", name=f"Select cusp {letter}")).to_have_attribute("aria-pressed", "true")


def test_the_loop_and_joint_limits_are_drawn(open_space: Open) -> None:
    page = open_space(f"{INNOCENTI}&l1=27&c=B&v=space&b=5,20,10,30&e=-37,50")
    expect(page.locator("#play")).to_be_enabled()
    expect(page.locator("#space-marks")).to_contain_text("loop")
    expect(page.locator("#space-marks")).to_contain_text("joint limits")
    before = photographed(page)
    pictures = int(told(page, "pictures"))
    page.locator("#scrubber").press("End")
    expect(page.locator("#space-board")).not_to_have_attribute("data-pictures", str(pictures))
    [[x, y, _]] = page.evaluate(SEEN, [[27, 15.5, 16.9]])
    at = round(x) + 2, round(y) + 2
    after = photographed(page)
    assert after.getpixel(at) != before.getpixel(at)
    red, green, _ = after.getpixel(at)
    assert green > red + 30, "the machine is there"


@pytest.mark.long
def test_other_legs_have_slices_too(open_space: Open) -> None:
    page = open_space()
    page.get_by_role("group", name="Slices of leg").get_by_label("2").check()
    expect(page.locator("#space-board")).to_have_attribute("data-edges", "22")
    slider = page.get_by_label("Length L2 of the slice")
    expect(slider).to_have_attribute("aria-valuetext", re.compile("^L2 = "))
    before = slider.get_attribute("aria-valuetext")
    slider.press("ArrowRight")
    expect(slider).not_to_have_attribute("aria-valuetext", str(before))
    expect(page).to_have_url(re.compile(r"&e=[-\d,]+(;|%3B)2,"))


def test_lines_are_drawn_without_webgl(open_space: Open, photograph: Inspect) -> None:
    page = open_space(has_webgl=False)
    assert told(page, "drawing") == "lines"
    expect(page.locator("#space-marks")).to_contain_text("contours of the surface")
    photograph(page, "space-lines")
    colours = photographed(page).getcolors(1 << 24)
    assert colours is not None
    assert len(colours) > 100
    page.locator("#space-board").press("ArrowLeft")
    expect(page.locator("#space-board")).to_have_attribute("data-eye", "-32,22")


@pytest.mark.long
def test_graphics_that_are_taken_away_come_back(open_space: Open) -> None:
    page = open_space()
    lose = """() => {
        const context = document.querySelector("#space-board canvas").getContext("webgl2");
        window.taken = context.getExtension("WEBGL_lose_context");
        window.taken.loseContext();
    }"""
    page.evaluate(lose)
    expect(page.locator("#space-board")).to_have_attribute("data-drawing", "lines")
    page.evaluate("window.taken.restoreContext()")
    expect(page.locator("#space-board")).to_have_attribute("data-drawing", "webgl")
    colours = photographed(page).getcolors(1 << 24)
    assert colours is not None
    assert len(colours) > 1000


@pytest.mark.long
def test_the_picture_is_saved(open_space: Open) -> None:
    page = open_space()
    open_tab(page, "Save")
    page.get_by_label("Picture of").select_option("space")
    expect(page.locator("#svg")).to_be_disabled()
    with page.expect_download() as download:
        page.get_by_role("button", name="PNG").click()
    picture = Image.open(download.value.path())
    size = page.locator("#space-board").evaluate("node => [2 * node.clientWidth, 2 * node.clientHeight]")
    assert list(picture.size) == size
    colours = picture.convert("RGB").getcolors(1 << 24)
    assert colours is not None
    assert len(colours) > 1000
    assert picture.getpixel((2, 2))[:3] == (255, 255, 255)


PINCH = """async (board) => {
    const {x, y, width, height} = board.getBoundingClientRect();
    const at = (type, pointerId, dx) => board.dispatchEvent(new PointerEvent(type, {
        pointerId, pointerType: "touch", isPrimary: pointerId === 1, buttons: 1, bubbles: true,
        clientX: x + width / 2 + dx, clientY: y + height / 2,
    }));
    board.setPointerCapture = () => {};
    at("pointerdown", 1, -30);
    at("pointerdown", 2, 30);
    at("pointermove", 1, -60);
    at("pointermove", 2, 60);
    at("pointerup", 1, -60);
    at("pointerup", 2, 60);
}"""


@pytest.mark.long
def test_fingers_magnify_it_on_a_phone(open_space: Open, inspect: Inspect) -> None:
    page = open_space(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    page.locator("input[name=shown][value=slice]").check()
    box = page.locator("#space-board").bounding_box()
    assert box["height"] > 200
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    inspect(page, "space-phone")
    page.locator("#space-board").evaluate(PINCH)
    expect(page.locator("#space-board")).to_have_attribute("data-eye", re.compile("^-37,22,2,"))


@pytest.mark.long
def test_a_machine_that_is_dragged_has_another_surface(open_space: Open) -> None:
    page = open_space()
    before = told(page, "box")
    page.locator("#d1").fill("19")
    expect(page.locator("#space-board")).not_to_have_attribute("data-box", before)
    expect(page.locator("#space-board")).to_have_attribute("data-edges", re.compile("[1-9]"))
    expect(page.locator("#space-board")).to_have_attribute("data-grid", "64,64,48")
