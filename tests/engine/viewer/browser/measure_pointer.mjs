// Measures how long a motion of the mouse takes to the engine and to the picture, in a window of a desktop
// (desktop.mjs) with the real program: from the time that the X server gives to the event
//   - until the server has seen the first tick that used it. It states this on a clock of its own, which is taken to be
//     as far behind the page's as the fastest message says: the times are too long by the time of that message;
//   - until the first picture that shows it has been drawn. The browser shows it at the next frame of the screen.
//
// run_in_node.py pointer PROJECT BUILD FOLDER PALPATE

import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { cpus, loadavg, tmpdir } from "node:os";
import { join } from "node:path";

import { assertClean, button, kClosed, kPrograms, openPage, startProgram, until } from "./chromium.mjs";
import { focusPage, openDesktop, press } from "./desktop.mjs";
import { writeLivePlan } from "./live_plan.mjs";

const kRates_Hz = [125, 1000]; // of the mouse
const kSeconds = 10; // for each of them
const kTurn = 50; // motions to one side before as many to the other

// Keeps which message each event made, and for each state its newest message, and when it was sent and received.
function watchTimes() {
  window.times = { events: [], states: [], pictures: [] };
  const Real = window.WebSocket;
  window.WebSocket = class extends Real {
    constructor(...args) {
      super(...args);
      this.addEventListener("message", ({ data }) => { // before the page's own
        const now_ms = performance.now();
        if (typeof data === "string") return;
        const view = new DataView(data); // engine/viewer/messages.h
        if (view.getUint16(0, true) !== 1) return;
        window.times.states.push([Number(view.getBigUint64(8, true)), 1000 * view.getFloat64(40, true), now_ms]);
      });
    }
  };
  addEventListener("pointerrawupdate", ({ timeStamp }) => { // after the page's own, which is nearer to the target
    if (window.palpate) window.times.events.push([window.palpate.sent(), timeStamp]); // the page has begun
  });
}

// The time from each event to the first of these that has its message; both in the order of time.
function delays(events, later) {
  const found = [];
  let at = 0;
  for (const [sequence, begin_ms] of events) {
    while (at < later.length && later[at][0] < sequence) ++at;
    if (at < later.length) found.push(later[at][1] - begin_ms);
  }
  return found.sort((a, b) => a - b);
}
const summary = (sorted) => ({
  median_ms: sorted[sorted.length >> 1], p99_ms: sorted[Math.floor(0.99 * sorted.length)], most_ms: sorted.at(-1),
});

async function measure(desktop, page, rate_Hz) {
  await page.evaluate(() => {
    for (const list of Object.values(window.times)) list.length = 0;
    window.palpate.onPicture((time_ms, state) => window.times.pictures.push([state.pointerSequence, time_ms]));
  });
  for (const end = Date.now() + 1000 * kSeconds; Date.now() < end;) {
    await desktop.act(...[1, -1].flatMap((right_px) => Array(kTurn).fill(
      ["mousemove_relative", "--", right_px, 0, "sleep", 1 / rate_Hz]).flat()));
  }
  await page.waitForTimeout(500);
  const { events, states, pictures } = await page.evaluate(() => window.times);
  const behind_ms = Math.min(...states.map(([, sent_ms, received_ms]) => received_ms - sent_ms));
  const ticks = states.map(([sequence, sent_ms]) => [sequence, sent_ms + behind_ms]);
  return { asked_Hz: rate_Hz, events: events.length,
           event_to_tick: summary(delays(events, ticks)), event_to_picture: summary(delays(events, pictures)) };
}

const folder = mkdtempSync(join(tmpdir(), "palpate-pointer-"));
const plan = writeLivePlan(folder, { rotation: ["R"] });
const program = await startProgram(kPrograms[0], ["experiment", "live", plan, "--participant", "1",
                                                  "--out", join(folder, "out")]);
const desktop = await openDesktop();
const result = { processors: cpus().length, load: loadavg()[0], seconds: kSeconds, rates: [] };
try {
  const page = await openPage(desktop, program.address, { script: watchTimes });
  await until(page, () => (window.palpate?.step() ?? null) !== null);
  await focusPage(desktop, page);
  const pressButton = (name) => press(desktop, page, button(page, name));
  await pressButton("Go on");
  await press(desktop, page, page.getByRole("checkbox"));
  for (const name of ["I agree", "Mouse", "Go on", "Fill the screen", "Skip", "Go on"]) await pressButton(name);
  await until(page, () => window.palpate.step() === "learning");
  await pressButton("Go on");
  await until(page, () => window.palpate.phase() === "running");
  for (const rate_Hz of kRates_Hz) result.rates.push(await measure(desktop, page, rate_Hz));
  assertClean(page, kClosed);
} finally {
  await desktop.close();
  await program.stop();
  rmSync(folder, { recursive: true });
}
const text = `${JSON.stringify(result, null, 1)}\n`;
writeFileSync(join(process.env.PALPATE_FOLDER, "pointer.json"), text);
process.stdout.write(text);
