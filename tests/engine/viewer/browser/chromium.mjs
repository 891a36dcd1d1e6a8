// Opens the page of `palpate view` in headless Chromium, for tests.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

export const driver = await import(pathToFileURL(join(process.env.PALPATE_DRIVER, "index.mjs")));

export const kProject = process.env.PALPATE_PROJECT;
export const kPrograms = process.env.PALPATE_PROGRAMS.split(":");
// What Chromium says when a program ends while its page is open.
export const kClosed = /WebSocket connection to|Failed to load resource: net::ERR_/;
const kContrast = 4.5; // of texts, at least
export const kStep_ms = 240_000; // only ends a test that hangs

// All flags of Chromium: software drawing, and no name is resolved but loopback.
export const kFlags = [
  "--no-sandbox",
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-gpu-watchdog", // it ends a process that a busy machine lets wait for 15 s
  "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
  "--disable-background-networking",
  "--force-color-profile=srgb",
];
const kFlagsWithoutWebgl = ["--disable-gpu", "--disable-3d-apis", "--disable-software-rasterizer"];

// Starts Chromium. hasWebgl false: without WebGL.
export function openBrowser(hasWebgl = true) {
  return driver.chromium.launch({
    timeout: kStep_ms,
    executablePath: process.env.PALPATE_CHROMIUM,
    args: hasWebgl ? kFlags : [...kFlags.filter((flag) => !/swiftshader|angle/.test(flag)),
                               ...kFlagsWithoutWebgl],
  });
}

// A browser that shows every page with this zoom, in one context and one window.
export async function openZoomedBrowser(zoom) {
  const profile = mkdtempSync(join(tmpdir(), "palpate_profile_"));
  mkdirSync(join(profile, "Default"));
  const level = Math.log(zoom) / Math.log(1.2); // as Chromium counts it
  writeFileSync(join(profile, "Default/Preferences"),
                JSON.stringify({ partition: { default_zoom_level: { x: level } } }));
  const context = await driver.chromium.launchPersistentContext(profile, {
    timeout: kStep_ms, executablePath: process.env.PALPATE_CHROMIUM, viewport: null,
    args: [...kFlags, "--window-size=1400,1000"],
  });
  return {
    newContext: async () => context,
    close: async () => {
      await context.close();
      rmSync(profile, { recursive: true });
    },
  };
}

// Opens an address of the page. options.script runs in it before its own scripts; options.context are
// options of the driver's context. `complaints` of the result collects errors of the console, reports of
// the content security policy and requests that leave loopback.
export async function openPage(browser, address, options = {}) {
  const context = await browser.newContext({
    viewport: options.viewport ?? { width: 1000, height: 640 }, // drawn in software
    colorScheme: options.theme ?? "light",
    ...options.context,
  });
  const page = await context.newPage();
  page.setDefaultTimeout(kStep_ms);
  const complaints = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) complaints.push(`console: ${message.text()}`);
  });
  page.on("pageerror", (error) => complaints.push(`error: ${error.stack}`));
  page.on("request", (request) => {
    const url = new URL(request.url());
    if (url.protocol !== "blob:" && url.hostname !== "127.0.0.1") complaints.push(`request: ${url}`);
  });
  await page.addInitScript(() => addEventListener("securitypolicyviolation", (event) =>
    console.error(`policy: ${event.violatedDirective} ${event.blockedURI}`)));
  if (options.script) await page.addInitScript(options.script);
  page.complaints = complaints;
  page.pending = new Set(); // requests without an answer
  page.on("request", (request) => page.pending.add(request.url()));
  for (const end of ["requestfinished", "requestfailed"]) {
    page.on(end, (request) => page.pending.delete(request.url()));
  }
  // The tests wait for what they need of the page; the end of loading is not among it.
  await explained(page, page.goto(address, { timeout: kStep_ms, waitUntil: "commit" }));
  return page;
}

// Fails if the page complained of anything that is not expected.
export function assertClean(page, expected = /^$/) {
  assert.deepEqual(page.complaints.filter((text) => !expected.test(text)), []);
}

// Adds to the error of a step what the page was waiting for and what it had complained of.
async function explained(page, step) {
  try {
    return await step;
  } catch (error) {
    const words = ["connection", "connection-notice", "said", "no-webgl", "watch-notice"];
    const said = await Promise.race([
      page.evaluate((ids) => ids.map((id) => document.getElementById(id)?.textContent), words),
      new Promise((resolve) => setTimeout(() => resolve(["the page does not answer"]), 10_000)),
    ]).catch((problem) => [String(problem)]);
    error.message += `\npending: ${[...page.pending].join(" ")}\n${page.complaints.join("\n")}` +
      `\nthe page says: ${said.join(" | ")}`;
    throw error;
  }
}

