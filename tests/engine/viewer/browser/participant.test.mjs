// A participant with a mouse in Chromium and the real program: from the information to the debriefing, by events
// of the pointer and clicks only. The hand follows the contour by what the page is told of the contact.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";

import {
  assertClean, button, closeAll, kClosed, kPrograms, openBrowser, openPage, startProgram, until,
} from "./chromium.mjs";
import { writeLivePlan } from "./live_plan.mjs";

const kStep_m = 1.5e-3; // along the contour, from one state to the next
const kDepth_m = 1e-3; // into the wall
const kTurn = Math.PI / 9; // from one state to the next, once contact is lost
const kWindow = { width: 640, height: 420 }; // drawn in software
const kInputs = ["mouse", "pen", "touch"];

let browser;
before(async () => (browser = await openBrowser()));
after(() => closeAll(browser));

const untilStep = (page, ...steps) => until(page, (all) => all.includes(window.palpate.step()), steps);

// The strokes of the input check, by events that state their own times.
async function stroke(page) {
  await page.locator(".said").filter({ hasText: "Stroke 1 of 4" }).waitFor();
  const client = await page.context().newCDPSession(page);
  let now_s = Date.now() / 1000;
  const mouse = (type, x) => client.send("Input.dispatchMouseEvent", {
    type, x, y: 300, button: "left", buttons: 1, clickCount: 1, timestamp: now_s });
  for (const time_s of [2.5, 0.3, 2.5, 0.3]) {
    now_s += 1;
    await mouse("mouseMoved", 100);
    await mouse("mousePressed", 100);
    for (let i = 1; i <= 5; ++i) {
      now_s += time_s / 5;
      await mouse("mouseMoved", 100 + 60 * i);
    }
    await mouse("mouseReleased", 400);
  }
  await page.locator(".said").filter({ hasText: "same way" }).waitFor();
}

// Where the device point should go next, scene frame: along the wall with the material on the left.
class WallFollower {
  constructor(green) {
    this.green = green;
    this.lost = 0;
  }
  next({ contact, proxy, normal }) {
    if (contact && Math.hypot(normal[0], normal[1]) > 0) {
      const n = Math.hypot(normal[0], normal[1]);
      this.inward = [-normal[0] / n, -normal[1] / n];
      this.lost = 0;
      this.at = [proxy[0] + kStep_m * this.inward[1] + kDepth_m * this.inward[0],
                 proxy[1] - kStep_m * this.inward[0] + kDepth_m * this.inward[1]];
    } else if (!this.inward) {
      const [x, y] = this.at ?? proxy;
      const [dx, dy] = [this.green[0] - x, this.green[1] - y];
      const away = Math.max(Math.hypot(dx, dy), 1e-9);
      this.at = [x + (kStep_m * dx) / away, y + (kStep_m * dy) / away];
    } else {
      const angle = Math.min(++this.lost * kTurn, Math.PI);
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      const [u, v] = this.inward;
      this.at = [this.at[0] + kStep_m * (c * v + s * u), this.at[1] + kStep_m * (-c * u + s * v)];
    }
    return this.at;
  }
}

// The newest record in the page, and the pixels of a metre.
const seen = (page) => page.evaluate(() => {
  const { record, pointerSequence } = window.palpate.state() ?? {};
  return { record, pointerSequence, pixels_per_m: window.palpate.pixels_per_m(), phase: window.palpate.phase(),
           sent: window.palpate.sent(), step: window.palpate.step() };
});

// A mouse whose place counts for nothing, only its motion.
class Mouse {
  constructor(page) {
    this.page = page;
    this.place = [kWindow.width / 2, kWindow.height / 2];
  }
  async by(right_px, up_px) {
    const { width, height } = kWindow;
    this.place = [this.place[0] + right_px, this.place[1] - up_px];
    assert.ok(this.place[0] > 0 && this.place[0] < width && this.place[1] > 0 && this.place[1] < height,
              `the mouse stays in the window: ${this.place}`);
    await this.page.mouse.move(...this.place);
  }
}

