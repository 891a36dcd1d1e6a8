// The paper's display: the ball in the middle, the other marks where the poses of the state put them, flat
// colours, and the rate of its pictures. Each picture is read back right after it was drawn.

import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";

import {
  assertClean, closeAll, kPrograms, kProject, openBrowser, openPage, pictureFolder, resizeView, startProgram,
  until, untilDrawn,
} from "./chromium.mjs";
import { writePpm } from "./png.mjs";

const kWidth = 640;
const kHeight = 480;
const kFarthestBall_px = 1; // from the middle of the picture
const kFarthest_px = 1.5; // of a mark from where it should be
const kColour = 8; // of 255
const kPerMetre_px = (1000 * 96) / 25.4; // at scale 1, without a calibration
const kPictures = 1000;
const kWhole = 60; // every so many pictures, one is kept as a whole
const kPeriod_ms = 25;
const kMean_ms = 0.5; // of the mean from the period
const kTimed = 400; // pictures
const kLeastRun_ms = 1000;
const kFewestGaps = 100;
const kLeastTurn_rad = (20 * Math.PI) / 180; // of the scene by A4, in the 1,000 pictures
const kRays = 90; // to the rim of a sphere
const kFewestRays = 30; // that meet nothing else there

// The stated colours.
const kColours = {
  background: [0x0d, 0x11, 0x17], object: [0xff, 0xd6, 0x33], ball: [0xd8, 0x1b, 0x78],
  frame: [0x00, 0x86, 0x3a], start: [0x33, 0xd1, 0x7a], end: [0xf0, 0x3a, 0x2e], ring: [0x2f, 0x74, 0xe0],
};
const isNear = (a, b) => a.every((v, k) => Math.abs(v - b[k]) <= kColour);
const half = (a, b) => a.map((v, k) => 0.5 * (v + b[k])); // one half-transparent over the other
const kinds = {
  start: [half(kColours.start, kColours.background), half(kColours.start, kColours.object)],
  end: [half(kColours.end, kColours.background), half(kColours.end, kColours.object)],
};

let browser;
before(async () => (browser = await openBrowser()));
after(() => closeAll(browser));

// Where the top view shows a point, from the definition: A1 up, A2 to the left, the proxy in the middle.
function rotated([w, x, y, z], v) {
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
          v[2] + w * t[2] + x * t[1] - y * t[0]];
}
const minus = (a, b) => a.map((v, k) => v - b[k]);
const plus = (a, b) => a.map((v, k) => v + b[k]);
const seenAt = (fromBall_m, scale) =>
  [kWidth / 2 - scale * kPerMetre_px * fromBall_m[1], kHeight / 2 - scale * kPerMetre_px * fromBall_m[0]];
function places(record, spheres, scale) {
  const q = record.q_after_wxyz;
  const proxy_device_m = plus(rotated(q, record.proxy_scene_m), record.o_after_m);
  const ofScene = (p) => seenAt(rotated(q, minus(p, record.proxy_scene_m)), scale);
  return { frame: seenAt(minus(record.device_m, proxy_device_m), scale), start: ofScene(spheres.green_m),
           end: ofScene(spheres.red_m), ofScene };
}