// The button with exactly this name.
export const button = (page, name) => page.getByRole("button", { name, exact: true });

// Waits until the function is true in the page.
export function until(page, predicate, argument) {
  return explained(page, page.waitForFunction(predicate, argument, { timeout: kStep_ms, polling: 20 }));
}

// Waits until the page receives states and knows the settings.
export function untilLive(page) {
  return until(page, () =>
    window.palpate?.isLive() && window.palpate.state() !== null && window.palpate.status() !== null);
}

// Waits until the page draws the scene and knows the settings.
export function untilDrawn(page) {
  return until(page, () => window.palpate?.drawnBodies() > 0 && window.palpate.drawnTick() >= 0 &&
                           window.palpate.status() !== null);
}

// The texts on the page whose contrast to their background is below kContrast, and what does not fit into the
// window.
export function faultsOf(page) {
  return page.evaluate((least) => {
    const numbers = (colour) => colour.match(/[0-9.]+/g).map(Number);
    const luminance = ([r, g, b]) => [r, g, b].map((v) => v / 255)
      .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
      .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
    const backgroundOf = (element) => {
      for (let e = element; e; e = e.parentElement) {
        const [r, g, b, a = 1] = numbers(getComputedStyle(e).backgroundColor);
        if (a === 1) return [r, g, b];
        if (a !== 0) return [NaN, NaN, NaN]; // a mixture: is not used
      }
      return [NaN, NaN, NaN];
    };
    const faults = [];
    if (document.documentElement.scrollWidth > innerWidth) faults.push("the page is wider than the window");
    for (const element of document.querySelectorAll("body *")) {
      const box = element.getBoundingClientRect();
      if (box.width === 0 || !element.checkVisibility()) continue;
      if (box.left < -1 || box.right > innerWidth + 1) faults.push(`${element.className} reaches out`);
      const hasText = [...element.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim() !== "");
      if (!hasText) continue;
      const [a, b] = [luminance(numbers(getComputedStyle(element).color)), luminance(backgroundOf(element))];
      const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
      if (!(contrast >= least)) faults.push(`"${element.textContent}" has a contrast of ${contrast}`);
    }
    return faults;
  }, kContrast);
}

// No program outlives the test.
const children = new Set();
process.once("exit", () => children.forEach((child) => child.kill("SIGKILL")));
for (const signal of ["SIGINT", "SIGTERM"]) process.once(signal, () => process.exit(1));

// Starts a program that ends with the test.
export function startChild(program, args, options) {
  const child = spawn(program, args, options);
  children.add(child);
  child.once("exit", () => children.delete(child));
  return child;
}

// Ends the browser, and the programs of a test that failed before it stopped them: a file of tests ends only
// when nothing of it runs.
export async function closeAll(browser) {
  await browser.close();
  children.forEach((child) => child.kill("SIGKILL"));
}

// A program that prints the address of a page in a line, or so many. ask(command) sends a line and waits
// for the next one.
export async function startProgram(program, args, count = 1) {
  const child = startChild(program, args, { stdio: ["pipe", "pipe", "inherit"] });
  const lines = createInterface({ input: child.stdout })[Symbol.asyncIterator]();
  const addresses = [];
  while (addresses.length < count) {
    const { value, done } = await lines.next();
    assert.ok(!done, `${program} ended without printing an address`);
    addresses.push(...(value.match(/http:\/\/[0-9.]+:[0-9]+\/#[0-9a-f]{32}/) ?? []));
  }
  const [address] = addresses;
  return {
    address,
    addresses,
    port: Number(new URL(address).port),
    child,
    ask: async (command) => {
      child.stdin.write(`${JSON.stringify(command)}\n`);
      assert.equal((await lines.next()).value, "done");
    },
    stop: async () => {
      const ended = new Promise((resolve) => child.once("exit", resolve));
      child.stdin.end();
      child.kill("SIGINT");
      await ended;
    },
  };
}

// Makes the view exactly this large, whatever surrounds it.
export async function resizeView(page, width, height) {
  for (let round = 0; round < 2; ++round) {
    const { width: w, height: h } = page.viewportSize();
    const box = await page.locator("#view").boundingBox();
    await page.setViewportSize({ width: Math.round(w + width - box.width),
                                 height: Math.round(h + height - box.height) });
  }
  await until(page, ([w, h]) => {
    const canvas = document.getElementById("view");
    return canvas.width === w && canvas.height === h;
  }, [width, height]);
}

// Hides what lies over the drawing.
export function hideWords(page) {
  return page.evaluate(() => {
    for (const id of ["readout", "key", "notices"]) document.getElementById(id).style.display = "none";
  });
}

// The folder for pictures that are looked at.
export function pictureFolder() {
  const folder = process.env.PALPATE_PICTURES;
  mkdirSync(folder, { recursive: true });
  return folder;
}
