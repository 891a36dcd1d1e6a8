// The page of the experimenter, with the program and a participant without a browser: what it shows, what
// its buttons do, and what a blind plan hides.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";

import {
  assertClean, button, closeAll, faultsOf, kClosed, kPrograms, openBrowser, openPage, pictureFolder,
  startProgram, until,
} from "./chromium.mjs";
import { writeLivePlan } from "./live_plan.mjs";

const kPython = process.env.PALPATE_PYTHON ?? "python3";

let browser;
before(async () => (browser = await openBrowser()));
after(() => closeAll(browser));

// Runs a test with the page, while a participant waits in the first trial. entries(): of the journal.
async function withPage(run, live = {}) {
  const folder = mkdtempSync(join(tmpdir(), "palpate-experimenter-"));
  const plan = writeLivePlan(folder, { limit_s: 3600, rotation: ["NoR", "R"], live });
  const program = await startProgram(kPrograms[1], ["experiment", "live", plan,
    "--participant", "3", "--out", join(folder, "out")], 2);
  const person = spawn(kPython, ["-B", join(import.meta.dirname, "waiting_participant.py"), program.addresses[0],
    "debriefing"], { stdio: ["ignore", "inherit", "inherit"] });
  const entries = () => readFileSync(join(folder, "out/participants/03/journal.txt"), "utf8").trimEnd()
    .split("\n").map((line) => JSON.parse(line.slice(17)));
  try {
    const page = await openPage(browser, program.addresses[1], { script: () => {
      const send = WebSocket.prototype.send; // what the page has sent
      window.sent = [];
      WebSocket.prototype.send = function (message) {
        window.sent.push(typeof message === "string" ? message : "binary");
        return send.call(this, message);
      };
    } });
    await untilValue(page, "Trial", "1 of 2, runs");
    await run(page, entries);
    assertClean(page, kClosed);
    await page.context().close();
  } finally {
    person.kill("SIGKILL");
    await program.stop();
    rmSync(folder, { recursive: true });
  }
}
// Waits until the value of a name is this text.
function untilValue(page, name, text) {
  return until(page, ([wantedName, wanted]) => [...document.querySelectorAll("dt")]
    .some((dt) => dt.textContent === wantedName && dt.nextElementSibling.textContent.includes(wanted)), [name, text]);
}
const untilSaid = (page, text) => page.locator(".experimenter .said").filter({ hasText: text }).waitFor();

test("the experimenter sees the trial, and what the buttons ask for is done and journalled", async () => {
  await withPage(async (page, entries) => {
    await until(page, () => window.palpate.drawnBodies() > 0 && window.palpate.drawnTick() > 0);
    assert.match(await page.title(), /participant 3/);
    await untilValue(page, "Step", "Practice");
    await untilValue(page, "Condition", "NoH-");
    await untilValue(page, "Object", "O1");
    await untilValue(page, "Pictures", "40.0 Hz");
    await untilValue(page, "Commanded", "0.00 N");
    await page.getByLabel("Note, for the journal").fill(" a <b>lorry</b> ");
    await page.keyboard.press("Enter");
    await untilSaid(page, "The note is in the journal");
    await page.keyboard.press("Shift+Tab"); // back to the last of the buttons
    assert.equal(await page.evaluate(() => document.activeElement.textContent), "Abort the trial");
    await page.keyboard.press("Enter");
    assert.equal(await page.evaluate(() => document.activeElement.textContent), "Back");
    await page.keyboard.press("Enter");
    await button(page, "Rearm").click();
    await untilSaid(page, "the force was not cut");
    assert.deepEqual(entries().filter(({ kind }) => kind === "end"), [], "nothing was aborted");
    await button(page, "Abort the trial").click();
    await button(page, "Abort this trial").click();
    await untilValue(page, "Last attempt", "practice, trial 1, attempt 1: aborted (experimenter)");
    await untilValue(page, "Trial", "2 of 2, runs");
    await button(page, "Repeat the trial").click();
    await button(page, "Skip the trial").click();
    await button(page, "Skip this trial").click();
    await untilValue(page, "Last attempt", "trial 2, attempt 1: skipped");
    await untilValue(page, "skipped", "1");
    await untilValue(page, "Trial", "1 of 2, runs");
    await untilValue(page, "Attempt", "2");
    await button(page, "Pause").click();
    await untilValue(page, "Step", "Paused");
    await button(page, "Go on").click();
    await untilValue(page, "Trial", "2 of 2, runs"); // the repeated one
    const kinds = entries().map(({ kind, by }) => (by ? `${kind} by ${by}` : kind));
    assert.deepEqual(kinds.filter((kind) => /note|repeat|by/.test(kind)),
                     ["note", "repeat", "pause by experimenter", "go_on by experimenter"]);
    assert.equal(entries().find(({ kind }) => kind === "note").text, "a <b>lorry</b>");
    // It cannot move the hand.
    const box = await page.locator(".top-view").boundingBox();
    await page.mouse.move(box.x + 50, box.y + 50);
    await page.mouse.down();
    await page.mouse.move(box.x + 150, box.y + 90, { steps: 5 });
    await page.mouse.up();
    assert.ok(!(await page.evaluate(() => window.sent)).includes("binary"));
    for (const [width, height] of [[1024, 700], [1920, 1080]]) {
      await page.setViewportSize({ width, height });
      for (const colorScheme of ["light", "dark"]) {
        await page.emulateMedia({ colorScheme });
        assert.deepEqual(await faultsOf(page), [], `${width} ${colorScheme}`);
        await page.screenshot({ path: join(pictureFolder(), `experimenter_${width}_${colorScheme}.png`) });
      }
    }
  });
});

test("a blind plan hides the condition, and with it the picture and the forces", async () => {
  await withPage(async (page) => {
    await untilValue(page, "Condition", "hidden by the plan");
    await untilValue(page, "Object", "hidden by the plan");
    assert.ok(await page.locator(".top-view").isHidden());
    assert.ok(await page.getByText("Commanded").isHidden());
    assert.equal(await page.evaluate(() => window.palpate.state()), null);
    await page.screenshot({ path: join(pictureFolder(), "experimenter_blind.png") });
  }, { blind: true });
});
