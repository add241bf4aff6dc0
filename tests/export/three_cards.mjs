// What three.js reads of the cards in a file, as JSON.
// Usage: node three_cards.mjs FILE
import { readFileSync } from 'node:fs';
import { ObjectLoader } from 'three';

const scene = new ObjectLoader().parse(JSON.parse(readFileSync(process.argv[2], 'utf8')));
const lights = [];
const planes = [];
scene.updateMatrixWorld(true);
scene.traverse((thing) => {
  if (thing.isLight) {
    const { type, width, height, intensity, color: { r, g, b } } = thing;
    lights.push({ type, width, height, intensity, color: [r, g, b] });
  }
  if (thing.isMesh) {
    const { width, height } = thing.material.map.image;
    planes.push({ type: thing.material.type, texture: [width, height] });
  }
});
console.log(JSON.stringify({ lights, planes }));
