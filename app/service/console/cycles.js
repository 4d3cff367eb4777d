// Tell the cycles of an axis apart: from thick and pale for the first to thin and strong for the latest, which lies on top.
import { colour, h, put } from "./dom.js";
import { AXES } from "./words.js";

const THICK = 5;
const THIN = 1.6;
const MOST_SHADES = 24;

const parts = (hex) => [1, 3, 5].map((at) => Number.parseInt(hex.slice(at, at + 2), 16));

/** Return a colour that lies so far from one to another (both #rrggbb). */
function mixed(from, to, share) {
  const [a, b] = [parts(from), parts(to)];
  return `rgb(${a.map((value, k) => Math.round(value + share * (b[k] - value))).join(", ")})`;
}

/** Return where a cycle stands among some, 0 for the first and 1 for the latest. */
const place = (cycle, cycles) => (cycles > 1 ? (Math.max(1, cycle) - 1) / (cycles - 1) : 1);

/** Return the colour of an axis in one of its cycles. */
export function tint(axis, cycle, cycles) {
  const own = colour(AXES[axis]);
  if (cycles < 2) return own;
  const at = place(cycle, cycles);
  return at < 0.5 ? mixed(own, colour("paper"), 0.5 - at) : mixed(own, colour("ink"), 0.5 * (at - 0.5));
}

/** Return the width of the line of a cycle. */
export const width = (cycle, cycles) => (cycles < 2 ? 1.8 : THICK + (THIN - THICK) * place(cycle, cycles));

/** Hold what tells the axes and cycles of the curves: a ramp of colours for each axis, and a choice of one cycle. */
export class Legend {
  constructor(chosen) {
    this.axes = h("div", { class: "bar" });
    this.select = h("select", { onchange: () => chosen(this.cycle) }, h("option", { value: "" }, "all"));
    this.choice = h("label", { hidden: true }, "Cycle ", this.select);
    this.node = h("div", { class: "bar spread" }, this.axes, this.choice);
  }

  /** Return the cycle that is chosen; 0 for all. */
  get cycle() {
    return Number(this.select.value);
  }

  show(axes, cycles) {
    for (let cycle = this.select.options.length; cycle <= cycles; cycle += 1) this.select.append(h("option", { value: cycle }, cycle));
    this.choice.hidden = cycles < 2;
    const key = [axes.join(), cycles, colour("ink")].join();
    if (key === this.key) return;
    this.key = key;
    this.axes.replaceChildren(...axes.map((axis) => this.entry(axis, cycles)));
  }

  entry(axis, cycles) {
    const ramp = h("span", { class: "ramp" });
    const count = Math.min(Math.max(cycles, 1), MOST_SHADES);
    for (let k = 1; k <= count; k += 1) {
      const shade = h("span");
      shade.style.background = tint(axis, k, count);
      shade.style.height = `${Math.max(2, width(k, count))}px`;
      ramp.append(shade);
    }
    const text = h("span");
    put(text, cycles > 1 ? `${AXES[axis]}, cycles 1 to ${cycles}` : AXES[axis]);
    return h("span", { class: "bar entry" }, ramp, text);
  }
}
