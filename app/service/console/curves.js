// Draw force over time, and stress over strain with the cycles told apart, as the rows come.
import { Chart } from "./vendor/chart.js";
import { Legend, tint, width } from "./cycles.js";
import { colour, h, put } from "./dom.js";
import { thin } from "./thin.js";
import { AXES } from "./words.js";

/** Return one chart on a canvas of its own; `tick` writes the numbers of its x axis, if given. */
export function chart(title, x, y, tick = null) {
  const canvas = h("canvas", { role: "img", "aria-label": `${title}: ${y} over ${x}` });
  const axis = (text, ticks = {}) => ({ type: "linear", title: { display: true, text }, ticks });
  const made = new Chart(canvas, {
    type: "scatter",
    data: { datasets: [] },
    options: {
      animation: false, maintainAspectRatio: false, showLine: true,
      elements: { point: { radius: 0, hitRadius: 6 }, line: { tension: 0 } },
      scales: { x: axis(x, tick ? { callback: tick } : {}), y: axis(y) },
      plugins: { legend: { display: false } },
    },
  });
  return { made, sets: new Map(), node: h("div", { class: "chart" }, canvas) };
}

/** Give the axes of a chart the colours of the present theme. */
export function paint({ options: { scales } }) {
  for (const axis of [scales.x, scales.y]) {
    axis.ticks = { ...axis.ticks, color: colour("faint") };
    axis.grid = { ...axis.grid, color: colour("line") };
    axis.title.color = colour("ink");
  }
}

/** Return the set of an axis and a cycle (0: of them all), which keeps every point beside the thinned ones. */
function setOf({ made, sets }, axis, cycle) {
  const key = `${axis} ${cycle}`;
  if (!sets.has(key)) {
    // The lower the order, the nearer to the top: the latest cycle lies on the others.
    const made_one = { axis, cycle, label: cycle ? `${AXES[axis]}, cycle ${cycle}` : AXES[axis], data: [], all: [], order: -cycle };
    sets.set(key, made_one);
    made.data.datasets.push(made_one);
  }
  return sets.get(key);
}

/** Hold the two charts of a job. */
export class Curves {
  constructor(signal) {
    this.time = chart("Force and time", "time [s]", "force [N]");
    this.stress = chart("Stress and strain", "strain [%]", "stress [kPa]");
    this.legend = new Legend(() => this.redraw());
    Object.assign(this, { section: null, waiting: [], last: {}, axes: [], cycles: 0, limits: [], rows: new Map() });
    this.none = h("p", { class: "faint" });
    this.drawn = h("div", { hidden: true }, this.legend.node, h("div", { class: "two" }, this.time.node, this.stress.node));
    this.node = h("section", {}, h("h2", {}, "Curves"), this.none, this.drawn);
    this.stress.node.hidden = true;
    window.addEventListener("theme", () => this.redraw(), { signal });
    signal.addEventListener("abort", () => {
      cancelAnimationFrame(this.due);
      for (const { made } of [this.time, this.stress]) made.destroy();
    });
  }

  /** Say why nothing is drawn. */
  say(over) {
    put(this.none, over ? "No row was recorded." : "No row is recorded yet.");
  }

  /** Give the sections [m²] by axis; stress is drawn from then on. */
  measure(section) {
    if (this.section) return;
    this.section = section;
    this.addStress(this.waiting.splice(0));
    this.redraw();
  }

  /** Take the rows at which limits of the material were passed: from there on a curve is not to be believed. */
  mark(limits) {
    if (limits.length === this.limits.length) return;
    this.limits = limits;
    this.redraw();
  }

  /** Put a cross on every curve where a limit was passed; on stress once the sections are known. */
  drawMarks() {
    const rows = this.limits.map(({ row }) => this.rows.get(row)).filter(Boolean);
    const marks = (chart, place) => {
      const all = rows.flatMap((row) => Object.keys(row.force).map((axis) => place(row, axis)));
      Object.assign(setOf(chart, "", 0), { all, label: "beyond strength", showLine: false, pointStyle: "crossRot", pointRadius: 7, order: -1e6 });
    };
    marks(this.time, (row, axis) => ({ x: row.time, y: row.force[axis] }));
    if (this.section) marks(this.stress, (row, axis) => this.point(row, axis));
  }

  /** Return the strain [%] and the stress [kPa] of an axis at a row. */
  point(row, axis) {
    return { x: 100 * row.strain[axis], y: row.force[axis] / this.section[axis] / 1e3 };
  }

  add(rows) {
    for (const row of rows) {
      this.rows.set(row.row, row);
      for (const [axis, force] of Object.entries(row.force)) {
        if (!this.axes.includes(axis)) this.axes.push(axis);
        setOf(this.time, axis, 0).all.push({ x: row.time, y: force });
      }
      this.cycles = Math.max(this.cycles, row.cycle);
    }
    if (this.section) this.addStress(rows);
    else this.waiting.push(...rows);
    this.redraw();
  }

  addStress(rows) {
    for (const row of rows) {
      for (const axis of Object.keys(row.force)) {
        const point = this.point(row, axis);
        const { all } = setOf(this.stress, axis, row.cycle);
        // A cycle sets out from where the one before ended.
        if (!all.length && this.last[axis]) all.push(this.last[axis]);
        all.push(point);
        this.last[axis] = point;
      }
    }
  }

  /** Draw what has come since, once for the next picture on the screen however many rows there are. */
  redraw() {
    cancelAnimationFrame(this.due);
    this.due = requestAnimationFrame(() => {
      this.none.hidden = this.axes.length > 0;
      this.drawn.hidden = !this.axes.length;
      this.stress.node.hidden = !this.stress.sets.size;
      this.legend.show(this.axes, this.cycles);
      if (this.limits.length) this.drawMarks();
      for (const one of [this.time, this.stress]) this.draw(one);
    });
  }

  draw({ made, sets, node }) {
    paint(made);
    const columns = Math.max(200, node.clientWidth);
    for (const set of sets.values()) {
      set.data = thin(set.all, columns);
      set.hidden = Boolean(set.cycle && this.legend.cycle && set.cycle !== this.legend.cycle);
      const plain = colour(AXES[set.axis] ?? "ink");
      set.borderColor = set.backgroundColor = set.cycle ? tint(set.axis, set.cycle, this.cycles) : plain;
      set.borderWidth = set.cycle ? width(set.cycle, this.cycles) : 1.8;
    }
    made.update("none");
  }
}
