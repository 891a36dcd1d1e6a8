// What the page draws of fixed records: ball, frame and force at the expected pixels, and the outline
// of the scene where rays hit it. The records come through the real socket.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";

import {
  assertClean, closeAll, hideWords, kPrograms, kProject, openBrowser, openPage, pictureFolder, resizeView,
  startProgram, until, untilDrawn,
} from "./chromium.mjs";
import { pixelsWhere, readPng, writePpm } from "./png.mjs";

const kFarthest_px = 3; // of a mark from where it should be
const kOutline_px = 2; // of a pixel from the outline of the scene
const kFewestOfHead = 6; // a dashed line alone has fewer beside it
const kShift_px = 4;
const kForceArrow = 0.06; // length of 1 N, as a share of the radius of the scene
const kWidth = 640;
const kHeight = 480;
const kTurn_rad = (37 * Math.PI) / 180; // of the scene by A4
const kMostPictures = 20; // until one shows the ball

let browser;
let folder;
before(async () => {
  browser = await openBrowser();
  folder = mkdtempSync(join(tmpdir(), "palpate_view_"));
});
after(async () => {
  await closeAll(browser);
  rmSync(folder, { recursive: true });
});

// Rotations and rigid transforms, computed apart from the page.
const add = (a, b) => a.map((v, i) => v + b[i]);
const scaled = (a, f) => a.map((v) => v * f);
const minus = (a, b) => add(a, scaled(b, -1));
function rotated([w, x, y, z], v) {
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
          v[2] + w * t[2] + x * t[1] - y * t[0]];
}
const turnAbout = (axis, angle) => {
  const s = Math.sin(angle / 2) / Math.hypot(...axis);
  return [Math.cos(angle / 2), ...scaled(axis, s)];
};

// Where a camera of the page shows a point of the display frame.
function pixelOf(camera, point) {
  const times = (m, v) => [0, 1, 2, 3].map((r) => [0, 1, 2, 3].reduce((s, c) => s + m[4 * c + r] * v[c], 0));
  const clip = times(camera.projection, times(camera.view, [...point, 1]));
  return [0.5 * (clip[0] / clip[3] + 1) * kWidth, 0.5 * (1 - clip[1] / clip[3]) * kHeight];
}

// Shows a record in a view of kWidth x kHeight.
async function show(program, page, mode, state) {
  await program.ask({ state });
  await until(page, (tick) => window.palpate.state()?.record.tick === tick, state.tick);
  if ((await page.evaluate(() => window.palpate.camera().mode)) !== mode) {
    await page.keyboard.press("c");
    await until(page, (m) => window.palpate.camera().mode === m, mode);
  }
  await page.keyboard.press("f"); // fits the camera to this state, in the next picture
  const before = await page.evaluate(() => window.palpate.pictures());
  await until(page, ([tick, n]) => window.palpate.drawnTick() === tick && window.palpate.pictures() > n,
              [state.tick, before]);
}

// The picture of the view, once it shows the ball: on a busy machine the browser shows it later than it draws.
async function pictureWithBall(page) {
  for (let n = 0;; ++n) {
    const picture = readPng(await page.locator("#view").screenshot());
    if (pixelsWhere(picture, isPink).length > 0 || n === kMostPictures) return picture;
  }
}

async function open(program) {
  const page = await openPage(browser, program.address);
  await hideWords(page);
  await program.ask({ state: { tick: 1, q_after_wxyz: [1, 0, 0, 0] } });
  await untilDrawn(page);
  await resizeView(page, kWidth, kHeight);
  return page;
}

// Half the diagonal of the scene's bounds.
async function sceneRadius(page) {
  const { low_m, high_m } = await page.evaluate(() => window.palpate.hello().scene);
  return 0.5 * Math.hypot(...minus(high_m, low_m));
}

const isPink = ([r, g, b]) => r > 150 && // the plate is darker
   r > 1.6 * g && b > 1.25 * g && b < r;
