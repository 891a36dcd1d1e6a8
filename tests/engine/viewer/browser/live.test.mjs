// The page with a running engine: the hand, the controls, the connection. Tests wait for ticks, sequence
// numbers and values of the engine, never for a time.

import assert from "node:assert/strict";
import { createServer } from "node:http";
import { join } from "node:path";
import { after, before, test } from "node:test";

import {
  assertClean, closeAll, kClosed, kPrograms, kProject, openBrowser, openPage, pictureFolder, startProgram,
  until, untilDrawn, untilLive,
} from "./chromium.mjs";
import { openLine } from "./cut_line.mjs";

const kStar = `${kProject}/models/star.glb`;
const kGallery = `${kProject}/models/gallery.glb`;

let browser;
before(async () => (browser = await openBrowser()));
after(() => closeAll(browser));

const view = (...args) => startProgram(kPrograms[1], ["view", ...args]);

async function withServer(args, run) {
  const server = await view(...args);
  try {
    await run(server);
  } finally {
    await server.stop();
  }
}

const state = (page) => page.evaluate(() => window.palpate.state());

// Where the top view shows a place of the device frame, on the screen.
async function screenPlace(page, place_m) {
  const at = await page.evaluate(([x, y, z]) => window.palpate.pixelOf(x, y, z), place_m);
  const box = await page.locator("#view").boundingBox();
  return [box.x + at.x, box.y + at.y];
}

// Waits until the engine has used a pointer message that was sent after this call.
async function untilUsed(page) {
  const sent = await page.evaluate(() => window.palpate.sent());
  await until(page, (n) => window.palpate.state().pointerSequence > n, sent);
}

// Waits until this number of further ticks has passed.
async function untilTicks(page, count) {
  const { record } = await state(page);
  await until(page, (tick) => window.palpate.state().record.tick >= tick, record.tick + count);
}

// Drags the hand from where it is to the places, and keeps the button down.
async function press(page, ...places_m) {
  await page.mouse.move(...(await screenPlace(page, (await state(page)).record.device_m)));
  await page.mouse.down();
  for (const place of places_m) await page.mouse.move(...(await screenPlace(page, place)), { steps: 10 });
  await untilUsed(page);
}

const length = (v) => Math.hypot(...v);
const minus = (a, b) => a.map((x, i) => x - b[i]);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);

// The wall on which the hand meets the star from its start, deep below the wall.
const kInTheStar_m = [0, 0.02, 0];

async function setFlag(page, name, key, value) {
  if ((await page.evaluate((n) => window.palpate.setting(n), name)) !== value) await page.keyboard.press(key);
  await until(page, ([n, v]) => window.palpate.status().settings[n] === v, [name, value]);
}

test("dragging into the star's wall stops the ball and shows a force against it", async () => {
  await withServer([kStar], async (server) => {
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    await setFlag(page, "a4", "a", false);
    await press(page, kInTheStar_m);
    await until(page, () => {
      const { record } = window.palpate.state();
      return record.contact === 1 && Math.hypot(...record.full_force_device_N) > 0.5;
    });
    const { record, target_m, isHeld, hasTarget } = await state(page);
    assert.ok(isHeld && hasTarget);
    assert.ok(length(minus(target_m, kInTheStar_m)) < 0.002, `the target is ${target_m}`);
    const out = minus(record.proxy_scene_m, record.goal_scene_m); // A4 is off: the scene has not turned
    assert.ok(dot(out, record.normal_scene) > 0, "the ball is outside of the wall");
    assert.ok(dot(record.full_force_device_N, out) > 0, "the force pushes the hand out");
    assert.match(await page.locator("#contact").textContent(), /Contact/);
    await page.mouse.up();
    await until(page, () => !window.palpate.state().isHeld);
    assertClean(page);
    await page.context().close();
  });
});

