// A participant in a window of a desktop, with the mouse and the keys of its X server and the real program: what
// Chromium grants of full screen and pointer lock, how far the mouse moves the hand, and what ends a trial. The
// screen has its own pixels, one and a half, and two for each CSS pixel.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { isDeepStrictEqual } from "node:util";

import { assertClean, button, kClosed, kPrograms, openPage, startProgram, until } from "./chromium.mjs";
import { focusPage, openDesktop, press } from "./desktop.mjs";
import { writeLivePlan } from "./live_plan.mjs";

const kScreen = { width: 1280, height: 800 };
const kCard_mm = 85.6;
const kDrag_px = 60; // of the corner of the picture of the card
const kStroke_px = 240;
const kFirst_px = 4; // of a first motion, to which Chromium may add the way of the window
const kMove_px = 100;
const kSteps = 10; // that make up this move: of whole pixels
const kFarthest_px = 1;
const kObject = [0xff, 0xd6, 0x33]; // its colour
const kColour = 8; // of 255
const kRest_s = 0.2; // of the mouse, until Chromium knows its place

const folder = mkdtempSync(join(tmpdir(), "palpate-desktop-"));
let program;
let desktop;
let css_px_per_mm; // at a scale of 1
before(async () => {
  const plan = writeLivePlan(folder, { scale: [0.4] });
  program = await startProgram(kPrograms[1], ["experiment", "live", plan, "--participant", "1",
                                              "--out", join(folder, "out")]);
});
after(() => {
  program.child.kill("SIGKILL");
  rmSync(folder, { recursive: true });
});

const untilStep = (page, step) => until(page, (s) => window.palpate.step() === s, step);
const untilPhase = (page, phase) => until(page, (p) => window.palpate.phase() === p, phase);

// Keeps what the page asks the browser for, and what it gets.
function watchGrants() {
  window.grants = [];
  const watch = (name, wordOf) => {
    const real = Element.prototype[name];
    Element.prototype[name] = async function (options) {
      try {
        await real.call(this, options);
        window.grants.push(wordOf(options));
      } catch (error) {
        window.grants.push(`${wordOf(options)}: ${error.name}`);
        throw error;
      }
    };
  };
  watch("requestPointerLock", (options) => (options?.unadjustedMovement ? "unadjusted lock" : "lock"));
  watch("requestFullscreen", () => "full screen");
}

// Runs with a page in a window of a desktop of this scale.
async function withPage(scale, run) {
  desktop = await openDesktop({ ...kScreen, scale });
  try {
    const page = await openPage(desktop, program.address, { script: watchGrants });
    await until(page, () => (window.palpate?.step() ?? null) !== null);
    await focusPage(desktop, page);
    await run(page);
    assertClean(page, kClosed);
  } finally {
    await desktop.close();
  }
}
const pressButton = (page, name = "Go on") => press(desktop, page, button(page, name));
const motions = (count, right_px, pause_s) => Array.from({ length: count }, () =>
  ["mousemove_relative", "--", right_px / count, 0, "sleep", pause_s]).flat();

// Drags the corner of the card. Returns its width, CSS pixels.
async function dragCard(page) {
  const card = page.getByRole("slider");
  await card.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await card.boundingBox();
  await desktop.act("mousemove", ...(await desktop.place(page, [x + width - 4, y + height - 4])), "mousedown", 1,
                    "mousemove_relative", kDrag_px, 0, "mouseup", 1);
  const widthNow = async () => (await card.boundingBox()).width;
  await until(page, (least) => document.querySelector("[role=slider]").offsetWidth > least, width + 1);
  assert.ok(Math.abs((await widthNow()) - width - kDrag_px) <= 1, `${width} to ${await widthNow()}`);
  return widthNow();
}

// The strokes of the input check, in their own times, until the page has what it needs: a busy machine makes some
// of the fast ones slow.
async function makeStrokes(page) {
  const said = page.locator(".said");
  await said.filter({ hasText: "Stroke 1 of 4" }).waitFor();
  for (let text = await said.textContent(); !/same way|farther/.test(text); text = await said.textContent()) {
    const way = /: slowly/.test(text) ? motions(20, kStroke_px, 0.11) : motions(4, kStroke_px, 0.01);
    await desktop.act("mousedown", 1, ...way, "mouseup", 1);
    await until(page, (last) => document.querySelector(".said").textContent !== last, text);
  }
  assert.match(await said.textContent(), /same way/);
}

// The left and the right side of the object in a picture that shows what has been sent until now, CSS pixels, and
// where the engine has the device point.
const seen = (page) => page.evaluate(([colour, tolerance]) => new Promise((resolve) => {
  const sent = window.palpate.sent();
  window.palpate.onPicture((_, state) => {
    if (state.pointerSequence < sent) return;
    window.palpate.onPicture(() => {});
    const canvas = document.querySelector(".picture");
    const gl = canvas.getContext("webgl2");
    const { width, height } = canvas;
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let [left, right] = [Infinity, -Infinity];
    for (let i = 0; i < width * height; ++i) {
      if (![0, 1, 2].every((k) => Math.abs(pixels[4 * i + k] - colour[k]) <= tolerance)) continue;
      [left, right] = [Math.min(left, i % width), Math.max(right, i % width)];
    }
    const { device_m, contact } = state.record;
    resolve({ left, right, middle: width / 2, device_m, contact });
  });
}), [kObject, kColour]);

