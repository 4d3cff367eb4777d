// Speak REST with the service that this page came from.

export class Problem extends Error {
  constructor(problem) {
    super(problem.detail ?? problem.title ?? "the service did not answer");
    this.problem = problem;
  }
}

const TOKEN = "knitlab-token";

/** Ask, and return the response; an error of the service becomes a `Problem`. */
export async function ask(path, options = {}) {
  const headers = { ...options.headers };
  const token = sessionStorage.getItem(TOKEN);
  if (token) headers.Authorization = `Bearer ${token}`;
  let response;
  try {
    response = await fetch(path, { ...options, headers });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Problem({ detail: "the service cannot be reached" });
  }
  if (response.status === 401) {
    const given = window.prompt("This service asks for its token:");
    if (given) {
      sessionStorage.setItem(TOKEN, given.trim());
      return ask(path, options);
    }
  }
  if (!response.ok) {
    const kind = response.headers.get("content-type") ?? "";
    throw new Problem(kind.includes("json") ? await response.json() : { detail: `${response.status} ${response.statusText}` });
  }
  return response;
}

export const get = async (path) => (await ask(path)).json();
export const post = async (path) => (await ask(path, { method: "POST" })).json();

/** Send a protocol's text. */
export const sendProtocol = (path, text, headers = {}) =>
  ask(path, { method: "POST", body: text, headers: { "Content-Type": "application/yaml", ...headers } });

/** Follow server-sent events to their end; comes back after a cut with the id of the last one seen. */
export async function follow(path, handle, signal) {
  let last = "";
  while (!signal.aborted) {
    try {
      const response = await ask(path, { signal, headers: last ? { "Last-Event-ID": last } : {} });
      if (response.status === 204) return;
      let rest = "";
      const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
      for (;;) {
        const { value, done } = await reader.read();
        if (done) break;
        const events = (rest + value).split("\n\n");
        rest = events.pop();
        for (const event of events) {
          const found = Object.fromEntries(event.split("\n").map((line) => line.split(/: (.*)/s).slice(0, 2)));
          if (found.id) last = found.id;
          if (found.data) handle(found.event, JSON.parse(found.data));
        }
      }
    } catch (error) {
      if (error.name === "AbortError") return;
      if (error instanceof Problem && error.problem.status === 404) throw error;
    }
    await new Promise((resolve) => setTimeout(resolve, 2000));
  }
}
