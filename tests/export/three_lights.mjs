// What three.js hands to its shaders for the lights of a file, as JSON.
// Usage: node three_lights.mjs FILE [PACKAGE]; a glTF asset goes through GLTFLoader, all else through ObjectLoader.
// PACKAGE is a release of three.js in package.json; "three" is the newest.
import { readFileSync } from 'node:fs';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const name = process.argv[3] ?? 'three';
const { ColorManagement, ObjectLoader, PerspectiveCamera } = await import(`${name}/src/Three.js`);
const { WebGLLights } = await import(`${name}/src/renderers/webgl/WebGLLights.js`);
ColorManagement.enabled = true; // the default from release 152 on

globalThis.self ??= globalThis; // GLTFLoader expects a browser
const text = readFileSync(process.argv[2], 'utf8');
const json = JSON.parse(text);
const scene = json.asset
  ? (await new GLTFLoader().parseAsync(text, '')).scene
  : new ObjectLoader().parse(json);

const lights = [];
scene.updateMatrixWorld(true);
scene.traverse((thing) => thing.isLight && lights.push(thing));
const { state, setup, setupView } = new WebGLLights({ has: () => true }, { isWebGL2: true });
setup(lights);
setupView(lights, new PerspectiveCamera()); // looks along -z from the origin: view space is the world

const rgb = ({ r, g, b }) => [r, g, b];
const map = scene.environment ?? null;
console.log(JSON.stringify({
  kinds: lights.map((light) => (light.isLightProbe ? 'LightProbe' : light.type)), // older releases call it a Light
  directional: state.directional.map((light) => [light.direction.toArray(), rgb(light.color)]),
  points: state.point.map((light) => [light.position.toArray(), rgb(light.color), light.distance, light.decay]),
  areas: state.rectArea.map((light) => [
    light.position.toArray(),
    rgb(light.color),
    light.halfWidth.toArray(),
    light.halfHeight.toArray(),
  ]),
  ambient: state.ambient,
  hemisphere: state.hemi.map((light) => [light.direction.toArray(), rgb(light.skyColor), rgb(light.groundColor)]),
  // Views are the world: centre, half sides and radiance of each rectangle.
  rectangles: state.rectArea.map((light) => [light.position.toArray(), light.halfWidth.toArray(), light.halfHeight.toArray(), rgb(light.color)]),
  probe: state.probe.map((each) => each.toArray()),
  map: map && {
    mapping: map.mapping,
    flipY: map.flipY,
    width: map.image.width,
    height: map.image.height,
    data: Array.from(map.image.data),
  },
  isBackground: Boolean(map) && scene.background === map,
  turns: [scene.environmentRotation, scene.backgroundRotation].map((turn) => turn?.toArray().slice(0, 3)),
}));
