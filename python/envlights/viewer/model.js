// A model of the user's: its textures, its uniforms and its controls.

// Textures of 32-bit integers in rows of 2048 texels.
function loadModel(scene, model) {
  const { gl } = scene;
  for (const [unit, name] of [[NODES, "nodes"], [TRIANGLES, "triangles"], [CORNERS, "corners"]]) {
    const { texels, channels } = model[name], bytes = Uint8Array.from(atob(texels), (c) => c.charCodeAt(0)), four = channels === 4;
    const rows = Math.ceil(bytes.length / 4 / channels / 2048), padded = new Uint8Array(rows * 2048 * channels * 4);
    padded.set(bytes);
    scene.texture(unit, gl.NEAREST);
    gl.texImage2D(gl.TEXTURE_2D, 0, four ? gl.RGBA32UI : gl.RG32UI, 2048, rows, 0, four ? gl.RGBA_INTEGER : gl.RG_INTEGER, gl.UNSIGNED_INT, new Uint32Array(padded.buffer));
  }
}

function placeModel(scene, s, model, frame) {
  const turn = s.model[2] * Math.PI / 180;
  scene.set({
    modelNodes: NODES, modelTriangles: TRIANGLES, modelCorners: CORNERS, modelNodeCount: model.count.nodes, modelGrid: [...model.lower, model.step],
    modelAt: s.model.slice(0, 2), modelTurn: [Math.cos(turn), Math.sin(turn)], frame,
  });
}

// Length of a ray to the box around the model.
function hitModel({ state, data: { model } }, eye, direction) {
  const [left, back, angle] = state.model, half = model.size.map((side) => side / 2);
  return hitBox(eye, direction, [left, half[1], back], half, angle * Math.PI / 180);
}

function modelPanel(page, degrees) {
  const { data: { model }, state, scene } = page;
  state.balls = state.only === 0;
  const others = page.check("Ball and box", "balls", () => { state.only = state.balls ? 0 : 3; });
  const size = model.size.map((x) => x.toPrecision(2)).join(" × "), notes = [`${model.count.triangles.toLocaleString("en")} triangles, ${size} m`, ...model.notes];
  if (!scene.hasFloats) notes.push("This browser cannot average pictures (EXT_color_buffer_float), so the shadows of the model are hard.");
  else if (!scene.sums) notes.push("This browser averages 16 pictures at most (no EXT_float_blend), so the shadows of the model are noisy.");
  return page.group("Model", ...notes.map((textContent) => node("p", { className: "note", textContent })), page.turn("Turn of the model", "model", 2, 360, degrees), others);
}
