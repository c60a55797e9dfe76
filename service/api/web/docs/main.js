/** The page of the HTTP API: every call of the contract, its members, its request in three languages, and its answer. */

import { address, key } from "../explorer/api.js";
import { byId, copy, make, on } from "../explorer/dom.js";
import { LANGUAGES } from "./requests.js";
import { item, members, readFrom, resolved, typeOf } from "./schemas.js";
import { inline, prose } from "./text.js";

const METHODS = ["post", "get", "put", "delete"];
const MOST = 20_000; // characters of an answer that are shown

let language = "curl"; // in which the reader wants requests

function show(contract) {
  const calls = [...Object.entries(contract.paths), ...Object.entries(contract.webhooks ?? {})].flatMap(([path, methods]) =>
    METHODS.filter((method) => method in methods).map((method) => ({ path, method, call: methods[method], shared: methods.parameters ?? [] })),
  );
  for (const { name, description } of contract.tags) {
    const own = calls.filter(({ call }) => call.tags?.includes(name));
    if (!own.length) continue;
    byId("contents").append(make("h2", { textContent: name }), make("ul", {}, ...own.map(entry)));
    byId("calls").append(make("section", {}, make("h2", { textContent: name }), make("p", { textContent: description }), ...own.map(block)));
  }
  byId("calls").ariaBusy = "false";
  byId("key").value = key.get();
  on("key", "input", () => {
    key.set(byId("key").value);
    renew();
  });
  on("key-form", "submit", (event) => event.preventDefault());
  on("filter", "input", filter);
  on(window, "hashchange", openLinked);
  openLinked();
}

const word = (method) => make("span", { className: `method ${method}`, textContent: method.toUpperCase() });

function entry({ path, method, call }) {
  const link = make("a", { href: `docs#${call.operationId}`, title: call.summary }, word(method), path.replace(/^\/v1/, ""));
  return make("li", {}, link);
}

function filter() {
  const text = byId("filter").value.toLowerCase();
  for (const entries of byId("contents").querySelectorAll("ul")) {
    for (const line of entries.children) line.hidden = !`${line.textContent} ${line.firstChild.title}`.toLowerCase().includes(text);
    entries.hidden = entries.previousSibling.hidden = [...entries.children].every((line) => line.hidden);
  }
}

function openLinked() {
  const linked = byId(location.hash.slice(1));
  if (linked?.matches("details")) {
    linked.open = true;
    linked.scrollIntoView();
  }
}

/** A call; what is in it is made when it is opened. */
function block(shown) {
  const { path, method, call } = shown;
  const head = make("summary", {}, word(method), make("code", { textContent: path }), make("span", {}, ...inline(call.summary)));
  const whole = make("details", { id: call.operationId, className: "call" }, head);
  const parts = () => (path.startsWith("/") ? [about(shown), request(shown)] : [about(shown)]); // webhooks are sent by the service
  on(whole, "toggle", () => whole.append(make("div", { className: "body" }, ...parts())), { once: true });
  return whole;
}

const parametersOf = ({ call, shared }) => [...shared, ...(call.parameters ?? [])].map(resolved);

function about(shown) {
  const { call } = shown;
  const left = make("div", {}, ...prose(call.description));
  const parameters = parametersOf(shown);
  if (parameters.length) {
    const list = make("dl");
    for (const { name, in: place, schema = {}, required, description } of parameters) {
      list.append(...item(place === "header" ? `${name}:` : name, schema, required, description));
    }
    left.append(make("h3", { textContent: "Parameters" }), list);
  }
  for (const [form, { schema }] of Object.entries(call.requestBody?.content ?? {})) {
    left.append(make("h3", {}, "Body: ", make("code", { textContent: form })));
    left.append(...prose(resolved(schema).description), members(schema));
  }
  left.append(make("h3", { textContent: "Answers" }), make("dl", {}, ...Object.entries(call.responses).flatMap(answer)));
  return left;
}

function answer([status, response]) {
  const { description, content = {} } = resolved(response);
  const forms = Object.keys(content);
  const term = make("dt", {}, make("code", { textContent: status }), " ", make("small", { textContent: forms.join(", ") }));
  const detail = make("dd", {}, ...prose(description));
  const { schema, example } = content["application/json"] ?? {};
  if (schema) {
    const below = make("details", {}, make("summary", { textContent: typeOf(schema) }));
    on(below, "toggle", () => below.append(members(schema), ...(example ? [pre(JSON.stringify(example, null, 2))] : [])), { once: true });
    detail.append(below);
  }
  return [term, detail];
}

const pre = (text) => make("pre", { textContent: text, tabIndex: 0 });

const renewals = new Set(); // what writes the requests that are open again
const renew = () => renewals.forEach((each) => each());

