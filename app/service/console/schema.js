// Walk through a JSON Schema: which fields and values a place of a file may have, and what they are.

/**
 * A level of a place: `{ key, siblings }` for the value of a key, with the names of the keys beside it, or `{ item }`
 * for an item of a list, counted from 0. A place is the levels that lead to it from the top of the file.
 */

const known = (form, names) => Boolean(form.properties) && names.every((name) => name in form.properties);

/** Return the part of a schema that a reference such as `#/$defs/RampModel` names. */
const referred = (root, reference) => reference.split("/").slice(1).reduce((part, name) => part?.[name], root);

/** Return the forms that a value may have: no references, no choices, no null. */
export function forms(schema, root) {
  if (!schema) return [];
  if (schema.$ref) return forms(referred(root, schema.$ref), root);
  const choices = schema.anyOf ?? schema.oneOf;
  if (choices) return choices.flatMap((choice) => forms(choice, root));
  return schema.type === "null" ? [] : [schema];
}

/** Return those of the forms of a mapping that have all the keys which are there already; all, if none has. */
function fitting(every, names) {
  const fit = every.filter((form) => known(form, names));
  return fit.length ? fit : every;
}

function below(form, { key, item }) {
  if (key === undefined) return form.prefixItems?.[item] ?? form.items;
  const other = form.additionalProperties;
  return form.properties?.[key] ?? (typeof other === "object" ? other : undefined);
}

/** Return the schemas of the value at a place, one for each kind that it may be of. */
export function schemasAt(root, place) {
  let found = [root];
  for (const level of place) {
    const every = found.flatMap((schema) => forms(schema, root));
    const fit = level.key === undefined ? every : fitting(every, [...level.siblings, level.key]);
    found = fit.map((form) => below(form, level)).filter(Boolean);
  }
  return found;
}

/** Return the fields that the mapping at a place may have beside those that it has: name, schema, whether it must be there. */
export function fieldsAt(root, place, names) {
  const every = schemasAt(root, place).flatMap((schema) => forms(schema, root));
  const fields = new Map();
  for (const { properties = {}, required = [] } of fitting(every, names)) {
    for (const [name, schema] of Object.entries(properties)) {
      if (!names.includes(name) && !fields.has(name)) fields.set(name, { name, schema, required: required.includes(name) });
    }
  }
  return [...fields.values()];
}

/** Return the words that a value may be. */
function words(schema) {
  const { enum: allowed, const: only, examples = [], type } = schema;
  const found = [...(allowed ?? (only === undefined ? [] : [only])), ...examples, ...(type === "boolean" ? [true, false] : [])];
  return (found.includes("on") ? found.filter((word) => typeof word !== "boolean") : found).map(String);
}

const unique = (list) => [...new Set(list)];

/** Return the words that a value of some schemas may be. */
export const valuesOf = (schemas, root) => unique(schemas.flatMap((schema) => [...words({ examples: schema.examples }), ...forms(schema, root).flatMap(words)]));

/** Return the units that a quantity of some schemas may have. */
export const unitsOf = (schemas, root) => unique(schemas.flatMap((schema) => forms(schema, root)).flatMap((form) => form["x-units"] ?? []));

/** Return a default as a file would have it; nothing where there is none to tell. */
function written(value, values, units) {
  if (value === undefined || value === null || typeof value === "object") return undefined;
  if (typeof value === "boolean" && values.includes("on")) return value ? "on" : "off";
  const unit = typeof value === "number" && units.length && units[0] !== "%" ? ` ${units[0]}` : "";
  return `${value}${unit}`;
}

/** Return what is known of a field: what it is, what it may be, words, units and default. */
export function helpOf(name, schemas, root) {
  const [first = {}] = schemas;
  // What allows a list allows its items.
  const items = schemas.flatMap((schema) => forms(schema, root)).map((form) => form.items).filter(Boolean);
  const values = valuesOf([...schemas, ...items], root), units = unitsOf(schemas, root);
  const described = first.description ?? forms(first, root)[0]?.description;
  return { name, title: first.title === name ? undefined : first.title, described, values, units, default: written(first.default, values, units) };
}
