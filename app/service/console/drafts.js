// Keep what is being written, and what was written before another protocol took its place.

const KEYS = { protocol: "knitlab-draft", materials: "knitlab-draft-materials" };
const ASIDE = "knitlab-drafts-aside";
const MOST = 5;

/** Return the texts that were kept; a text is null where there is none. */
export const kept = () => Object.fromEntries(Object.entries(KEYS).map(([name, key]) => [name, localStorage.getItem(key)]));

/** Keep texts as the draft. */
export function keep(texts) {
  for (const [name, key] of Object.entries(KEYS)) localStorage.setItem(key, texts[name]);
}

/** Return the drafts that other protocols took the place of, the latest last. */
export const aside = () => JSON.parse(localStorage.getItem(ASIDE) ?? "[]");

/** Put a draft aside; the oldest go where a browser has no room for all, as with large files. */
export function putAside(texts) {
  for (let all = [...aside(), texts].slice(-MOST); all.length; all = all.slice(1)) {
    try {
      localStorage.setItem(ASIDE, JSON.stringify(all));
      return;
    } catch {
      // One fewer is tried.
    }
  }
}

/** Take back the draft that was put aside last. */
export function takeBack() {
  const all = aside();
  const last = all.pop();
  localStorage.setItem(ASIDE, JSON.stringify(all));
  return last;
}
