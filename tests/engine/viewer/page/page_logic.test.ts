// Tests of what the page computes without a browser: messages, charts, display and controls.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Quaternion, Vector3 } from "three";

import { arrowOf } from "@page/contact_drawing.ts";
import { liveAddress, stateAfter } from "@page/connection.ts";
import { sliderScale } from "@page/controls.ts";
import { displayOf, touchOf } from "@page/display.ts";
import { roundStep } from "@page/felt_scene.ts";
import { readFeltGlb } from "@page/felt_glb.ts";
import { History, kBucket_s, kSpan_s } from "@page/history.ts";
import { Keys } from "@page/keys.ts";
import { timeLeft, Words } from "@page/live_words.ts";
import { paperColours } from "@page/paper_display.ts";
import { PicturePacer } from "@page/picture_pacer.ts";
import { decodeBinary, encodePointer, type Ticks } from "@page/protocol.ts";
import { decodeRecord, recordBytes, type TickRecord } from "@page/record.ts";
import { Journey } from "@page/status.ts";
import { faultOf, isEven, motionOf, strokeRatio } from "@page/strokes.ts";
import { faultsInWords, touchedInWords } from "@page/words.ts";
import { ViewCamera } from "@page/view_camera.ts";

const kEpsilon = 2 ** -52;
const kRoundoff_px = 64 * 1000 * kEpsilon; // 64 roundings of coordinates of up to 1000 pixels

// A generator of pseudo-random numbers in [0, 1), Park and Miller 1988.
function random(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state * 48271) % 2147483647;
    return state / 2147483647;
  };
}
const seed = Number(process.env["PALPATE_SEED"] ?? 1 + Math.floor(Math.random() * 2147483645));
console.log(`PALPATE_SEED=${seed}`);

function record(): TickRecord {
  return decodeRecord(new DataView(new ArrayBuffer(recordBytes)), 0);
}

function ticks(base_s: number, rows: { t: number; angle: number; force: number }[]): Ticks {
  const column = (pick: (row: { t: number; angle: number; force: number }) => number): Float32Array =>
    Float32Array.from(rows, pick);
  return {
    lost: 0, base_s, time_s: column((r) => r.t), angle_deg: column((r) => r.angle),
    depth_m: column(() => 0), force_N: column((r) => r.force), fullForce_N: column((r) => r.force),
    step_us: column(() => 1), contact: column(() => 1),
  };
}

test("the live connection has the scheme, the host and the folder of the page", () => {
  const expected = [
    ["http://127.0.0.1:43210/", "ws://127.0.0.1:43210/live"],
    ["https://lab.example/", "wss://lab.example/live"],
    ["https://lab.example/lab/palpate/", "wss://lab.example/lab/palpate/live"],
    ["https://lab.example:8443/lab/palpate/index.html?a=/b/#c/d", "wss://lab.example:8443/lab/palpate/live"],
    ["http://[2001:db8::1]:80/x/", "ws://[2001:db8::1]/x/live"],
  ];
  for (const [page, live] of expected) assert.equal(liveAddress(page ?? ""), live);
});

test("a connection that ended says why, and names a proxy that passes no WebSockets", () => {
  const failed = { code: 1006, wasOpen: false, failures: 3, status: 405 };
  assert.equal(stateAfter(failed), "no sockets");
  assert.equal(stateAfter({ ...failed, failures: 2 }), "lost"); // a server that has just started
  assert.equal(stateAfter({ ...failed, failures: 0 }), "lost"); // a connection was open before
  assert.equal(stateAfter({ ...failed, status: null }), "lost"); // no server
  assert.equal(stateAfter({ ...failed, status: 502 }), "lost"); // a proxy without its server
  assert.equal(stateAfter({ ...failed, status: 403 }), "refused");
  assert.equal(stateAfter({ ...failed, code: 4401 }), "new address");
  const ended = { code: 1006, wasOpen: true, failures: 0, status: null };
  assert.equal(stateAfter(ended), "lost");
  assert.equal(stateAfter({ ...ended, code: 1013 }), "full");
});