test("A4 turns the scene while it is on, and only then", async () => {
  await withServer([kStar], async (server) => {
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    await setFlag(page, "a4", "a", false);
    await press(page, kInTheStar_m);
    await until(page, () => window.palpate.state().record.contact === 1);
    const before = (await state(page)).record.q_after_wxyz;
    await untilTicks(page, 500);
    assert.deepEqual((await state(page)).record.q_after_wxyz, before);
    await setFlag(page, "a4", "a", true);
    await until(page, (q) => {
      const now = window.palpate.state().record.q_after_wxyz;
      const cosine = Math.abs(now.reduce((sum, x, i) => sum + x * q[i], 0)); // of half the angle
      return Math.acos(Math.min(1, cosine)) > (2 * Math.PI) / 180;
    }, before);
    await setFlag(page, "a4", "a", false);
    const turned = (await state(page)).record.q_after_wxyz;
    await untilTicks(page, 500);
    assert.deepEqual((await state(page)).record.q_after_wxyz, turned);
    assertClean(page);
    await page.context().close();
  });
});

test("with the camera metaphor a drag moves the target by the pointer's displacement", async () => {
  await withServer([kStar], async (server) => {
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    await page.keyboard.press("c");
    await until(page, () => window.palpate.camera().mode === "camera");
    const box = await page.locator("#view").boundingBox();
    const before = (await state(page)).record.device_m;
    const perPixel = await page.evaluate(() => window.palpate.metresPerPixel(0, 0, 0));
    await page.mouse.move(box.x + 200, box.y + 300);
    await page.mouse.down();
    await page.mouse.move(box.x + 170, box.y + 320); // 30 px left: +A2; 20 px down: -A1
    await untilUsed(page);
    const moved = minus((await state(page)).target_m, before);
    // The device rests, but not to the bit: it may differ from the record that the drag began with.
    const expected = [-20 * perPixel, 30 * perPixel];
    assert.ok(length(minus(moved.slice(0, 2), expected)) < perPixel, `moved by ${moved}`);
    await page.mouse.up();
    assertClean(page);
    await page.context().close();
  });
});

test("arrow keys move the hand, and Escape lets go", async () => {
  await withServer([kStar], async (server) => {
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    await page.locator("#view").focus();
    const before = (await state(page)).record.device_m;
    for (let i = 0; i < 5; ++i) await page.keyboard.press("ArrowLeft");
    await until(page, () => window.palpate.state().isHeld && window.palpate.state().hasTarget);
    await untilUsed(page);
    assert.ok((await state(page)).target_m[1] > before[1], "left is +A2");
    await page.keyboard.press("Escape");
    await until(page, () => !window.palpate.state().isHeld);
    assertClean(page);
    await page.context().close();
  });
});

test("the wheel moves the hand in depth with three sensors", async () => {
  await withServer([`${kProject}/models/sphere.glb`, "--fit", "0.2", "--sensors", "3"], async (server) => {
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    const before = (await state(page)).record.device_m;
    const box = await page.locator("#view").boundingBox();
    await page.mouse.move(box.x + 300, box.y + 300);
    await page.mouse.wheel(0, -40);
    await until(page, () => window.palpate.state().isHeld);
    await untilUsed(page);
    const moved = minus((await state(page)).target_m, before);
    const ahead = await page.evaluate(() => {
      const m = window.palpate.camera().view; // world to camera: the third row is backwards
      return [-m[2], -m[6], -m[10]];
    });
    assert.ok(dot(moved, ahead) > 0.9 * length(moved) && length(moved) > 0, `moved by ${moved}`);
    await page.keyboard.press("Escape");
    assertClean(page);
    await page.context().close();
  });
});

test("each control changes the value of the engine", async () => {
  await withServer([kGallery, "--fit", "auto"], async (server) => {
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    await page.evaluate(() => document.querySelectorAll("details").forEach((box) => (box.open = true)));
    const { settings } = await page.evaluate(() => window.palpate.hello());
    assert.ok(settings.length >= 5, "A4, axes, force, stiffness, damping");
    assert.ok(settings.some(({ name }) => name.startsWith("material/")), "materials of the gallery");
    for (const setting of settings) {
      const control = page.locator(`[data-setting="${setting.name}"]`);
      let wanted;
      if (setting.kind === "flag") {
        wanted = !setting.value;
        await control.click();
      } else if (setting.kind === "choice") {
        wanted = setting.choices.find((choice) => choice !== setting.value);
        await control.getByRole("button", { name: wanted, exact: true }).click();
      } else if (setting.kind === "axes") {
        wanted = [[0, 1, 0]];
        await control.getByRole("button", { name: "motor on A2" }).click();
        await until(page, () => window.palpate.status().settings.axes.length === 2);
        await control.getByRole("button", { name: "motor on A1" }).click();
      } else {
        wanted = setting.low + 0.25 * (setting.high - setting.low);
        if (wanted === setting.value) wanted = setting.low + 0.5 * (setting.high - setting.low);
        await control.locator("input[type=number]").fill(String(wanted));
        await control.locator("input[type=number]").press("Enter");
      }
      await until(page, ([name, value]) => {
        const { settings, pending } = window.palpate.status();
        return !pending && JSON.stringify(settings[name]) === JSON.stringify(value);
      }, [setting.name, wanted]);
      if (setting.kind !== "axes") continue;
      await until(page, (axes) => JSON.stringify(window.palpate.state().axes) === JSON.stringify(axes), wanted);
    }
    assertClean(page);
    await page.context().close();
  });
});

