// The lights of a page: a row and a handle for each, and files of what they became.

// Largest change of brightness in stops, and least angle to a pole, where azimuth would be lost, over 180 degrees.
const STOPS = 4, POLE = 1e-6;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

const clamp = (x, least, most) => Math.min(Math.max(x, least), most);
const encode = (x) => (x > 0.0031308 ? 1.055 * x ** (1 / 2.4) - 0.055 : 12.92 * x);
const decode = (x) => (x > 0.04045 ? ((x + 0.055) / 1.055) ** 2.4 : x / 12.92);

/** Position on the map of a direction, from 0 to 1 to the right and down, and the direction of a position. */
const placeOf = ([x, y, z]) => [0.5 - Math.atan2(x, z) / (2 * Math.PI), Math.atan2(Math.hypot(x, z), y) / Math.PI];
const directionAt = (u, v) => [Math.sin(Math.PI * v) * Math.sin(2 * Math.PI * (0.5 - u)), Math.cos(Math.PI * v), Math.sin(Math.PI * v) * Math.cos(2 * Math.PI * (0.5 - u))];

// Code of a colour at full brightness.
function codeOf(irradiance) {
  const most = Math.max(...irradiance, 1e-30);
  return `#${irradiance.map((x) => Math.round(255 * encode(x / most)).toString(16).padStart(2, "0")).join("")}`;
}

/** Controls of the lights; `page.list()` writes them for another rig. */
function lightsPanel(page) {
  const { data, state } = page, picture = node("img", { src: data.map, alt: "", draggable: false });
  const sky = node("div", { className: "sky" }), rows = node("div", { className: "lamps" }), fitted = node("p", { className: "note" });
  const button = (textContent, title, onclick) => node("button", { type: "button", textContent, title, onclick });
  const undo = button("Undo", "All lights as they were", () => {
    const rig = rigOf(data, state);
    rig.lights = rig.rows.map(lightOf);
    state.off = [];
    page.list();
    page.redraw();
  });
  // Brighten the picture, because its largest code is far above the white of the page.
  picture.style.filter = `brightness(${(data.exposure * data.white) ** (1 / 2.4)})`;
  const updateNote = () => {
    const rig = rigOf(data, state), count = rig.lights.length - state.off.length, lights = `${count} light${count === 1 ? "" : "s"}`;
    undo.disabled = !state.off.length && JSON.stringify(rig.lights) === JSON.stringify(rig.rows.map(lightOf));
    fitted.textContent = undo.disabled ? (rig.error > 0 ? `${lights}: error of the irradiance ${(100 * rig.error).toPrecision(2)} %` : lights) : `${lights}, changed: the error is not measured`;
  };
  page.list = () => {
    const rig = rigOf(data, state), controls = rig.lights.map((_, k) => lightControls(page, rig, k, updateNote));
    sky.replaceChildren(picture, ...controls.map(([handle]) => handle).reverse());
    rows.replaceChildren(...controls.map(([, row]) => row));
    page.caution.hidden = rig.floor;
    updateNote();
  };
  const files = node("div", { className: "files" },
    button("Save lights", "lights.json, which el.Rig.load reads", () => download("lights.json", JSON.stringify(rigFile(page), null, 1))),
    button("Save map", "map.hdr: the ambient term and the lights as discs", () => download("map.hdr", ...hdrFile(page))), undo);
  return [sky, rows, fitted, files];
}

// Handle and row of a light of a rig, which change it.
function lightControls(page, rig, k, updateNote) {
  const { data, state } = page, light = rig.lights[k], name = `light ${k + 1}`;
  const luminance = (rgb) => rgb.reduce((sum, x, channel) => sum + x * data.luminance[channel], 0);
  const scaled = (rgb, most) => rgb.map((x) => x * most / (luminance(rgb) || 1));
  const first = luminance(lightOf(rig.rows[k]).irradiance), now = luminance(light.irradiance);
  const text = light.radius > 0 ? `a disc of ${(light.radius * 180 / Math.PI).toFixed(1)}° radius` : "a point";
  const on = node("input", { type: "checkbox", checked: !state.off.includes(k), ariaLabel: `Light ${k + 1}, ${text}` });
  const stops = node("input", { type: "range", min: -STOPS, max: STOPS, step: 0.1, value: now > 0 ? Math.log2(now / first) : 0, ariaLabel: `Brightness of ${name}` });
  const tint = node("input", { type: "color", value: codeOf(light.irradiance), ariaLabel: `Colour of ${name}` }), output = node("output");
  const handle = node("button", { type: "button", className: "handle", textContent: k + 1 });
  const row = node("div", { className: "lamp" }, node("label", { title: `Light ${k + 1}: ${text}` }, on, node("span", { textContent: k + 1 })), stops, output, tint);
  const show = () => {
    const place = placeOf(light.direction), [azimuth, elevation] = [360 * place[0], 90 - 180 * place[1]].map(Math.round);
    Object.assign(handle.style, { left: `${100 * place[0]}%`, top: `${100 * place[1]}%` });
    handle.ariaLabel = `Direction of ${name}: azimuth ${azimuth}°, elevation ${elevation}°; arrow keys move it`;
    handle.classList.toggle("off", !on.checked);
    for (const each of [handle, row]) each.style.setProperty("--lamp", codeOf(light.irradiance));
    output.textContent = page.stops(Number(stops.value));
  };
  const change = (values) => { Object.assign(light, values); show(); updateNote(); page.redraw(); };
  const aim = (u, v) => change({ direction: directionAt(u, clamp(v, POLE, rig.floor ? 0.5 : 1 - POLE)) });
  on.addEventListener("input", () => { state.off = state.off.filter((j) => j !== k).concat(on.checked ? [] : [k]); change({}); });
  stops.addEventListener("input", () => change({ irradiance: scaled(light.irradiance, first * 2 ** stops.value) }));
  tint.addEventListener("input", () => {
    const rgb = [1, 3, 5].map((at) => decode(parseInt(tint.value.slice(at, at + 2), 16) / 255));
    if (luminance(rgb) > 0) change({ irradiance: scaled(rgb, luminance(light.irradiance)) });
    else tint.value = codeOf(light.irradiance);
  });
  handle.addEventListener("keydown", (event) => {
    const step = ARROWS[event.key], [u, v] = placeOf(light.direction);
    if (!step) return;
    event.preventDefault();
    aim(u + step[0] / 180, v - step[1] / 90);
  });
  let grip = null;
  const at = ({ clientX, clientY }) => { const { width, height } = handle.parentElement.getBoundingClientRect(); return [clientX / width, clientY / height]; };
  handle.addEventListener("pointerdown", (event) => {
    const place = placeOf(light.direction);
    handle.setPointerCapture(event.pointerId);
    grip = at(event).map((x, axis) => place[axis] - x);
    page.aimed = true;
  });
  handle.addEventListener("pointermove", (event) => grip && aim(...at(event).map((x, axis) => x + grip[axis])));
  for (const end of ["pointerup", "pointercancel"]) handle.addEventListener(end, () => { grip = null; page.aimed = false; page.redraw(); });
  show();
  return [handle, row];
}

