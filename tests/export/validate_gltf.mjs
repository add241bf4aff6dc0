// The Khronos validator's report on a glTF asset, as JSON. Usage: node validate_gltf.mjs FILE
import { readFileSync } from 'node:fs';
import validator from 'gltf-validator';

const bytes = new Uint8Array(readFileSync(process.argv[2]));
console.log(JSON.stringify(await validator.validateBytes(bytes, { maxIssues: 0 })));
