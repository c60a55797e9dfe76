// Asks a service for a table, and then for one that it refuses, with the types that openapi-typescript makes.
import createClient from "openapi-fetch";
import type { components, paths } from "./contract.js";

declare const process: { argv: string[] };

type Kinds = "application/json" | "application/problem+json";
const client = createClient<paths, Kinds>({ baseUrl: process.argv[2] });

const geometry: components["schemas"]["Geometry"] = {
  a2x: "15.91", a3x: 0, a3y: 10, d1: 17.04, d2: "16.54", d3: 20.84,
};
const table = await client.POST("/v1/cusp-tables", {
  params: { header: { Prefer: "wait=30" } },
  body: { geometry, l1: "14.98", digits: 15 },
});
if (table.error || !("slices" in table.data)) throw new Error(JSON.stringify(table));
const counts: (number | undefined)[] = table.data.slices.map((slice) => slice.count);
const first: string | undefined = table.data.slices[0]?.cusps?.[0]?.l2;

const refused = await client.POST("/v1/cusp-tables", { body: { geometry, l1: "14.98", digits: 5 } });
const fields: string[] | undefined = refused.error?.errors?.map((error) => error.field);

console.log(JSON.stringify({ counts, first, fields }));
