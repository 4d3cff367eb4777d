// List the sweeps, newest first, with how far each is.
import { every, get, report } from "./api.js";
import { arrange, entitle, h, put } from "./dom.js";
import { FINAL } from "./states.js";

const PERIOD = 3000;
const PAGE = 25;

const sum = (counts, states) => states.reduce((all, state) => all + counts[state], 0);

/** Return how a sweep is in numbers: jobs done, failed or cancelled, left, and in all. */
export function tally(counts) {
  const all = sum(counts, Object.keys(counts)), done = counts.succeeded, failed = counts.failed, cancelled = counts.cancelled;
  return { all, done, failed, cancelled, running: counts.running, left: all - sum(counts, FINAL) };
}

/** Say in words how far a sweep is. */
export function progressOf(counts) {
  const { all, done, failed, cancelled, running, left } = tally(counts);
  const parts = [[done, "done"], [failed, "failed"], [cancelled, "cancelled"], [left, "left"], [running, "of these running"]];
  return `${parts.filter(([count, what]) => count || what === "done").map(([count, what]) => `${count} ${what}`).join(", ")}; ${all} in all`;
}

/** Hold the bar of a sweep: done in the colour of success, failed in that of failure. */
export class Bar {
  constructor(name) {
    this.done = h("span", { class: "part good" });
    this.bad = h("span", { class: "part bad" });
    this.node = h("div", { class: "sweepbar", role: "img" }, this.done, this.bad);
    this.name = name;
  }

  show(counts) {
    const { all, done, failed, cancelled } = tally(counts);
    this.done.style.width = `${(100 * done) / all}%`;
    this.bad.style.width = `${(100 * (failed + cancelled)) / all}%`;
    this.node.setAttribute("aria-label", `${this.name}: ${progressOf(counts)}`);
  }
}

class Line {
  constructor(sweep) {
    this.bar = new Bar(sweep.name);
    this.far = h("div", { class: "narrow faint" });
    this.cells = ["done", "failed", "cancelled", "left", "all"].map((what) => [what, h("td", { class: "number" })]);
    this.row = h("tr", { "data-sweep": sweep.id },
      h("td", { class: "name" }, h("a", { href: `#/sweeps/${sweep.id}` }, sweep.name), " ", h("span", { class: "faint" }, sweep.id.slice(0, 8))),
      h("td", {}, this.bar.node, this.far), ...this.cells.map(([, cell]) => cell), h("td", {}, new Date(sweep.created).toLocaleString()));
  }

  show({ counts }) {
    this.bar.show(counts);
    put(this.far, progressOf(counts));
    const found = tally(counts);
    for (const [what, cell] of this.cells) put(cell, String(found[what]));
  }
}

class List {
  constructor(place, signal) {
    Object.assign(this, { signal, cursors: [null], lines: new Map(), turn: 0 });
    this.body = h("tbody");
    this.empty = h("p", { class: "faint", hidden: true }, "No sweeps here. A protocol with ", h("code", {}, "sweep:"), " or ", h("code", {}, "sample:"),
      " becomes one: ", h("a", { href: "#/new" }, "begin a test"), ".");
    this.newer = h("button", { type: "button", hidden: true, onclick: () => this.go(() => this.cursors.pop()) }, "Newer");
    this.older = h("button", { type: "button", hidden: true, onclick: () => this.go(() => this.cursors.push(this.next)) }, "Older");
    const heads = ["Sweep", "How far", "Done", "Failed", "Cancelled", "Left", "In all", "Submitted"];
    const numbers = heads.slice(2, 7);
    place.append(h("h1", {}, "Sweeps"), h("section", {},
      h("div", { class: "scroll" }, h("table", {},
        h("thead", {}, h("tr", {}, heads.map((name) => h("th", { scope: "col", class: numbers.includes(name) ? "number" : null }, name)))), this.body)),
      this.empty, h("div", { class: "bar" }, this.newer, this.older)));
  }

  go(turn) {
    turn();
    this.refresh().catch(report);
  }

  async refresh() {
    const turn = (this.turn += 1);
    const query = new URLSearchParams({ limit: PAGE, ...(this.cursors.at(-1) && { cursor: this.cursors.at(-1) }) });
    const { sweeps, cursor } = await get(`v1/sweeps?${query}`, this.signal);
    if (turn !== this.turn) return;
    this.next = cursor;
    const lines = new Map(sweeps.map((sweep) => [sweep.id, this.lines.get(sweep.id) ?? new Line(sweep)]));
    this.lines = lines;
    for (const sweep of sweeps) lines.get(sweep.id).show(sweep);
    arrange(this.body, [...lines.values()].map(({ row }) => row));
    this.empty.hidden = sweeps.length > 0;
    this.newer.hidden = this.cursors.length === 1;
    this.older.hidden = !cursor;
  }
}

export async function showSweeps(place, signal) {
  entitle("Sweeps");
  const list = new List(place, signal);
  await list.refresh();
  setTimeout(() => every(signal, async () => {
    await list.refresh();
    return PERIOD;
  }), PERIOD);
}
