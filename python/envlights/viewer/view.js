// The page around the picture: controls, pointers and keys. `render({ model, el })` is the entry of a page and of a widget.

const SMEARED = "The map was photographed from one point. What stands near it is smeared over the ground, inside the dome.";

const WITHOUT_FLOOR = "Harmonics cannot be fitted over a floor: they hold the light of the ground as well, which stays where the things hide it.";

// Milliseconds of the first look at a change, and of a step of a full frame; size of the very first picture.
const FIRST = 60, STEP = 120, QUARTER = 0.25;

function node(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/** Build the picture and its controls in `el`; `model.get("data")` is what Python wrote. Resolves when it is drawn. */
async function render({ model, el }) {
  const given = model.get("data"), data = { ...given, rigs: Object.fromEntries(Object.entries(given.rigs).map(([name, rigs]) => [name, rigs.map(unpack)])) };
  const canvas = node("canvas", { tabIndex: 0 });
  canvas.setAttribute("role", "img");
  const stage = node("div", { className: "stage" }, canvas), root = node("div", { className: "envlights" }, stage);
  el.append(root);
  try {
    const scene = new Scene(canvas, data), state = { ...structuredClone(START), ...arranged(data.state.azimuth), ...data.state };
    await scene.load();
    return new Page({ root, stage, canvas, scene, state, data });
  } catch (error) {
    stage.replaceChildren(node("p", { className: "failure", role: "alert", textContent: error.message }));
    return { error };
  }
}

class Page {
  constructor(parts) {
    Object.assign(this, parts, { due: false, dragged: null, aimed: false, changed: true, opened: false, pace: 1e-3, fingers: new Map() });
    this.labels = ["under the map", "under the lights", "difference × 4"].map((text) => node("span", { textContent: text }));
    this.caption = node("div", { className: "probes" }, ...this.labels);
    this.stage.append(this.caption, node("p", { className: "refining", textContent: "refining" }), node("p", { className: "hint", textContent: "Drag to look around, drag a thing to move it" }));
    this.root.append(this.panel());
    this.pointers();
    this.keys();
    new ResizeObserver(() => this.redraw()).observe(this.canvas);
    this.redraw();
  }

  // Draw soon, from the start.
  redraw() {
    this.changed = true;
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => this.draw());
  }

  // A first look within the time of a frame; then full frames by rows, until the picture is smooth. `pace` is what
  // the last step needed, in milliseconds for each pixel, unless it had to compile a program. The very first picture
  // has overlays, whose program compiles in half the time of exact shadows.
  draw() {
    const { canvas, scene, state, opened } = this, moving = this.dragged ?? this.aimed, programs = scene.programs.size, ratio = Math.min(devicePixelRatio, 2), start = performance.now();
    const width = Math.max(Math.round(canvas.clientWidth * ratio), 1), height = Math.max(Math.round(canvas.clientHeight * ratio), 1);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    let drawn;
    if (this.changed) {
      this.changed = false;
      this.place(ratio);
      const scale = opened ? Math.min(Math.sqrt(FIRST / (this.pace * width * height)), moving ? 0.5 : 1) : QUARTER, size = [width, height].map((x) => Math.max(Math.round(x * scale), 16));
      scene.preview(opened || state.shadows !== "exact" ? state : { ...state, shadows: "paper" }, size);
      drawn = size[0] * size[1];
    } else {
      const count = Math.min(Math.max(Math.round(STEP / (this.pace * width)), 8), height - scene.row);
      scene.rows(state, count);
      drawn = count * width;
    }
    canvas.setAttribute("aria-label", this.text());
    scene.finished(start, (time) => {
      if (scene.programs.size === programs) this.pace = time / drawn;
      this.changed ||= !opened;
      this.opened = true;
      canvas.ariaBusy = String(!moving && scene.frames === 0);
      this.due = this.changed || (!moving && scene.frames < scene.most);
      if (this.due) requestAnimationFrame(() => this.draw());
    });
  }

  // Put the probes where their captions are.
  place(ratio) {
    const box = this.caption.getBoundingClientRect(), outer = this.canvas.getBoundingClientRect(), side = box.width / 3;
    this.state.inset = [box.left - outer.left, outer.bottom - box.top - side, box.width, side].map((x) => x * ratio);
  }

  /** Linear radiance of the picture with other options: RGBA rows from below. For tests and for pictures of other sizes. */
  render({ width = 320, height = 180, task = 0, ...options } = {}) {
    const { rig, column = 0, ...state } = options;
    return Array.from(this.scene.read({ ...this.state, ...state }, task, width, height, { rig, column }));
  }

  /** Hidden share of each point (x, y, z, thing) with its normal, and form factors of ball and box: RGBA rows. */
  hidden({ points, normals, column, rig, ...options }) {
    return Array.from(this.scene.table({ ...this.state, ...options }, points, normals, column, rig));
  }

  text() {
    const rig = rigOf(this.data, this.state), count = rig.lights.length - this.state.off.length;
    return `${this.data.model ? "A model" : "A ball and a box"} in ${this.data.title}, lit by ${count} lights and an ambient term. Arrow keys turn the camera.`;
  }

  panel() {
    const { data, state } = this, form = node("form", { className: "panel" });
    form.addEventListener("submit", (event) => event.preventDefault());
    const rigs = Object.keys(data.rigs), most = data.rigs[rigs[0]].length;
    const degrees = (x) => `${Math.round(x)}°`, metres = (x) => `${x.toFixed(1)} m`, plain = (x) => x.toFixed(2);
    const lights = [];
    this.caution = node("p", { className: "note", textContent: WITHOUT_FLOOR });
    if (most > 1) lights.push(this.slider("Number of lights", "count", 1, most, 1, String, () => { state.off = []; this.list(); }));
    lights.push(...lightsPanel(this));
    if (rigs.some((name) => name.endsWith("points"))) lights.push(this.choice("Lights are", "shape", { discs: "discs", points: "points" }, () => this.list()));
    if (["constant", "harmonics"].every((each) => rigs.some((name) => name.startsWith(each)))) lights.push(this.choice("Ambient term", "ambient", { constant: "constant", harmonics: "harmonics" }, () => this.list()), this.caution);
    form.append(
      node("h1", { textContent: data.title }),
      this.group("Lights", ...lights),
      this.group("Shadows", this.choice("Shadows are", "shadows", { exact: "exact", paper: "overlays", none: "none" })),
      this.group("Picture", this.slider("Exposure", "exposure", -4, 4, 0.1, this.stops), this.check("Probes", "probes", () => { this.caption.hidden = !state.probes; })),
      ...(data.model ? [modelPanel(this, degrees)] : []),
      ...(data.truth ? [truthPanel(this)] : []),
      this.group("Ball and box", this.slider("Albedo", "albedo", 0.05, 0.95, 0.01, plain), this.slider("Highlight", "shine", 0, 1, 0.01, plain),
        this.slider("Roughness", "roughness", 0.1, 0.9, 0.01, plain), this.turn("Turn of the box", "box", 5, 90, degrees)),
      this.group("Ground", this.slider("Camera height", "cameraHeight", 0.3, 6, 0.1, metres), this.slider("Dome radius", "dome", 3, 60, 0.5, metres),
        node("p", { className: "note", textContent: SMEARED })),
      ...data.notes.map((text) => node("p", { className: "note", textContent: text })),
    );
    this.list();
    return form;
  }

  group(legend, ...children) { return node("fieldset", {}, node("legend", { textContent: legend }), ...children); }

  slider(label, key, min, max, step, text, then = () => {}) {
    const { state } = this, input = node("input", { type: "range", min, max, step, value: state[key] });
    const output = node("output", { textContent: text(state[key]) });
    input.addEventListener("input", () => {
      state[key] = Number(input.value);
      output.textContent = text(state[key]);
      then();
      this.redraw();
    });
    return node("label", { className: "slider" }, node("span", { textContent: label }), output, input);
  }

  stops(x) { return `${x > 0 ? "+" : ""}${x.toFixed(1)} EV`; }

  turn(label, thing, place, most, text) {
    const { state } = this, key = `${thing}Turn`;
    state[key] = state[thing][place];
    return this.slider(label, key, 0, most, 1, text, () => { state[thing][place] = state[key]; });
  }

  choice(label, key, values, then = () => {}) {
    const name = `${key}-${Math.random().toString(36).slice(2)}`;
    const options = Object.entries(values).map(([value, text]) => {
      const input = node("input", { type: "radio", name, value, checked: this.state[key] === value });
      input.addEventListener("input", () => { this.state[key] = value; then(); this.redraw(); });
      return node("label", {}, input, node("span", { textContent: text }));
    });
    const group = node("div", { className: "choice" }, ...options);
    group.setAttribute("role", "radiogroup");
    group.setAttribute("aria-label", label);
    return group;
  }

  check(label, key, then = () => {}) {
    const input = node("input", { type: "checkbox", checked: this.state[key] });
    input.addEventListener("input", () => { this.state[key] = input.checked; then(); this.redraw(); });
    return node("label", { className: "check" }, input, node("span", { textContent: label }));
  }

  // Ray of a position of the pointer: eye and direction.
  ray(event) {
    const box = this.canvas.getBoundingClientRect(), { eye, right, up, forward } = view(this.state);
    const wide = spread(this.state, box.width, box.height), x = (2 * (event.clientX - box.left) / box.width - 1) * wide;
    const y = (1 - 2 * (event.clientY - box.top) / box.height) * wide * box.height / box.width;
    return { eye, direction: forward.map((f, k) => f + x * right[k] + y * up[k]) };
  }

  // The thing under the pointer, and where its ray meets the horizontal plane through that point.
  pick(event) {
    const { state } = this, { eye, direction } = this.ray(event), [x, z, radius] = state.ball, [p, q, a, b, c, turn] = state.box;
    const found = { ball: hitBall(eye, direction, [x, radius, z], radius), box: hitBox(eye, direction, [p, b, q], [a, b, c], turn * Math.PI / 180) };
    if (state.only) found.ball = found.box = Infinity;
    if (this.data.model) found.model = hitModel(this, eye, direction);
    const name = Object.keys(found).reduce((best, other) => (found[other] < found[best] ? other : best));
    return found[name] < Infinity ? { name, height: eye[1] + found[name] * direction[1] } : null;
  }

  ground(event, height) {
    const { eye, direction } = this.ray(event), t = (height - eye[1]) / direction[1];
    return t > 0 && t < 50 ? [eye[0] + t * direction[0], eye[2] + t * direction[2]] : null;
  }

  move(name, dx, dz) {
    const thing = this.state[name], limit = (x) => Math.min(4, Math.max(-4, x));
    thing[0] = limit(thing[0] + dx);
    thing[1] = limit(thing[1] + dz);
  }

  orbit(dx, dy) {
    this.state.azimuth -= dx;
    this.state.elevation = Math.min(1.5, Math.max(0.02, this.state.elevation + dy));
  }

  zoom(by) {
    const { model } = this.data, [least, most] = model ? [1.2, 20].map((k) => k * Math.hypot(...model.size) / 2) : [1.6, 11];
    this.state.distance = Math.min(most, Math.max(least, this.state.distance * by));
  }

  pointers() {
    const { canvas, fingers } = this;
    canvas.addEventListener("pointerdown", (event) => {
      fingers.set(event.pointerId, event);
      canvas.setPointerCapture(event.pointerId);
      this.dragged = fingers.size === 1 ? this.pick(event) ?? { name: "eye" } : { name: "eye" };
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => {
      fingers.delete(event.pointerId);
      if (fingers.size) return;
      this.dragged = null;
      this.redraw();
    });
    canvas.addEventListener("pointermove", (event) => {
      if (fingers.has(event.pointerId)) this.drag(event);
      else if (event.pointerType === "mouse") canvas.style.cursor = this.pick(event) ? "move" : "grab";
    });
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.zoom(Math.exp(event.deltaY * 0.001)); this.redraw(); }, { passive: false });
  }

  drag(event) {
    const { fingers, dragged } = this, last = fingers.get(event.pointerId), apart = () => {
      const [a, b] = [...fingers.values()];
      return Math.max(Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY), 1);
    };
    if (fingers.size > 1) {
      const before = apart();
      fingers.set(event.pointerId, event);
      this.zoom(before / apart());
    } else if (dragged.name === "eye") this.orbit((event.clientX - last.clientX) * 0.008, (event.clientY - last.clientY) * 0.006);
    else {
      const from = this.ground(last, dragged.height), to = this.ground(event, dragged.height);
      if (from && to) this.move(dragged.name, to[0] - from[0], to[1] - from[1]);
    }
    fingers.set(event.pointerId, event);
    this.redraw();
  }

  // Arrows turn the camera; with Shift they move the ball, with Alt the box, as the eye sees left and away.
  keys() {
    this.canvas.addEventListener("keydown", (event) => {
      const step = ARROWS[event.key], { right, forward } = view(this.state), flat = Math.hypot(forward[0], forward[2]);
      if (step && (event.shiftKey || event.altKey)) {
        const [dx, dz] = [0, 2].map((k) => 0.1 * (step[0] * right[k] + step[1] * forward[k] / flat));
        this.move(event.shiftKey ? "ball" : "box", dx, dz);
      } else if (step) this.orbit(0.1 * step[0], 0.06 * step[1]);
      else if ("+=".includes(event.key)) this.zoom(0.9);
      else if (event.key === "-") this.zoom(1 / 0.9);
      else return;
      event.preventDefault();
      this.redraw();
    });
  }
}

function hitBall(eye, direction, centre, radius) {
  const m = eye.map((x, k) => x - centre[k]), dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const a = dot(direction, direction), b = dot(m, direction), root = b * b - a * (dot(m, m) - radius * radius);
  return root < 0 ? Infinity : (-b - Math.sqrt(root)) / a;
}

function hitBox(eye, direction, centre, half, turn) {
  const into = ([x, y, z]) => [Math.cos(turn) * x - Math.sin(turn) * z, y, Math.sin(turn) * x + Math.cos(turn) * z];
  const q = into(eye.map((x, k) => x - centre[k])), e = into(direction);
  const near = Math.max(...q.map((x, k) => (-Math.sign(e[k]) * half[k] - x) / e[k])), far = Math.min(...q.map((x, k) => (Math.sign(e[k]) * half[k] - x) / e[k]));
  return near < far && near > 0 ? near : Infinity;
}