test("a value outside of its range is refused, said, and not shown", async () => {
  await withServer([kStar], async (server) => {
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    const field = page.locator('[data-setting="stiffness"] input[type=number]');
    const before = await field.inputValue();
    await field.fill("-5");
    await field.press("Enter");
    await page.locator("#said").filter({ hasText: "stiffness" }).waitFor();
    await field.blur();
    await until(page, (value) =>
      document.querySelector('[data-setting="stiffness"] input[type=number]').value === value, before);
    assertClean(page);
    await page.context().close();
  });
});

test("pause holds the ticks, and start brings the hand back", async () => {
  await withServer([kStar], async (server) => {
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    await page.keyboard.press("Space");
    await until(page, () => window.palpate.state().isPaused && window.palpate.status().paused);
    const { tick } = (await state(page)).record;
    await page.keyboard.press("a"); // acts when the ticks go on
    await until(page, () => window.palpate.status().pending);
    await page.keyboard.press("Space");
    await until(page, () => !window.palpate.status().pending);
    await until(page, (n) => {
      const { isPaused, record } = window.palpate.state();
      return !isPaused && record.tick > n;
    }, tick);
    await press(page, [-0.12, 0.05, 0]);
    await page.mouse.up();
    await page.keyboard.press("s");
    await until(page, () => {
      const start = window.palpate.hello().start_device_m;
      const now = window.palpate.state().record.device_m;
      return Math.hypot(...now.map((v, i) => v - start[i])) < 1e-3;
    });
    assertClean(page);
    await page.context().close();
  });
});

test("a cut connection is said, and comes back with newer ticks", async () => {
  await withServer([kStar], async (server) => {
    const line = await openLine(server.port);
    const page = await openPage(browser, line.address(server.address));
    await untilDrawn(page);
    await until(page, () => window.palpate.isLive());
    assert.equal(await page.evaluate(() => location.hash), "", "the token is not in the address bar");
    const { tick } = (await state(page)).record;
    await page.evaluate(() => {
      window.seen = [];
      new MutationObserver(() => window.seen.push(document.getElementById("connection").textContent))
        .observe(document.getElementById("connection"), { childList: true });
    });
    line.cut();
    await until(page, () => window.seen.includes("Disconnected"));
    await until(page, (n) => window.palpate.isLive() && window.palpate.state().record.tick > n, tick);
    assert.ok(await page.locator("#connection-notice").isHidden());
    assertClean(page, kClosed);
    await page.context().close();
    await line.close();
  });
});

test("without a connection the state is grey, not present", async () => {
  const server = await view(kStar);
  const line = await openLine(server.port);
  const page = await openPage(browser, line.address(server.address));
  await untilDrawn(page);
  assert.ok(!(await page.evaluate(() => document.body.classList.contains("stale"))));
  await line.close();
  await until(page, () => document.body.classList.contains("stale"));
  await page.locator("#connection-notice").filter({ hasText: "The connection ended" }).waitFor();
  assertClean(page, kClosed);
  await page.context().close();
  await server.stop();
});

test("after a restart of the server the page asks for the new address", async () => {
  const first = await view(kStar);
  const line = await openLine(first.port);
  const page = await openPage(browser, line.address(first.address));
  await untilDrawn(page);
  await first.stop();
  const second = await view(kStar);
  line.leadTo(second.port);
  await page.locator("#connection-notice").filter({ hasText: "its address is new" }).waitFor();
  assertClean(page, kClosed);
  await page.context().close();
  await line.close();
  await second.stop();
});

