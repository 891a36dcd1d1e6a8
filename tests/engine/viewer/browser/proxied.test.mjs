// The page through a reverse proxy that speaks https and shows the server under a path.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import {
  assertClean, closeAll, kPrograms, kProject, openBrowser, openPage, startProgram, until, untilDrawn,
  untilLive,
} from "./chromium.mjs";
import { openProxy } from "./https_proxy.mjs";

const kStar = `${kProject}/models/star.glb`;
const kGone = /WebSocket connection to|Failed to load resource: net::ERR_/; // said by Chromium
const kTrusting = { ignoreHTTPSErrors: true }; // the certificate signs itself

let browser;
before(async () => (browser = await openBrowser()));
after(() => closeAll(browser));

const view = (...args) => startProgram(kPrograms[1], ["view", kStar, ...args]);

for (const passesHost of [true, false]) {
  test(`the page works through https under a path, ${passesHost ? "with" : "without"} the browser's Host`,
       async () => {
    const proxy = await openProxy({ passesHost });
    const server = await view("--allow-origin", proxy.origin);
    const address = proxy.lead("/lab/palpate", server.address);
    const page = await openPage(browser, address.replace("/#", "#"), { context: kTrusting });
    await untilDrawn(page);
    await untilLive(page);
    assert.equal(await page.evaluate(() => location.href), `${proxy.origin}/lab/palpate/`);
    assert.deepEqual(new Set(proxy.socketsAsked), new Set(["/lab/palpate/live"]));
    await page.locator("#view").focus();
    await page.keyboard.press("ArrowLeft");
    await until(page, () => window.palpate.state().isHeld && window.palpate.sent() > 0);
    await page.keyboard.press("Escape");
    await page.evaluate(() => {
      window.seen = [];
      new MutationObserver(() => window.seen.push(document.getElementById("connection").textContent))
        .observe(document.getElementById("connection"), { childList: true });
    });
    const tick = await page.evaluate(() => window.palpate.state().record.tick);
    await proxy.switchOff();
    await until(page, () => window.seen.includes("Disconnected"));
    await proxy.switchOn();
    await until(page, (n) => window.palpate.isLive() && window.palpate.state().record.tick > n, tick);
    await until(page, () => window.palpate.status().control);
    assertClean(page, kGone);
    await page.context().close();
    await server.stop();
    await proxy.close();
  });
}

test("the page works through a proxy that asks for a password", async () => {
  const proxy = await openProxy({ password: "person:secret" });
  const server = await view("--allow-origin", proxy.origin);
  const page = await openPage(browser, proxy.lead("/lab", server.address), { context: {
    ...kTrusting, httpCredentials: { username: "person", password: "secret" },
  } });
  await untilDrawn(page);
  assertClean(page, /status of 401/);
  await page.context().close();
  await server.stop();
  await proxy.close();
});

test("a proxy that passes no WebSockets is named", async () => {
  const proxy = await openProxy({ dropsSockets: true });
  const server = await view("--allow-origin", proxy.origin);
  const page = await openPage(browser, proxy.lead("/lab", server.address), { context: kTrusting });
  await page.locator("#connection-notice").filter({ hasText: "does not pass WebSockets" }).waitFor();
  assert.equal(await page.locator("#connection").textContent(), "Blocked");
  assertClean(page, /WebSocket connection to|Failed to load resource/);
  await page.context().close();
  await server.stop();
  await proxy.close();
});

test("an origin that is not allowed is named, and works once it is", async () => {
  const proxy = await openProxy();
  const first = await view("--allow-origin", proxy.origin.replace("https", "http"));
  const page = await openPage(browser, proxy.lead("/lab", first.address), { context: kTrusting });
  await page.locator("#connection-notice").filter({ hasText: `does not accept pages of ${proxy.origin}` })
    .waitFor();
  assert.equal(await page.locator("#connection").textContent(), "Refused");
  await first.stop();
  const second = await view("--allow-origin", proxy.origin);
  proxy.lead("/lab", second.address);
  await page.locator("#connection-notice").filter({ hasText: "its address is new" }).waitFor();
  assertClean(page, /WebSocket connection to|Failed to load resource/);
  await page.context().close();
  await second.stop();
  await proxy.close();
});

test("two servers behind one proxy keep their tokens apart in a tab", async () => {
  const proxy = await openProxy();
  const servers = [];
  for (let i = 0; i < 2; ++i) servers.push(await view("--allow-origin", proxy.origin));
  const addresses = servers.map((server, i) => proxy.lead(`/lab/${i}`, server.address));
  const page = await openPage(browser, addresses[0], { context: kTrusting });
  await untilLive(page);
  await page.goto(addresses[1]);
  await untilLive(page);
  await page.goto(addresses[0].split("#")[0]);
  await untilLive(page);
  assertClean(page, kGone);
  await page.context().close();
  for (const server of servers) await server.stop();
  await proxy.close();
});
