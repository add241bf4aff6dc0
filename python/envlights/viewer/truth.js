// A path-traced picture of the start, left of a slider, while the picture is that of the start.

// Unit of the texture, and the width of the handle in pixels of the style.
const TRUTH = 10, HANDLE = 24;
const TRACED = PRESENT.replace("size;", "size, corner;\nuniform float gain;").replace("texture(map, gl_FragCoord.xy / size).rgb", "gain * texture(map, (gl_FragCoord.xy - corner) / size).rgb");

async function loadTruth(scene, truth) {
  const { gl } = scene, blob = await (await fetch(truth.picture)).blob();
  const image = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none", imageOrientation: "flipY" });
  scene.texture(TRUTH, gl.LINEAR);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
  scene.truth = { ...truth, wide: image.width / image.height, of: (s) => JSON.stringify(Object.keys(truth.start).map((key) => s[key])), at: 0.5, tell() {} };
  image.close();
}

// Draw over the left part; the shorter side of the picture has the angle of the canvas.
function presentTruth(scene, s) {
  const { gl, canvas: { width, height, clientWidth }, truth } = scene;
  const holds = truth.of(s) === truth.of(truth.start);
  truth.tell(holds);
  if (!holds) return;
  const side = Math.min(width, height), size = [side * truth.wide, side], corner = [(width - size[0]) / 2, (height - side) / 2];
  const edge = (HANDLE / 2 + truth.at * (clientWidth - HANDLE)) * width / clientWidth;
  const left = Math.max(Math.round(corner[0]), 0), right = Math.min(Math.round(edge), Math.round(corner[0] + size[0]));
  scene.use(TRACED, { traced: true });
  scene.set({ map: TRUTH, corner, size, gain: truth.headroom * 2 ** s.exposure });
  gl.enable(gl.SCISSOR_TEST);
  gl.scissor(left, Math.round(corner[1]), Math.max(right - left, 0), side);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  gl.disable(gl.SCISSOR_TEST);
}

// The slider over the picture, and what the truth is.
function truthPanel(page) {
  const { scene, state, stage } = page, { truth } = scene;
  page.split ??= node("input", { className: "split", type: "range", min: 0, max: 1, step: 0.005, value: truth.at, ariaLabel: "Path-traced left, page right" });
  page.sides ??= node("div", { className: "sides" }, ...["path-traced", "this page"].map((textContent) => node("span", { textContent })));
  stage.append(page.sides, page.split);
  page.split.oninput = () => {
    truth.at = Number(page.split.value);
    scene.present(state, scene.frames ? SUM : SMALL);
  };
  const back = node("button", { type: "button", textContent: "Back to the start" });
  back.onclick = () => {
    Object.assign(state, structuredClone(truth.start));
    page.root.querySelector(".panel").replaceWith(page.panel());
    page.redraw();
  };
  const text = `Left of the slider: path-traced under the map, ${truth.paths} paths for each pixel, noise ${(100 * truth.noise).toPrecision(2)} %.`;
  const hidden = node("div", { className: "changed", hidden: true }, node("p", { className: "note", role: "status", textContent: "Hidden, because camera, things or ground have changed." }), back);
  truth.tell = (holds) => {
    hidden.hidden = holds;
    page.split.hidden = page.sides.hidden = !holds;
  };
  return page.group("Truth", node("p", { className: "note", textContent: text }), hidden);
}
