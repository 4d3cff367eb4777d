// Lay a tube around the yarn of a frame.
import { Vector3 } from "./vendor/three.js";

export const SIDES = 10;

/** Cut a frame's numbers into its fields: nodes (3 a node), strains of edges, contact force of nodes. */
export function unpack(buffer, { nodes, edges }) {
  const all = new Float32Array(buffer);
  let at = 0;
  const take = (count) => all.subarray(at, (at += count));
  return { nodes: take(3 * nodes), axial: take(edges), bending: take(edges), contact: take(nodes) };
}

/** Return the places of the yarn at its nodes: they are control points of a quadratic B-spline. */
function yarn(nodes, from, count) {
  const places = [];
  const node = (k) => new Vector3(nodes[3 * k], nodes[3 * k + 1], nodes[3 * k + 2]);
  for (let k = from; k < from + count; k += 1) {
    const here = node(k);
    if (k > from && k < from + count - 1) here.multiplyScalar(6).add(node(k - 1)).add(node(k + 1)).divideScalar(8);
    places.push(here);
  }
  return places;
}

/** Fill a tube around one strand, with normals that turn no more than its centreline does. */
function fillStrand(places, radius, positions, normals, offset) {
  const tangent = new Vector3(), normal = new Vector3(), binormal = new Vector3(), out = new Vector3();
  normal.set(0, 0, 1);
  places.forEach((place, k) => {
    tangent.subVectors(places[Math.min(k + 1, places.length - 1)], places[Math.max(k - 1, 0)]).normalize();
    normal.addScaledVector(tangent, -normal.dot(tangent));
    if (normal.lengthSq() < 1e-6) normal.set(1, 0, 0).addScaledVector(tangent, -tangent.x);
    normal.normalize();
    binormal.crossVectors(tangent, normal);
    for (let side = 0; side < SIDES; side += 1) {
      const angle = (2 * Math.PI * side) / SIDES;
      out.copy(normal).multiplyScalar(Math.cos(angle)).addScaledVector(binormal, Math.sin(angle));
      const at = 3 * (offset + k * SIDES + side);
      out.toArray(normals, at);
      out.multiplyScalar(radius).add(place).toArray(positions, at);
    }
  });
}

/** Fill the corners of all strands, brought to a middle and a scale. */
export function fill(nodes, { strands, radius }, { middle, scale }, positions, normals) {
  let first = 0;
  for (const count of strands) {
    const places = yarn(nodes, first, count).map((place) => place.sub(middle).multiplyScalar(scale));
    fillStrand(places, radius * scale, positions, normals, first * SIDES);
    first += count;
  }
}

/** Return triangles between neighbouring rings of every strand. */
export function triangles(strands) {
  const index = [];
  let first = 0;
  for (const count of strands) {
    for (let k = 0; k < count - 1; k += 1) {
      for (let side = 0; side < SIDES; side += 1) {
        const next = (side + 1) % SIDES;
        const a = (first + k) * SIDES + side, b = (first + k) * SIDES + next;
        index.push(a, b, a + SIDES, b, b + SIDES, a + SIDES);
      }
    }
    first += count;
  }
  return index;
}

/** Return the triangles that are left where the fibre is broken: a gap stands there. */
export const unbroken = (index, axial) => index.filter((_, k) => !Number.isNaN(axial[Math.floor(k / (6 * SIDES))]));

/** Return a field at the nodes: that of an edge is the mean of the two at a node; a broken edge has none. */
export function atNodes(values, strands, perEdge) {
  if (!perEdge) return values;
  const found = [];
  let edge = 0;
  for (const count of strands) {
    for (let k = 0; k < count; k += 1) {
      const beside = [k > 0 ? values[edge + k - 1] : NaN, k < count - 1 ? values[edge + k] : NaN].filter(Number.isFinite);
      found.push(beside.length ? beside.reduce((sum, value) => sum + value, 0) / beside.length : NaN);
    }
    edge += count - 1;
  }
  return found;
}

/** Widen a box {low, high} by the nodes of a frame. */
export function widen({ low, high }, nodes) {
  const one = new Vector3();
  for (let k = 0; k < nodes.length; k += 3) {
    one.fromArray(nodes, k);
    low.min(one);
    high.max(one);
  }
}
