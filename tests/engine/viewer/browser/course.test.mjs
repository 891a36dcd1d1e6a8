// The page of a participant, with a server that has no engine: the course from the information to the
// debriefing, the input check, the motions of a trial, and what ends one.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";

import {
  assertClean, button, closeAll, faultsOf, kClosed, kProject, openBrowser, openPage, openZoomedBrowser,
  pictureFolder, until,
} from "./chromium.mjs";
import { FakeLive } from "./fake_live.mjs";

const kInch_mm = 25.4;
const kCard_mm = 85.6;
const kEvents = 1000; // of the mouse, as fast as the browser takes them
const kEpsilon = 2 ** -52;

let browser;
before(async () => (browser = await openBrowser()));
after(() => closeAll(browser));

const kStart_m = [0.01, -0.02, 0.003];
const trialOf = (number, scene = 0) => ({
  type: "trial", number, of: 4, scene, green_m: [-0.01, 0.02, 0], red_m: [-0.01, 0.045, 0], radius_m: 0.006,
  start_device_m: kStart_m, step: "block",
});
const kChecked = {
  input: "mouse", motion: "unknown", css_px_per_mm: 5, device_pixel_ratio: 1, width_px: 1000, height_px: 640,
  refresh_Hz: 60, unadjusted: false, stroke_ratio: null,
};

// Runs a test with a server and a page. change(fake): sets its hello. other: another browser. complaints: that are expected.
async function withPage(run, { change = () => {}, options = {}, other, complaints = kClosed } = {}) {
  const fake = await FakeLive.start(`${kProject}/models/star.glb`);
  try {
    change(fake);
    const page = await openPage(other ?? browser, fake.address, options);
    await until(page, () => (window.palpate?.step() ?? null) !== null);
    try {
      await run(page, fake);
    } catch (error) {
      const seen = await page.evaluate(() => [window.palpate.step(), window.palpate.phase(), window.palpate.pictures(),
        document.hidden, window.palpate.state() !== null, document.getElementById("notice").textContent]);
      error.message += `\n${page.complaints.join("\n")}\nthe page: ${seen}`;
      throw error;
    }
    assertClean(page, complaints);
    if (!other) await page.context().close();
  } finally {
    await fake.stop();
  }
}
const untilStep = (page, step) => until(page, (s) => window.palpate.step() === s, step);
const untilPhase = (page, phase) => until(page, (p) => window.palpate.phase() === p, phase);
const ofType = (type) => (message) => message.type === type;

// A page in the step before trials, in which a click has begun the first one.
async function withTrial(run, how = {}) {
  await withPage(async (page, fake) => {
    fake.sendState({ tick: 3, device_m: kStart_m, proxy_scene_m: [-0.03, 0.03, 0] });
    await button(page, "Go on").click();
    await fake.next((m) => m.type === "next" && m.step === "block", 0);
    fake.send(trialOf(1));
    await untilPhase(page, how.phase ?? "running");
    await run(page, fake);
  }, { ...how, change: (fake) => {
    fake.hello.checked = kChecked;
    fake.hello.step = { ...fake.hello.step, step: "block", title: "First block", number: 1 };
    how.change?.(fake);
  } });
}

