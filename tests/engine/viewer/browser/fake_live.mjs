// A server of `experiment live` without an engine, for tests of the participant's page: it serves the page,
// speaks its messages, and keeps what the page sends.

import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";

const kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"; // of RFC 6455
const kVersion = 4;
const kHeaderBytes = 136; // of a state
const kPatience_ms = 10_000; // only ends a test that hangs
const kToken = "0123456789abcdef0123456789abcdef";

const kPage = join(process.env.PALPATE_BUILD, "page");
const kFiles = {
  "/": ["live.html", "text/html; charset=utf-8"], "/page.js": ["live.js", "text/javascript"],
  "/page.css": ["live.css", "text/css"], "/icon.svg": ["icon.svg", "image/svg+xml"],
};

// Where the decoder of the page reads the numbers of a record: {name: [offset, ...]}.
const decoder = readFileSync(join(process.env.PALPATE_BUILD, "page_build/record.ts"), "utf8");
const kRecordBytes = Number(decoder.match(/recordBytes = ([0-9]+)/)[1]);
const kNumbers = Object.fromEntries([...decoder.matchAll(/^ {4}(\w+): \[?(view\.getFloat64.*)\]?,$/gm)]
  .map(([, name, reads]) => [name, [...reads.matchAll(/at \+ ([0-9]+)/g)].map(([, at]) => Number(at))]));

function stateMessage(fields) {
  const bytes = Buffer.alloc(kHeaderBytes + kRecordBytes);
  bytes.writeUInt16LE(1, 0);
  bytes.writeUInt16LE(kVersion, 2);
  bytes.writeUInt32LE(kRecordBytes, 48);
  bytes.writeBigUInt64LE(BigInt(fields.tick ?? 1), kHeaderBytes);
  for (const [name, values] of Object.entries({ q_after_wxyz: [1, 0, 0, 0], ...fields })) {
    (kNumbers[name] ?? []).forEach((at, k) => bytes.writeDoubleLE([values].flat()[k], kHeaderBytes + at));
  }
  return bytes;
}

// A frame of RFC 6455 from the server, which is not masked.
function frameOf(payload, isText) {
  const head = [0x80 | (isText ? 1 : 2)];
  const size = payload.length;
  if (size < 126) head.push(size);
  else if (size < 65536) head.push(126, size >> 8, size & 255);
  else head.push(127, 0, 0, 0, 0, size >>> 24, (size >> 16) & 255, (size >> 8) & 255, size & 255);
  return Buffer.concat([Buffer.from(head), payload]);
}

// Reads whole frames from a buffer: [{opcode, payload}, ...] and the rest. Clients mask.
function readFrames(buffer) {
  const frames = [];
  for (;;) {
    if (buffer.length < 6) break;
    let [size, at] = [buffer[1] & 127, 2];
    if (size === 126) [size, at] = [buffer.readUInt16BE(2), 4];
    else if (size === 127) [size, at] = [Number(buffer.readBigUInt64BE(2)), 10];
    if (buffer.length < at + 4 + size) break;
    const mask = buffer.subarray(at, at + 4);
    const payload = Buffer.from(buffer.subarray(at + 4, at + 4 + size)).map((b, i) => b ^ mask[i & 3]);
    frames.push({ opcode: buffer[0] & 15, payload });
    buffer = buffer.subarray(at + 4 + size);
  }
  return [frames, buffer];
}

const kStep = { title: "", text: "", number: 0, of: 3, remaining_s: null, may_go_on: true, about: [] };

export class FakeLive {
  hello = {
    type: "hello", role: "participant", version: kVersion, engine: "test", language: "en", direction: "ltr",
    words: {}, display: { Hz: 40, scale: 1, sphere_radius_m: 0.006, proxy_radius_m: 0 }, checked: null,
    inputs: ["mouse"], rate_Hz: 1000,
    step: { ...kStep, step: "information", title: "Information", text: "A text." },
  };
  messages = []; // JSON that the page has sent, newest last
  pointers = []; // {sequence, holds, isClutched, target_m}
  scenes = 0; // how often /felt.glb was fetched with the token
  refusal = null; // why the next request is refused
  #sockets = new Set();
  #waiting = [];