test("the new address works in the tab of the old one", async () => {
  const first = await view(kStar);
  const page = await openPage(browser, first.address);
  await untilDrawn(page);
  await first.stop();
  const second = await view(kStar, "--port", String(first.port)); // only the part after # differs
  await page.evaluate((address) => { location.href = address; }, second.address);
  await until(page, (engine) => window.palpate?.isLive() && location.hash === "");
  await untilDrawn(page);
  assertClean(page, kClosed);
  await page.context().close();
  await second.stop();
});

test("a token that comes late is sent again", async () => {
  await withServer([kStar], async (server) => {
    const page = await openPage(browser, server.address, { script: () => {
      const { send } = WebSocket.prototype;
      window.late = 0;
      WebSocket.prototype.send = function (data) { // the first one, by more than the 2 s of the server
        if (window.late++ === 0) setTimeout(() => send.call(this, data), 3000);
        else send.call(this, data);
      };
    } });
    await untilDrawn(page);
    assert.ok(await page.evaluate(() => window.late) > 1);
    assertClean(page, /already in CLOSING or CLOSED state/);
    await page.context().close();
  });
});

test("another server of this host cannot frame the page and is told no secret", async () => {
  await withServer([kStar], async (server) => {
    const heard = [];
    const other = createServer((request, response) => {
      heard.push(JSON.stringify([request.url, request.headers]));
      response.setHeader("Content-Type", "text/html");
      response.end(`<!doctype html><title>other</title><iframe src="${server.address}"></iframe>`);
    });
    other.unref();
    await new Promise((resolve) => other.listen(0, "127.0.0.1", resolve));
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    const token = await page.evaluate(() => sessionStorage.getItem("palpate-token /"));
    assert.match(token, /^[0-9a-f]{32}$/);
    assert.equal(await page.evaluate(() => document.cookie), "");
    await page.goto(`http://127.0.0.1:${other.address().port}/`);
    await page.waitForFunction(() => document.querySelector("iframe"));
    await until(page, () => performance.getEntriesByType("resource").length > 0);
    const [, frame] = page.frames();
    assert.ok(await frame.evaluate(() => !window.palpate), "the page runs in a foreign frame");
    assert.ok(page.complaints.some((text) => /frame-ancestors|refused to connect|Refused to frame/i.test(text)),
              page.complaints.join("\n"));
    assert.ok(heard.length > 0 && heard.every((text) => !text.includes(token) && !/cookie/i.test(text) &&
                                                        !text.includes(`:${server.port}`)), heard.join("\n"));
    await page.context().close();
    await new Promise((resolve) => other.close(resolve));
  });
});

test("a page that was opened without the token says what to open", async () => {
  await withServer([kStar], async (server) => {
    const page = await openPage(browser, server.address.split("#")[0]);
    await page.locator("#connection-notice").filter({ hasText: "Open the address" }).waitFor();
    assertClean(page);
    await page.context().close();
  });
});

test("closing a page lets go and passes control on, and a watching page can take it", async () => {
  await withServer([kStar], async (server) => {
    const first = await openPage(browser, server.address);
    await untilDrawn(first);
    const second = await openPage(browser, server.address);
    await untilLive(second);
    await second.locator("#watch-notice").waitFor();
    assert.ok(await second.locator('[data-setting="a4"]').isDisabled());
    await press(first, [-0.12, 0.03, 0]);
    await until(second, () => window.palpate.state().isHeld);
    await first.context().close();
    await second.locator("#said").filter({ hasText: "this page is in control now" }).waitFor();
    await until(second, () => !window.palpate.state().isHeld);
    await until(second, () => window.palpate.status().control);
    await until(second, () => !document.querySelector('[data-setting="a4"]').disabled);
    const third = await openPage(browser, server.address);
    await untilLive(third);
    await third.locator("#watch-notice").waitFor();
    await third.getByRole("button", { name: "Take control" }).click();
    await until(third, () => window.palpate.status().control);
    await second.locator("#watch-notice").waitFor();
    for (const page of [second, third]) {
      assertClean(page);
      await page.context().close();
    }
  });
});

