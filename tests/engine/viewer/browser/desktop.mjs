// Chromium in a window of a desktop: a screen in memory (Xvfb), a window manager, and a mouse and keys whose
// events come from the X server (xdotool). Other than a headless browser it fills a screen, loses a focus, and
// moves its locked pointer by what the X server says.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { promisify } from "node:util";

import { driver, kFlags, kStep_ms, startChild, until } from "./chromium.mjs";

const run = promisify(execFile);
const kWindowPart = 0.75; // of the width and the height of the screen

// The first line of a stream that fits, as a match.
async function lineOf(stream, pattern) {
  for await (const line of createInterface({ input: stream })) {
    const found = line.match(pattern);
    if (found) {
      stream.resume(); // what else it says is not read
      return found;
    }
  }
  return assert.fail(`a program ended before it said ${pattern}`);
}

// width, height: of the screen, in its own pixels. scale: of these for each CSS pixel.
export async function openDesktop({ width = 1280, height = 800, scale = 1 } = {}) {
  const profile = mkdtempSync(join(tmpdir(), "palpate_profile_"));
  const server = startChild("Xvfb", ["-displayfd", "3", "-screen", "0", `${width}x${height}x24`, "-nolisten", "tcp",
                                     "-noreset"], { stdio: ["ignore", "ignore", "ignore", "pipe"] });
  const env = { ...process.env, DISPLAY: `:${(await lineOf(server.stdio[3], /^[0-9]+$/))[0]}` };
  // Without its default font, which Xvfb has not.
  const manager = startChild("evilwm", ["-fn", "fixed", "-bw", "0"], { env, stdio: "ignore" });
  const chromium = startChild(process.env.PALPATE_CHROMIUM, [
    ...kFlags, `--force-device-scale-factor=${scale}`,
    `--window-size=${Math.round((kWindowPart * width) / scale)},${Math.round((kWindowPart * height) / scale)}`,
    "--remote-debugging-port=0", `--user-data-dir=${profile}`, "--no-first-run", "--no-default-browser-check",
    "--test-type", // no bar about flags
    "about:blank",
  ], { env, stdio: ["ignore", "ignore", "pipe"] });
  const [, address] = await lineOf(chromium.stderr, /(ws:\/\/\S+)/);
  // Without the defaults of the driver: it would pretend a focus, and Chromium would then fill the tab only.
  const browser = await driver.chromium.connectOverCDP(address, { noDefaults: true, timeout: kStep_ms });
  const act = (...words) => run("xdotool", words.map(String), { env });
  return {
    newContext: async () => browser.contexts()[0],
    act, // commands of xdotool
    scale,
    // The place of a point of the page on the screen.
    place: async (page, [x, y]) => {
      const [left, top] = await page.evaluate(() => [screenX, screenY + outerHeight - innerHeight]);
      return [Math.round(scale * (left + x)), Math.round(scale * (top + y))];
    },
    close: async () => {
      await browser.close();
      for (const child of [chromium, manager, server]) { // in this order: each needs the next one
        if (child.exitCode !== null || child.signalCode !== null) continue;
        const ended = once(child, "exit");
        child.kill();
        await ended;
      }
      rmSync(profile, { recursive: true, force: true });
    },
  };
}

// Gives the page the focus of the desktop, as the first click into a window does.
export async function focusPage(desktop, page) {
  await desktop.act("mousemove", ...(await desktop.place(page, [5, 5])));
  await until(page, () => document.hasFocus());
}

// Presses what the mouse can reach.
export async function press(desktop, page, locator) {
  await locator.scrollIntoViewIfNeeded(); // as a person does with the wheel
  const box = await locator.boundingBox();
  const place = await desktop.place(page, [box.x + 0.5 * box.width, box.y + 0.5 * box.height]);
  await desktop.act("mousemove", ...place, "click", 1);
}
