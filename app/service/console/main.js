// Show the page that the address names: the jobs, a job, several over each other, the sweeps, a sweep, a new test.
import { Unreachable } from "./api.js";
import { entitle, h } from "./dom.js";
import { showJobs } from "./jobs.js";
import { showJob } from "./job.js";
import { showNew } from "./new.js";
import { showOverlay } from "./overlay.js";
import { showSweep } from "./sweep.js";
import { showSweeps } from "./sweeps.js";

const page = document.getElementById("page");
const theme = document.getElementById("theme");
let leave = () => {};

/** Remember a theme, and tell whoever draws on a canvas. */
function wear(name) {
  if (name) document.documentElement.dataset.theme = name;
  else delete document.documentElement.dataset.theme;
  localStorage.setItem("knitlab-theme", name);
  window.dispatchEvent(new Event("theme"));
}

/** Mark the link to the page that is shown. */
function point(kind) {
  for (const link of document.querySelectorAll("nav a")) {
    const here = link.getAttribute("href") === (["new", "sweeps"].includes(kind) ? `#/${kind}` : "#/");
    if (here) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
}

function fail(place, error, signal) {
  if (signal.aborted) return;
  if (error instanceof Unreachable) {
    place.replaceChildren(h("p", { class: "faint" }, "This page comes as soon as the service can be reached."));
    window.addEventListener("reached", route, { once: true, signal });
  } else {
    entitle("Not shown");
    place.replaceChildren(h("section", {}, h("h1", {}, "That did not work"), h("p", { class: "wrong" }, error.message)));
  }
}

async function route() {
  leave();
  const [path, query] = location.hash.replace(/^#\/?/, "").split("?");
  const [kind, id, part] = path.split("/").map(decodeURIComponent);
  const controller = new AbortController();
  const { signal } = controller;
  leave = () => controller.abort();
  // Each page fills a place of its own: one that is left before it has loaded fills nothing that is seen.
  const place = h("div");
  page.replaceChildren(place);
  point(kind);
  try {
    const asked = new URLSearchParams(query);
    if (kind === "jobs" && id) await showJob(place, signal, id, part);
    else if (kind === "compare") await showOverlay(place, signal, id ?? "", asked);
    else if (kind === "sweeps" && id) await showSweep(place, signal, id);
    else if (kind === "sweeps") await showSweeps(place, signal);
    else if (kind === "new") await showNew(place, signal, asked.get("job"));
    else await showJobs(place, signal, asked);
  } catch (error) {
    fail(place, error, signal);
  }
}

theme.value = localStorage.getItem("knitlab-theme") ?? "";
wear(theme.value);
theme.addEventListener("change", () => wear(theme.value));
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => wear(theme.value));
// The address names the page already: the skip link moves the focus only.
document.querySelector(".skip").addEventListener("click", (event) => { event.preventDefault(); page.focus(); });
window.addEventListener("hashchange", () => { route(); page.focus(); });
route();