// Keeps in the page the place of the ball in each picture, and `kept`, whole pictures with their states.
function watch(page, whole) {
  return page.evaluate(([every, ball, tolerance]) => {
    const canvas = document.getElementById("view");
    const gl = canvas.getContext("webgl2");
    const seen = { balls: [], kept: [] };
    window.seen = seen;
    window.palpate.onPicture((_, state) => {
      const { width, height } = canvas;
      const isKept = seen.balls.length % every === 0;
      const size = 80; // of the part that is searched for the ball
      const [left, low, w, h] = isKept ? [0, 0, width, height]
        : [(width - size) / 2, (height - size) / 2, size, size];
      const pixels = new Uint8Array(4 * w * h);
      gl.readPixels(left, low, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      let [n, x, y] = [0, 0, 0];
      for (let i = 0; i < w * h; ++i) {
        if (![0, 1, 2].every((k) => Math.abs(pixels[4 * i + k] - ball[k]) <= tolerance)) continue;
        ++n;
        x += left + (i % w) + 0.5;
        y += height - (low + Math.floor(i / w) + 0.5);
      }
      seen.balls.push([n, x / n, y / n]);
      if (isKept) seen.kept.push({ pixels, width, height, record: state.record });
    });
  }, [whole, kColours.ball, kColour]);
}

// The whole pictures that the page has kept, and takes them from it.
async function takeKept(page) {
  const kept = await page.evaluate(() => window.seen.kept.splice(0).map(({ pixels, ...rest }) => {
    let text = "";
    for (let i = 0; i < pixels.length; i += 8192) {
      text += String.fromCharCode(...pixels.subarray(i, i + 8192));
    }
    return { ...rest, pixels: btoa(text) };
  }));
  return kept.map(({ pixels, width, height, record }) => {
    const bytes = Buffer.from(pixels, "base64");
    const at = (x, y) => {
      const i = 4 * ((height - 1 - Math.floor(y)) * width + Math.floor(x));
      return [bytes[i], bytes[i + 1], bytes[i + 2]];
    };
    return { at, width, height, record };
  });
}

// The middle of the box around the pixels of a colour.
function middleOfColour(picture, colour) {
  let [left, right, top, bottom] = [Infinity, -Infinity, Infinity, -Infinity];
  for (let y = 0; y < picture.height; ++y) {
    for (let x = 0; x < picture.width; ++x) {
      if (!isNear(picture.at(x, y), colour)) continue;
      [left, right] = [Math.min(left, x), Math.max(right, x + 1)];
      [top, bottom] = [Math.min(top, y), Math.max(bottom, y + 1)];
    }
  }
  return [0.5 * (left + right), 0.5 * (top + bottom)];
}

// The centre of the circle that fits points best (least squares of x^2 + y^2 + a x + b y + c = 0).
function centreOfCircle(points) {
  const n = points.length;
  const [mx, my] = [0, 1].map((k) => points.reduce((s, p) => s + p[k], 0) / n);
  let [xx, xy, yy, xr, yr] = [0, 0, 0, 0, 0];
  for (const [px, py] of points) {
    const [x, y] = [px - mx, py - my];
    const r = x * x + y * y;
    [xx, xy, yy, xr, yr] = [xx + x * x, xy + x * y, yy + y * y, xr + x * r, yr + y * r];
  }
  const d = 2 * (xx * yy - xy * xy);
  return [mx + (xr * yy - yr * xy) / d, my + (yr * xx - xr * xy) / d];
}

// Where the picture shows a half-transparent sphere near a place, from its rim. null: nearly all of the rim
// is covered, or out of the picture.
function centreOfSphere(picture, colours, [x, y], radius_px) {
  const isOf = (p) => colours.some((colour) => isNear(p, colour));
  const isBare = (p) => isNear(p, kColours.background) || isNear(p, kColours.object);
  const rim = [];
  for (let i = 0; i < kRays; ++i) {
    const [c, s] = [Math.cos((2 * Math.PI * i) / kRays), Math.sin((2 * Math.PI * i) / kRays)];
    const at = (r) => [x + r * c, y + r * s];
    const colour = (r) => {
      const [u, v] = at(r);
      return u < 0 || v < 0 || u >= picture.width || v >= picture.height ? [-99, -99, -99] : picture.at(u, v);
    };
    for (let r = 0.5 * radius_px; r < 1.5 * radius_px; r += 0.125) {
      if (!isOf(colour(r)) || isOf(colour(r + 0.125))) continue;
      if (isBare(colour(r + 0.125))) rim.push(at(r + 0.0625));
      break;
    }
  }
  return rim.length < kFewestRays ? null : centreOfCircle(rim);
}

function assertNear(seen, expected, what) {
  const away = Math.hypot(seen[0] - expected[0], seen[1] - expected[1]);
  assert.ok(away <= kFarthest_px, `${what} is at ${seen}; expected ${expected}`);
}

// Checks the frame and the spheres of a picture. Returns how many spheres were seen.
function checkMarks(picture, spheres, scale) {
  const expected = places(picture.record, spheres, scale);
  assertNear(middleOfColour(picture, kColours.frame), expected.frame, "the frame");
  let seen = 0;
  for (const name of ["start", "end"]) {
    const centre = centreOfSphere(picture, kinds[name], expected[name], scale * kPerMetre_px * spheres.radius_m);
    if (!centre) continue;
    ++seen;
    assertNear(centre, expected[name], `the ${name} sphere`);
  }
  return seen;
}

async function openPaper(server) {
  const page = await openPage(browser, server.address);
  await untilDrawn(page);
  await resizeView(page, kWidth, kHeight);
  return page;
}

for (const [turn_deg, scale] of [[0, 1], [37, 1], [200, 2], [-71, 0.5]]) {
  test(`scale ${scale}, turned by ${turn_deg} degrees: each mark has its place and its colour`, async () => {
    const spheres = { green_m: [-0.01, 0.02, 0], red_m: [-0.01, 0.045, 0], radius_m: 0.006 };
    const display = JSON.stringify({ name: "paper", Hz: 40, scale, spheres });
    const program = await startProgram(kPrograms[0], [`${kProject}/models/star.glb`, "2", display]);
    try {
      const angle = (turn_deg * Math.PI) / 360;
      const q = [Math.cos(angle), 0, 0, Math.sin(angle)];
      const o_after_m = [0.013, -0.021, 0.002];
      const proxy_scene_m = [-0.03, 0.03, 0];
      const device_m = plus(plus(rotated(q, proxy_scene_m), o_after_m), [0.004 / scale, 0.012 / scale, 0]);
      const page = await openPage(browser, program.address);
      await program.ask({ state: { tick: 5, q_after_wxyz: q, o_after_m, device_m, proxy_scene_m } });
      await untilDrawn(page);
      await resizeView(page, kWidth, kHeight);
      await until(page, () => window.palpate.drawnTick() === 5);
      await watch(page, 1);
      await until(page, () => window.seen.kept.length > 2);
      const picture = (await takeKept(page)).at(-1);
      writePpm(join(pictureFolder(), `paper_${turn_deg}.ppm`), kWidth, kHeight, picture.at);
      assert.equal(checkMarks(picture, spheres, scale), 2);
      const { start, end, ofScene } = places(picture.record, spheres, scale);
      assert.ok(isNear(picture.at(kWidth / 2, kHeight / 2), kColours.ball), "the ball");
      assert.ok(isNear(picture.at(...ofScene([-0.02, 0.01, 0])), kColours.object), "the object");
      assert.ok(isNear(picture.at(2, 2), kColours.background), "the background");
      for (const [name, place] of [["start", start], ["end", end]]) {
        const colour = picture.at(...place);
        assert.ok(kinds[name].some((kind) => isNear(colour, kind)), `${name} has ${colour}`);
      }
      // Nothing else is drawn: each pixel has one of the stated colours.
      const known = [...Object.values(kColours), ...kinds.start, ...kinds.end];
      for (let y = 0; y < kHeight; ++y) {
        for (let x = 0; x < kWidth; ++x) {
          const colour = picture.at(x, y);
          assert.ok(known.some((k) => isNear(colour, k)), `the pixel ${[x, y]} has ${colour}`);
        }
      }
      assertClean(page);
      await page.context().close();
    } finally {
      await program.stop();
    }
  });
}

test("in 1,000 pictures the ball is in the middle and the marks are in place while A4 turns", async () => {
  const server = await startProgram(kPrograms[1], ["view", `${kProject}/models/star.glb`, "--display", "paper"]);
  try {
    const page = await openPaper(server);
    const { spheres, Hz, scale } = await page.evaluate(() => window.palpate.hello().display);
    assert.ok(spheres && Hz === 40 && scale === 1);
    await watch(page, kWhole);
    // Into the wall of the star, then to and fro along it.
    const [x, y] = [kWidth / 2, kHeight / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x, y - 260, { steps: 30 });
    const pictures = () => page.evaluate(() => window.seen.balls.length);
    for (let i = 0; (await pictures()) < kPictures; ++i) {
      await page.mouse.move(x + 220 * Math.sin(0.05 * i), y - 260, { steps: 2 });
    }
    await page.screenshot({ path: join(pictureFolder(), "paper_live.png") });
    const balls = await page.evaluate(() => window.seen.balls);
    for (const [n, u, v] of balls) {
      assert.ok(n > 0 && Math.hypot(u - kWidth / 2, v - kHeight / 2) <= kFarthestBall_px, `the ball: ${[n, u, v]}`);
    }
    const kept = await takeKept(page);
    const seen = kept.reduce((sum, picture) => sum + checkMarks(picture, spheres, scale), 0);
    assert.ok(seen > kept.length / 2, `${seen} spheres were seen in ${kept.length} pictures`);
    const angles = kept.map(({ record: { q_after_wxyz: [w, , , z] } }) => 2 * Math.atan2(z, w));
    assert.ok(Math.max(...angles) - Math.min(...angles) > kLeastTurn_rad, `A4 has turned to ${angles}`);
    assertClean(page);
    await page.context().close();
  } finally {
    await server.stop();
  }
});

// The parts of a session in which the browser gave frames without a pause, as a busy machine does not:
// [begin, end] in ms, each at least kLeastRun_ms long.
function runsWithoutPause(frames_ms) {
  const runs = [];
  let begin = frames_ms[0];
  frames_ms.forEach((t, i) => {
    const next = frames_ms[i + 1] ?? Infinity;
    if (next - t <= kPeriod_ms) return;
    if (t - begin >= kLeastRun_ms) runs.push([begin, t]);
    begin = next;
  });
  return runs;
}

test("the mean time between pictures is that of 40 Hz", async () => {
  const server = await startProgram(kPrograms[1], ["view", `${kProject}/models/star.glb`, "--display", "paper"]);
  try {
    const page = await openPage(browser, server.address, { viewport: { width: 320, height: 240 } });
    await untilDrawn(page);
    await page.evaluate(() => {
      window.seen = { times_ms: [], frames_ms: [] };
      const frame = (now_ms) => {
        requestAnimationFrame(frame);
        window.seen.frames_ms.push(now_ms);
      };
      requestAnimationFrame(frame);
      window.palpate.onPicture((time_ms) => window.seen.times_ms.push(time_ms));
    });
    await until(page, (count) => window.seen.times_ms.length >= count, kTimed);
    const { times_ms, frames_ms } = await page.evaluate(() => window.seen);
    const gaps_ms = runsWithoutPause(frames_ms).flatMap(([begin, end]) => {
      const times = times_ms.filter((t) => t > begin + kPeriod_ms && t < end);
      return times.slice(1).map((t, i) => t - times[i]);
    });
    const mean_ms = gaps_ms.reduce((sum, gap) => sum + gap, 0) / gaps_ms.length;
    console.log(`${gaps_ms.length} of ${kTimed} gaps without a pause of the browser, mean ${mean_ms} ms`);
    const all_ms = (times_ms.at(-1) - times_ms[0]) / (times_ms.length - 1);
    assert.ok(all_ms >= kPeriod_ms - kMean_ms, `pictures come too soon: ${all_ms} ms`);
    if (gaps_ms.length >= kFewestGaps) assert.ok(Math.abs(mean_ms - kPeriod_ms) <= kMean_ms, `${mean_ms} ms`);
    assertClean(page);
    await page.context().close();
  } finally {
    await server.stop();
  }
});

test("the page of the paper's display shows it alone, and pauses and stops", async () => {
  const server = await startProgram(kPrograms[1], ["view", `${kProject}/models/star.glb`, "--display", "paper"]);
  try {
    const page = await openPaper(server);
    const shown = await page.evaluate(() => ["#readout", "#key", "aside", "header", "#settings", "canvas"]
      .filter((name) => document.querySelector(name).getClientRects().length > 0));
    assert.deepEqual(shown, ["canvas"]);
    await page.keyboard.press("a"); // a key of the full page
    await page.keyboard.press("c");
    await page.getByRole("button", { name: "Pause" }).click();
    await until(page, () => window.palpate.state().isPaused);
    assert.equal(await page.evaluate(() => window.palpate.status().settings.a4), true);
    assertClean(page);
    await page.context().close();
  } finally {
    await server.stop();
  }
});
