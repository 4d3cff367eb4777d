// Put a shape on a stage that can be turned, moved and zoomed, by pointer and by keyboard.
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, HemisphereLight, Mesh, MeshStandardMaterial, OrbitControls,
  PerspectiveCamera, Scene, WebGLRenderer,
} from "./vendor/three.js";
import { colour } from "./dom.js";
import { SIDES, triangles, unbroken } from "./tube.js";

const TURN = 0.12;
const ZOOM = 1.15;
const HALF_ANGLE = (Math.PI / 180) * 15;

export class Stage {
  /** Throws where there is no WebGL. */
  constructor(canvas, { nodes, strands }, signal) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.scene = new Scene();
    // Light from the eye alone, of a strength that shows what faces it in just its colour of the scale; edges darken.
    this.light = new HemisphereLight(0xffffff, 0x000000, Math.PI);
    this.camera = new PerspectiveCamera(30, 1, 0.01, 100);
    this.camera.up.set(0, 1, 0);
    this.geometry = new BufferGeometry();
    for (const name of ["position", "normal", "color"]) {
      this.geometry.setAttribute(name, new BufferAttribute(new Float32Array(3 * nodes * SIDES), 3));
    }
    this.whole = triangles(strands);
    this.geometry.setIndex(this.whole);
    const yarn = new MeshStandardMaterial({ vertexColors: true, roughness: 1, side: DoubleSide });
    this.scene.add(this.light, new Mesh(this.geometry, yarn));
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    window.addEventListener("theme", () => this.draw(), { signal });
    const sized = new ResizeObserver(() => this.resize());
    sized.observe(canvas.parentElement);
    signal.addEventListener("abort", () => {
      sized.disconnect();
      this.renderer.dispose();
      // A browser gives a page few of these; the next view needs one.
      this.renderer.forceContextLoss();
    });
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    if (!this.placed) this.home();
    this.draw();
  }

  home() {
    const far = 0.95 / Math.tan(HALF_ANGLE) / Math.min(1, this.camera.aspect);
    this.camera.position.set(0, -0.25 * far, far);
    this.controls.target.set(0, 0, 0);
    this.controls.update();
    this.placed = true;
  }

  /** Do what a key stands for, and tell whether it stands for anything. */
  key(key) {
    const turns = { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, -TURN], ArrowDown: [0, TURN] };
    if (turns[key]) this.turn(...turns[key]);
    else if (key === "+" || key === "=") this.zoom(1 / ZOOM);
    else if (key === "-" || key === "_") this.zoom(ZOOM);
    else if (key === "Home") this.home();
    else return false;
    this.draw();
    return true;
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

  /** Take up what was written into the geometry's attributes; a gap where the axial strain says that it broke. */
  update(axial) {
    const broken = axial.some((value) => Number.isNaN(value));
    if (broken || this.gaps) this.geometry.setIndex(broken ? unbroken(this.whole, axial) : this.whole);
    this.gaps = broken;
    for (const one of Object.values(this.geometry.attributes)) one.needsUpdate = true;
    this.geometry.computeBoundingSphere();
    this.draw();
  }

  draw() {
    this.scene.background = new Color(colour("stage"));
    this.light.position.copy(this.camera.position).sub(this.controls.target);
    this.renderer.render(this.scene, this.camera);
  }
}