test("a state is decoded at the offsets of its layout", () => {
  const names = ["wall é", "wood"].map((name) => new TextEncoder().encode(name)) as [Uint8Array, Uint8Array];
  const bytes = new ArrayBuffer(136 + recordBytes + 64 + names[0].length + names[1].length);
  const view = new DataView(bytes);
  view.setUint16(0, 1, true);
  view.setUint16(2, 4, true);
  view.setUint32(4, 5, true);
  view.setBigUint64(8, 12345678901n, true);
  [0.1, -0.2, 0.3].forEach((v, i) => view.setFloat64(16 + 8 * i, v, true));
  view.setFloat64(40, 12.5, true);
  view.setUint32(48, recordBytes, true);
  view.setUint32(52, 1, true);
  view.setUint32(56, 2, true);
  [0, 1, 0, 0, 0, -1, 1, 0, 0].forEach((v, i) => view.setFloat64(64 + 8 * i, v, true));
  view.setBigUint64(136, 99n, true); // the first field of the record: tick
  view.setUint32(136 + recordBytes, 7, true);
  [1, 0, 0, 0, 4, 5, 6].forEach((v, i) => view.setFloat64(136 + recordBytes + 8 + 8 * i, v, true));
  view.setUint16(60, names[0].length, true);
  view.setUint16(62, names[1].length, true);
  new Uint8Array(bytes).set([...names[0], ...names[1]], 136 + recordBytes + 64);
  const message = decodeBinary(bytes);
  assert.equal(message.kind, "state");
  if (message.kind !== "state") return;
  const { state } = message;
  assert.deepEqual([state.hasTarget, state.isPaused, state.isHeld], [true, false, true]);
  assert.equal(state.pointerSequence, 12345678901);
  assert.deepEqual(state.target_m, [0.1, -0.2, 0.3]);
  assert.equal(state.sent_s, 12.5);
  assert.deepEqual(state.axes, [[0, 1, 0], [0, 0, -1]]);
  assert.equal(state.record.tick, 99);
  assert.deepEqual(state.bodies, [{ body: 7, rotation_wxyz: [1, 0, 0, 0], position_m: [4, 5, 6] }]);
  assert.deepEqual([state.bodyName, state.materialName], ["wall é", "wood"]);
  assert.equal(touchedInWords(state.bodyName, state.materialName), "wall é, wood");
  assert.equal(touchedInWords(state.bodyName, ""), "wall é");
  assert.equal(touchedInWords("", ""), "");
});

test("a message of another version or length is refused by name", () => {
  const bytes = new ArrayBuffer(136);
  new DataView(bytes).setUint16(0, 1, true);
  assert.throws(() => decodeBinary(bytes), /version is 0; expected 4/);
  new DataView(bytes).setUint16(2, 4, true);
  assert.throws(() => decodeBinary(bytes), /state: has 136 bytes/);
  new DataView(bytes).setUint16(0, 3, true);
  assert.throws(() => decodeBinary(bytes), /kind is 3/);
  assert.throws(() => decodeBinary(new ArrayBuffer(3)), /has 3 bytes/);
});

test("columns of ticks are read one after another", () => {
  const rows = 3;
  const bytes = new ArrayBuffer(24 + 28 * rows);
  const view = new DataView(bytes);
  view.setUint16(0, 2, true);
  view.setUint16(2, 4, true);
  view.setUint32(4, rows, true);
  view.setFloat64(8, 2.5, true);
  for (let i = 0; i < 7 * rows; ++i) view.setFloat32(24 + 4 * i, i, true);
  const message = decodeBinary(bytes);
  assert.ok(message.kind === "ticks");
  assert.equal(message.ticks.base_s, 2.5);
  assert.deepEqual([...message.ticks.time_s], [0, 1, 2]);
  assert.deepEqual([...message.ticks.force_N], [9, 10, 11]);
  assert.deepEqual([...message.ticks.contact], [18, 19, 20]);
});

test("a pointer message has the bytes of its layout", () => {
  const view = new DataView(encodePointer(258, [0.5, -1, 2], true));
  assert.equal(view.byteLength, 40);
  assert.deepEqual([view.getUint16(0, true), view.getUint16(2, true), view.getUint32(4, true)],
                   [16, 4, 1]);
  assert.equal(view.getBigUint64(8, true), 258n);
  assert.deepEqual([16, 24, 32].map((at) => view.getFloat64(at, true)), [0.5, -1, 2]);
  assert.equal(new DataView(encodePointer(1, [0, 0, 0], false)).getUint32(4, true), 0);
});

