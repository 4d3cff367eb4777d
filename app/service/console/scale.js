// Give every value of a field its colour, and show which colour is which value.
import { Color } from "./vendor/three.js";
import { h } from "./dom.js";
import { prefixed } from "./words.js";

// Light to dark, and sound for colour-blind readers (YlOrRd of ColorBrewer, Apache-2.0).
const MAP = ["#ffffcc", "#ffeda0", "#fed976", "#feb24c", "#fd8d3c", "#fc4e2a", "#e31a1c", "#bd0026", "#800026"].map((hex) => new Color(hex));
const STOPS = 32;
const TICKS = 4;

/** The fields: what a value is written in, and the least range, below which it is the noise of rounding. */
export const FIELDS = {
  axial: { name: "axial strain", least: 1e-4, unit: () => [0.01, "%"] },
  bending: { name: "bending strain", least: 1e-4, unit: () => [0.01, "%"] },
  contact: { name: "contact force", least: 1e-5, unit: (high) => { const [size, prefix] = prefixed(high); return [size, `${prefix}N`]; } },
};

/** Return the colour of a share of the map. */
function shade(share, into) {
  const at = Math.min(1, Math.max(0, share)) * (MAP.length - 1);
  const low = Math.min(MAP.length - 2, Math.floor(at));
  return into.lerpColors(MAP[low], MAP[low + 1], at - low);
}

/** Return about so many round numbers between two. */
function rounds(low, high) {
  const rough = (high - low) / TICKS;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((one) => one * power >= 0.75 * rough);
  const digits = Math.max(0, -Math.floor(Math.log10(step)));
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high * (1 + 1e-9); k += 1) found.push([k * step, (k * step).toFixed(digits)]);
  return found;
}

/** Hold the scale of one field at a time. */
export class Scale {
  constructor() {
    this.title = h("span");
    this.strip = h("span", { class: "strip" });
    this.ticks = h("span", { class: "ticks" });
    const stops = Array.from({ length: STOPS + 1 }, (_, k) => shade(k / STOPS, new Color()).getStyle());
    this.strip.style.background = `linear-gradient(90deg, ${stops.join(", ")})`;
    this.node = h("div", { class: "legend" }, this.title, h("span", {}, this.strip, this.ticks));
  }

  /** Take a field and the range of its values. Zero is always on the scale. */
  set(field, [low, high]) {
    const { name, least, unit } = FIELDS[field];
    this.low = Math.min(0, low);
    this.high = Math.max(0, high);
    if (this.high - this.low < least) [this.low, this.high] = [0, least];
    const [size, symbol] = unit(Math.max(this.high, -this.low));
    this.title.textContent = `${name} [${symbol}]`;
    this.ticks.replaceChildren(...rounds(this.low / size, this.high / size).map(([value, text]) => {
      const tick = h("span", {}, text.replace("-", "−"));
      tick.style.left = `${100 * this.share(value * size)}%`;
      return tick;
    }));
  }

  share(value) {
    return (value - this.low) / (this.high - this.low);
  }

  /** Return the colour of a value; what has none (a broken edge) is like zero. */
  colour(value, into) {
    return shade(this.share(Number.isFinite(value) ? value : 0), into);
  }
}
