// Show the page that the address names: the jobs, a job, a new test.
import { h } from "./dom.js";
import { showJobs } from "./jobs.js";
import { showJob } from "./job.js";
import { showNew } from "./new.js";

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

async function route() {
  leave();
  const address = location.hash.replace(/^#\/?/, "");
  const [kind, id] = address.split("/");
  page.replaceChildren();
  for (const link of document.querySelectorAll("nav a")) {
    const here = link.getAttribute("href") === (kind === "new" ? "#/new" : "#/");
    if (here) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  const left = new AbortController();
  leave = () => left.abort();
  try {
    if (kind === "jobs" && id) await showJob(page, decodeURIComponent(id), left.signal);
    else if (kind === "new") await showNew(page, left.signal, id);
    else await showJobs(page, left.signal);
  } catch (error) {
    if (left.signal.aborted) return;
    page.replaceChildren(h("section", {}, h("h1", {}, "That did not work"), h("p", { class: "wrong" }, error.message)));
  }
}

theme.value = localStorage.getItem("knitlab-theme") ?? "";
wear(theme.value);
theme.addEventListener("change", () => wear(theme.value));
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => wear(theme.value));
window.addEventListener("hashchange", () => { route(); page.focus(); });
route();
