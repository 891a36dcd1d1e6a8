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

import {
  assertClean, kPrograms, kProject, openBrowser, openPage, startProgram, until, untilDrawn,
} from "./chromium.mjs";
import { animatedWebp } from "./webp.mjs";

const kWidth = 840; // beyond the width at which the page puts its numbers over the view
const kHeight = 520;
const kSpeed_m_per_s = 0.25;
const kPause_ms = 700; // in which a wall is pressed
const kLength_s = 10;
const kShortest_s = 0.09; // between two frames
const kMostBytes = 2_000_000;
const kQuality = 0.72;
const kDepthPerWheel = 0.25; // pixels of depth for each unit of the wheel, as in pointing.ts
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
  await page.waitForTimeout(500); // the first frames can be of an earlier layout
  await session.send("Page.startScreencast", { format: "jpeg", quality: 95 });
  await act();
  while (frames.at(-1).time_s - frames[0].time_s < kLength_s) await page.waitForTimeout(100);
  await session.send("Page.stopScreencast");
  const end_s = frames[0].time_s + kLength_s;
  let last_s = -Infinity;
  const kept = frames.filter(({ time_s }) => {
    const isKept = time_s > frames[0].time_s && time_s < end_s && time_s - last_s >= kShortest_s;
    if (isKept) last_s = time_s;
    return isKept;
  });
  return kept.map((frame, i) => {
    const next_s = kept[i + 1]?.time_s ?? end_s;
    return { ...frame, duration_ms: 1000 * (next_s - frame.time_s) };
  });
}

// Moves the mouse along a straight line in the top view, at the speed of a hand.
async function glide(page, from_m, to_m) {
  const [from, to] = [await screenPlace(page, from_m), await screenPlace(page, to_m)];
  const begin_ms = Date.now();
  const lasts_ms = (1000 * Math.hypot(...to_m.map((v, i) => v - from_m[i]))) / kSpeed_m_per_s;
  for (let share = 0; share < 1;) {
    share = Math.min(1, (Date.now() - begin_ms) / lasts_ms);
    await page.mouse.move(...from.map((v, k) => v + (to[k] - v) * share));
    await page.waitForTimeout(20);
  }
}

// Where the middle of the scene is now, device frame.
const middle = (page) => page.evaluate(() => {
  const { q_after_wxyz: [w, , , z], o_after_m: o } = window.palpate.state().record;
  const { low_m, high_m } = window.palpate.hello().scene;
  const [x, y] = [0, 1].map((i) => 0.5 * (low_m[i] + high_m[i]));
  const [c, s] = [w * w - z * z, 2 * w * z];
  return [o[0] + c * x - s * y, o[1] + s * x + c * y, 0];
});

async function makeStar() {
  const server = await startProgram(kPrograms[0], ["view", `${kProject}/models/star.glb`]);
  const page = await openPage(browser, server.address, { viewport: { width: kWidth, height: kHeight } });
  await untilDrawn(page);
  await page.evaluate(() => { // only the view and its numbers
    for (const hidden of [document.querySelector("aside"), document.getElementById("key")]) {
      hidden.style.display = "none";
    }
    document.querySelector("main").style.gridTemplateColumns = "1fr";
  });
  await page.keyboard.press("-"); // the star moves as it turns
  await page.waitForTimeout(500);
  const frames = await record(page, async () => {
    const device = (await page.evaluate(() => window.palpate.state())).record.device_m;
    await page.mouse.move(...(await screenPlace(page, device)));
    await page.mouse.down();
    let last = [-0.03, 0.035, 0];
    await glide(page, device, last); // onto a wall from below
    await page.waitForTimeout(kPause_ms);
    for (const side of [1, -1]) { // then onto walls from the left and from the right
      const centre = await middle(page);
      const path = [[-0.14, 0], [-0.12, 0.13 * side], [-0.01, 0.13 * side], [-0.01, 0.03 * side]];
      for (const [x, y] of path) {
        const next = [centre[0] + x, centre[1] + y, 0];
        await glide(page, last, next);
        last = next;
      }
      await page.waitForTimeout(kPause_ms);
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

// Drags and wheels until the target of the hand is at a place of the device frame. pointer: where the
// mouse is, with its button down.
async function moveTarget(page, pointer, place_m) {
  for (let round = 0; round < 3; ++round) {
    const [right, up, ahead] = await page.evaluate((to) => {
      const { target_m, record, hasTarget } = window.palpate.state();
      const from = hasTarget ? target_m : record.device_m;
      const m = window.palpate.camera().view; // rows: right, up, backwards
      const pixel_m = window.palpate.metresPerPixel(...from);
      const along = (row) => [0, 1, 2].reduce((sum, i) => sum + m[4 * i + row] * (to[i] - from[i]), 0);
      return [along(0), along(1), -along(2)].map((v) => v / pixel_m);
    }, place_m);
    pointer.x += right;
    pointer.y -= up;
    await page.mouse.move(pointer.x, pointer.y, { steps: 4 });
    await page.mouse.wheel(0, -ahead / kDepthPerWheel);
    await page.waitForTimeout(300);
  }
}

async function makeTorus() {
  const server = await startProgram(kPrograms[0], ["view", `${kProject}/models/torus.glb`, "--fit", "0.2",
                                                   "--sensors", "3", "--actuators", "1"]);
  const page = await openPage(browser, server.address, { viewport: kStill });
  await untilDrawn(page);
  const pointer = { x: 400, y: 400 };
  await page.mouse.move(pointer.x, pointer.y);
  await page.mouse.down();
  await moveTarget(page, pointer, [-0.078, 0.04, 0.05]);
  await moveTarget(page, pointer, [-0.078, 0.04, 0.008]);
  await until(page, () => window.palpate.state().record.contact === 1);
  await until(page, () => {
    const { alpha_rad, contact } = window.palpate.state().record;
    return contact === 1 && alpha_rad < 0.1; // A4 has turned the wall to the motor
  });
  await moveTarget(page, pointer, (await page.evaluate(() => { // presses along the motor's axis
    const [x, y, z] = window.palpate.state().record.device_m;
    return [x + 0.04, y, z]; // the spring of the hand is soft
  })));
  await page.screenshot({ path: join(folder, "torus.png") });
  console.log(await page.evaluate(() => {
    const { record } = window.palpate.state();
    return `torus.png: contact angle ${(record.alpha_rad * 180) / Math.PI} deg`;
  }));
  assertClean(page);
  await page.context().close();
  await server.stop();
}

await makeStar();
await makeTorus();
await browser.close();
