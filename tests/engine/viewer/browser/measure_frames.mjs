// Measures the frames of the page: the script of a frame without drawing, and the frames a second that
// Chromium draws in software. The scene is a scan of about 60,000 triangles.
//
// run_in_node.py frames PROJECT BUILD FOLDER PALPATE WRITE_MESH

import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { cpus, tmpdir } from "node:os";
import { join } from "node:path";

import {
  assertClean, kPrograms, openBrowser, openPage, resizeView, startProgram, until, untilDrawn, untilLive,
} from "./chromium.mjs";

const kCell_m = "0.0038"; // of the scan: about 60,000 triangles
const kSeconds = 20;
const folder = process.env.PALPATE_FOLDER;
const [palpate, writeMesh] = kPrograms;

// Totals of the page since its start, s.
async function totals(client) {
  const { metrics } = await client.send("Performance.getMetrics");
  return Object.fromEntries(metrics.map(({ name, value }) => [name, value]));
}

// Counts the frames of kSeconds, and the script that ran in them.
async function measure(page, countOf) {
  const client = await page.context().newCDPSession(page);
  await client.send("Performance.enable");
  await page.evaluate(() => {
    window.frames_seen = 0;
    const frame = () => { ++window.frames_seen; requestAnimationFrame(frame); };
    requestAnimationFrame(frame);
  });
  await page.waitForTimeout(2000); // the first pictures compile shaders
  const before = await totals(client);
  const first = await page.evaluate(countOf);
  await page.waitForTimeout(1000 * kSeconds);
  const last = await page.evaluate(countOf);
  const after = await totals(client);
  const frames = last - first;
  return {
    frames_per_s: frames / (after.Timestamp - before.Timestamp),
    script_ms_per_frame: (1000 * (after.ScriptDuration - before.ScriptDuration)) / frames,
    task_ms_per_frame: (1000 * (after.TaskDuration - before.TaskDuration)) / frames,
  };
}

// Presses the hand into the middle of the scene, so that A4 turns it and every frame has a new shadow.
async function press(page) {
  const box = await page.locator("#view").boundingBox();
  await page.mouse.move(box.x + 320, box.y + 240);
  await page.mouse.down();
  await page.mouse.wheel(0, -400);
}

const work = mkdtempSync(join(tmpdir(), "palpate_frames_"));
const scene = join(work, "scan.glb");
execFileSync(writeMesh, [scene, "scan", kCell_m], { stdio: "ignore" });
const server = await startProgram(palpate, ["view", scene, "--fit", "0.2", "--sensors", "3"]);
const result = { processors: cpus().length, seconds: kSeconds };
try {
  for (const hasWebgl of [false, true]) {
    const browser = await openBrowser(hasWebgl);
    const page = await openPage(browser, server.address);
    await untilLive(page);
    result.triangles = await page.evaluate(() => window.palpate.hello().scene.triangles);
    if (hasWebgl) {
      await untilDrawn(page);
      await resizeView(page, 640, 480);
      result.drawn = await measure(page, () => window.palpate.pictures());
      await press(page);
      await until(page, () => window.palpate.state().record.contact === 1);
      result.drawn_in_contact = await measure(page, () => window.palpate.pictures());
    } else {
      result.not_drawn = await measure(page, () => window.frames_seen);
    }
    assertClean(page, /WebGL|GPU/);
    await browser.close();
  }
} finally {
  await server.stop();
  rmSync(work, { recursive: true });
}
const text = `${JSON.stringify(result, null, 1)}\n`;
writeFileSync(join(folder, "frames.json"), text);
process.stdout.write(text);
