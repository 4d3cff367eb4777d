// Lay jobs over each other: stress and strain of an axis, one curve a job, told apart by colour, dashes and marks.
import { every, get } from "./api.js";
import { Busy } from "./busy.js";
import { MOST } from "./choice.js";
import { chart, paint } from "./curves.js";
import { entitle, h, put } from "./dom.js";
import { drawn, lookOf, swatch } from "./looks.js";
import { FINAL } from "./states.js";
import { thin } from "./thin.js";
import { badge, stamp } from "./verbs.js";
import { AXES, ended, percent, prefixed, si } from "./words.js";

const PERIOD = 3000;
const MARKED = 7;
const QUANTITIES = { stress: ["stress", "Pa"], force: ["force", "N"] };

/** Hold one job of the comparison: its curve, and its line under the plot. */
class Entry {
  constructor(id, style, drop) {
    Object.assign(this, { id, style, job: null, curves: null });
    this.name = h("a", { href: `#/jobs/${id}` }, id);
    this.state = badge();
    this.why = h("span", { class: "wrong" });
    this.figures = ["largest", "peak", "end"].map(() => h("td", { class: "number" }));
    this.figures[2].className = "";
    this.drop = h("button", { type: "button", "aria-label": `take out ${id}`, onclick: drop }, "Take out");
    this.row = h("tr", { "data-job": id }, h("td", { class: "look" }, swatch(style)), h("td", { class: "name" }, this.name, " ", h("span", { class: "faint" }, id.slice(0, 8)), " ", this.why),
      h("td", {}, this.state), ...this.figures, h("td", {}, this.drop));
  }

  get over() {
    return this.failed || (this.job && FINAL.includes(this.job.state) && this.curves);
  }

  /** Take up what the service has of the job; what is wrong with one leaves the others. */
  async refresh(signal) {
    try {
      this.job = await get(`v1/jobs/${this.id}`, signal);
      put(this.name, this.job.name);
      this.drop.setAttribute("aria-label", `take out ${this.job.name}`);
      stamp(this.state, this.job);
      this.curves = await get(`v1/jobs/${this.id}/curves`, signal);
      put(this.why, this.curves.rows ? "" : "no row yet");
    } catch (error) {
      if (!error.problem) throw error;
      const waits = error.problem.status === 409;
      this.failed = !waits || FINAL.includes(this.job?.state);
      put(this.why, waits ? "no record yet" : error.message);
    }
  }

  /** Return the points of the curve [%, SI] along an axis, in one cycle or in all (0). */
  points(axis, quantity, cycle) {
    const along = this.curves?.[quantity][axis];
    if (!along) return [];
    const { strain, cycle: cycles } = this.curves;
    const all = along.map((y, k) => ({ x: 100 * strain[axis][k], y, cycle: cycles[k] }));
    if (!cycle) return all;
    const first = all.findIndex((point) => point.cycle === cycle);
    // A cycle sets out from where the one before ended.
    return all.filter((point, k) => point.cycle === cycle || (k === first - 1 && point.cycle > 0));
  }

  tellFigures(points, unit) {
    const peak = points.reduce((most, one) => (Math.abs(one.y) > Math.abs(most) ? one.y : most), 0);
    put(this.figures[0], points.length ? percent(Math.max(...points.map(({ x }) => x)) / 100) : "");
    put(this.figures[1], points.length ? si(peak, unit) : "");
    put(this.figures[2], this.job?.finished ? ended(this.job) : "");
  }
}

