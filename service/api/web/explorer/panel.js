/** Round the boards: tabs, what a pointer or the focus is on, terms of the glossary, what a phone shows. */

import { address } from "./api.js";
import { byId, make, on, write } from "./dom.js";

/** Makes the buttons of a list tabs that work with pointer and keys; `onOpen(tab)` is told which one opens. */
export function bindTabs(list, onOpen) {
  const tabs = [...list.children];
  const open = (tab) => {
    for (const other of tabs) {
      other.role = "tab";
      other.ariaSelected = other === tab;
      other.tabIndex = other === tab ? 0 : -1;
    }
    onOpen(tab);
  };
  tabs.forEach((tab, k) => {
    on(tab, "click", () => {
      open(tab);
      tab.scrollIntoView({ block: "nearest", inline: "center" });
    });
    on(tab, "keydown", (event) => {
      const to = { ArrowRight: k + 1, ArrowLeft: k - 1, Home: 0, End: -1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      tabs.at(to % tabs.length).click();
      tabs.at(to % tabs.length).focus();
    });
  });
  open(tabs[0]);
}

/** The tabs of the panel, the switch of a phone between the boards, hints and the glossary; `onOpen(id)` is told which panel opens. */
export function bindPanel(onOpen) {
  const sections = [...document.querySelectorAll("#panel > section:not([data-absent])")];
  for (const section of sections) {
    const tab = make("button", { id: `tab-${section.id}`, textContent: section.dataset.tab });
    tab.setAttribute("aria-controls", section.id);
    byId("tabs").append(tab);
    Object.assign(section, { role: "tabpanel", tabIndex: 0 });
    section.setAttribute("aria-labelledby", tab.id);
  }
  bindTabs(byId("tabs"), (tab) => {
    for (const section of sections) section.hidden = section.dataset.tab !== tab.textContent;
    if (tab.textContent === "Help") fillTerms();
    onOpen(tab.getAttribute("aria-controls"));
  });
  for (const radio of document.querySelectorAll("input[name=shown]")) on(radio, "change", () => (byId("boards").dataset.shown = radio.value));
  on("keys", "change", () => byId("boards").classList.toggle("keyed", byId("keys").checked));
  on("notice-close", "click", () => (byId("notice").hidden = true));
  bindTips();
  bindTerms();
}

/** Brings a board into view that somebody with a small screen has put away. */
export function reveal(board) {
  if (!byId(board).checkVisibility()) document.querySelector("input[name=shown][value=both]").click();
}

/** Shows a notice that can be closed; an empty one hides it. */
export function notice(text) {
  write("notice-text", text);
  byId("notice").hidden = !text;
}

/** Says beside the pointer or the focus what the thing there is: its `data-what`. */
function bindTips() {
  const [tip, stage] = [byId("tip"), byId("stage")];
  let isPressed = false; // then the focus is where the pointer is
  const hide = () => (tip.hidden = true);
  const show = (target, x, y) => {
    const what = target.closest?.("[data-what]")?.dataset.what;
    tip.hidden = !what;
    if (!what) return;
    write("tip", what);
    const { width, height } = tip.getBoundingClientRect();
    tip.style.left = `${Math.min(Math.max(x + 14, 4), innerWidth - width - 4)}px`;
    tip.style.top = `${y + 18 + height > innerHeight ? y - height - 10 : y + 18}px`;
  };
  on(stage, "pointermove", (event) => (event.buttons ? hide() : show(event.target, event.clientX, event.clientY)), true);
  on(stage, "pointerdown", () => (isPressed = true), true);
  on(window, "pointerup", () => (isPressed = false));
  on(stage, "focusin", ({ target }) => {
    const { right, bottom } = target.getBoundingClientRect();
    if (!isPressed && target.matches(":focus-visible")) show(target, right, bottom);
  });
  for (const event of ["pointerleave", "pointerdown", "focusout"]) on(stage, event, hide, true);
  on(document, "keydown", ({ key }) => key === "Escape" && hide());
}

let glossary = null;

async function terms() {
  glossary ??= fetch(address("static/explorer/glossary.json")).then((response) => response.json());
  return glossary;
}

/** A click on a term shows its definition. */
function bindTerms() {
  on(document, "click", async ({ target }) => {
    const button = target.closest(".term");
    if (!button) return;
    const name = (button.dataset.term ?? button.textContent).toLowerCase();
    const known = Object.entries(await terms()).find(([term]) => term.toLowerCase() === name);
    write("definition-text", known ? `${known[0]}: ${known[1]}` : `${name} is not in the glossary.`);
    byId("definition").showPopover();
  });
  on("term-filter", "input", fillTerms);
}

async function fillTerms() {
  const wanted = byId("term-filter").value.trim().toLowerCase();
  const entries = Object.entries(await terms()).filter((entry) => entry.join(" ").toLowerCase().includes(wanted));
  const nodes = entries.flatMap(([term, meaning]) => [make("dt", { textContent: term }), make("dd", { textContent: meaning })]);
  byId("terms").replaceChildren(...nodes);
}