async function followContour(page, mouse) {
  const hand = new WallFollower(await page.evaluate(() => window.palpate.green()));
  for (;;) {
    const { record, pixels_per_m, phase, pointerSequence, sent } = await seen(page);
    if (phase !== "running") return;
    if (!record || pointerSequence < sent) continue; // the engine has not used the last motion
    const q = record.q_before_wxyz;
    const turn = 2 * Math.atan2(q[3], q[0]);
    const [x, y] = hand.next({ contact: record.contact === 1, proxy: record.proxy_scene_m, normal: record.normal_scene });
    const o = record.o_before_m;
    const target = [Math.cos(turn) * x - Math.sin(turn) * y + o[0], Math.sin(turn) * x + Math.cos(turn) * y + o[1]];
    const up_px = pixels_per_m * (target[0] - record.device_m[0]);
    const right_px = -pixels_per_m * (target[1] - record.device_m[1]);
    await mouse.by(right_px, up_px);
  }
}

test("a participant with a mouse takes the whole course", { timeout: 600_000 }, async () => {
  const folder = mkdtempSync(join(tmpdir(), "palpate-course-"));
  const plan = writeLivePlan(folder, { blocks: 3, scale: [0.4], live: { about: ["age"] } });
  const program = await startProgram(kPrograms[1], ["experiment", "live", plan, "--participant", "1",
                                                    "--out", join(folder, "out")]);
  try {
    const page = await openPage(browser, program.address, { viewport: kWindow });
    await until(page, () => (window.palpate?.step() ?? null) !== null);
    await button(page, "Go on").click();
    await untilStep(page, "consent");
    await page.getByRole("checkbox").check();
    await button(page, "I agree").click();
    await untilStep(page, "check");
    await button(page, "Mouse").click();
    await page.getByRole("slider").focus();
    const width = async () => Number(await page.getByRole("slider").getAttribute("aria-valuenow"));
    for (let last = -1; last !== (await width());) { // the smallest card: the contour fits into the window
      last = await width();
      await page.keyboard.press("Shift+ArrowLeft");
    }
    await button(page, "Go on").click();
    await button(page, "Fill the screen").click();
    await button(page, "Begin").click();
    await stroke(page);
    await button(page, "Go on").click();
    await untilStep(page, "instructions");
    assert.equal(await page.locator("#screen b").count(), 0, "tags are text");
    await button(page, "Go on").click();
    await untilStep(page, "about");
    await button(page, "Go on").click();
    const mouse = new Mouse(page);
    await page.mouse.move(...mouse.place);
    let trials = 0;
    for (;;) {
      await until(page, () => ["waiting", "running"].includes(window.palpate.phase()) ||
                              ["break", "debriefing"].includes(window.palpate.step()) && window.palpate.phase() === "none");
      const { phase, step } = await seen(page);
      if (phase === "none") {
        await button(page, "Go on").click();
        if (step === "debriefing") break;
        await until(page, (s) => window.palpate.step() !== s, step);
      } else if (phase === "waiting") {
        await button(page, "Go on").click();
        await until(page, () => window.palpate.phase() !== "waiting");
      } else if (step === "learning") {
        await until(page, () => window.palpate.state() !== null);
        await page.keyboard.press("Enter");
        await until(page, () => window.palpate.phase() !== "running");
      } else {
        await followContour(page, mouse);
        ++trials;
      }
    }
    assert.equal(trials, 4);
    const ended = new Promise((resolve) => program.child.once("exit", resolve));
    await untilStep(page, "done");
    assert.equal(await ended, 0);
    assertClean(page, kClosed);
  } finally {
    if (program.child.exitCode === null) await program.stop();
  }
  const [head, ...rows] = readFileSync(join(folder, "out/trials.csv"), "utf8").trim().split("\n").map((line) => line.split(","));
  const column = (name) => rows.map((row) => row[head.indexOf(name)]);
  assert.deepEqual(column("status"), ["done", "done", "done", "done"], readFileSync(join(folder, "out/trials.csv"), "utf8"));
  assert.deepEqual(column("block"), ["0", "1", "2", "3"]);
  assert.ok(column("input").every((input) => kInputs.includes(input)));
  rmSync(folder, { recursive: true });
});