class Overlay {
  constructor(place, signal, ids, asked) {
    Object.assign(this, { signal, place });
    this.entries = ids.map((id, k) => new Entry(id, lookOf(k), () => this.drop(id)));
    this.asked = { axis: asked.get("axis"), cycle: Number(asked.get("cycle") ?? 0) || 0 };
    const chosen = () => { this.keep(); this.draw(); };
    this.axis = h("select", { onchange: chosen });
    this.cycle = h("select", { onchange: chosen }, h("option", { value: 0 }, "all"));
    this.quantity = h("select", { onchange: chosen }, Object.entries(QUANTITIES).map(([value, [name]]) => h("option", { value }, name)));
    if (QUANTITIES[asked.get("y")]) this.quantity.value = asked.get("y");
    this.busy = new Busy();
    this.title = h("h1", { tabindex: "-1" }, `Compare ${ids.length} ${ids.length === 1 ? "job" : "jobs"}`);
    this.none = h("p", { class: "faint" });
    this.panel = chart("Jobs over each other", "strain [%]", "stress");
    this.panel.node.classList.add("tall");
    this.peak = h("th", { scope: "col", class: "number" });
    place.append(
      h("div", { class: "bar spread" }, this.title, this.busy.node),
      h("section", {},
        h("div", { class: "bar" }, h("label", { class: "bar field" }, "Axis ", this.axis), h("label", { class: "bar field" }, "Cycle ", this.cycle), h("label", { class: "bar field" }, "Draw ", this.quantity)),
        this.none, this.panel.node),
      h("section", {}, h("h2", {}, "Which is which"), h("div", { class: "scroll" }, h("table", {},
        h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "Curve"), h("th", { scope: "col" }, "Test"), h("th", { scope: "col" }, "State"),
          h("th", { scope: "col", class: "number" }, "Largest strain"), this.peak, h("th", { scope: "col" }, "End"), h("th", { scope: "col" }, "Ask"))),
        h("tbody", {}, this.entries.map(({ row }) => row))))));
    window.addEventListener("theme", () => this.draw(), { signal });
    signal.addEventListener("abort", () => { cancelAnimationFrame(this.due); this.panel.made.destroy(); });
  }

  /** Keep in the address what is shown, so that it can be bookmarked. */
  keep() {
    const query = new URLSearchParams({ axis: this.axis.value, ...(Number(this.cycle.value) && { cycle: this.cycle.value }), ...(this.quantity.value !== "stress" && { y: this.quantity.value }) });
    history.replaceState(null, "", `#/compare/${this.entries.map(({ id }) => id).join(",")}?${query}`);
  }

  drop(id) {
    const at = this.entries.findIndex((entry) => entry.id === id);
    const [gone] = this.entries.splice(at, 1);
    gone.row.remove();
    (this.entries[Math.min(at, this.entries.length - 1)]?.drop ?? this.title).focus();
    put(this.title, `Compare ${this.entries.length} ${this.entries.length === 1 ? "job" : "jobs"}`);
    this.keep();
    this.draw();
  }

  /** Bring everything up to date; a job whose test is over is not asked for again. */
  async look() {
    const open = this.entries.filter((entry) => !entry.over);
    const first = !this.seen;
    const work = (told) => Promise.all(open.map(async (entry, k) => { await entry.refresh(this.signal); told(`Reading ${open.length} jobs`, (k + 1) / open.length); }));
    await (first ? this.busy.during(`Reading ${open.length} jobs`, work) : work(() => {}));
    if (this.signal.aborted) return 0;
    this.seen = true;
    this.offer();
    this.draw();
    return this.entries.every((entry) => entry.over) ? 0 : PERIOD;
  }

  /** Offer the axes and cycles that any of the jobs has. */
  offer() {
    const known = this.entries.map(({ curves }) => curves).filter(Boolean);
    const axes = [...new Set(known.flatMap(({ force }) => Object.keys(force)))];
    if (this.axis.options.length !== axes.length) {
      const before = this.axis.value || this.asked.axis;
      this.axis.replaceChildren(...axes.map((axis) => h("option", { value: axis }, AXES[axis] ?? axis)));
      if (axes.includes(before)) this.axis.value = before;
    }
    const cycles = Math.max(0, ...known.flatMap(({ cycle }) => cycle));
    for (let k = this.cycle.options.length; k <= cycles; k += 1) this.cycle.append(h("option", { value: k }, k));
    if (this.asked.cycle && this.asked.cycle <= cycles) {
      this.cycle.value = this.asked.cycle;
      this.asked.cycle = 0;
    }
  }

  draw() {
    cancelAnimationFrame(this.due);
    this.due = requestAnimationFrame(() => this.redraw());
  }

  redraw() {
    const { made, node } = this.panel;
    const [name, unit] = QUANTITIES[this.quantity.value];
    const curves = this.entries.map((entry) => entry.points(this.axis.value, this.quantity.value, Number(this.cycle.value)));
    const largest = curves.reduce((most, points) => points.reduce((one, { y }) => Math.max(one, Math.abs(y)), most), 0);
    const [scale, prefix] = largest ? prefixed(largest) : [1, ""];
    const label = `${name} [${prefix}${unit}]`;
    paint(made);
    made.options.scales.y.title.text = label;
    made.options.scales.x.title.text = `strain, ${AXES[this.axis.value] ?? this.axis.value} [%]`;
    put(this.peak, `Largest ${name}`);
    const columns = Math.max(200, node.clientWidth);
    made.data.datasets = this.entries.map((entry, k) => {
      const data = thin(curves[k].map(({ x, y }) => ({ x, y: y / scale })), columns);
      entry.tellFigures(curves[k], unit);
      const step = Math.max(1, Math.ceil(data.length / MARKED)), offset = Math.floor((step * (k + 0.5)) / this.entries.length);
      return {
        ...drawn(entry.style), data, label: entry.job?.name ?? entry.id, pointRadius: data.map((_, at) => (at % step === offset ? 5 : 0)),
      };
    });
    made.canvas.setAttribute("aria-label", `${made.data.datasets.map((set) => set.label).join(", ")}: ${label} over strain`);
    made.update("none");
    const any = curves.some((points) => points.length);
    this.none.hidden = any;
    node.hidden = !any;
    put(this.none, this.seen ? "None of these jobs has rows along this axis yet." : "Reading …");
  }
}

export async function showOverlay(place, signal, list, asked) {
  entitle("Compare");
  const ids = [...new Set(list.split(",").filter(Boolean))];
  if (!ids.length || ids.length > MOST) {
    place.append(h("section", {}, h("h1", {}, "Compare"), h("p", {}, ids.length ? `${ids.length} jobs are named here; at most ${MOST} are compared.` : "No job is named here. ",
      h("a", { href: "#/" }, "Choose two or more in the list of jobs"))));
    return;
  }
  const overlay = new Overlay(place, signal, ids, asked);
  overlay.draw();
  every(signal, () => overlay.look());
}