test("a message that took longer than the fastest one has a delay, whatever the clocks are", () => {
  const journey = new Journey();
  const zero_s = 4711; // of the server's clock
  const delays = [5, 3, 303, 300].map((took_ms, n) =>
    journey.delay_ms(zero_s + 0.001 * 20 * n, 20 * n + took_ms));
  assert.ok(delays[0]! < 1 && delays[1]! < 1);
  assert.ok(delays[2]! > 290 && delays[3]! > 285 && delays[2]! <= 300 && delays[3]! <= 297, `${delays}`);
  journey.begin(); // another connection, perhaps to another machine
  assert.ok(journey.delay_ms(1, 2000) < 1);
  // Clocks that drift apart by a second in an hour are no delay.
  let longest_ms = 0;
  for (let t_s = 0; t_s < 3600; ++t_s) {
    longest_ms = Math.max(longest_ms, journey.delay_ms(t_s, 1000 * t_s * (1 + 1 / 3600)));
  }
  assert.ok(longest_ms < 1, `${longest_ms}`);
});

test("a chart shows the lowest and the highest value of each interval", () => {
  const history = new History();
  history.add(ticks(4, [{ t: 0.001, angle: 10, force: 1 }, { t: 0.002, angle: 40, force: 5 },
                        { t: 0.003, angle: 20, force: 2 }]));
  const [, angle, force] = history.points(["angle_deg", "force_N"]);
  assert.deepEqual(angle, [10, 40]);
  assert.deepEqual(force, [1, 5]);
});

test("a chart has a gap where there is no contact and where no tick came", () => {
  const history = new History();
  history.add(ticks(0, [{ t: 0.01, angle: 10, force: 1 }, { t: 0.03, angle: NaN, force: 0 },
                        { t: 0.5, angle: 30, force: 1 }]));
  assert.deepEqual(history.points(["angle_deg"])[1], [10, 10, null, null, null, 30, 30]);
});

test("a chart keeps ten seconds and starts again when time goes back", () => {
  const history = new History();
  for (let i = 0; i < 3000; ++i) history.add(ticks(0.01 * i, [{ t: 0, angle: i, force: 0 }]));
  const [times] = history.points(["angle_deg"]);
  assert.ok((times[0] ?? NaN) >= -kSpan_s - kBucket_s);
  assert.ok((times[0] ?? NaN) < -kSpan_s + 2 * kBucket_s);
  history.add(ticks(1, [{ t: 0, angle: 7, force: 0 }]));
  assert.deepEqual(history.points(["angle_deg"])[1], [7, 7]);
});

test("both displays follow display_transform of the engine", () => {
  const next = random(seed);
  for (let round = 0; round < 100; ++round) {
    const q = new Quaternion(next() - 0.5, next() - 0.5, next() - 0.5, next() - 0.5).normalize();
    const origin = new Vector3(next(), next(), next());
    const proxy = new Vector3(next(), next(), next());
    const device = new Vector3(next(), next(), next());
    const r: TickRecord = {
      ...record(), q_after_wxyz: [q.w, q.x, q.y, q.z], o_after_m: origin.toArray(),
      proxy_scene_m: proxy.toArray(), device_m: device.toArray(),
    };
    const turned = proxy.clone().applyQuaternion(q);
    // A few roundings of numbers up to 4: sums of three products, twice, of lengths below 2.
    const tolerance = 64 * kEpsilon;
    const classical = touchOf(r, displayOf(r, "classical"), null);
    assert.ok(classical.ball_m.distanceTo(turned.clone().add(origin)) < tolerance);
    assert.ok(classical.device_m.distanceTo(device) < tolerance);
    const camera = touchOf(r, displayOf(r, "camera"), null);
    assert.ok(camera.ball_m.length() < tolerance);
    const between = classical.device_m.clone().sub(classical.ball_m);
    assert.ok(camera.device_m.distanceTo(between) < 4 * tolerance);
  }
});

test("the top view has A1 up and A2 to the left", () => {
  const camera = new ViewCamera(true);
  camera.resize(800, 400);
  camera.fit({ centre_m: new Vector3(1, 2, 3), radius_m: 0.5 });
  const middle = camera.pixelOf(new Vector3(1, 2, 3));
  assert.ok(Math.abs(middle.x - 400) < kRoundoff_px && Math.abs(middle.y - 200) < kRoundoff_px);
  const a1 = camera.pixelOf(new Vector3(1.5, 2, 3));
  assert.ok(Math.abs(a1.x - 400) < kRoundoff_px && Math.abs(a1.y - 0) < kRoundoff_px);
  const a2 = camera.pixelOf(new Vector3(1, 2.5, 3));
  assert.ok(Math.abs(a2.x - 200) < kRoundoff_px && Math.abs(a2.y - 200) < kRoundoff_px);
  assert.ok(Math.abs(camera.metresPerPixel(new Vector3()) - 1 / 400) < 8 * kEpsilon);
});

