// Makes the pictures of the README's section on `view`, from running engines:
//
//   star.webp   10 s: a hand presses into the star's wall; A4 turns the star under the motor's axis, and
//               the contact angle falls
//   torus.png   a still of a scene with A4 on a device with three sensors
//
// run_in_node.py pictures PROJECT BUILD FOLDER PROGRAM

import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";

import { assertClean, kPrograms, kProject, openBrowser, openPage, startProgram, until, untilDrawn } from "./chromium.mjs";
import { animatedWebp } from "./webp.mjs";

const kWidth = 720;
const kHeight = 480;
const kLength_s = 10;
const kMostBytes = 2_000_000;
const kQuality = 0.72;
const kStill = { width: 1280, height: 800 };
const folder = process.env.PALPATE_FOLDER;

const browser = await openBrowser();

async function screenPlace(page, place_m) {
  const at = await page.evaluate(([x, y, z]) => window.palpate.pixelOf(x, y, z), place_m);
  const box = await page.locator("#view").boundingBox();
  return [box.x + at.x, box.y + at.y];
}

// Turns the JPEG frames of a screencast into WebP files, in a page of its own.
async function toWebp(frames) {
  const page = await browser.newPage();
  const pictures = [];
  for (const { data } of frames) {
    const url = await page.evaluate(async ([jpeg, quality]) => {
      const image = new Image();
      image.src = `data:image/jpeg;base64,${jpeg}`;
      await image.decode();
      const canvas = document.createElement("canvas");
      canvas.width = image.naturalWidth;
      canvas.height = image.naturalHeight;
      canvas.getContext("2d").drawImage(image, 0, 0);
      return canvas.toDataURL("image/webp", quality);
    }, [data, kQuality]);
    pictures.push(Buffer.from(url.split(",")[1], "base64"));
  }
  await page.close();
  return pictures;
}

// The frames of the page while `act` runs and until kLength_s have passed.
async function record(page, act) {
  const session = await page.context().newCDPSession(page);
  const frames = [];
  session.on("Page.screencastFrame", ({ data, metadata, sessionId }) => {
    frames.push({ data, time_s: metadata.timestamp });
    void session.send("Page.screencastFrameAck", { sessionId });
  });
  await session.send("Page.startScreencast", { format: "jpeg", quality: 95, everyNthFrame: 5 });
  await act();
  while (frames.at(-1).time_s - frames[0].time_s < kLength_s) await page.waitForTimeout(100);
  await session.send("Page.stopScreencast");
  const end_s = frames[0].time_s + kLength_s;
  const kept = frames.filter(({ time_s }) => time_s < end_s);
  return kept.map((frame, i) => ({ ...frame, duration_ms: 1000 * ((kept[i + 1]?.time_s ?? end_s) - frame.time_s) }));
}

async function makeStar() {
  const server = await startProgram(kPrograms[0], ["view", `${kProject}/models/star.glb`]);
  const page = await openPage(browser, server.address, { viewport: { width: kWidth, height: kHeight } });
  await untilDrawn(page);
  await page.evaluate(() => { // only the view and its numbers
    document.querySelector("aside").style.display = "none";
    document.querySelector("main").style.display = "block";
    const stage = document.getElementById("stage");
    stage.style.height = `${innerHeight - stage.getBoundingClientRect().top}px`;
    stage.style.display = "block";
    for (const [id, rule] of [["view", "absolute"], ["readout", "absolute"], ["key", "absolute"]]) {
      document.getElementById(id).style.position = rule;
    }
    const view = document.getElementById("view");
    view.style.height = "100%";
    view.style.minHeight = "0";
  });
  await page.waitForTimeout(300);
  const frames = await record(page, async () => {
    const from = await screenPlace(page, (await page.evaluate(() => window.palpate.state())).record.device_m);
    const to = await screenPlace(page, [-0.03, 0.035, 0]);
    await page.mouse.move(...from);
    await page.mouse.down();
    for (let i = 1; i <= 40; ++i) {
      await page.mouse.move(...from.map((v, k) => v + ((to[k] - v) * i) / 40));
      await page.waitForTimeout(35);
    }
  });
  assertClean(page);
  const pictures = await toWebp(frames);
  const animation = animatedWebp(kWidth, kHeight, frames.map(({ duration_ms }, i) =>
    ({ picture: pictures[i], x: 0, y: 0, width: kWidth, height: kHeight, duration_ms })));
  assert.ok(animation.length <= kMostBytes, `star.webp has ${animation.length} bytes`);
  writeFileSync(join(folder, "star.webp"), animation);
  console.log(`star.webp: ${frames.length} frames, ${animation.length} bytes`);
  await page.context().close();
  await server.stop();
}

async function makeTorus() {
  const server = await startProgram(kPrograms[0], ["view", `${kProject}/models/torus.glb`, "--fit", "0.2",
                                                   "--sensors", "3", "--actuators", "1"]);
  const page = await openPage(browser, server.address, { viewport: kStill });
  await untilDrawn(page);
  const box = await page.locator("#view").boundingBox();
  const device = (await page.evaluate(() => window.palpate.state())).record.device_m;
  const from = await screenPlace(page, device);
  const to = await screenPlace(page, [-0.02, 0.065, 0.02]);
  assert.ok(to[0] > box.x && to[1] > box.y);
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move(...to, { steps: 20 });
  for (let i = 0; i < 60; ++i) {
    await page.mouse.wheel(0, -40);
    const { record } = await page.evaluate(() => window.palpate.state());
    if (record.contact && Math.hypot(...record.full_force_device_N) > 3) break;
    await page.waitForTimeout(60);
  }
  await until(page, () => window.palpate.state().record.contact === 1);
  await page.waitForTimeout(2500);
  await page.screenshot({ path: join(folder, "torus.png") });
  assertClean(page);
  await page.context().close();
  await server.stop();
}

await makeStar();
await makeTorus();
await browser.close();
