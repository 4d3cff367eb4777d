// Say what the service refuses in words of the page: its own are for programs, and some for the command line.

import { AXES } from "./words.js";

// What the fields of a request are called in the page.
const LABELS = {
  axis: "Axis", cycle: "Which loading", slack: "Slack to", gauge_length: "Gauge length", width: "Width", thickness: "Thickness",
  offset: "Force from its mean before the start", pictures: "Plots and pictures of every test",
};

// A text in a page has no files beside it: what to do instead, by the end of the place that names one.
const BESIDE = "a text without a file";
const INSTEAD = [
  [/(^|\/)materials$/, (file) => `materials: no file ${file} is here; open Materials below the protocol and put its text there`],
  [/\/centreline$/, (file) => `centreline: no file ${file} is here; add it under Files below the protocol`],
  [/\/table$/, (file) => `table: no file ${file} is here; add it under Files below the protocol`],
];

// What a measured file lacks: the command line takes that from a mapping, the page from the file itself.
const LACKING = [
  [/expected the unit of (column .*), in its heading.*$/, "$1 has no unit; write it into the heading of the file, as in Load [N]"],
  [/expected headings with time.*$/, "no headings are known; give the file a first line such as Time [s],Load [N],Extension [mm]"],
];

// What to do by the kind of a problem; `detail` is what the service said.
const KINDS = {
  unknown: () => "That is not there any more; it may have been deleted. Jobs shows what there is.",
  busy: ({ detail }) => `The service is busy: ${detail}. Try again in a moment.`,
  away: () => "The service cannot keep its data for the moment. Try again in a moment.",
  full: () => "The disk of the service is full. Delete jobs that are no longer needed, then try again.",
  "not-ended": () => "This job has not ended. Press cancel first; delete it once it is cancelled.",
  "key-used": () => "This was sent before with another text. Press Submit again.",
  "too-large": ({ detail }) => `That is too large for the service: ${detail}.`,
  "too-slow": () => "Sending took too long. Try again, or over a faster connection.",
  swept: () => "This protocol is a sweep; New test submits it as one.",
  forbidden: () => "The service takes nothing from a page at this address. Open it at the address under which it was started.",
};
const FAILED = "The service failed. Its log, on the machine where it runs, says how.";

/** Return what to say of one place, or nothing where the service's words do. */
function ofPlace({ detail = "", pointer = "", parameter }) {
  if (detail.includes(BESIDE)) {
    const [, file = ""] = detail.match(/: found '?(.*?)'?, allowed /) ?? [];
    const found = INSTEAD.find(([where]) => where.test(pointer));
    if (found) return found[1](file);
  }
  const lacking = LACKING.find(([words]) => words.test(detail));
  if (lacking) return detail.replace(...lacking);
  const label = LABELS[parameter];
  if (!label || !detail.startsWith(`${parameter}:`)) return null;
  return `${label}${detail.slice(parameter.length)}`.replace(/one of ([CWP]{1,2}(?:, [CWP]{1,2})*)$/, (_, axes) => `one of ${axes.split(", ").map((axis) => AXES[axis] ?? axis).join(", ")}`);
}

/** Return a problem of the service as it is told in the page. */
export function inPage(problem) {
  const said = KINDS[problem.type?.split(":").at(-1)];
  if (said) return { ...problem, detail: said(problem) };
  if (problem.status === 500) return { ...problem, detail: FAILED };
  const errors = (problem.errors ?? []).map((place) => ({ ...place, detail: ofPlace(place) ?? place.detail }));
  let { detail } = problem;
  problem.errors?.forEach((place, k) => { detail = detail?.replace(place.detail, () => errors[k].detail); });
  return { ...problem, detail, ...(problem.errors && { errors }) };
}