  // scene: a GLB file.
  static async start(scene) {
    const fake = new FakeLive();
    const glb = readFileSync(scene);
    fake.http = createServer((request, response) => fake.#answer(request, response, glb));
    fake.http.on("upgrade", (request, socket) => fake.#upgrade(request, socket));
    await new Promise((resolve) => fake.http.listen(0, "127.0.0.1", resolve));
    fake.port = fake.http.address().port;
    fake.address = `http://127.0.0.1:${fake.port}/#${kToken}`;
    return fake;
  }

  async stop() {
    this.cut();
    this.http.closeAllConnections();
    await new Promise((resolve) => this.http.close(resolve));
  }

  // Ends the connections of pages.
  cut() {
    for (const socket of this.#sockets) socket.destroy();
  }

  send(json) {
    for (const socket of this.#sockets) socket.write(frameOf(Buffer.from(JSON.stringify(json)), true));
  }
  sendStep(step) {
    this.hello.step = { ...kStep, ...step };
    this.send({ type: "step", ...this.hello.step });
  }
  sendState(fields) {
    for (const socket of this.#sockets) socket.write(frameOf(stateMessage(fields), false));
  }

  // The first message from now on that fits, or one that was sent before with `since` of 0.
  next(fits, since = this.messages.length) {
    const found = this.messages.slice(since).find(fits);
    if (found) return Promise.resolve(found);
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error(`the page has sent no message for ${fits}, but ` +
        this.messages.slice(-5).map((message) => JSON.stringify(message)).join(" "))), kPatience_ms);
      this.#waiting.push({ fits, resolve: (message) => {
        clearTimeout(timer);
        resolve(message);
      } });
    });
  }

  #answer(request, response, glb) {
    response.setHeader("Content-Security-Policy", "default-src 'none'; script-src 'self'; style-src 'self'; " +
      `img-src 'self'; connect-src 'self' ws://127.0.0.1:${this.port}; base-uri 'none'; form-action 'none'; ` +
      "frame-ancestors 'none'");
    response.setHeader("Cache-Control", "no-store");
    if (request.url === "/felt.glb") {
      const isTrusted = request.headers["palpate-token"] === kToken;
      if (isTrusted) ++this.scenes;
      response.statusCode = isTrusted ? 200 : 401;
      response.end(isTrusted ? glb : "");
      return;
    }
    const [file, type] = kFiles[request.url] ?? [];
    response.statusCode = file ? 200 : 404;
    if (type) response.setHeader("Content-Type", type);
    response.end(file ? readFileSync(join(kPage, file)) : "");
  }

  #upgrade(request, socket) {
    const key = createHash("sha1").update(request.headers["sec-websocket-key"] + kGuid).digest("base64");
    socket.write("HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n" +
                 `Sec-WebSocket-Accept: ${key}\r\n\r\n`);
    socket.setNoDelay(true);
    let rest = Buffer.alloc(0);
    socket.on("data", (data) => {
      let frames;
      [frames, rest] = readFrames(Buffer.concat([rest, data]));
      for (const { opcode, payload } of frames) {
        if (opcode === 1) this.#receive(JSON.parse(payload.toString()), socket);
        if (opcode === 2) this.#receivePointer(payload);
        if (opcode === 8) socket.end();
      }
    });
    socket.on("close", () => this.#sockets.delete(socket));
    socket.on("error", () => this.#sockets.delete(socket));
  }

  #receive(message, socket) {
    if (message.type === "token") {
      if (message.token !== kToken) return socket.destroy();
      this.#sockets.add(socket);
      this.send(this.hello);
      return;
    }
    this.messages.push(message);
    if (message.id !== undefined) {
      const problem = this.refusal;
      this.refusal = null;
      this.send({ type: "answer", id: message.id, ok: problem === null, ...(problem === null ? {} : { problem }) });
    }
    const due = this.#waiting.filter(({ fits }) => fits(message));
    this.#waiting = this.#waiting.filter((one) => !due.includes(one));
    for (const { resolve } of due) resolve(message);
  }

  #receivePointer(bytes) {
    this.pointers.push({
      sequence: Number(bytes.readBigUInt64LE(8)), holds: (bytes.readUInt32LE(4) & 1) !== 0,
      isClutched: (bytes.readUInt32LE(4) & 2) !== 0,
      target_m: [16, 24, 32].map((at) => bytes.readDoubleLE(at)),
    });
  }
}
