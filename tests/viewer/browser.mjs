// Open a page in Chromium without a window, run a script in it, and print what it returned, its messages and requests.
import fs from "node:fs";
import { chromium } from "playwright-core";

const [page_, job_] = process.argv.slice(2);
const job = JSON.parse(fs.readFileSync(job_, "utf8"));
const args = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
args.push(...(job.webgl ? ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] : ["--disable-3d-apis"]));
const browser = await chromium.launch({ executablePath: job.chromium, args });
const page = await browser.newPage({ viewport: { width: job.size[0], height: job.size[1] }, colorScheme: job.scheme });
page.setDefaultTimeout(0);
const messages = [], requests = [];
// Software renderers warn of each read of a canvas.
page.on("console", (message) => /GPU stall due to ReadPixels/.test(message.text()) || messages.push(message.text()));
page.on("pageerror", (error) => messages.push(error.message));
page.on("request", (request) => /^(data|blob|about):/.test(request.url()) || requests.push(request.url()));
const saved = [];
page.on("download", (download) => saved.push(download.saveAs(`${job.folder}/${download.suggestedFilename()}`)));
if (job.still) await page.addInitScript(() => { window.requestAnimationFrame = () => 0; });
const start = performance.now();
await page.goto(`file://${page_}`);
await page.waitForFunction("window.envlights", null, { polling: 20 });
const opened = performance.now() - start;
await page.waitForFunction(job.wait, null, { polling: 50 });
const result = await page.evaluate(`(${job.script})(${JSON.stringify(job.argument)})`);
while (saved.length < job.files) await page.waitForTimeout(20);
await Promise.all(saved);
if (job.picture) await page.screenshot({ path: job.picture });
await browser.close();
console.log(JSON.stringify({ result, messages, requests, opened }));
