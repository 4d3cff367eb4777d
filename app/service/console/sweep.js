// Show one sweep: how far it is, its jobs with what they came to, and a figure over a parameter.
import { every, get, post, report } from "./api.js";
import { Busy } from "./busy.js";
import { Choice, box } from "./choice.js";
import { deleted } from "./deletion.js";
import { arrange, entitle, h, put, tell } from "./dom.js";
import { saveBlob } from "./files.js";
import { FINAL } from "./states.js";
import { Bar, progressOf, tally } from "./sweeps.js";
import { SweepPlot } from "./sweep_plot.js";
import { badge, stamp } from "./verbs.js";
import { ended, figure } from "./words.js";

const PERIOD = 3000;
const STEP = 200;
// What is shown of the figures unless others are chosen: the first of each kind.
const FIRST = [/^secant modulus to peak/, /^loop area,/, /^largest strain of a fibre/];

class Row {
  constructor({ job, values }, parameters, chosen) {
    this.job = job;
    this.state = badge();
    this.end = h("td", { class: "end" });
    this.box = box(job, chosen);
    this.figures = new Map();
    this.fixed = [
      h("td", { class: "box" }, this.box), h("td", { class: "name" }, h("a", { href: `#/jobs/${job.id}` }, job.name)),
      ...parameters.map((name) => h("td", { class: "number" }, String(values[name] ?? ""))), h("td", {}, this.state), this.end];
    this.files = h("td", { class: "files" }, h("a", { href: `#/jobs/${job.id}/files`, "aria-label": `files and plots of ${job.name}` }, "files"));
    this.row = h("tr", { "data-job": job.id }, this.fixed, this.files);
  }

  show({ job, figures }, names, shown) {
    this.job = job;
    stamp(this.state, job);
    put(this.end, job.end === "target" ? "as planned" : job.finished ? ended(job) : job.state === "running" ? `${Math.round(100 * job.progress.share)} %` : "");
    const cells = shown.map((name) => {
      if (!this.figures.has(name)) this.figures.set(name, h("td", { class: "number" }));
      const at = names.findIndex((one) => one.name === name);
      put(this.figures.get(name), figures.length ? figure(figures[at], names[at].unit) : "");
      return this.figures.get(name);
    });
    arrange(this.row, [...this.fixed, ...cells, this.files]);
  }
}

class Sweep {
  constructor(place, signal, id, table) {
    Object.assign(this, { signal, id, limit: STEP, rows: new Map(), shown: [], columns: new Map() });
    const { sweep, parameters } = table;
    this.title = h("h1", { tabindex: "-1" }, sweep.name, " ", h("span", { class: "faint" }, `sweep ${sweep.id}`));
    this.bar = new Bar(sweep.name);
    this.far = h("span");
    this.busy = new Busy();
    this.cancel = h("button", { type: "button", onclick: () => this.act(() => this.cancelAll()) }, "Cancel what is left");
    this.remove = h("button", { type: "button", onclick: () => this.act(() => this.deleteAll()) }, "Delete the sweep");
    this.more = h("button", { type: "button", hidden: true, onclick: () => { this.limit += STEP; this.refresh().catch(report); } }, `Show ${STEP} more`);
    this.choice = new Choice(() => [...this.rows.values()].map((row) => row.box), () => this.refresh().catch(report));
    this.plot = new SweepPlot(parameters, signal);
    this.head = h("tr");
    this.heads = new Map();
    this.body = h("tbody");
    this.which = h("div", { class: "columns" });
    this.picker = h("details", { hidden: true }, h("summary", {}, "Figures in the table"), this.which);
    this.csv = h("button", { type: "button", onclick: () => this.save() }, "Save as CSV");
    place.append(
      h("div", { class: "bar spread" }, this.title, h("div", { class: "bar" }, this.busy.node, this.cancel, this.remove)),
      h("div", { class: "bar" }, this.bar.node, this.far, h("a", { href: `#/?sweep=${id}` }, "As a list of jobs")),
      this.plot.node,
      h("section", {}, h("div", { class: "bar spread" }, h("h2", {}, "Outcomes"), this.csv), this.choice.node, this.picker,
        h("div", { class: "scroll" }, h("table", {}, h("thead", {}, this.head), this.body)), this.more));
    this.show(table);
  }

  /** Read the jobs that are to be shown, page by page. */
  async read(limit) {
    let cursor = null, whole = null;
    do {
      const query = new URLSearchParams({ limit: Math.min(STEP, limit - (whole?.points.length ?? 0)), ...(cursor && { cursor }) });
      const page = await get(`v1/sweeps/${this.id}?${query}`, this.signal);
      whole = whole ? joined(whole, page) : page;
      ({ cursor } = page);
    } while (cursor && whole.points.length < limit);
    return { ...whole, cursor };
  }

  async refresh() {
    this.show(await this.read(this.limit));
  }