/** Rig of the lights that are on, as `Rig.load` of Python reads it: no longer measured. */
function rigFile({ data, state }) {
  const rig = rigOf(data, state), on = rig.lights.map((_, k) => k).filter((k) => !state.off.includes(k)), of = (name) => on.map((k) => rig.lights[k][name]);
  const lights = { ...data.file.lights, direction: of("direction"), irradiance: of("irradiance"), angular_radius: of("radius"), origin: rig.origin && on.map((k) => rig.origin[k]) };
  const ambient = rig.ambient.length > 1 ? rig.ambient.map((row, k) => row.map((x) => x / data.factors[k])) : rig.ambient[0];
  return { ...data.file, ambient, lights, floor: rig.floor };
}

/** Parts of a Radiance file of the rig at the size of the map: its ambient term and its lights as discs, like `Rig.to_map`. */
function hdrFile(page) {
  const { width, height } = page.scene.size, codes = new Uint8Array(4 * width * height), radiance = panorama(page, width, height);
  for (let at = 0; at < width * height; at++) {
    const rgb = [0, 1, 2].map((channel) => Math.min(radiance[3 * at + channel], 1e38)), most = Math.max(...rgb);
    if (most < 1e-38) continue;
    const exponent = Math.floor(Math.log2(most * 512 / 511)) + 1;
    codes.set([...rgb.map((x) => Math.round(x * 2 ** (8 - exponent))), exponent + 128], 4 * at);
  }
  return [`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`, codes];
}

function panorama({ data, state }, width, height) {
  const { ambient, floor, lights } = rigOf(data, state), radiance = new Float32Array(3 * width * height);
  const pixel = (row, column) => directionAt((column + 0.5) / width, (row + 0.5) / height);
  // Radiance over irradiance of harmonics by their degree.
  const factor = (k) => (k ? k < 4 ? 3 / 2 : 4 : 1) / Math.PI;
  for (let row = 0; row < (floor ? height / 2 : height); row++) for (let column = 0; column < width; column++) {
    const [x, y, z] = pixel(row, column), terms = [1, y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y];
    const sky = ambient.length > 1 ? [0, 1, 2].map((channel) => Math.max(terms.reduce((sum, term, k) => sum + term * factor(k) * ambient[k][channel], 0), 0)) : ambient[0];
    radiance.set(sky, 3 * (row * width + column));
  }
  for (const { direction, irradiance, radius } of lights.filter((_, k) => !state.off.includes(k))) {
    const step = Math.PI / height, reach = Math.max(radius, step) + step, middle = placeOf(direction)[1] * Math.PI, found = [];
    let sum = 0;
    for (let row = Math.max(Math.floor((middle - reach) / step), 0); row < Math.min((middle + reach) / step, height); row++) for (let column = 0; column < width; column++) {
      const n = pixel(row, column), angle = 2 * Math.asin(Math.min(Math.hypot(...n.map((x, k) => x - direction[k])) / 2, 1));
      const covered = clamp((reach - step - angle) / step + 0.5, 0, 1), solid = 2 * step * Math.sin(step / 2) * Math.sin((row + 0.5) * step);
      if (covered > 0) found.push([3 * (row * width + column), covered]);
      sum += covered * Math.max(Math.cos(angle), 0) * solid;
    }
    for (const [at, covered] of found) irradiance.forEach((x, channel) => { radiance[at + channel] += x * covered / sum; });
  }
  return radiance;
}

function download(name, ...parts) {
  const href = URL.createObjectURL(new Blob(parts));
  node("a", { href, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(href), 60_000);
}
