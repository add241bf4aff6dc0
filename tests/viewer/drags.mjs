// Drag a light of a page each second for some minutes; print the heap after garbage collection every 3 minutes.
import { chromium } from "playwright-core";
const [path, url, minutes] = process.argv.slice(-3), end = Date.now() + 60000 * minutes, errors = [];
const args = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const browser = await chromium.launch({ executablePath: path, args }), page = await browser.newPage();
page.on("pageerror", (error) => errors.push(error.message));
await page.goto(url);
await page.waitForFunction("window.envlights", null, { timeout: 0 });
const cdp = await page.context().newCDPSession(page);
await cdp.send("Performance.enable");
for (let drags = 0, said = 0, last = false; !last; drags++) {
  last = Date.now() > end;
  if (drags === 10 || last || Date.now() > said + 180000) {
    await cdp.send("HeapProfiler.collectGarbage");
    const { metrics } = await cdp.send("Performance.getMetrics"), of = (name) => metrics.find((each) => each.name === name).value;
    console.log(`${drags} drags, heap ${of("JSHeapUsedSize") / 1e6} MB, ${of("Nodes")} nodes, ${of("JSEventListeners")} listeners, errors: ${errors}`);
    said = Date.now();
  }
  await page.evaluate((down) => {
    const held = document.querySelector(".handle"), box = held.parentElement.getBoundingClientRect();
    held.setPointerCapture = () => {};
    const send = (type, x, y) => held.dispatchEvent(new PointerEvent(type, { pointerId: 1, clientX: 9 + x * box.width, clientY: 9 + y * box.height }));
    send("pointerdown", 0, 0); send("pointermove", 0.1, 0); send("pointerup", 0.1, down);
  }, drags % 2 ? 0.05 : -0.05);
  await page.waitForTimeout(1000);
}
await browser.close();
