/** A call as a request of other programs. */

const quoted = (text) => `'${text.replaceAll("'", `'\\''`)}'`;
const literal = (text) => (text.includes("\n") ? `"""${text.replaceAll("\\", "\\\\")}"""` : JSON.stringify(text));
const indented = (text, by) => text.replaceAll("\n", `\n${by}`);

/** JSON as Python writes it. */
function python(value) {
  const words = { true: "True", false: "False", null: "None" };
  return JSON.stringify(value, null, 4).replace(/("(?:[^"\\]|\\.)*")|\b(true|false|null)\b/g, (_, text, word) => text ?? words[word]);
}

const isJson = (headers) => headers["Content-Type"] === "application/json";

/** The value of a body in JSON; undefined while it is edited and is none. */
function valueOf({ headers, body }) {
  if (!body || !isJson(headers)) return undefined;
  try {
    return JSON.parse(body);
  } catch {
    return undefined;
  }
}

function curl({ method, url, headers, body }) {
  const lines = [`curl ${method === "GET" ? "" : `-X ${method} `}${quoted(url)}`];
  for (const [name, value] of Object.entries(headers)) lines.push(`-H ${quoted(`${name}: ${value}`)}`);
  if (body) lines.push(`--data-binary ${quoted(body)}`);
  return lines.join(" \\\n  ").replace(`'Authorization: Bearer $RPR_CUSPS_API_KEY'`, '"Authorization: Bearer $RPR_CUSPS_API_KEY"');
}

function inPython(request) {
  const { method, url, headers, body } = request;
  const value = valueOf(request);
  const sent = Object.entries(headers).filter(([name]) => value === undefined || name !== "Content-Type");
  const pairs = sent.map(([name, text]) => `"${name}": ${name === "Authorization" ? 'f"Bearer {os.environ[\'RPR_CUSPS_API_KEY\']}"' : JSON.stringify(text)}`);
  const lines = [JSON.stringify(method), JSON.stringify(url)];
  if (pairs.length) lines.push(`headers={${pairs.join(", ")}}`);
  if (value !== undefined) lines.push(`json=${indented(python(value), "    ")}`);
  else if (body) lines.push(`content=${literal(body)}`);
  lines.push("timeout=60");
  const imports = "Authorization" in headers ? "import os\n\nimport httpx" : "import httpx";
  return `${imports}\n\nanswer = httpx.request(\n    ${lines.join(",\n    ")},\n)\nprint(answer.status_code, answer.text)`;
}

function inJavaScript(request) {
  const { method, url, headers, body } = request;
  const value = valueOf(request);
  const pairs = Object.entries(headers).map(([name, text]) => `    "${name}": ${name === "Authorization" ? "`Bearer ${process.env.RPR_CUSPS_API_KEY}`" : JSON.stringify(text)},`);
  const lines = [`  method: ${JSON.stringify(method)},`];
  if (pairs.length) lines.push(`  headers: {\n${pairs.join("\n")}\n  },`);
  if (value !== undefined) lines.push(`  body: JSON.stringify(${indented(JSON.stringify(value, null, 2), "  ")}),`);
  else if (body) lines.push(`  body: ${JSON.stringify(body)},`);
  return `const answer = await fetch(${JSON.stringify(url)}, {\n${lines.join("\n")}\n});\nconsole.log(answer.status, await answer.text());`;
}

/** Language → a request `{ method, url, headers, body }` in it. */
export const LANGUAGES = { curl, Python: inPython, JavaScript: inJavaScript };
