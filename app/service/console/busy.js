// Show that something is going on which takes more than a moment, and for how long it has.
import { h, put } from "./dom.js";

const SOON = 300;

/** Hold a bar that is seen while something is waited for; of several things at a time it tells of the latest. */
export class Busy {
  constructor() {
    this.turn = 0;
    this.what = h("span", { role: "status" });
    this.time = h("span", { class: "faint", "aria-hidden": "true" });
    this.bar = h("progress");
    this.node = h("span", { class: "bar busy" }, this.what, this.time);
  }

  /** Do something, and say meanwhile what; `told(text, share)`, which it is given, says how far it is. */
  async during(what, act) {
    const turn = (this.turn += 1);
    const began = Date.now();
    const told = (text, share) => {
      if (turn !== this.turn) return;
      put(this.what, text);
      if (share !== undefined) this.bar.value = share;
    };
    const show = () => {
      if (turn !== this.turn) return;
      this.bar.setAttribute("aria-label", what);
      if (!this.bar.parentNode) this.node.prepend(this.bar);
      if (!this.what.textContent) told(what);
      put(this.time, `${Math.round((Date.now() - began) / 1000)} s`);
    };
    if (this.bar.parentNode) told(what);
    const first = setTimeout(show, SOON), clock = setInterval(show, 1000);
    try {
      return await act(told);
    } finally {
      clearTimeout(first);
      clearInterval(clock);
      if (turn === this.turn) this.clear();
    }
  }

  clear() {
    this.bar.remove();
    this.bar.removeAttribute("value");
    put(this.what, "");
    put(this.time, "");
  }
}
