// Make elements; text is always text, so nothing a job is called can become markup.

/** Return an element: attributes, `on…` listeners, children (nodes, texts, lists, or nothing). */
export function h(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.flat(3).filter((child) => child !== null && child !== undefined && child !== false));
  return made;
}

/** Change a text only if it is another one: what is selected in it, or read of it, stays. */
export function put(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** Bring the children of a node to a list in its order, and move none that is in its place: it would lose the focus. */
export function arrange(node, wanted) {
  const kept = new Set(wanted);
  for (const child of [...node.children]) if (!kept.has(child)) child.remove();
  wanted.forEach((child, k) => { if (node.children[k] !== child) node.insertBefore(child, node.children[k] ?? null); });
}

/** Say something in the corner, and to a screen reader. */
export function tell(text) {
  const status = document.getElementById("status");
  status.textContent = text;
  clearTimeout(tell.timer);
  tell.timer = setTimeout(() => { status.textContent = ""; }, 6000);
}

/** Name what is shown in the title of the window. */
export function entitle(text) {
  document.title = `${text} – knitlab`;
}

/** Return the value of a CSS variable as it is in the present theme. */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Return an element of SVG with attributes and children. */
export function s(tag, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) if (value !== null) made.setAttribute(name, value);
  made.append(...children);
  return made;
}
