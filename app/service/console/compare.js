// Lay a measured file over the test of a job: both curves, and how far they are apart.
import { ask, report } from "./api.js";
import { Busy } from "./busy.js";
import { chart, paint } from "./curves.js";
import { colour, h, put } from "./dom.js";
import { thin } from "./thin.js";
import { AXES, percent, prefixed, size } from "./words.js";

const MOST_BYTES = 4e6;
const NAMES = { stress: "stress", force: "force", strain: "strain [%]", travel: "travel [mm]" };
const UNITS = { stress: "Pa", force: "N" };
// Of a measured file dark, of the test in the colour of its axis; a band is as wide as its repeats are apart.
const LOOKS = { loading: [1.8], mean: [1.8], unloading: [1.2, [5, 4]], low: [0.8, [2, 2]], high: [0.8, [2, 2]], repeat: [0.5] };

/** Return a field with its label. */
const field = (label, input) => h("label", { class: "bar field" }, label, input);
const text = (hint) => h("input", { type: "text", size: 7, maxlength: 32, placeholder: hint });

export class Comparison {
  constructor(job, signal) {
    Object.assign(this, { job, signal, charts: [] });
    this.file = h("input", { type: "file", required: true, accept: ".csv,.txt,.tsv,.dat,text/csv,text/plain" });
    this.axis = h("select", {}, h("option", { value: "" }, "all"), Object.entries(AXES).map(([axis, name]) => h("option", { value: axis }, name)));
    this.cycle = h("input", { type: "number", min: 1, value: 1, required: true });
    this.offset = h("input", { type: "checkbox" });
    this.said = { gauge_length: text("45 mm"), width: text("40 mm"), thickness: text("1 mm"), slack: text("50 mN") };
    this.send = h("button", { type: "submit", class: "main" }, "Compare");
    this.working = new Busy();
    this.wrong = h("p", { class: "wrong", role: "alert" });
    this.wrong.hidden = true;
    this.found = h("div", {});
    const form = h("form", { class: "bar", onsubmit: (event) => { event.preventDefault(); this.ask().catch(report); } },
      field("File ", this.file), field("Axis ", this.axis), field("Which loading ", this.cycle),
      field("Gauge length ", this.said.gauge_length), field("Width ", this.said.width),
      field("Thickness ", this.said.thickness), field("Slack to ", this.said.slack),
      field("Force from its mean before the start ", this.offset), this.send, this.working.node);
    this.node = h("section", {}, h("h2", {}, "Compare with a measured file"), form, this.wrong, this.found);
    window.addEventListener("theme", () => this.redraw(), { signal });
    signal.addEventListener("abort", () => this.clear());
  }

  clear() {
    for (const { made } of this.charts.splice(0)) made.destroy();
    this.found.replaceChildren();
  }

  /** Say what is wrong; nothing takes it back. */
  say(what) {
    put(this.wrong, what);
    this.wrong.hidden = !what;
  }

  async ask() {
    const [file] = this.file.files;
    if (!file || this.busy) return;
    if (file.size > MOST_BYTES) {
      this.say(`${file.name} is too large: ${size(file.size)}, at most ${size(MOST_BYTES)} are taken. Save every tenth row, say, and choose that file.`);
      return;
    }
    const query = new URLSearchParams({ name: file.name.slice(0, 200), cycle: this.cycle.value, offset: this.offset.checked });
    if (this.axis.value) query.set("axis", this.axis.value);
    for (const [name, input] of Object.entries(this.said)) if (input.value.trim()) query.set(name, input.value.trim());
    this.busy = true;
    try {
      const answer = await this.working.during("Comparing", () => ask(`v1/jobs/${this.job}/compare?${query}`, {
        method: "POST", body: file, signal: this.signal, headers: { "Content-Type": "text/csv" },
      }));
      this.show(await answer.json());
      this.say("");
    } catch (error) {
      if (!error.problem) throw error;
      this.clear();
      this.say(error.problem.detail ?? error.message);
    } finally {
      this.busy = false;
    }
  }

  show({ across, along, curves, scores }) {
    this.clear();
    const axes = [...new Set(curves.map(({ axis }) => axis))];
    const largest = Math.max(...curves.flatMap(({ y }) => y.map(Math.abs)));
    const [scale, prefix] = prefixed(largest);
    const panels = axes.map((axis) => {
      const title = AXES[axis] ?? axis;
      const panel = chart(`Comparison ${title}`, NAMES[across], `${NAMES[along]} [${prefix}${UNITS[along]}]`);
      for (const one of curves.filter((curve) => curve.axis === axis)) {
        const [borderWidth, borderDash = []] = LOOKS[one.part];
        const all = one.x.map((x, k) => ({ x: x * (across === "strain" ? 100 : 1e3), y: one.y[k] / scale }));
        panel.made.data.datasets.push({ label: `${one.name}, ${one.part}`, all, data: [], borderWidth, borderDash, measured: one.measured, axis });
      }
      this.charts.push(panel);
      return h("figure", {}, h("figcaption", {}, title), this.legend(curves.filter((curve) => curve.axis === axis)), panel.node);
    });
    this.found.append(h("div", { class: "two" }, panels), this.table(scores));
    this.redraw();
  }

  /** Return which line is which, once for each test. */
  legend(curves) {
    const names = new Map(curves.map(({ name, measured, axis }) => [name, measured ? "ink" : AXES[axis] ?? "link"]));
    return h("div", { class: "bar" }, [...names].map(([name, ink]) => {
      const strip = h("span", { class: "ramp" }, h("span", {}));
      strip.firstChild.style.height = "3px";
      strip.firstChild.style.background = `var(--${ink})`;
      return h("span", { class: "bar field" }, strip, name);
    }));
  }

  /** Return the scores: a row a figure, a column a test. */
  table(scores) {
    const names = [...new Set(scores.map(({ name }) => name))];
    const rows = new Map();
    for (const one of scores) {
      const key = [one.axis, one.figure, one.unit].join("\n");
      rows.set(key, { ...rows.get(key), one, [`of ${one.name}`]: one });
    }
    const cells = (row) => names.map((name) => h("td", { class: "number" }, this.value(row[`of ${name}`])));
    return h("div", { class: "scroll" }, h("table", {},
      h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "Axis"), h("th", { scope: "col" }, "Figure"), names.map((name) => h("th", { scope: "col", class: "number" }, name)))),
      h("tbody", {}, [...rows.values()].map((row) => h("tr", {}, h("td", {}, AXES[row.one.axis] ?? row.one.axis), h("td", {}, row.one.figure), cells(row))))));
  }

  value(one) {
    if (!one) return "";
    if (one.figure === "NRMSE") return percent(one.value, 2);
    if (one.unit === "1") return Number(one.value.toPrecision(4)).toString();
    if (one.value === 0) return `0 ${one.unit}`;
    const [scale, prefix] = prefixed(one.value);
    return `${(one.value / scale).toPrecision(4)} ${prefix}${one.unit}`;
  }

  redraw() {
    for (const { made, node } of this.charts) {
      paint(made);
      for (const set of made.data.datasets) {
        set.borderColor = set.backgroundColor = set.measured ? colour("ink") : colour(AXES[set.axis] ?? "link");
        set.data = thin(set.all, Math.max(200, node.clientWidth));
      }
      made.update("none");
    }
  }
}
