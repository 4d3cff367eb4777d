// Plot a figure of a sweep's tests over one of its parameters.
import { chart, paint } from "./curves.js";
import { h, put } from "./dom.js";
import { drawn, lookOf, swatch } from "./looks.js";
import { prefixed } from "./words.js";

const MOST_CURVES = 12;
const USUAL = /^secant modulus to peak/;
const QUANTITY = /^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$/;

/** Return the places of values on an axis: by their numbers where all have one unit, else by the order of first sight. */
function scaleOf(values) {
  const parts = values.map((value) => (typeof value === "boolean" ? null : String(value).match(QUANTITY)));
  const units = new Set(parts.map((part) => part?.[2]));
  const numbers = parts.every(Boolean) && units.size === 1;
  const order = [...new Set(values.map(String))];
  return numbers
    ? { unit: [...units][0], place: (value) => Number(String(value).match(QUANTITY)[1]), order: null }
    : { unit: "", place: (value) => order.indexOf(String(value)), order };
}

export class SweepPlot {
  constructor(parameters, signal) {
    this.parameters = parameters;
    const draw = () => this.draw();
    this.over = h("select", { onchange: draw }, parameters.map((name) => h("option", { value: name }, name)));
    this.figure = h("select", { onchange: draw });
    this.legend = h("div", { class: "bar sweeplegend" });
    this.order = null;
    // Values that are no numbers stand on the axis by their order.
    const tick = (place) => (this.order ? this.order[place] ?? "" : String(Number(place.toPrecision(6))));
    this.panel = chart("Sweep", "", "", tick);
    this.none = h("p", { class: "faint" });
    this.drawn = h("div", { hidden: true }, this.legend, this.panel.node);
    this.node = h("section", {}, h("h2", {}, "Figure over parameter"),
      h("div", { class: "bar" }, h("label", { class: "bar field" }, "Figure ", this.figure), h("label", { class: "bar field" }, "Over ", this.over)), this.none, this.drawn);
    this.node.hidden = !parameters.length;
    window.addEventListener("theme", draw, { signal });
    signal.addEventListener("abort", () => { cancelAnimationFrame(this.due); this.panel.made.destroy(); });
  }

  show(table) {
    this.table = table;
    const names = table.figures.map(({ name }) => name);
    if (this.figure.options.length !== names.length) {
      const before = this.figure.value || names.find((name) => USUAL.test(name));
      this.figure.replaceChildren(...names.map((name) => h("option", { value: name }, name)));
      if (names.includes(before)) this.figure.value = before;
    }
    this.draw();
  }

  draw() {
    cancelAnimationFrame(this.due);
    this.due = requestAnimationFrame(() => this.redraw());
  }

  /** Return the curves: points by the values of the other parameters; one of dots alone where these are on no grid. */
  curves(over, at) {
    const { points, parameters } = this.table;
    const others = parameters.filter((name) => name !== over && new Set(points.map(({ values }) => String(values[name]))).size > 1);
    const known = points.filter(({ figures }) => Number.isFinite(figures[at]));
    const groups = new Map();
    for (const point of known) {
      const label = others.map((name) => `${name} = ${point.values[name]}`).join(", ");
      groups.set(label, [...(groups.get(label) ?? []), point]);
    }
    const scattered = groups.size > MOST_CURVES || (groups.size > 1 && groups.size === known.length);
    return scattered ? [{ label: `${others.join(", ")} of all values`, found: known, line: false }] : [...groups].map(([label, found]) => ({ label, found, line: true }));
  }

  redraw() {
    const { made } = this.panel;
    const over = this.over.value, at = this.table.figures.findIndex(({ name }) => name === this.figure.value);
    const curves = at < 0 ? [] : this.curves(over, at);
    this.none.hidden = curves.length > 0;
    put(this.none, "The plot comes with the first test that ends.");
    this.drawn.hidden = !curves.length;
    if (!curves.length) return;
    const { name, unit } = this.table.figures[at];
    const scale = scaleOf(this.table.points.map(({ values }) => values[over]));
    this.order = scale.order;
    const largest = Math.max(...curves.flatMap(({ found }) => found.map(({ figures }) => Math.abs(figures[at]))));
    const [size, prefix] = unit === "1" || !largest ? [1, ""] : prefixed(largest);
    const label = unit === "1" ? name : `${name} [${prefix}${unit}]`;
    paint(made);
    const { x, y } = made.options.scales;
    y.title.text = label;
    x.title.text = scale.unit ? `${over} [${scale.unit}]` : over;
    made.data.datasets = curves.map(({ label: text, found, line }, k) => ({
      ...drawn(lookOf(k)), label: text || name, showLine: line, pointRadius: 5,
      data: found.map(({ figures, values }) => ({ x: scale.place(values[over]), y: figures[at] / size })).sort((a, b) => a.x - b.x),
    }));
    this.legend.replaceChildren(...(curves.length > 1 || curves[0].label ? curves.map(({ label: text, line }, k) => h("span", { class: "bar entry" }, swatch(lookOf(k), line), text)) : []));
    made.canvas.setAttribute("aria-label", `${label} over ${over}, ${curves.length} ${curves.length === 1 ? "curve" : "curves"}`);
    made.update("none");
  }
}