test("the orbit shows the whole sphere that it fits", () => {
  const next = random(seed);
  for (const [width, height] of [[800, 400], [360, 640]] as const) {
    const camera = new ViewCamera(false);
    camera.resize(width, height);
    const centre_m = new Vector3(next(), next(), next());
    const radius_m = 0.1 + next();
    camera.fit({ centre_m, radius_m });
    for (let i = 0; i < 1000; ++i) {
      const away = new Vector3(next() - 0.5, next() - 0.5, next() - 0.5).setLength(radius_m);
      const { x, y } = camera.pixelOf(centre_m.clone().add(away));
      assert.ok(x >= -0.5 && x <= width + 0.5 && y >= -0.5 && y <= height + 0.5, `${x} ${y}`);
    }
  }
});

test("one pixel of the orbit is as long as it is said to be", () => {
  const camera = new ViewCamera(false);
  camera.resize(800, 600);
  camera.fit({ centre_m: new Vector3(), radius_m: 1 });
  const step_m = camera.metresPerPixel(new Vector3());
  const seen = camera.pixelOf(camera.right.clone().multiplyScalar(step_m));
  assert.ok(Math.abs(seen.x - 401) < kRoundoff_px && Math.abs(seen.y - 300) < kRoundoff_px);
});

test("an arrow is proportional to its force until it is cut", () => {
  const one = arrowOf(new Vector3(1, 0, 0), 2).length();
  assert.ok(one > 0);
  assert.ok(Math.abs(arrowOf(new Vector3(0, 3, 0), 2).length() - 3 * one) < 8 * kEpsilon);
  assert.ok(arrowOf(new Vector3(0, 1000, 0), 2).length() < 2);
});

test("a slider reaches both ends and returns what it shows", () => {
  for (const [low, high, value] of [[0, 1, 0.5], [1, 20000, 1000], [1, 20000, 100], [0, 100, 0]] as const) {
    const scale = sliderScale(low, high, value);
    assert.equal(scale.valueAt(0), low);
    assert.equal(scale.valueAt(1), high);
    for (let share = 0; share <= 1; share += 0.125) {
      const shown = scale.valueAt(share);
      // valueAt() rounds to three digits, half a unit of which is 0.5 % of the value at most.
      assert.ok(Math.abs(scale.valueAt(scale.shareOf(shown)) - shown) <= 0.011 * shown);
    }
  }
});

test("a key is given once, and a taken one is replaced", () => {
  const keys = new Keys();
  keys.add({ key: "a", label: "A4", run: () => {} });
  assert.throws(() => keys.add({ key: "a", label: "other", run: () => {} }), /two meanings/);
  assert.equal(keys.freeKey("a", "Axes"), "x");
  assert.equal(keys.freeKey(undefined, "A4"), "4");
});

test("grid steps are 1, 2 or 5 times a power of ten", () => {
  assert.deepEqual([0.0119, 0.02, 0.049, 0.5, 7, 99].map((v) => Number(roundStep(v).toPrecision(6))),
                   [0.01, 0.02, 0.02, 0.5, 5, 50]);
});

test("faults are said in words, the most frequent first", () => {
  assert.equal(faultsInWords({ jump: 2, slew: 1500 }),
               "growth of the force was limited (1\u2009500), position jumped (2)");
  assert.equal(faultsInWords({}), "");
});

test("a GLB without its chunks is refused by name", () => {
  assert.throws(() => readFeltGlb(new ArrayBuffer(40)), /felt\.glb: is no GLB file/);
});

test("pictures have their own mean rate on every screen, and each frame shows at most one", () => {
  const next = random(seed);
  for (const screen_Hz of [59.94, 60, 75, 90, 120, 144, 240]) {
    for (const rate_Hz of [24, 40, 59]) {
      const pacer = new PicturePacer(rate_Hz);
      const frame_ms = 1000 / screen_Hz;
      const begin_ms = 1000 * next();
      const shown: number[] = [];
      const kFrames = 6000;
      for (let i = 0; i < kFrames; ++i) {
        const now_ms = begin_ms + i * frame_ms + 0.4 * (next() - 0.5); // frames jitter
        if (pacer.isDue(now_ms)) shown.push(now_ms);
      }
      const mean_ms = ((shown.at(-1) ?? NaN) - (shown[0] ?? NaN)) / (shown.length - 1);
      // The ends are known to a frame.
      const tolerance_ms = (2 * (frame_ms + 1)) / (shown.length - 1);
      assert.ok(Math.abs(mean_ms - 1000 / rate_Hz) <= tolerance_ms,
                `${rate_Hz} Hz on ${screen_Hz} Hz: ${mean_ms} ms`);
    }
  }
});