// Moves by kMove_px away from the object. The object goes the other way in the picture, because the ball stays in the
// middle.
async function checkLength(page) {
  const { scale } = desktop;
  const start = await seen(page);
  const sign = start.left + start.right > 2 * start.middle ? -1 : 1;
  await desktop.act(...motions(1, sign * kFirst_px * scale, 0.1));
  const before = await seen(page);
  const px_per_mm = css_px_per_mm / scale;
  const moved_px = (from, to) => -1000 * (to.device_m[1] - from.device_m[1]) * px_per_mm;
  const first_px = moved_px(start, before);
  assert.ok(Math.abs(first_px - sign * kFirst_px) <= kFarthest_px, `the first motion moves by ${first_px} px`);
  await desktop.act(...motions(kSteps, sign * kMove_px * scale, 0.02));
  await page.waitForTimeout(200);
  const after = await seen(page);
  assert.deepEqual([before.contact, after.contact], [0, 0]);
  const length_px = moved_px(before, after);
  assert.ok(Math.abs(length_px - sign * kMove_px) <= kFarthest_px, `the device point moves by ${length_px} px`);
  for (const side of ["left", "right"]) {
    const shown_px = before[side] - after[side];
    assert.ok(Math.abs(shown_px - sign * kMove_px) <= kFarthest_px, `the ${side} side moves by ${shown_px} px`);
  }
}

test("from the information to a trial, with a filled screen and a locked pointer", async () => {
  await withPage(1, async (page) => {
    await pressButton(page);
    await untilStep(page, "consent");
    await press(desktop, page, page.getByRole("checkbox"));
    await pressButton(page, "I agree");
    await untilStep(page, "check");
    await pressButton(page, "Mouse");
    css_px_per_mm = (await dragCard(page)) / kCard_mm;
    await pressButton(page);
    await pressButton(page, "Fill the screen");
    await button(page, "Begin").waitFor();
    assert.deepEqual(await page.evaluate(() => [innerWidth, innerHeight]), [kScreen.width, kScreen.height]);
    await pressButton(page, "Begin");
    await makeStrokes(page);
    const grants = await page.evaluate(() => window.grants);
    console.log(`Chromium grants: ${grants.join(", ")}`);
    assert.equal(grants.shift(), "full screen");
    assert.ok([["unadjusted lock"], ["unadjusted lock: NotSupportedError", "lock"]]
      .some((expected) => isDeepStrictEqual(grants, expected)), `${grants}`);
    await pressButton(page);
    await untilStep(page, "instructions");
    await pressButton(page);
    await untilStep(page, "learning");
    await pressButton(page);
    await untilPhase(page, "running");
    await desktop.act("key", "Return");
    await untilStep(page, "practice");
    await pressButton(page);
    await untilPhase(page, "running");
    await checkLength(page);
    await desktop.act("key", "F11"); // after it Chromium grants another lock at once
    await untilPhase(page, "left");
    // The window is small again, and the mouse rests where Chromium has to take it away: the next motion must not
    // have the way of the window in it.
    await desktop.act("mousemove", ...(await desktop.place(page, [20, 20])), "sleep", kRest_s, "key", "Return");
    await untilPhase(page, "running");
    await checkLength(page);
    await desktop.act("key", "Escape");
    await untilPhase(page, "left");
  });
});

for (const [scale, end] of [[1.5, async () => {}], [2, async (page) => {
  await desktop.act("key", "ctrl+n"); // another window takes the focus
  await untilPhase(page, "left");
}]]) {
  test(`the mouse moves the hand by its calibrated length if a CSS pixel has ${scale} pixels`, async () => {
    await withPage(scale, async (page) => {
      await pressButton(page);
      await untilPhase(page, "running");
      assert.ok(Math.abs((await page.evaluate(() => innerWidth)) - kScreen.width / scale) < 1);
      await checkLength(page);
      await end(page);
    });
  });
}

test("each trial was aborted with its reason", async () => {
  await program.stop();
  const [head, ...rows] = readFileSync(join(folder, "out/trials.csv"), "utf8").trim().split("\n")
    .map((line) => line.split(","));
  const column = (name) => rows.map((row) => row[head.indexOf(name)]);
  assert.deepEqual(column("status"), Array(4).fill("aborted"));
  // Chromium ends full screen and lock together, and tells one of them first. hidden: it was closed.
  assert.deepEqual(column("reason").map((reason) => reason.replace("full_screen", "pointer_lock")),
                   ["pointer_lock", "pointer_lock", "hidden", "focus"]);
  assert.deepEqual(column("motion"), Array(4).fill("unaccelerated"));
});
