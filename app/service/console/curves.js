// Draw force over time, and stress over strain with the cycles told apart, as the rows come.
import { Chart } from "./vendor/chart.js";
import { AXES, colour, h } from "./dom.js";

const DASHES = [[], [6, 3], [2, 3], [9, 3, 2, 3]];

/** Return one chart on a canvas of its own. */
function chart(title, x, y) {
  const canvas = h("canvas", { role: "img", "aria-label": `${title}: ${y} over ${x}` });
  const axis = (text) => ({ type: "linear", title: { display: true, text } });
  const made = new Chart(canvas, {
    type: "scatter",
    data: { datasets: [] },
    options: {
      animation: false, maintainAspectRatio: false, showLine: true,
      elements: { point: { radius: 0, hitRadius: 6 }, line: { borderWidth: 1.8, tension: 0 } },
      scales: { x: axis(x), y: axis(y) },
      plugins: { legend: { labels: { boxHeight: 2 } } },
    },
  });
  return { canvas, made };
}

function dress({ made }) {
  const { scales } = made.options;
  for (const axis of [scales.x, scales.y]) {
    axis.ticks = { ...axis.ticks, color: colour("faint") };
    axis.grid = { ...axis.grid, color: colour("line") };
    axis.title.color = colour("ink");
  }
  made.options.plugins.legend.labels.color = colour("ink");
  for (const set of made.data.datasets) set.borderColor = set.backgroundColor = colour(AXES[set.axis]);
  made.update("none");
}

/** Hold the two charts of a job; `size` says section [m²] by axis, once it is known. */
export class Curves {
  constructor(host, signal) {
    this.time = chart("Force and time", "time [s]", "force [N]");
    this.stress = chart("Stress and strain", "strain [%]", "stress [kPa]");
    this.section = null;
    this.waiting = [];
    this.last = {};
    host.append(h("div", { class: "two" },
      [this.time, this.stress].map(({ canvas }) => h("div", { class: "chart" }, canvas))));
    const redress = () => [this.time, this.stress].forEach(dress);
    window.addEventListener("theme", redress, { signal });
    signal.addEventListener("abort", () => [this.time, this.stress].forEach(({ made }) => made.destroy()));
    redress();
  }

  /** Give the sections [m²]; stress is drawn from then on. */
  measure(section) {
    this.section = section;
    const rows = this.waiting;
    this.waiting = [];
    this.addStress(rows);
  }

  add(rows) {
    for (const row of rows) {
      for (const [axis, force] of Object.entries(row.force)) this.set(this.time, axis, 0).data.push({ x: row.time, y: force });
    }
    this.time.made.update("none");
    if (this.section) this.addStress(rows);
    else this.waiting.push(...rows);
  }

  addStress(rows) {
    for (const row of rows) {
      for (const [axis, force] of Object.entries(row.force)) {
        const point = { x: 100 * row.strain[axis], y: force / this.section[axis] / 1e3 };
        const set = this.set(this.stress, axis, row.cycle);
        // A cycle sets out from where the one before ended.
        if (!set.data.length && this.last[axis]) set.data.push(this.last[axis]);
        set.data.push(point);
        this.last[axis] = point;
      }
    }
    this.stress.made.update("none");
  }

  set({ made }, axis, cycle) {
    const found = made.data.datasets.find((set) => set.axis === axis && set.cycle === cycle);
    if (found) return found;
    const tint = colour(AXES[axis]);
    const label = cycle ? `${AXES[axis]}, cycle ${cycle}` : AXES[axis];
    const made_set = { axis, cycle, label, data: [], borderColor: tint, backgroundColor: tint, borderDash: cycle ? DASHES[(cycle - 1) % DASHES.length] : [] };
    made.data.datasets.push(made_set);
    return made_set;
  }
}
