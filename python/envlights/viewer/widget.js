// A widget of Jupyter: the traits of the Python object and the state of the page follow each other.

const round = (x) => Number(x.toFixed(6));

// For each trait: its value in a state, and a change of the state.
const TRAITS = {
  exposure: { get: (s) => round(s.exposure), set: (s, value) => { s.exposure = value; } },
  count: { get: (s) => s.count, set: (s, value) => { s.count = value; } },
  sizes: { get: (s) => s.shape === "discs", set: (s, value) => { s.shape = value ? "discs" : "points"; } },
  off: { get: (s) => s.off.toSorted((a, b) => a - b), set: (s, value) => { s.off = [...value]; } },
  eye: { get: (s) => view(s).eye.map(round), set: lookFrom },
};
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

// Move the camera to a point, above the floor.
function lookFrom(s, eye) {
  const [x, y, z] = eye.map((value, k) => value - s.look[k]), distance = Math.max(Math.hypot(x, y, z), 1e-3);
  Object.assign(s, { distance, azimuth: Math.atan2(x, z), elevation: Math.min(1.5, Math.max(0.02, Math.asin(y / distance))) });
}

async function renderWidget({ model, el }) {
  el.style.height = "35rem";
  const page = await render({ model, el });
  if (page.error) return;
  const { state } = page, redraw = page.redraw.bind(page);
  const push = () => {
    for (const [name, { get }] of Object.entries(TRAITS)) if (!same(get(state), model.get(name))) model.set(name, get(state));
    model.save_changes();
  };
  const pulls = Object.entries(TRAITS).map(([name, { get, set }]) => [`change:${name}`, () => {
    const value = model.get(name);
    if (value === null || same(value, get(state))) return;
    set(state, value);
    page.root.querySelector(".panel").replaceWith(page.panel());
    page.redraw();
  }]);
  for (const [name, { set }] of Object.entries(TRAITS)) if (model.get(name) !== null) set(state, model.get(name));
  page.root.querySelector(".panel").replaceWith(page.panel());
  page.redraw = (...rest) => { redraw(...rest); push(); };
  page.redraw();
  for (const [event, pull] of pulls) model.on(event, pull);
  return () => {
    for (const [event, pull] of pulls) model.off(event, pull);
    page.scene.gl.getExtension("WEBGL_lose_context")?.loseContext();
  };
}
export default { render: renderWidget };
