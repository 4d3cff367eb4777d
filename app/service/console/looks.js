// Give the curves of several tests looks that differ by colour, dashes and marks, so that none needs its colour.
import { colour, s } from "./dom.js";

const COLOURS = 6;
const DASHES = [[], [9, 4], [2, 3], [12, 3, 2, 3]];
// The shapes of Chart.js, and the same drawn in a legend.
const MARKS = [
  ["circle", "M2 5a3 3 0 1 0 6 0a3 3 0 1 0-6 0"], ["triangle", "M5 1L9 8.5H1Z"], ["rect", "M2 2H8V8H2Z"],
  ["rectRot", "M5 .8L9.2 5L5 9.2L.8 5Z"], ["crossRot", "M2 2L8 8M8 2L2 8"],
];

/** Return how the curve of a number looks; no two of the first sixty look alike. */
export const lookOf = (k) => ({ ink: `line-${(k % COLOURS) + 1}`, dash: DASHES[k % DASHES.length], mark: MARKS[k % MARKS.length] });

/** Return a look as Chart.js takes it, in the present theme. */
export const drawn = ({ ink, dash, mark: [pointStyle] }) => ({
  borderColor: colour(ink), backgroundColor: colour(ink), borderWidth: 2, borderDash: dash, pointStyle,
  // Marks on the frame are seen whole.
  clip: 8,
});

/** Draw a look for a legend: its line, unless there are marks alone, and its mark. */
export function swatch({ ink, dash, mark: [, path] }, line = true) {
  return s("svg", { viewBox: "0 0 52 10", width: 52, height: 14, "aria-hidden": "true", style: `color: var(--${ink})` },
    s("path", { d: line ? "M0 5H52" : "", stroke: "currentColor", "stroke-width": 2, "stroke-dasharray": dash.join(" ") || null, fill: "none" }),
    s("g", { transform: "translate(21 0)" }, s("path", { d: path, stroke: "currentColor", "stroke-width": 1.5, fill: "currentColor" })));
}
