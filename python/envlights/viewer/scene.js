// The picture: WebGL programs, textures and uniforms. Nothing here knows the page around the canvas.

const VERTEX = `#version 300 es
void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0, 0, 1); }`;
const PRESENT = `#version 300 es
precision highp float;
uniform sampler2D map;
uniform vec2 size;
out vec4 colour;
void main() {
  vec3 x = clamp(texture(map, gl_FragCoord.xy / size).rgb, 0.0, 1.0);
  colour = vec4(mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308))), 1);
}`;
const SHADOWS = { none: 0, paper: 1, exact: 2 };
const MAP = 0, POINTS = 1, NORMALS = 2, SUM = 3, WHOLE = 4, SMALL = 5, OWN = 6, NODES = 7, TRIANGLES = 8, CORNERS = 9;
const MOST = 8;
// Triangles in the way of a light, where there are none.
const NO_MODEL = "bool modelBlocks(vec3 x, vec3 d) { return false; }";

/** What the picture shows at first; `data.state` overrides it. */
export const START = {
  azimuth: 0, elevation: 0.3, distance: 4.6, look: [0, 0.42, 0], fov: 36, exposure: 0,
  count: 4, shape: "discs", ambient: "constant", shadows: "exact", off: [], only: 0, bare: false,
  ball: [-0.62, 0.1, 0.5], model: [0, 0, 0], box: [0.65, -0.1, 0.42, 0.42, 0.42, 30], albedo: 0.7, shine: 0, roughness: 0.35,
  cameraHeight: 1.6, dome: 12, flatFloor: false, probes: true,
};

/** Ball and box as the camera at an azimuth sees them first: side by side. */
export function arranged(azimuth) {
  const cos = Math.cos(azimuth), sin = Math.sin(azimuth), at = (x, z) => [cos * x + sin * z, cos * z - sin * x];
  return { ball: [...at(-0.62, 0.12), 0.5], box: [...at(0.62, -0.1), 0.42, 0.42, 0.42, (3630 + azimuth * 180 / Math.PI) % 90] };
}

/** Eye and axes (right, up, forward) of the camera; azimuth 0 is +z, a quarter turn +x. */
export function view(s) {
  const c = Math.cos(s.elevation), away = [Math.sin(s.azimuth) * c, Math.sin(s.elevation), Math.cos(s.azimuth) * c];
  const eye = s.look.map((x, k) => x + s.distance * away[k]), forward = away.map((x) => -x);
  const right = [Math.cos(s.azimuth), 0, -Math.sin(s.azimuth)];
  const up = [0, 1, 2].map((k) => right[(k + 1) % 3] * forward[(k + 2) % 3] - right[(k + 2) % 3] * forward[(k + 1) % 3]);
  return { eye, right, up, forward };
}

/** Lights and ambient term that a state shows. */
export function rigOf(data, s) {
  const rigs = data.rigs[`${s.ambient} ${s.shape}`];
  return rigs[Math.min(s.count, rigs.length) - 1];
}

const lightOf = ([x, y, z, r, g, b, radius]) => ({ direction: [x, y, z], irradiance: [r, g, b], radius });
// A rig with its lights as they are now, and with the rows from which they started.
const unpack = (rig) => ({ ...rig, rows: rig.lights, lights: rig.lights.map(lightOf) });

/** Tangent of half the angle across the picture: `fov` is the angle of its shorter side. */
export function spread(s, width, height) {
  return Math.tan(s.fov * Math.PI / 360) * Math.max(width / height, 1);
}

export class Scene {
  constructor(canvas, data) {
    const gl = canvas.getContext("webgl2", { antialias: false, alpha: false, preserveDrawingBuffer: true });
    if (!gl) throw new Error("This page needs WebGL 2, which this browser does not offer or has switched off.");
    Object.assign(this, { canvas, data, gl, programs: new Map(), textures: [], targets: [], frames: 0, row: 0 });
    this.hasFloats = Boolean(gl.getExtension("EXT_color_buffer_float"));
    // Half floats lose small changes of a mean over many frames.
    this.sums = Boolean(data.model && this.hasFloats && gl.getExtension("EXT_float_blend"));
    this.most = this.sums ? 256 : 16;
    this.buffer = gl.createFramebuffer();
    gl.bindVertexArray(gl.createVertexArray());
  }

