/** Pictures to keep: the same that the service draws for print, as SVG or PNG. */

import { address, fileOf, save } from "./api.js";
import { byId, copy, make, on, say } from "./dom.js";
import { MODES, hashOf, letterOf } from "./state.js";

const SCALE = 2; // pixels of a PNG by one of the picture

export class Save {
  #state = null;
  #canvases;

  /** `canvases` gives those of pictures that the page itself draws, by name. */
  constructor(canvases) {
    this.#canvases = canvases;
    on("picture", "change", () => (byId("svg").disabled = byId("picture").value in canvases));
    on("copy-link", "click", () => copy(location.href, "The link is copied."));
    on("copy-frame", "click", () => copy(frameOf(this.#state), "The line for a page is copied."));
    on("svg", "click", () => save(pictureOf(this.#state, byId("picture").value), "image/svg+xml", "cusps.svg"));
    on("png", "click", () => this.#png());
  }

  show(state) {
    this.#state = state;
  }

  /** Says that there is nothing to save, since what is asked is wrong. */
  block(isWrong) {
    byId("unsaved").hidden = !isWrong;
    for (const node of byId("save").querySelectorAll(":scope > :not(#unsaved)")) node.inert = isWrong;
  }

  async #png() {
    try {
      const own = this.#canvases[byId("picture").value];
      const canvas = own ? await own() : await this.#printed();
      make("a", { href: canvas.toDataURL("image/png"), download: "cusps.png" }).click();
    } catch (error) {
      say(error.message);
    }
  }

  async #printed() {
    const svg = await (await fileOf(pictureOf(this.#state, byId("picture").value), "image/svg+xml")).text();
    const image = new Image();
    image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
    await image.decode();
    const canvas = make("canvas", { width: SCALE * image.width, height: SCALE * image.height });
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
    return canvas;
  }
}

/** The board as an element of another page. */
function frameOf({ home, mode, ...state }) {
  const link = `${address("embed")}${hashOf({ ...state, mode: MODES[0] })}`.replaceAll("&", "&amp;").replaceAll('"', "%22");
  return `<iframe src="${link}" width="640" height="560" title="Cusps of a 3-RPR manipulator" loading="lazy"></iframe>`;
}

/** The question of a picture; it is light on white, as for print. */
function pictureOf({ geometry, l1, cusp, at }, plot) {
  const isPosed = plot === "mechanism" && at;
  const members = {
    slice: { l1 }, torus: { l1 }, loop: { l1, cusp: letterOf(cusp) }, census: {},
    mechanism: isPosed ? { l1, l2: at.l2, l3: at.l3, pose: at.pose + 1 } : { l1, cusp: letterOf(cusp) },
  }[plot];
  return ["v1/plots", { geometry, plot, ...members, theme: "light" }];
}