const isGreen = ([r, g, b]) => g > 90 && g > 1.6 * r && g > 1.3 * b;
const isOrange = ([r, g, b]) => r > 120 && r > 2 * g && r > 3 * b;

function middleOfBox(pixels) {
  const middle = (axis) => {
    const values = pixels.map((p) => p[axis]);
    return 0.5 * (Math.min(...values) + Math.max(...values) + 1);
  };
  return [middle(0), middle(1)];
}

function assertNear(seen, expected, what) {
  const away = Math.hypot(seen[0] - expected[0], seen[1] - expected[1]);
  assert.ok(away <= kFarthest_px, `${what} is at ${seen}; expected ${expected}`);
}

function serve(model, sensors) {
  return startProgram(kPrograms[0], [`${kProject}/models/${model}.glb`, String(sensors)]);
}

// The scene, its number of sensors, and a contact in the device frame that lies beside the scene, as
// shares of its radius.
const kContacts = [
  { model: "star", sensors: 2, ball: [-0.55, 0.35, 0], device: [-0.2, 0.35, 0], force: [-5, 0, 0],
    full: [-5, 3, 0] },
  { model: "torus", sensors: 3, ball: [-0.3, 0.2, 0.75], device: [-0.3, 0.2, 0.4],
    force: [0, 0, 4], full: [3, 0, 4] },
];

for (const { model, sensors, ball, device, force, full } of kContacts) {
  for (const mode of ["classical", "camera"]) {
    for (const turn_rad of [0, kTurn_rad]) {
      const degrees = Math.round((turn_rad * 180) / Math.PI);
      test(`${model}, ${mode}, turned by ${degrees} degrees: ball, frame and force are where they belong`,
           async () => {
        const program = await serve(model, sensors);
        try {
          const page = await open(program);
          const radius_m = await sceneRadius(page);
          const q = sensors === 2 ? turnAbout([0, 0, 1], turn_rad) : turnAbout([1, 2, 2], turn_rad);
          const inverse = [q[0], -q[1], -q[2], -q[3]];
          const o = scaled([0.05, -0.08, 0], radius_m);
          const proxy = scaled(ball, radius_m);
          const point = scaled(device, radius_m);
          const toScene = (p) => rotated(inverse, minus(p, o));
          const out = minus(proxy, point);
          await show(program, page, mode, {
            tick: 100 + degrees, q_after_wxyz: q, o_after_m: o, device_m: point,
            proxy_scene_m: toScene(proxy), goal_scene_m: toScene(point),
            normal_scene: rotated(inverse, scaled(out, 1 / Math.hypot(...out))), contact: 1,
            force_device_N: force, full_force_device_N: full,
          });
          const camera = await page.evaluate(() => window.palpate.camera());
          const shift = mode === "camera" ? scaled(proxy, -1) : [0, 0, 0]; // the ball stays in the middle
          const at = (p) => pixelOf(camera, add(p, shift));
          const picture = await pictureWithBall(page);
          assertNear(middleOfBox(pixelsWhere(picture, isPink)), at(proxy), "the ball");
          assertNear(middleOfBox(pixelsWhere(picture, isGreen)), at(point), "the frame");
          // The dashed end of the arrow is farthest from the ball: what the device cannot give.
          const [x, y] = at(proxy);
          const away = (p) => Math.hypot(p[0] - x, p[1] - y);
          const far = pixelsWhere(picture, isOrange)
            .reduce((best, p) => (away(p) > away(best) ? p : best), [x, y]);
          assertNear(far, at(add(proxy, scaled(full, kForceArrow * radius_m))), "the end of the full force");
          // The solid arrow ends where the force that the device gives ends: its head is there.
          const tip = at(add(proxy, scaled(force, kForceArrow * radius_m)));
          const head = pixelsWhere(picture, isOrange)
            .filter((p) => Math.hypot(p[0] + 0.5 - tip[0], p[1] + 0.5 - tip[1]) <= 2 * kFarthest_px);
          assert.ok(head.length >= kFewestOfHead, `${head.length} pixels of a head at ${tip}`);
          if (mode === "camera") assertNear(at(proxy), [kWidth / 2, kHeight / 2], "the middle");
          assertClean(page);
          await page.context().close();
        } finally {
          await program.stop();
        }
      });
    }
  }
}