  async load() {
    const { gl, data } = this, blob = await (await fetch(data.map)).blob();
    const image = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
    this.texture(MAP, gl.LINEAR);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
    this.size = { width: image.width, height: image.height };
    image.close();
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    for (const [unit, { size, halves }] of [[NORMALS, data.irradiance.floor], [WHOLE, data.irradiance.whole]]) {
      const bytes = Uint8Array.from(atob(halves), (c) => c.charCodeAt(0));
      this.texture(unit, gl.LINEAR);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB16F, ...size, 0, gl.RGB, gl.HALF_FLOAT, new Uint16Array(bytes.buffer));
    }
    if (data.model) loadModel(this, data.model);
    if (data.truth) await loadTruth(this, data.truth);
  }

  // A new texture in a unit.
  texture(unit, filter) {
    const { gl } = this, texture = gl.createTexture();
    gl.deleteTexture(this.textures[unit] ?? null);
    this.textures[unit] = texture;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const name of ["TEXTURE_MIN_FILTER", "TEXTURE_MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D, gl[name], filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return texture;
  }

  // One program for each choice: a software renderer computes all sides of a branch.
  use(source, choices, models = 0) {
    const { gl, data: { shaders } } = this, text = `#define MODELS ${models}\n` + Object.entries(choices).map(([name, value]) => `const ${typeof value === "boolean" ? "bool" : "int"} ${name} = ${value};`).join(" ");
    if (!this.programs.has(text)) {
      const program = link(gl, VERTEX, source.replace("//LIGHT", shaders.light).replace("//CHOICES", text).replace("//MODEL", models ? shaders.model : NO_MODEL).replace("//PATHS", shaders.paths));
      const places = new Map(), count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
      for (let k = 0; k < count; k++) {
        const { name, type } = gl.getActiveUniform(program, k);
        places.set(name.replace("[0]", ""), [gl.getUniformLocation(program, name), type]);
      }
      this.programs.set(text, { program, places });
    }
    this.places = this.programs.get(text).places;
    gl.useProgram(this.programs.get(text).program);
  }

  // Set those uniforms that the program has.
  set(values) {
    const { gl } = this;
    for (const [name, value] of Object.entries(values)) {
      if (!this.places.has(name)) continue;
      const [place, type] = this.places.get(name), list = [value].flat(2).map(Number);
      if (type === gl.FLOAT) gl.uniform1fv(place, list);
      else if (type === gl.FLOAT_VEC2) gl.uniform2fv(place, list);
      else if (type === gl.FLOAT_VEC3) gl.uniform3fv(place, list);
      else if (type === gl.FLOAT_VEC4) gl.uniform4fv(place, list);
      else if (type === gl.FLOAT_MAT3) gl.uniformMatrix3fv(place, false, list);
      else gl.uniform1i(place, list[0]);
    }
  }

  // Draw with the program of a task into the current target.
  draw(s, task, size, extra = {}) {
    const { gl, data } = this, rig = extra.rig ? unpack(extra.rig) : rigOf(data, s), on = rig.lights.filter((_, k) => !s.off.includes(k));
    const soft = on.some((light) => light.radius > 3e-4), harmonic = rig.ambient.length > 1;
    // The rays of a model are refined over the frames; before, and for other shadows, they end in the centre of a light.
    const { frame = -1 } = extra, models = !data.model || task > 0 ? 0 : frame >= 0 && s.shadows === "exact" ? 2 : 1;
    this.use(data.shaders.scene, {
      task, shadows: SHADOWS[s.shadows], soft, harmonic, glossy: s.shine > 0, floats: Boolean(extra.floats),
    }, models);
    if (models) placeModel(this, s, data.model, frame);
    const { eye, right, up, forward } = view(s), lit = (of, empty) => Array.from({ length: MOST }, (_, k) => (on[k] ? of(on[k]) : empty));
    const [x, z, a, b, c, turn] = s.box, cos = Math.cos(turn * Math.PI / 180), sin = Math.sin(turn * Math.PI / 180);
    this.set({
      size, eye, camera: [right, up, forward], tanX: spread(s, ...size), exposure: 2 ** s.exposure * data.exposure,
      white: data.white, cameraHeight: s.cameraHeight, dome: s.dome, flatFloor: s.flatFloor, bare: s.bare, only: s.only,
      jitter: [0, 0], map: MAP, points: POINTS, normals: NORMALS, lights: on.length, overFloor: rig.floor, ambient: rig.ambient,
      direction: lit((l) => l.direction, [0, 1, 0]), strength: lit((l) => l.irradiance, [0, 0, 0]),
      radius: lit((l) => [Math.sin(l.radius), Math.cos(l.radius)], [0, 1]), floorAlbedo: data.floor,
      albedo: [s.albedo, s.albedo, s.albedo, s.albedo, s.albedo, s.albedo], shine: s.shine, exponent: 2 / s.roughness ** 4 - 2 + 1e-3,
      ball: [s.ball[0], s.ball[2], s.ball[1], s.ball[2]], boxCentre: [x, b, z], boxHalf: [a, b, c], boxTurn: [cos, sin],
      ...extra,
    });
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // A first look at a smaller size; the frames start anew.
  preview(s, size) {
    this.target(SMALL, this.format(), ...size);
    this.frames = this.row = 0;
    this.draw(s, 0, size);
    this.present(s, SMALL);
  }

  // The next rows of a frame at full size. Frames are averaged, each with another offset in the pixel.
  rows(s, count) {
    const { gl, canvas } = this, size = [canvas.width, canvas.height];
    this.target(SUM, this.sums ? gl.RGBA32F : this.format(), ...size);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, this.row, size[0], count);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.CONSTANT_ALPHA, gl.ONE_MINUS_CONSTANT_ALPHA);
    gl.blendColor(0, 0, 0, 1 / (this.frames + 1));
    this.draw(s, 0, size, { jitter: offset(this.frames), frame: this.hasFloats ? this.frames : -1 });
    gl.disable(gl.BLEND);
    gl.disable(gl.SCISSOR_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.row += count;
    if (this.row < size[1]) return;
    this.row = 0;
    this.frames++;
    this.present(s, SUM);
  }

  format() { return this.hasFloats ? this.gl.RGBA16F : this.gl.SRGB8_ALPHA8; }

  // Show a texture of linear values, and the probes.
  present(s, unit) {
    const { gl, canvas } = this, size = [canvas.width, canvas.height];
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, ...size);
    this.use(PRESENT, {});
    this.set({ map: unit, size });
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    if (this.truth) presentTruth(this, s);
    if (!s.probes || !s.inset) return;
    const [left, bottom, width, height] = s.inset.map(Math.round);
    gl.viewport(left, bottom, width, height);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    this.draw({ ...s, shadows: "none", shine: 0 }, 2, [width, height], { origin: [left, bottom], normals: rigOf(this.data, s).floor ? NORMALS : WHOLE });
    gl.disable(gl.BLEND);
  }

  // Call `then` with the milliseconds since `start` when all is drawn.
  finished(start, then) {
    const { gl } = this, fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const wait = () => {
      if (gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) return void setTimeout(wait, 4);
      gl.deleteSync(fence);
      then(performance.now() - start);
    };
    setTimeout(wait, 0);
  }

  // Draw into a texture of its own.
  target(unit, format, width, height) {
    const { gl } = this, key = `${width} ${height} ${format}`;
    if (this.targets[unit] !== key) {
      this.texture(unit, unit === SMALL ? gl.LINEAR : gl.NEAREST);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
      this.targets[unit] = key;
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.buffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.textures[unit], 0);
    gl.viewport(0, 0, width, height);
  }

  // RGBA of a task without the canvas, rows from below: floats, or codes of one sample for each pixel.
  read(s, task, width, height, extra = {}) {
    const { gl } = this, pixels = new Float32Array(4 * width * height);
    if (!this.hasFloats) throw new Error("This browser cannot draw into float textures.");
    this.target(OWN, gl.RGBA32F, width, height);
    this.draw(s, task, [width, height], { floats: true, ...extra });
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return pixels;
  }

  // Hidden shares of points (x, y, z, thing) with normals: one RGBA a point, of a light (-1: the ambient term).
  table(s, points, normals, column, rig) {
    const { gl } = this, count = points.length, before = this.textures[NORMALS];
    const upload = (unit, rows) => {
      this.textures[unit] = null;
      this.texture(unit, gl.NEAREST);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, count, 1, 0, gl.RGBA, gl.FLOAT, new Float32Array(rows.flat()));
    };
    upload(POINTS, points);
    upload(NORMALS, normals.map((n) => [...n, 0]));
    const out = this.read(s, 1, count, 1, { column, rig });
    gl.deleteTexture(this.textures[NORMALS]);
    gl.activeTexture(gl.TEXTURE0 + NORMALS);
    gl.bindTexture(gl.TEXTURE_2D, this.textures[NORMALS] = before);
    return out;
  }
}

// Offsets of the frames in a pixel: an even spread (R2 sequence) around the middle.
const offset = (k) => [0.7548776662, 0.5698402909].map((step) => ((0.5 + k * step) % 1) - 0.5);

function link(gl, ...sources) {
  const program = gl.createProgram();
  sources.forEach((source, k) => {
    const shader = gl.createShader(k ? gl.FRAGMENT_SHADER : gl.VERTEX_SHADER);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(`The graphics driver refused the shader: ${gl.getShaderInfoLog(shader)}`);
    gl.attachShader(program, shader);
  });
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(`The graphics driver refused the shader: ${gl.getProgramInfoLog(program)}`);
  return program;
}
