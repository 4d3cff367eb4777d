// Write numbers, strains and ends as people say them.

export const AXES = { C: "course", W: "wale", P: "pile", WC: "shear-WC", PC: "shear-PC", PW: "shear-PW" };

const ENDS = {
  target: "Carried out to its end", rupture: "Ruptured", slipped: "Slipped, nothing broke", unravelled: "Unravelled", limit: "Stopped at a limit", cancelled: "Cancelled",
  timeout: "Timed out", memory: "Out of memory", diverged: "No equilibrium found", error: "Failed", crash: "Crashed",
};

/** Write a share as a percentage. */
export const percent = (share, digits = 1) => `${(100 * share).toFixed(digits)} %`;

const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

/** Return the SI prefix that suits a number, and what it stands for. */
export const prefixed = (value) => PREFIXES.find(([size]) => Math.abs(value) >= size) ?? PREFIXES.at(-1);

/** Write a number with an SI prefix and its unit. */
export function si(value, unit) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return `0 ${unit}`;
  const [scale, prefix] = prefixed(value);
  return `${(value / scale).toPrecision(3)} ${prefix}${unit}`;
}

/** Write a figure of a test. */
export function figure(value, unit) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  return unit === "1" ? Number(value.toPrecision(4)).toString() : si(value, unit.replace("m3", "m³"));
}

/** Write seconds. */
export function span(seconds) {
  if (seconds === null || seconds === undefined) return "–";
  if (seconds < 90) return `${Math.max(0, Math.round(seconds))} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}

/** Write the length of a file. */
export function size(bytes) {
  if (bytes < 1e3) return `${bytes} B`;
  return bytes < 1e5 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

/** Write the strain of every axis. */
export const strains = (strain) => Object.entries(strain).map(([axis, value]) => `${AXES[axis]} ${percent(value)}`).join(", ");

/** Say what a job is doing, and where its axes are. */
export function doing({ text, strain, force }) {
  const places = Object.keys(strain).map((axis) => `${AXES[axis]} ${percent(strain[axis])}, ${si(force[axis], "N")}`);
  // After its colon the text gives the strains again.
  return places.length ? `${text.split(":")[0]}: ${places.join("; ")}` : text;
}

/** Say in a word or two how a job ended. */
export const ended = ({ end, state }) => ENDS[end] ?? end ?? state;

/** Say in a sentence how a job ended, and why. */
export const ending = (job) => `${ended(job)}${job.message ? `: ${job.message.replace(/\.$/, "")}` : ""}.`;