  show(table) {
    const { sweep, parameters, figures, points, cursor } = table;
    this.table = table;
    const { left, all } = tally(sweep.counts);
    this.left = left;
    this.bar.show(sweep.counts);
    put(this.far, progressOf(sweep.counts));
    this.cancel.hidden = !left;
    this.remove.hidden = left > 0;
    this.more.hidden = !cursor;
    entitle(left ? `${all - left}/${all} ${sweep.name}` : `${sweep.name}, sweep`);
    this.offer(figures);
    this.heading(parameters, figures);
    const rows = points.map((point) => {
      const row = this.rows.get(point.job.id) ?? new Row(point, parameters, () => this.choice.show());
      row.show(point, figures, this.shown);
      return [point.job.id, row];
    });
    this.rows = new Map(rows);
    this.choice.refresh(points.map(({ job }) => job));
    arrange(this.body, rows.map(([, { row }]) => row));
    this.plot.show(table);
  }

  /** Offer every figure as a column; the first of some kinds are shown until others are chosen. */
  offer(figures) {
    if (!this.columns.size) this.shown = FIRST.map((kind) => figures.find(({ name }) => kind.test(name))?.name).filter(Boolean);
    for (const { name } of figures) {
      if (this.columns.has(name)) continue;
      const input = h("input", { type: "checkbox", onchange: () => this.pick() });
      input.checked = this.shown.includes(name);
      this.columns.set(name, input);
      this.which.append(h("label", { class: "bar field" }, input, name));
    }
    this.picker.hidden = !figures.length;
  }

  pick() {
    this.shown = [...this.columns].filter(([, input]) => input.checked).map(([name]) => name);
    this.show(this.table);
  }

  heading(parameters, figures) {
    const names = ["Choose", "Test", ...parameters, "State", "End", ...this.shown, "More"];
    arrange(this.head, names.map((name, k) => {
      const key = `${k < 2 + parameters.length ? "fixed" : ""} ${name}`;
      const number = parameters.includes(name) || this.shown.includes(name);
      if (!this.heads.has(key)) this.heads.set(key, h("th", { scope: "col", class: number ? "number" : null }, name));
      return this.heads.get(key);
    }));
  }

  /** Do one thing at a time with the whole sweep; the title takes the focus if its button goes. */
  async act(what) {
    if (this.acting) return;
    this.acting = true;
    try {
      await what();
    } catch (error) {
      report(error);
    }
    this.acting = false;
  }

  async all() {
    return (await this.busy.during("Reading the jobs", () => this.read(Infinity))).points.map(({ job }) => job);
  }

  async cancelAll() {
    const open = (await this.all()).filter(({ state }) => !FINAL.includes(state));
    await this.busy.during("Cancelling", async (told) => {
      for (const [k, { id }] of open.entries()) {
        told(`Cancelling ${k + 1} of ${open.length}`, k / open.length);
        await post(`v1/jobs/${id}/cancel`);
      }
    });
    tell(`${open.length} jobs: cancel asked for`);
    await this.refresh();
    this.title.focus();
    this.watch();
  }

  async deleteAll() {
    const jobs = await this.all();
    const gone = await deleted(jobs, this.busy);
    if (gone.length === jobs.length) location.hash = "#/sweeps";
    else if (gone.length) await this.refresh();
  }

  /** Save the whole table, of all jobs, as CSV; a text that a spreadsheet would take for a formula is none. */
  async save() {
    const { sweep, parameters, figures, points } = await this.busy.during("Reading the table", () => this.read(Infinity));
    const cell = (value) => {
      const text = String(value ?? "");
      const safe = typeof value === "string" && /^[=@\t\r]|^[+-](?!\.?\d)/.test(text) ? `'${text}` : text;
      return /[",\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
    };
    const lines = [
      ["job", "id", ...parameters, "state", "end", ...figures.map(({ name, unit }) => `${name} [${unit}]`)],
      ...points.map(({ job, values, figures: own }) => [job.name, job.id, ...parameters.map((name) => values[name]), job.state, job.end, ...figures.map((_, k) => own[k])])];
    saveBlob(new Blob([lines.map((line) => `${line.map(cell).join(",")}\n`).join("")], { type: "text/csv" }), `${sweep.name}.csv`);
  }

  /** Follow the sweep until none of its jobs is left; once at a time. */
  async watch() {
    if (this.watching) return;
    this.watching = true;
    await every(this.signal, async () => {
      if (this.seen) await this.refresh();
      this.seen = true;
      return this.left ? PERIOD : 0;
    });
    this.watching = false;
  }
}

/** Join two pages of a table: a figure that either has is one of both. */
function joined(one, other) {
  const names = new Map([...one.figures, ...other.figures].map((each) => [each.name, each]));
  const all = ({ figures, points }) => points.map((point) => {
    const own = new Map(figures.map(({ name }, k) => [name, point.figures[k]]));
    return { ...point, figures: point.figures.length ? [...names.keys()].map((name) => own.get(name) ?? null) : [] };
  });
  return { ...other, parameters: [...new Set([...one.parameters, ...other.parameters])], figures: [...names.values()], points: [...all(one), ...all(other)] };
}

export async function showSweep(place, signal, id) {
  const table = await get(`v1/sweeps/${id}?limit=${STEP}`, signal);
  new Sweep(place, signal, id, table).watch();
}
