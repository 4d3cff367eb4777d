// Hold the JSON Schemas of the files that are edited, once the service has sent them.
import { get, report } from "./api.js";

const KINDS = ["protocol", "material"];

export class Schemas {
  constructor(signal) {
    for (const kind of KINDS) this.fetch(kind, signal);
    // Without the service there are no hints; with it there are.
    window.addEventListener("reached", () => KINDS.filter((kind) => !this[kind]).forEach((kind) => this.fetch(kind, signal)), { signal });
  }

  async fetch(kind, signal) {
    try {
      this[kind] = await get(`v1/schemas/${kind}`, signal);
    } catch (error) {
      report(error);
    }
  }
}