test("a screen that is slower than the pictures shows one in each frame, and a pause is not made up for", () => {
  const slow = new PicturePacer(40);
  for (let i = 0; i < 100; ++i) assert.ok(slow.isDue((i * 1000) / 30));
  const pacer = new PicturePacer(40);
  assert.ok(pacer.isDue(0));
  assert.ok(pacer.isDue(400));
  let shown = 0;
  for (let i = 1; i <= 60; ++i) shown += pacer.isDue(400 + (i * 1000) / 60) ? 1 : 0;
  assert.ok(Math.abs(shown - 40) <= 1, `${shown} pictures in a second after a pause`);
});

// Relative luminance and contrast of WCAG 2.2.
function luminance(colour: string): number {
  const [r, g, b] = [1, 3, 5].map((at) => {
    const value = parseInt(colour.slice(at, at + 2), 16) / 255;
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  }) as [number, number, number];
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}
function contrast(a: string, b: string): number {
  const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y) as [number, number];
  return (high + 0.05) / (low + 0.05);
}

test("ball, frame and ring of the paper's display stand out from object and background", () => {
  const { background, object, ball, frame, ring } = paperColours;
  assert.ok(contrast(object, background) >= 3);
  for (const mark of [ball, frame, ring]) {
    for (const below of [object, background]) {
      assert.ok(contrast(mark, below) >= 3, `${mark} on ${below}: ${contrast(mark, below)}`);
    }
  }
});

test("the top view at a scale shows a length with its pixels, and the centre in the middle", () => {
  for (const [width, height] of [[800, 400], [300, 900], [641, 481]] as const) {
    const camera = new ViewCamera(true);
    camera.resize(width, height);
    camera.showAtScale(new Vector3(1, 2, 3), 1 / 3779.5, 0.4);
    const middle = camera.pixelOf(new Vector3(1, 2, 3));
    assert.ok(Math.abs(middle.x - 0.5 * width) + Math.abs(middle.y - 0.5 * height) < kRoundoff_px);
    const a1 = camera.pixelOf(new Vector3(1.01, 2, 3.3));
    assert.ok(Math.abs(middle.y - a1.y - 37.795) < kRoundoff_px && Math.abs(a1.x - middle.x) < kRoundoff_px);
    const a2 = camera.pixelOf(new Vector3(1, 2.01, 2.7));
    assert.ok(Math.abs(middle.x - a2.x - 37.795) < kRoundoff_px);
  }
});

test("strokes of a mouse count only if they are as slow or as fast as asked", () => {
  assert.equal(faultOf("slow", 300, 2), null);
  assert.equal(faultOf("slow", 300, 1.9), "too_fast");
  assert.equal(faultOf("fast", 300, 0.5), null);
  assert.equal(faultOf("fast", 300, 0.6), "too_slow");
  assert.equal(faultOf("fast", 39, 0.1), "too_short");
});

test("a mouse whose fast strokes are longer or shorter by a quarter is accelerated", () => {
  assert.equal(strokeRatio([300, 330, 310, 341]), 671 / 610);
  assert.ok(isEven(1.2) && isEven(1 / 1.2) && !isEven(1.3) && !isEven(1 / 1.3));
  assert.equal(motionOf(1.1, false), "unaccelerated"); // what was measured counts,
  assert.equal(motionOf(2, true), "accelerated");
  assert.equal(motionOf(null, true), "unaccelerated"); // else what the browser has granted
  assert.equal(motionOf(null, false), "unknown");
});

test("words are those of the server, and the English ones where it has none", () => {
  const words = new Words();
  assert.equal(words.get("block_of", { number: 2, of: 3 }), "Block 2 of 3");
  words.set({ block_of: "{of} Bl\u00f6cke, Nr. {number}, {nothing}", no_such_key: "x" });
  assert.equal(words.get("block_of", { number: 2, of: 3 }), "3 Bl\u00f6cke, Nr. 2, {nothing}");
  assert.equal(words.get("pause"), "Pause");
  assert.deepEqual([0, -3, 59.2, 60, 605].map(timeLeft), ["0:00", "0:00", "1:00", "1:00", "10:05"]);
});
