// Show the knit as a tube that can be turned and scrubbed through the test, coloured by what its yarn bears.
import {
  BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, HemisphereLight, Mesh, MeshStandardMaterial,
  OrbitControls, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "./vendor/three.js";
import { ask } from "./api.js";
import { AXES, colour, h, percent, si } from "./dom.js";

const SIDES = 10;
const TURN = 0.12;
// Light to dark, and sound for colour-blind readers (YlOrRd of ColorBrewer, Apache-2.0).
const MAP = ["#ffffcc", "#ffeda0", "#fed976", "#feb24c", "#fd8d3c", "#fc4e2a", "#e31a1c", "#bd0026", "#800026"].map((hex) => new Color(hex));
export const FIELDS = {
  axial: { name: "axial strain", write: (value) => percent(value, 2) },
  bending: { name: "bending strain", write: (value) => percent(value, 2) },
  contact: { name: "contact force", write: (value) => si(value, "N") },
};

/** Return the colour of a share of the map. */
function shade(share, into) {
  const at = Math.min(1, Math.max(0, share)) * (MAP.length - 1);
  const low = Math.min(MAP.length - 2, Math.floor(at));
  return into.lerpColors(MAP[low], MAP[low + 1], at - low);
}

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

/** Return triangles between neighbouring rings of every strand. */
function triangles(strands) {
  const index = [];
  let first = 0;
  for (const count of strands) {
    for (let k = 0; k < count - 1; k += 1) {
      for (let side = 0; side < SIDES; side += 1) {
        const next = (side + 1) % SIDES;
        const a = (first + k) * SIDES + side, b = (first + k) * SIDES + next;
        index.push(a, a + SIDES, b, b, a + SIDES, b + SIDES);
      }
    }
    first += count;
  }
  return index;
}

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

/** Hold the view of a job's knit. */
export class Knit {
  constructor(host, job, index, signal) {
    Object.assign(this, { job, index, cache: new Map(), at: 0, field: "axial" });
    this.canvas = h("canvas", { tabindex: "0", role: "img", "aria-describedby": "knit-keys" });
    const box = h("div", { class: "knit" }, this.canvas);
    this.slider = h("input", { type: "range", id: "frame", min: 0, max: index.frames.length - 1, value: 0, oninput: () => this.go(Number(this.slider.value)) });
    this.play = h("button", { type: "button", onclick: () => this.toggle() }, "Play");
    this.select = h("select", { id: "field", onchange: () => { this.field = this.select.value; this.go(this.at); } },
      Object.entries(FIELDS).map(([name, field]) => h("option", { value: name }, field.name)));
    this.where = h("output", { for: "frame" });
    this.low = h("span");
    this.high = h("span");
    host.append(
      h("div", { class: "bar" }, h("label", {}, "Colour by ", this.select), this.play, h("label", { class: "bar", style: "flex:1" }, "Test ", this.slider), this.where),
      box,
      h("div", { class: "legend" }, this.low,
        h("span", { role: "img", "aria-label": "scale of colours, low to high", style: `background: linear-gradient(90deg, ${MAP.map((one) => one.getStyle()).join(", ")})` }),
        this.high),
      h("p", { id: "knit-keys", class: "faint" }, "Drag to turn, scroll to zoom. With the keyboard, on the picture: arrows turn, + and − zoom, Home looks from above, Page Up and Page Down step through the test."));
    this.stage(box, signal);
  }

  stage(box, signal) {
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.scene = new Scene();
    this.scene.add(new HemisphereLight(0xffffff, 0x777788, 2.6));
    const sun = new DirectionalLight(0xffffff, 2.4);
    this.camera = new PerspectiveCamera(30, 1, 0.01, 100);
    this.camera.up.set(0, 1, 0);
    this.camera.add(sun);
    sun.position.set(-1, 1.5, 1);
    this.scene.add(this.camera);
    this.geometry = new BufferGeometry();
    const corners = this.index.nodes * SIDES;
    for (const name of ["position", "normal", "color"]) this.geometry.setAttribute(name, new BufferAttribute(new Float32Array(3 * corners), 3));
    this.whole = triangles(this.index.strands);
    this.geometry.setIndex(this.whole);
    this.scene.add(new Mesh(this.geometry, new MeshStandardMaterial({ vertexColors: true, roughness: 0.55, side: DoubleSide })));
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    const sized = new ResizeObserver(() => this.resize(box));
    sized.observe(box);
    window.addEventListener("theme", () => this.draw(), { signal });
    signal.addEventListener("abort", () => { sized.disconnect(); clearInterval(this.timer); this.renderer.dispose(); });
  }

  resize(box) {
    this.renderer.setSize(box.clientWidth, box.clientHeight, false);
    this.camera.aspect = box.clientWidth / box.clientHeight;
    this.camera.updateProjectionMatrix();
    if (!this.placed) this.home();
    this.draw();
  }

  home() {
    const far = 0.95 / Math.tan((Math.PI / 180) * 15) / Math.min(1, this.camera.aspect);
    this.camera.position.set(0, -0.25 * far, far);
    this.controls.target.set(0, 0, 0);
    this.controls.update();
    this.placed = true;
  }

  key(event) {
    const { key } = event;
    const turns = { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, -TURN], ArrowDown: [0, TURN] };
    if (turns[key]) this.turn(...turns[key]);
    else if (key === "+" || key === "=") this.zoom(1 / 1.15);
    else if (key === "-" || key === "_") this.zoom(1.15);
    else if (key === "Home") this.home();
    else if (key === "PageUp") this.go(Math.min(this.at + 1, this.index.frames.length - 1));
    else if (key === "PageDown") this.go(Math.max(this.at - 1, 0));
    else return;
    event.preventDefault();
    this.draw();
  }

  turn(about, over) {
    const way = this.camera.position.clone().sub(this.controls.target);
    const far = way.length();
    const polar = Math.min(Math.PI - 0.05, Math.max(0.05, Math.acos(way.y / far) + over));
    const around = Math.atan2(way.x, way.z) + about;
    way.set(Math.sin(polar) * Math.sin(around), Math.cos(polar), Math.sin(polar) * Math.cos(around)).multiplyScalar(far);
    this.camera.position.copy(this.controls.target).add(way);
    this.camera.lookAt(this.controls.target);
  }

  zoom(factor) {
    const way = this.camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
    this.camera.position.copy(this.controls.target).add(way);
  }

  toggle() {
    if (this.timer) {
      clearInterval(this.timer);
      this.timer = null;
    } else {
      this.timer = setInterval(() => this.go((this.at + 1) % this.index.frames.length), 150);
    }
    this.play.textContent = this.timer ? "Pause" : "Play";
  }

  /** Take up frames that came since. */
  extend(index) {
    const atEnd = this.at === this.index.frames.length - 1;
    this.index = index;
    this.slider.max = index.frames.length - 1;
    if (atEnd) this.go(index.frames.length - 1);
  }

  async frame(k) {
    if (!this.cache.has(k)) {
      if (this.cache.size > 80) this.cache.delete(this.cache.keys().next().value);
      const found = await (await ask(`v1/jobs/${this.job}/frames/${k}`)).arrayBuffer();
      this.cache.set(k, unpack(found, this.index));
    }
    return this.cache.get(k);
  }

  async go(k) {
    this.at = k;
    this.slider.value = k;
    const shape = await this.frame(k);
    if (this.at !== k) return;
    this.fill(shape);
    const { time, strain, phase, cycle } = this.index.frames[k];
    const strains = Object.entries(strain).map(([axis, value]) => `${AXES[axis]} ${percent(value)}`).join(", ");
    this.where.textContent = `${time.toFixed(1)} s, ${phase} ${cycle}: ${strains}`;
    this.canvas.setAttribute("aria-label", `The knit at ${this.where.textContent}, coloured by ${FIELDS[this.field].name}`);
    this.draw();
  }

  fill(shape) {
    const { position, normal, color } = this.geometry.attributes;
    const { strands, radius } = this.index;
    this.fit ??= this.measure(shape.nodes);
    const { middle, scale } = this.fit;
    let first = 0;
    for (const count of strands) {
      const places = yarn(shape.nodes, first, count).map((place) => place.sub(middle).multiplyScalar(scale));
      fillStrand(places, radius * scale, position.array, normal.array, first * SIDES);
      first += count;
    }
    this.paint(shape, color.array);
    this.cut(shape.axial);
    for (const one of [position, normal, color]) one.needsUpdate = true;
    this.geometry.computeBoundingSphere();
  }

  /** Return what brings the knit to the size of the stage: the same in all frames, so that stretching shows. */
  measure(nodes) {
    const low = new Vector3(Infinity, Infinity, Infinity), high = low.clone().negate(), one = new Vector3();
    for (let k = 0; k < nodes.length; k += 3) {
      one.fromArray(nodes, k);
      low.min(one);
      high.max(one);
    }
    const grown = 1 + Math.max(0, ...this.index.frames.flatMap((frame) => Object.values(frame.strain)));
    return { middle: low.clone().add(high).divideScalar(2), scale: 1.5 / grown / Math.max(...high.sub(low).toArray()) };
  }

  paint(shape, colours) {
    const { strands, range } = this.index;
    const values = atNodes(shape[this.field], strands, this.field !== "contact");
    const [low, high] = range[this.field];
    const tint = new Color();
    values.forEach((value, k) => {
      shade(high > low && Number.isFinite(value) ? (value - low) / (high - low) : 0, tint);
      for (let side = 0; side < SIDES; side += 1) tint.toArray(colours, 3 * (k * SIDES + side));
    });
    this.low.textContent = FIELDS[this.field].write(low);
    this.high.textContent = FIELDS[this.field].write(high);
  }

  /** Leave a gap where the fibre is broken. */
  cut(axial) {
    const broken = axial.some((value) => Number.isNaN(value));
    if (!broken && !this.gaps) return;
    this.gaps = broken;
    const per = 6 * SIDES;
    this.geometry.setIndex(this.whole.filter((_, k) => !Number.isNaN(axial[Math.floor(k / per)])));
  }

  draw() {
    this.scene.background = new Color(colour("ground"));
    this.renderer.render(this.scene, this.camera);
  }
}
