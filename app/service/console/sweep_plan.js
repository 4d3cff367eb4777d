// Say what a sweep would do: how many tests, over which values, how long on the rig and how large their logs.
import { h } from "./dom.js";
import { size, span } from "./words.js";

const MOST_LINES = 50;

const value = (one) => h("td", { class: "number" }, String(one ?? ""));

/** Return the totals of a sweep, and a table of its tests. */
export function sweepPlan({ count, looked_at: looked, duration_s: duration, rows, log_bytes: bytes, points }) {
  const about = looked < count ? "about " : "";
  const names = Object.keys(points[0].values);
  const pairs = {
    Tests: count,
    "Over values of": names.map((name) => `${name} (${new Set(points.map(({ values }) => String(values[name]))).size}${about && " and more"})`).join(", ") || "a list of protocols",
    "Take on the rig": `${about}${span(duration)} in all`,
    "Rows of the logs": `${about}${rows}`,
    "Files of the logs": `${about}${size(bytes)} at most`,
  };
  const shown = points.slice(0, MOST_LINES);
  return h("div", {},
    h("dl", {}, Object.entries(pairs).map(([name, text]) => [h("dt", {}, name), h("dd", {}, text)])),
    about && h("p", { class: "faint" }, `The first ${looked} were looked at, the totals estimated from them; all are looked at when they are submitted.`),
    h("div", { class: "scroll strokes", tabindex: "0", role: "group", "aria-label": "Tests of the sweep" }, h("table", {},
      h("thead", {}, h("tr", {}, ["Test", ...names, "Takes", "Rows"].map((name, k) => h("th", { scope: "col", class: k ? "number" : null }, name)))),
      h("tbody", {}, shown.map((point) => h("tr", {}, h("td", {}, point.name), names.map((name) => value(point.values[name])), value(span(point.duration_s)), value(point.rows)))))),
    count > shown.length && h("p", { class: "faint" }, `${count - shown.length} tests more.`),
    h("h3", {}, "The first of them"));
}