// The pixels in which two masks differ farther than kOutline_px from an outline of the second.
function differences(drawn, rays) {
  const far = [];
  for (let y = 0; y < kHeight; ++y) {
    for (let x = 0; x < kWidth; ++x) {
      if (drawn[y * kWidth + x] === rays[y * kWidth + x]) continue;
      let isNearOutline = false;
      for (let v = Math.max(0, y - kOutline_px); v <= Math.min(kHeight - 1, y + kOutline_px); ++v) {
        for (let u = Math.max(0, x - kOutline_px); u <= Math.min(kWidth - 1, x + kOutline_px); ++u) {
          isNearOutline ||= Math.hypot(u - x, v - y) <= kOutline_px &&
                            rays[v * kWidth + u] !== rays[y * kWidth + x];
        }
      }
      if (!isNearOutline) far.push([x, y]);
    }
  }
  return far;
}

function shifted(mask) {
  return mask.map((_, i) => (i % kWidth >= kShift_px ? mask[i - kShift_px] : 0));
}

const kOutlines = [
  { model: "star", sensors: 2, pose: { q: turnAbout([0, 0, 1], kTurn_rad), o: [0.02, 0, 0] }, bodies: [] },
  { model: "torus", sensors: 3, pose: { q: turnAbout([2, -1, 1], kTurn_rad), o: [0, 0.1, 0] }, bodies: [] },
  { model: "effect_friction", sensors: 3, pose: { q: [1, 0, 0, 0], o: [0, 0, 0] }, moves: true },
];

for (const { model, sensors, pose, moves } of kOutlines) {
  test(`${model}${moves ? ", one body moved" : ""}: what is drawn is what rays hit`, async () => {
    const program = await serve(model, sensors);
    try {
      const page = await open(program);
      const radius_m = await sceneRadius(page);
      const bodies = moves
        ? [{ body: 0, q: turnAbout([0, 1, 0], 0.4), o: scaled([0.1, 0.2, 0.4], radius_m) }] : [];
      await page.evaluate(() => window.palpate.setFlat(true));
      await show(program, page, "classical",
                 { tick: 7, q_after_wxyz: pose.q, o_after_m: pose.o, bodies });
      const picture = readPng(await page.locator("#view").screenshot());
      const camera = await page.evaluate(() => window.palpate.camera());
      const file = join(folder, "rays");
      await program.ask({ rays: { ...camera, display: pose, width: kWidth, height: kHeight, file } });
      const rays = [...readFileSync(file)];
      const drawn = rays.map((_, i) =>
        picture.at(i % kWidth, Math.floor(i / kWidth))[0] > 127 ? 1 : 0);
      const hits = rays.filter((hit) => hit === 1).length;
      assert.ok(hits > 0.02 * rays.length && hits < 0.9 * rays.length, `${hits} rays hit`);
      const far = differences(drawn, rays);
      if (far.length > 0) {
        const name = join(pictureFolder(), `difference_${model}.ppm`);
        writePpm(name, kWidth, kHeight, (x, y) =>
          [255 * drawn[y * kWidth + x], 255 * rays[y * kWidth + x], 0]); // red: only drawn
        assert.fail(`${far.length} pixels differ, the first at ${far[0]}; see ${name}`);
      }
      assert.ok(differences(shifted(drawn), rays).length > 0, "a mesh shifted by 4 px was not noticed");
      assertClean(page);
      await page.context().close();
    } finally {
      await program.stop();
    }
  });
}
