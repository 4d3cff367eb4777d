// Bundle what the console uses of other packages, one file each, and gather their licences.
import { copyFileSync, existsSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const parts = {
  three: `
    export { BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, HemisphereLight, Mesh, MeshStandardMaterial,
      PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
    export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";`,
  chart: `
    import { Chart, Legend, LinearScale, LineElement, PointElement, ScatterController, Tooltip } from "chart.js";
    Chart.register(Legend, LinearScale, LineElement, PointElement, ScatterController, Tooltip);
    export { Chart };`,
  codemirror: `
    export { autocompletion, closeCompletion, completionKeymap, pickedCompletion, startCompletion } from "@codemirror/autocomplete";
    export { EditorState, StateEffect, StateField } from "@codemirror/state";
    export { EditorView, drawSelection, highlightActiveLine, hoverTooltip, keymap, lineNumbers, showTooltip } from "@codemirror/view";
    export { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
    export { HighlightStyle, indentUnit, syntaxHighlighting } from "@codemirror/language";
    export { yaml, yamlLanguage } from "@codemirror/lang-yaml";
    export { lintGutter, linter } from "@codemirror/lint";
    export { tags } from "@lezer/highlight";`,
};

const used = new Set();
for (const [name, contents] of Object.entries(parts)) {
  const { metafile } = await build({
    stdin: { contents, resolveDir: "." }, bundle: true, minify: true, format: "esm", metafile: true,
    legalComments: "none", outfile: `${name}.js`,
  });
  for (const input of Object.keys(metafile.inputs)) {
    const found = input.match(/node_modules\/((?:@[^/]+\/)?[^/]+)\//);
    if (found) used.add(found[1]);
  }
}

// The page of the REST documentation comes as one bundle of its own.
for (const name of ["swagger-ui-bundle.js", "swagger-ui.css"]) copyFileSync(`node_modules/swagger-ui-dist/${name}`, name);
used.add("swagger-ui-dist");

const licences = [...used].sort().map((name) => {
  const folder = `node_modules/${name}`;
  const { version, license } = JSON.parse(readFileSync(`${folder}/package.json`));
  const file = readdirSync(folder).find((one) => /^licen[cs]e/i.test(one));
  const text = file && existsSync(`${folder}/${file}`) ? readFileSync(`${folder}/${file}`, "utf8").trim() : `Licence: ${license}`;
  return `${name} ${version}\n\n${text}\n`;
});
writeFileSync("LICENSES.txt", licences.join("\n----\n\n"));