/** The request of a call: its parameters and its body, edited; in the reader's language; and the answer. */
function request(shown) {
  const { path, method, call } = shown;
  const right = make("div", {}, make("h3", { textContent: "Request" }));
  const fields = parametersOf(shown).map((parameter) => ({ ...parameter, input: field(parameter, right) }));
  const [form, content] = Object.entries(call.requestBody?.content ?? {})[0] ?? [];
  const body = form && make("textarea", { rows: 12, spellcheck: false, ariaLabel: "Body" });
  if (body) right.append(examples(content, body), body);

  const code = pre("");
  const tabs = make("div", { role: "tablist", ariaLabel: "Language" });
  for (const name of Object.keys(LANGUAGES)) {
    const tab = make("button", { role: "tab", textContent: name, onclick: () => { language = name; renew(); } });
    tabs.append(tab);
  }
  const asked = () => requested({ path, method, fields, form, body });
  const write = () => {
    for (const tab of tabs.children) tab.ariaSelected = String(tab.textContent === language);
    const { headers, ...rest } = asked();
    const shownHeaders = { ...headers, ...(key.get() ? { Authorization: "Bearer $RPR_CUSPS_API_KEY" } : {}) };
    code.textContent = LANGUAGES[language]({ ...rest, headers: shownHeaders });
  };
  renewals.add(write);
  for (const input of [...fields.map((each) => each.input), body].filter(Boolean)) on(input, "input", write);
  const result = make("div");
  const buttons = make("div", { className: "row" },
    make("button", { className: "send", textContent: "Send", onclick: () => send(asked(), result) }),
    make("button", { textContent: "Copy the request", onclick: () => copy(code.textContent, "The request is copied.") }));
  right.append(tabs, code, buttons, result);
  write();
  return right;
}

/** The input of a parameter. */
function field({ name, in: place, schema = {}, required, example, examples: several }, parent) {
  const choices = resolved(schema).enum;
  const first = example ?? Object.values(several ?? {})[0]?.value ?? (required ? schema.example : undefined) ?? "";
  const input = choices
    ? make("select", {}, ...["", ...choices].map((value) => make("option", { textContent: value })))
    : make("input", { value: required || name === "Prefer" ? first : "", placeholder: String(first) });
  parent.append(make("label", { className: "row" }, make("code", { textContent: name }), place === "path" ? " in the path" : "", input));
  return input;
}

/** The choice of examples of a body. */
function examples({ example, examples: several }, body) {
  const texts = Object.values(several ?? { only: { summary: "example", value: example ?? {} } });
  const select = make("select", { ariaLabel: "Example" }, ...texts.map(({ summary }) => make("option", { textContent: summary })));
  const take = () => {
    const { value } = texts[select.selectedIndex];
    body.value = typeof value === "string" ? value : JSON.stringify(value, null, 2);
  };
  on(select, "input", () => {
    take();
    body.dispatchEvent(new Event("input"));
  });
  take();
  return make("div", { className: "row" }, select);
}

function requested({ path, method, fields, form, body }) {
  const headers = form ? { "Content-Type": form } : {};
  const query = new URLSearchParams();
  let filled = path;
  for (const { name, in: place, input } of fields) {
    const value = input.value.trim();
    if (place === "path") filled = filled.replace(`{${name}}`, value ? encodeURIComponent(value) : name.toUpperCase());
    else if (value && place === "query") query.append(name, value);
    else if (value && place === "header") headers[name] = value;
  }
  const words = query.toString();
  return { method: method.toUpperCase(), url: address(filled) + (words && `?${words}`), headers, body: body?.value };
}

async function send({ method, url, headers, body }, place) {
  place.replaceChildren(make("p", { textContent: "Waiting for the answer …" }));
  const bearer = key.get() ? { Authorization: `Bearer ${key.get()}` } : {};
  const start = performance.now();
  try {
    const response = await fetch(url, { method, headers: { ...headers, ...bearer }, body });
    const text = await response.text();
    const isJson = response.headers.get("content-type")?.includes("json") && !response.headers.get("content-type").includes("ndjson");
    const shown = isJson && text.length < MOST ? JSON.stringify(JSON.parse(text), null, 2) : text;
    const cut = shown.length > MOST ? `${shown.slice(0, MOST)}\n… ${shown.length - MOST} characters more` : shown;
    const kept = ["content-type", "location", "content-location", "retry-after", "etag"].filter((name) => response.headers.has(name));
    const lines = kept.map((name) => `${name}: ${response.headers.get(name)}`);
    const seconds = ((performance.now() - start) / 1000).toFixed(2);
    place.replaceChildren(make("h3", { textContent: `${response.status} ${response.statusText} · ${seconds} s` }), pre([...lines, "", cut].join("\n")));
  } catch (error) {
    place.replaceChildren(make("p", { role: "alert", textContent: `The service cannot be reached: ${error.message}` }));
  }
}

const contract = await (await fetch("openapi.json")).json();
readFrom(contract);
show(contract);
