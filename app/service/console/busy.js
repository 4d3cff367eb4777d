// Show that something is going on which takes more than a moment, and for how long it has.
import { h, put } from "./dom.js";

const SOON = 300;

/** Hold a bar that is seen while something is waited for; its node has a place from the beginning. */
export class Busy {
  constructor() {
    this.what = h("span", { role: "status" });
    this.time = h("span", { class: "faint", "aria-hidden": "true" });
    this.bar = h("progress");
    this.node = h("span", { class: "bar busy" }, this.what, this.time);
  }

  /** Do something, and say meanwhile what; `told(text, share)`, which it is given, says how far it is. */
  async during(what, act) {
    const began = Date.now();
    const show = () => {
      this.bar.setAttribute("aria-label", what);
      if (!this.bar.parentNode) this.node.prepend(this.bar);
      put(this.time, `${Math.round((Date.now() - began) / 1000)} s`);
    };
    const told = (text, share) => {
      put(this.what, text);
      if (share !== undefined) this.bar.value = share;
    };
    const first = setTimeout(() => { show(); if (!this.what.textContent) told(what); }, SOON);
    const clock = setInterval(show, 1000);
    try {
      return await act(told);
    } finally {
      clearTimeout(first);
      clearInterval(clock);
      this.bar.remove();
      this.bar.removeAttribute("value");
      put(this.what, "");
      put(this.time, "");
    }
  }
}