// Waits until the server has received a pointer message for this motion from the start, in pixels. With a zoom
// the motion is known to the half pixel to which a window states its width.
async function untilTarget(fake, right_px, up_px, px_per_mm, zoom = 1) {
  const metres = 1e-3 / px_per_mm;
  const wanted = [kStart_m[0] + metres * up_px, kStart_m[1] - metres * right_px, kStart_m[2]];
  const isThere = () => {
    const newest = fake.pointers.at(-1);
    const most_m = zoom === 1 ? 4096 * kEpsilon : 1e-3 * metres * Math.hypot(right_px, up_px);
    return newest && newest.target_m.every((x, k) => Math.abs(x - wanted[k]) <= most_m);
  };
  for (let i = 0; !isThere(); ++i) {
    assert.ok(i < 1500, `the target is ${fake.pointers.at(-1)?.target_m}; expected ${wanted}`);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

function assertColour(seen, stated, what) {
  assert.ok(seen.every((v, k) => Math.abs(v - stated[k]) <= 8), `${what} has ${seen}; expected ${stated}`);
}

test("the course works with the keyboard alone, and consent needs the tick", async () => {
  await withPage(async (page, fake) => {
    const reach = async (name) => { // with Tab, from where the focus is
      for (let i = 0; i < 12; ++i) {
        await page.keyboard.press("Tab");
        if ((await page.evaluate(() => { // the text of a button, or what else it is
          const element = document.activeElement;
          return element.textContent || element.type || element.getAttribute("role");
        })) === name) return;
      }
      assert.fail(`Tab does not reach ${name}`);
    };
    const press = async (name) => {
      await reach(name);
      await page.keyboard.press(name === "checkbox" ? "Space" : "Enter");
    };
    const information = "First paragraph.\n\nSecond <b>one</b>.";
    fake.sendStep({ step: "information", title: "Welcome", text: information });
    await page.getByRole("heading", { name: "Welcome" }).waitFor();
    assert.deepEqual(await page.locator("#screen .text").allTextContents(), information.split("\n\n"));
    assert.equal(await page.locator("#screen b").count(), 0, "tags are text");
    await press("Go on");
    assert.equal((await fake.next(ofType("next"), 0)).step, "information");
    fake.sendStep({ step: "consent", title: "Consent", text: "Do you agree?" });
    await untilStep(page, "consent");
    assert.ok(await button(page, "I agree").isDisabled());
    await press("checkbox");
    await press("I agree");
    assert.equal((await fake.next(ofType("consent"), 0)).value, true);
    fake.sendStep({ step: "about", title: "About you", about: ["age", "hand"] });
    await untilStep(page, "about");
    await page.keyboard.press("Tab");
    await page.keyboard.type(" 31 ");
    await press("Go on");
    assert.deepEqual((await fake.next(ofType("about"), 0)).answers, { age: "31" });
    fake.sendStep({ step: "check", title: "Your screen" });
    await untilStep(page, "check");
    await reach("slider");
    await page.keyboard.press("ArrowLeft");
    await press("Go on");
    await press("Fill the screen");
    await page.locator(".check").filter({ hasText: "four strokes" }).waitFor();
    await press("Skip"); // strokes need the mouse
    const { motion, stroke_ratio, css_px_per_mm } = await fake.next(ofType("checked"), 0);
    assert.deepEqual([motion, stroke_ratio], ["unknown", null]);
    assert.ok(Math.abs(css_px_per_mm * kCard_mm - ((kCard_mm * 96) / kInch_mm - 1)) < 1e-9);
    await press("Stop");
    await press("Do not stop");
    fake.refusal = "not now";
    fake.sendStep({ step: "debriefing", title: "Thank you" });
    await untilStep(page, "debriefing");
    await press("Go on");
    await page.locator("#notice").filter({ hasText: "not now" }).waitFor();
  });
});

test("the questionnaire has no preset marks, needs all of them, and works with the keyboard", async () => {
  await withPage(async (page, fake) => {
    fake.sendStep({ step: "questionnaire", title: undefined });
    await page.getByRole("heading", { name: "How was it?" }).waitFor();
    const scales = page.getByRole("group");
    assert.equal(await scales.count(), 7);
    const marks = await scales.evaluateAll((all) => all.map((scale) =>
      [...scale.querySelectorAll("input")].map(({ value }) => Number(value))));
    const tlx = Array.from({ length: 21 }, (_, i) => 5 * i);
    assert.deepEqual(marks, [tlx, tlx, tlx, tlx, tlx, tlx, [1, 2, 3, 4, 5, 6, 7]]);
    assert.equal(await page.locator("input:checked").count(), 0);
    for (let scale = 0; scale < 7; ++scale) {
      assert.ok(await button(page, "Go on").isDisabled());
      await page.keyboard.press("Tab");
      await page.keyboard.press("Space"); // marks the first one
      for (let i = 0; i < scale; ++i) await page.keyboard.press("ArrowRight");
    }
    await page.keyboard.press("Tab");
    await page.keyboard.press("Enter");
    assert.deepEqual((await fake.next(ofType("rated"), 0)).answers, {
      tlx_mental: 0, tlx_physical: 5, tlx_temporal: 10, tlx_performance: 15, tlx_effort: 20,
      tlx_frustration: 25, real: 7 });
  });
});

test("who refuses to take part says so with one button", async () => {
  await withPage(async (page, fake) => {
    fake.sendStep({ step: "consent", title: "Consent" });
    await button(page, "I do not want to take part").click();
    assert.equal((await fake.next(ofType("consent"), 0)).value, false);
    fake.sendStep({ step: "refused", title: "Good bye" });
    await untilStep(page, "refused");
    assert.ok(await button(page, "Stop").isHidden());
  });
});

test("stopping asks whether to keep or to delete what was recorded", async () => {
  for (const [name, keep] of [["Stop, and keep what was recorded", true],
                              ["Stop, and delete what was recorded", false]]) {
    await withPage(async (page, fake) => {
      await button(page, "Stop").click();
      await button(page, "Do not stop").click();
      assert.ok(await page.locator("#stop-dialog").isHidden());
      assert.ok(!fake.messages.some(ofType("stop")));
      await button(page, "Stop").click();
      await button(page, name).click();
      assert.equal((await fake.next(ofType("stop"), 0)).keep, keep);
    });
  }
});

test("the input check knows lengths by a card, and whether fast strokes are longer", async () => {
  for (const [factor, motion] of [[1.02, "unaccelerated"], [1.8, "accelerated"]]) {
    await withPage(async (page, fake) => {
      fake.sendStep({ step: "check", title: "Your screen" });
      await page.getByRole("slider").focus();
      const wished_px = 412;
      const width = async () => Number(await page.getByRole("slider").getAttribute("aria-valuenow"));
      const first_px = await width();
      assert.ok(Math.abs(first_px - (kCard_mm * 96) / kInch_mm) < 1, "96 pixels an inch at first");
      for (let left = wished_px - first_px; left !== 0; left = wished_px - (await width())) {
        await page.keyboard.press(left >= 10 ? "Shift+ArrowRight" : "ArrowRight");
      }
      const box = await page.getByRole("slider").boundingBox();
      assert.ok(Math.abs(box.width / box.height - kCard_mm / 53.98) < 0.01);
      const css_px_per_mm = box.width / kCard_mm;
      await button(page, "Go on").click();
      await button(page, "Fill the screen").click();
      await button(page, "Begin").click();
      await page.locator(".said").filter({ hasText: "Stroke 1 of 4: slowly" }).waitFor();
      await page.evaluate(() => document.exitPointerLock()); // as Esc does
      await button(page, "Begin").click();
      await page.locator(".said").filter({ hasText: "Stroke 1 of 4: slowly" }).waitFor();
      // Events that state their own times, so that a busy machine makes no stroke slower.
      const client = await page.context().newCDPSession(page);
      let now_s = Date.now() / 1000;
      const mouse = (type, x) => client.send("Input.dispatchMouseEvent", {
        type, x, y: 300, button: "left", buttons: 1, clickCount: 1, timestamp: now_s });
      const stroke = async (length_px, time_s) => {
        now_s += 1;
        await mouse("mouseMoved", 100);
        await mouse("mousePressed", 100);
        for (let i = 1; i <= 5; ++i) {
          now_s += time_s / 5;
          await mouse("mouseMoved", 100 + (length_px * i) / 5);
        }
        await mouse("mouseReleased", 100 + length_px);
      };
      await stroke(300, 0.3); // was to be slow
      await page.locator(".said").filter({ hasText: "too fast" }).waitFor();
      for (let i = 0; i < 2; ++i) {
        await stroke(300, 2.5);
        await stroke(factor * 300, 0.3);
      }
      await page.locator(".said").filter({ hasText: factor < 1.25 ? "same way" : "farther" }).waitFor();
      await button(page, "Go on").click();
      const checked = await fake.next(ofType("checked"), 0);
      assert.equal(checked.input, "mouse");
      assert.equal(checked.motion, motion);
      assert.ok(Math.abs(checked.stroke_ratio - factor) < 0.02, `${checked.stroke_ratio}`);
      assert.ok(Math.abs(checked.css_px_per_mm - css_px_per_mm) < 0.02);
      assert.equal(checked.device_pixel_ratio, 1);
      assert.equal(typeof checked.unadjusted, "boolean");
      assert.ok(checked.refresh_Hz > 0);
    });
  }
});

test("a pen needs no strokes, and a participant chooses among the inputs of the plan", async () => {
  await withPage(async (page, fake) => {
    fake.sendStep({ step: "check", title: "Your screen" });
    await button(page, "Pen").click();
    await button(page, "Go on").click();
    await button(page, "Fill the screen").click();
    const checked = await fake.next(ofType("checked"), 0);
    assert.deepEqual([checked.input, checked.motion, checked.unadjusted], ["pen", "unaccelerated", null]);
  }, { change: (fake) => (fake.hello.inputs = ["mouse", "pen"]) });
});

for (const [deviceScaleFactor, zoom] of [[1, 1], [1.5, 1], [2, 1], [1, 1.5]]) {
  test(`at ${100 * deviceScaleFactor} % and a zoom of ${zoom}, 100 px move the frame by the calibrated length, and ` +
       "no motion is lost", async (t) => {
    const other = zoom === 1 ? undefined : await openZoomedBrowser(zoom);
    t.after(() => other?.close());
    await withTrial(async (page, fake) => {
      const ratio = await page.evaluate(() => devicePixelRatio);
      assert.ok(Math.abs(ratio - zoom * deviceScaleFactor) < 0.01, `${ratio}`);
      assert.equal((await fake.next(ofType("ready"), 0)).trial, 1);
      assert.equal(fake.scenes, 1);
      await untilTarget(fake, 0, 0, 5);
      // The picture: a metre has these many pixels, and the frame moves by as many pixels as the pointer.
      assert.ok(Math.abs((await page.evaluate(() => window.palpate.pixels_per_m())) - 5000) < 5000 * 4 * kEpsilon);
      await page.mouse.move(500, 300);
      fake.pointers.length = 0;
      fake.send({ type: "trial_end", number: 1 });
      fake.send(trialOf(2));
      await until(page, () => window.palpate.phase() === "running");
      await untilTarget(fake, 0, 0, 5);
      await page.mouse.move(600, 300);
      await untilTarget(fake, 100, 0, 5, zoom);
      await page.mouse.move(600, 260, { steps: 40 });
      await untilTarget(fake, 100, 40, 5, zoom);
      // Many small motions while the page is busy, so that the browser joins events.
      await page.evaluate(() => {
        const busy = setInterval(() => {
          for (const end = performance.now() + 40; performance.now() < end;);
        }, 60);
        setTimeout(() => clearInterval(busy), 2000);
      });
      const client = await page.context().newCDPSession(page);
      await Promise.all(Array.from({ length: kEvents }, (_, i) => client.send("Input.dispatchMouseEvent", {
        type: "mouseMoved", x: 600 - 0.45 * (i + 1), y: 260 + 0.15 * (i + 1) }))); // without waiting for each
      await untilTarget(fake, 100 - 0.45 * kEvents, 40 - 0.15 * kEvents, 5, zoom);
      assert.ok(fake.pointers.every(({ holds }) => holds));
      const sequences = fake.pointers.map(({ sequence }) => sequence);
      assert.ok(sequences.every((n, i) => i === 0 || n > sequences[i - 1]), "sequences count up");
      assert.equal(fake.scenes, 1, "the same object is not fetched again");
    }, { options: { context: { deviceScaleFactor } }, other, change: (fake) =>
      (fake.hello.checked = { ...kChecked, device_pixel_ratio: zoom * deviceScaleFactor }) });
  });
}

test("a trial of another object fetches it, and the times of pictures are told", async () => {
  await withTrial(async (page, fake) => {
    const { times_ms } = await fake.next((m) => m.type === "frames" && m.times_ms.length > 0, 0);
    assert.ok(times_ms.every((t, i) => i === 0 || t > times_ms[i - 1]) && times_ms.length <= 100);
    fake.send({ type: "trial_end", number: 1 });
    fake.send(trialOf(2, 1));
    await fake.next((m) => m.type === "ready" && m.trial === 2, 0);
    assert.equal(fake.scenes, 2);
    fake.send({ type: "ring", p_scene_m: [0, 0, 0] });
    await page.locator(".ring").filter({ hasText: "blue ring" }).waitFor();
    // The proxy is in the middle; 5 px a mm, A1 up, A2 to the left. The ring has a radius of 6 mm.
    const [middle, rim] = await page.evaluate(() => new Promise((resolve) => {
      const canvas = document.querySelector(".picture");
      const gl = canvas.getContext("webgl2");
      const colour = (x, y) => {
        const pixel = new Uint8Array(4);
        gl.readPixels(x, canvas.height - 1 - y, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
        return [...pixel.subarray(0, 3)];
      };
      window.palpate.onPicture(() => resolve([colour(500, 320), colour(500 + 150 + 30, 320 - 150)]));
    }));
    assertColour(middle, [0xd8, 0x1b, 0x78], "the ball");
    assertColour(rim, [0x2f, 0x74, 0xe0], "the ring");
    await page.screenshot({ path: join(pictureFolder(), "course_trial.png") });
    fake.send({ type: "ring", p_scene_m: null });
    await until(page, () => document.querySelector(".ring").textContent === "");
  });
});

test("who frees the pointer ends the trial, is told so, and can go on, pause or stop", async () => {
  await withTrial(async (page, fake) => {
    await page.evaluate(() => document.exitPointerLock()); // as Esc does
    assert.equal((await fake.next(ofType("left"), 0)).why, "pointer_lock");
    await untilPhase(page, "left");
    const count = fake.pointers.length;
    assert.deepEqual(await faultsOf(page), []);
    await page.screenshot({ path: join(pictureFolder(), "course_left.png") });
    await button(page, "Pause").last().click();
    await fake.next(ofType("pause"), 0);
    fake.sendStep({ step: "paused", title: "Pause" });
    await untilStep(page, "paused");
    await button(page, "Go on").click();
    await fake.next(ofType("go_on"), 0);
    fake.send(trialOf(2));
    await untilPhase(page, "running");
    assert.ok(fake.pointers.length > count);
    await page.evaluate(() => document.exitFullscreen());
    await fake.next((m) => m.type === "left" && ["full_screen", "pointer_lock"].includes(m.why));
    assert.equal(fake.messages.filter(ofType("left")).length, 2, "once for each trial");
    fake.send(trialOf(3)); // repeated: waits for a click
    await untilPhase(page, "waiting");
    await button(page, "Go on").click();
    await fake.next((m) => m.type === "ready" && m.trial === 3, 0);
    await untilPhase(page, "running");
    await page.evaluate(() => dispatchEvent(new Event("blur")));
    assert.equal((await fake.next((m) => m.type === "left" && m.why === "focus", 0)).why, "focus");
  });
});

test("who frees the pointer between two trials is asked to go on, and no trial was interrupted", async () => {
  await withTrial(async (page, fake) => {
    fake.send({ type: "trial_end", number: 1 });
    await untilPhase(page, "between");
    await page.evaluate(() => document.exitPointerLock());
    await button(page, "Go on").click();
    await until(page, () => document.querySelector(".overlay").hidden);
    fake.send(trialOf(2));
    await fake.next((m) => m.type === "ready" && m.trial === 2, 0);
    await untilPhase(page, "running");
    assert.ok(!fake.messages.some(ofType("left")));
  });
});

test("Enter ends a condition once, and again after a refusal", async () => {
  await withTrial(async (page, fake) => {
    const isEnd = (m) => m.type === "next" && m.step === "learning";
    fake.send({ type: "trial_end", number: 1 });
    fake.send({ ...trialOf(2), step: "learning" });
    await fake.next((m) => m.type === "ready" && m.trial === 2, 0);
    await untilPhase(page, "running");
    fake.refusal = "too many messages wait";
    await page.keyboard.press("Enter");
    await page.locator("#notice").filter({ hasText: "too many messages wait" }).waitFor();
    const accepted = fake.next(isEnd);
    await page.keyboard.press("Enter");
    await accepted;
    await page.keyboard.press("Enter");
    await fake.next(ofType("frames")); // is sent after the key
    assert.equal(fake.messages.filter(isEnd).length, 2);
  });
});

test("a board moves without the pointer, and its participant can pause", async () => {
  await withTrial(async (page, fake) => {
    await page.mouse.move(300, 300);
    await fake.next(ofType("frames"));
    assert.equal(fake.pointers.length, 0);
    await button(page, "Pause").click();
    await fake.next(ofType("pause"), 0);
  }, { change: (fake) => {
    fake.hello.inputs = ["board"];
    fake.hello.checked = { ...kChecked, input: "board" };
  } });
});

async function untilClutched(fake, isClutched) {
  for (let i = 0; fake.pointers.at(-1)?.isClutched !== isClutched; ++i) {
    assert.ok(i < 1500);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

test("space bar and left button are the clutch of a mouse where the plan permits it, and end no trial", async () => {
  await withTrial(async (page, fake) => {
    await untilClutched(fake, false);
    await page.locator(".bar .clutch").filter({ hasText: "space bar" }).waitFor();
    await page.keyboard.down(" ");
    await untilClutched(fake, true);
    assert.ok(fake.pointers.at(-1).holds);
    await page.keyboard.up(" ");
    await untilClutched(fake, false);
    await page.mouse.down();
    await untilClutched(fake, true);
    await page.mouse.up();
    await untilClutched(fake, false);
    assert.equal(await page.evaluate(() => window.palpate.phase()), "running");
    fake.sendStep({ step: "instructions" });
    await untilStep(page, "instructions");
    await page.locator("#screen").filter({ hasText: "set the mouse back" }).waitFor();
    assert.deepEqual(await faultsOf(page), []);
  }, { change: (fake) => (fake.hello.clutch = true) });
  await withTrial(async (page, fake) => {
    await page.keyboard.down(" ");
    await page.mouse.down();
    await fake.next(ofType("frames"));
    await page.mouse.up();
    assert.ok(fake.pointers.length > 0 && !fake.pointers.some((one) => one.isClutched));
    assert.equal(await page.locator(".bar .clutch").textContent(), "");
  });
});

test("a finger moves the device as far as it moves itself, and each press is one hold", async () => {
  await withTrial(async (page, fake) => {
    const client = await page.context().newCDPSession(page);
    const touch = (type, ...points) => client.send("Input.dispatchTouchEvent", {
      type, touchPoints: points.map(([x, y]) => ({ x, y })) });
    const untilFree = async () => {
      for (let i = 0; fake.pointers.at(-1).holds; ++i) {
        assert.ok(i < 1500);
        await new Promise((resolve) => setTimeout(resolve, 20));
      }
    };
    await page.locator(".bar .clutch").filter({ hasText: "Do not lift" }).waitFor();
    assert.ok(!fake.pointers.some((one) => one.isClutched), "before the first press");
    await touch("touchStart", [300, 300]);
    await touch("touchMove", [330, 280]);
    await untilTarget(fake, 30, 20, 5);
    assert.ok(fake.pointers.at(-1).holds && !fake.pointers.at(-1).isClutched);
    await touch("touchEnd");
    await untilFree();
    assert.ok(fake.pointers.at(-1).isClutched, "a lift is a clutch");
    await page.evaluate(() => addEventListener("pointerdown", ({ pointerId }) => (window.pressed = pointerId)));
    await touch("touchStart", [600, 100]);
    await touch("touchMove", [605, 100]);
    await untilTarget(fake, 35, 20, 5);
    // A browser that takes the finger for a gesture of its own states no place.
    await page.evaluate(() => document.querySelector(".picture").dispatchEvent(
      new PointerEvent("pointercancel", { pointerId: window.pressed })));
    await untilFree();
    await untilTarget(fake, 35, 20, 5);
    await touch("touchEnd");
    await touch("touchStart", [300, 300]);
    await touch("touchMove", [300, 290]);
    await untilTarget(fake, 35, 30, 5);
    await touch("touchEnd");
  }, { options: { context: { hasTouch: true } }, change: (fake) => {
    fake.hello.inputs = ["touch"];
    fake.hello.checked = { ...kChecked, input: "touch" };
  } });
});

test("a reload or a cut connection comes back to the step of the server", async () => {
  await withTrial(async (page, fake) => {
    fake.hello.step = { ...fake.hello.step, step: "paused", title: "Pause" };
    fake.cut();
    await untilStep(page, "paused");
    assert.ok(await page.locator("#trial").isHidden());
    await page.reload();
    await until(page, () => window.palpate?.step() === "paused");
    await button(page, "Go on").click();
    fake.send(trialOf(4));
    await untilPhase(page, "running");
    assert.ok((await page.evaluate(() => window.palpate.pixels_per_m())) === 5000, "the calibration is kept");
  });
});

test("a page without its token, or of another version, says so", async () => {
  const fake = await FakeLive.start(`${kProject}/models/star.glb`);
  try {
    const stranger = await openPage(browser, fake.address.split("#")[0]);
    await stranger.locator("#connection").filter({ hasText: "without its whole address" }).waitFor();
    fake.hello.version = 3;
    const old = await openPage(browser, fake.address);
    await old.locator("#connection").filter({ hasText: "another version" }).waitFor();
    for (const page of [stranger, old]) {
      assertClean(page);
      await page.context().close();
    }
  } finally {
    await fake.stop();
  }
});

test("a drawing that the browser has taken away counts no pictures", async () => {
  await withTrial(async (page, fake) => {
    await fake.next((m) => m.type === "frames" && m.times_ms.length > 0, 0);
    const drawn = await page.evaluate(async () => {
      const canvas = document.querySelector(".picture");
      const lost = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
      const isLost = new Promise((resolve) => canvas.addEventListener("webglcontextlost", resolve));
      lost.loseContext();
      await isLost;
      const before = window.palpate.pictures();
      await new Promise((resolve) => setTimeout(resolve, 300));
      const during = window.palpate.pictures() - before;
      setTimeout(() => lost.restoreContext());
      return { before, during };
    });
    assert.equal(drawn.during, 0);
    await until(page, (n) => window.palpate.pictures() > n, drawn.before);
  }, { complaints: /Context (Lost|Restored)/ });
});

test("each word of the page is used", () => {
  const folder = join(kProject, "engine/viewer/page");
  const source = readdirSync(folder).filter((name) => name.endsWith(".ts"))
    .map((name) => readFileSync(join(folder, name), "utf8")).join("\n");
  const made = new RegExp("^(stroke_(slow|fast|too_\\w+)|about_(age|gender|hand|experience|left|right|both)|" +
    `title_(${source.match(/type StepName =([^;]*);/)[1].match(/\w+/g).join("|")})|` +
    "(tlx_(mental|physical|temporal|performance|effort|frustration)|real)_(name|text))$"); // by parts
  const words = JSON.parse(readFileSync(join(folder, "live_words.json"), "utf8"));
  assert.deepEqual(Object.keys(words).filter((key) => !made.test(key) && !source.includes(`"${key}"`)), []);
});

test("the words, the language and the direction are those of the server", async () => {
  await withPage(async (page, fake) => {
    const [lang, dir] = await page.evaluate(() => [document.documentElement.lang, document.documentElement.dir]);
    assert.deepEqual([lang, dir, await page.title()], ["he", "rtl", "\u05e0\u05d9\u05e1\u05d5\u05d9"]);
    await button(page, "\u05d4\u05de\u05e9\u05da").click();
    await fake.next(ofType("next"), 0);
    fake.sendStep({ step: "check", title: "\u05de\u05e1\u05da" });
    const before = await page.getByRole("slider").boundingBox();
    await page.mouse.move(before.x + 20, before.y + 40);
    await page.mouse.down();
    await page.mouse.move(before.x - 30, before.y + 40); // the card begins at the right
    await page.mouse.up();
    const now = await page.getByRole("slider").boundingBox();
    assert.ok(Math.abs(now.width - before.width - 50) < 1, `${before.width} to ${now.width}`);
    await page.screenshot({ path: join(pictureFolder(), "course_rtl.png") });
  }, { change: (fake) => Object.assign(fake.hello, {
    language: "he", direction: "rtl",
    words: { page_title: "\u05e0\u05d9\u05e1\u05d5\u05d9", go_on: "\u05d4\u05de\u05e9\u05da", unknown_key: "x" },
  }) });
});

const kText = "Sentences of a text that a plan states, which are long enough for more than one line. ".repeat(6);
const kSteps = [
  { step: "information", title: "What this is about", text: `${kText}\n\n${kText}` },
  { step: "consent", title: "Consent", text: kText },
  { step: "check", title: "Your screen and your mouse" },
  { step: "about", title: "About you", about: ["age", "gender", "hand", "experience"] },
  { step: "block", title: "Second block", text: kText, number: 2 },
  { step: "questionnaire", title: undefined },
  { step: "break", title: "A break", text: "Look out of the window.", remaining_s: 95, may_go_on: false },
  { step: "paused", title: "Pause" },
  { step: "stopped", title: "You have stopped", text: kText },
];
for (const [width, height, theme] of [[1024, 700, "light"], [1920, 1080, "dark"], [3840, 2160, "light"],
                                      [1024, 700, "dark"]]) {
  test(`the screens fit into ${width} x ${height}, ${theme}, with enough contrast`, async () => {
    await withPage(async (page, fake) => {
      for (const step of kSteps) {
        fake.sendStep(step);
        await untilStep(page, step.step);
        await page.screenshot({ path: join(pictureFolder(), `course_${step.step}_${width}_${theme}.png`) });
        assert.deepEqual(await faultsOf(page), [], step.step);
        if (step.step === "break") {
          fake.send({ type: "status", paused: false, remaining_s: 3000 });
          await page.locator(".countdown").filter({ hasText: /50:00|49:5[0-9]/ }).waitFor();
        }
        if (step.step !== "paused") continue;
        await button(page, "Stop").click();
        assert.deepEqual(await faultsOf(page), [], "the dialog");
        await page.screenshot({ path: join(pictureFolder(), `course_dialog_${width}_${theme}.png`) });
      }
    }, { options: { viewport: { width, height }, theme } });
  });
}