test("a page that loses control with its connection is told so", async () => {
  await withServer([kStar], async (server) => {
    const line = await openLine(server.port);
    const first = await openPage(browser, line.address(server.address));
    await untilLive(first);
    await until(first, () => window.palpate.status().control);
    const second = await openPage(browser, server.address);
    await untilLive(second);
    line.cut();
    await first.locator("#said").filter({ hasText: "another page came into control" }).waitFor();
    await first.locator("#watch-notice").waitFor();
    await until(second, () => window.palpate.status().control);
    assertClean(first, kClosed);
    for (const page of [first, second]) await page.context().close();
    await line.close();
  });
});

test("a picture is saved without breaking the policy", async () => {
  await withServer([kStar], async (server) => {
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("p")]);
    assert.match(download.suggestedFilename(), /^palpate-[0-9]+\.png$/);
    assertClean(page);
    await page.context().close();
  });
});

test("every control has a key and a name, and ? lists the keys", async () => {
  await withServer([kGallery, "--fit", "auto"], async (server) => {
    const page = await openPage(browser, server.address);
    await untilDrawn(page);
    await page.evaluate(() => document.querySelectorAll("details").forEach((box) => (box.open = true)));
    const without = await page.evaluate(() => {
      const controls = [...document.querySelectorAll(
        "#settings [data-setting], #materials-box summary, aside .buttons button")];
      return controls.filter((control) => !control.querySelector("kbd")?.textContent)
        .map((control) => control.textContent);
    });
    assert.deepEqual(without, [], "controls without a key");
    const fields = await page.locator("#materials [data-setting]").count();
    const visited = new Set();
    for (let i = 0; i < fields; ++i) {
      await page.keyboard.press("m");
      visited.add(await page.evaluate(
        () => document.activeElement.closest("[data-setting]").dataset.setting));
    }
    assert.equal(visited.size, fields, "the key M goes to each field of a material");
    await page.evaluate(() => document.activeElement.blur());
    const names = await page.evaluate(() =>
      [...document.querySelectorAll("button, input, summary, #view")].map((control) =>
        control.getAttribute("aria-label") || control.labels?.[0]?.textContent || control.textContent));
    assert.ok(names.every((name) => name.trim() !== ""), `${names}`);
    await page.keyboard.press("?");
    await page.locator("#help").waitFor();
    const keys = await page.locator("#help kbd").allTextContents();
    assert.equal(new Set(keys).size, keys.length, `a key has two meanings: ${keys}`);
    assertClean(page);
    await page.context().close();
  });
});

test("without WebGL the page says so and shows numbers and charts", async () => {
  await withServer([kStar], async (server) => {
    const plain = await openBrowser(false);
    const page = await openPage(plain, server.address);
    await page.locator("#no-webgl").filter({ hasText: "no WebGL" }).waitFor();
    await until(page, () =>
      window.palpate.state()?.record.tick > 0 && window.palpate.points("force_N")[0].length > 0);
    await page.locator("#rate").filter({ hasText: "Hz" }).waitFor();
    assertClean(page);
    await plain.close();
  });
});

for (const [width, height] of [[1400, 900], [360, 740]]) {
  for (const theme of ["light", "dark"]) {
    test(`the page fits into ${width} px, ${theme}`, async () => {
      await withServer([kStar], async (server) => {
        const page = await openPage(browser, server.address, { viewport: { width, height }, theme });
        await untilDrawn(page);
        await press(page, kInTheStar_m);
        await until(page, () => window.palpate.state().record.contact === 1);
        await untilTicks(page, 1500);
        const fits = await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth);
        assert.ok(fits, "the page is wider than the window");
        const [background, text] = await page.evaluate(() => {
          const style = getComputedStyle(document.body);
          return [style.backgroundColor, style.color].map((c) => c.match(/[0-9]+/g).map(Number));
        });
        const isDark = length(background) < length(text);
        assert.equal(isDark, theme === "dark");
        await page.screenshot({ path: join(pictureFolder(), `page_${width}_${theme}.png`), fullPage: true });
        assertClean(page);
        await page.context().close();
      });
    });
  }
}
