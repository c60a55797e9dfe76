/** What surrounds the boards: tabs, what a pointer or the focus is on, terms of the glossary, what a phone shows. */

import { address } from "./api.js";

const byId = (id) => document.getElementById(id);

/** Makes a list of tabs work with pointer and keys; `onOpen(tab)` is told which one opens. */
export function bindTabs(list, onOpen) {
  const tabs = [...list.querySelectorAll("[role=tab]")];
  const open = (tab, isFocused) => {
    for (const other of tabs) {
      other.setAttribute("aria-selected", String(other === tab));
      other.tabIndex = other === tab ? 0 : -1;
    }
    if (isFocused) tab.focus();
    tab.scrollIntoView({ block: "nearest", inline: "nearest" });
    onOpen(tab);
  };
  tabs.forEach((tab, k) => {
    tab.addEventListener("click", () => open(tab));
    tab.addEventListener("keydown", (event) => {
      const to = { ArrowRight: k + 1, ArrowLeft: k - 1, Home: 0, End: -1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      open(tabs.at(to % tabs.length), true);
    });
  });
  return open;
}

/** The tabs of the panel, the switch of a phone between the boards, hints and the glossary. */
export function bindPanel() {
  const open = bindTabs(byId("tabs"), (tab) => {
    for (const panel of byId("panel").querySelectorAll(":scope > [role=tabpanel]")) panel.hidden = panel.id !== tab.getAttribute("aria-controls");
    if (tab.id === "tab-help") fillTerms();
  });
  for (const radio of document.querySelectorAll("input[name=shown]")) {
    radio.addEventListener("change", () => (byId("boards").dataset.shown = radio.value));
  }
  byId("keys").addEventListener("change", () => byId("boards").classList.toggle("keyed", byId("keys").checked));
  byId("notice-close").addEventListener("click", () => (byId("notice").hidden = true));
  bindTips();
  bindTerms();
  return { open: (name) => open(byId(`tab-${name}`)) };
}

/** Brings a board into view that somebody with a small screen has put away. */
export function reveal(board) {
  if (!byId(board).checkVisibility()) document.querySelector("input[name=shown][value=both]").click();
}

/** Shows a notice that can be closed; an empty one hides it. */
export function notice(text) {
  byId("notice-text").textContent = text;
  byId("notice").hidden = !text;
}

/** Says beside the pointer or the focus what the thing there is: its `data-what`. */
function bindTips() {
  const tip = byId("tip");
  let isPressed = false; // then the focus is where the pointer is
  const hide = () => (tip.hidden = true);
  const show = (target, x, y) => {
    const what = target.closest?.("[data-what]")?.dataset.what;
    tip.hidden = !what;
    if (!what) return;
    tip.textContent = what;
    const { width, height } = tip.getBoundingClientRect();
    tip.style.left = `${Math.min(Math.max(x + 14, 4), innerWidth - width - 4)}px`;
    tip.style.top = `${y + 18 + height > innerHeight ? y - height - 10 : y + 18}px`;
  };
  byId("stage").addEventListener("pointermove", (event) => (event.buttons ? hide() : show(event.target, event.clientX, event.clientY)));
  byId("stage").addEventListener("pointerleave", hide);
  byId("stage").addEventListener("pointerdown", () => {
    isPressed = true;
    hide();
  });
  window.addEventListener("pointerup", () => (isPressed = false));
  byId("stage").addEventListener("focusin", ({ target }) => {
    if (isPressed || !target.matches(":focus-visible")) return;
    const { right, bottom } = target.getBoundingClientRect();
    show(target, right, bottom);
  });
  byId("stage").addEventListener("focusout", hide);
  document.addEventListener("keydown", ({ key }) => key === "Escape" && hide());
}

let glossary = null;

/** The terms of the glossary with their definitions, asked for when somebody wants one. */
async function terms() {
  glossary ??= fetch(address("static/explorer/glossary.json")).then((response) => response.json());
  return glossary;
}

/** A click on a term shows its definition. */
function bindTerms() {
  document.addEventListener("click", async ({ target }) => {
    const button = target.closest(".term");
    if (!button) return;
    const name = (button.dataset.term ?? button.textContent).toLowerCase();
    const known = Object.entries(await terms()).find(([term]) => term.toLowerCase() === name);
    byId("definition-text").textContent = known ? `${known[0]}: ${known[1]}` : `${name} is not in the glossary.`;
    byId("definition").showPopover();
  });
  byId("term-filter").addEventListener("input", fillTerms);
}

async function fillTerms() {
  const wanted = byId("term-filter").value.trim().toLowerCase();
  const entries = Object.entries(await terms()).filter((entry) => entry.join(" ").toLowerCase().includes(wanted));
  const nodes = entries.flatMap(([term, meaning]) => [["dt", term], ["dd", meaning]].map(([tag, text]) => Object.assign(document.createElement(tag), { textContent: text })));
  byId("terms").replaceChildren(...nodes);
}
