// A reverse proxy that speaks https, as it stands in front of a server that does not: each prefix of
// its paths leads to a server of this machine. A test can switch it off and on again.

import { generateKeyPairSync, randomBytes, sign } from "node:crypto";
import { request } from "node:http";
import { createServer } from "node:https";
import { connect } from "node:net";

// DER (X.690): a tag, the length of the contents, the contents.
function der(tag, ...contents) {
  const bytes = Buffer.concat(contents.map((c) => Buffer.from(c)));
  const { length } = bytes;
  const head = length < 128 ? [length] : length < 256 ? [0x81, length] : [0x82, length >> 8, length & 255];
  return Buffer.concat([Buffer.from([tag, ...head]), bytes]);
}
const sequence = (...contents) => der(0x30, ...contents);
const kEcdsaWithSha256 = sequence(der(0x06, [0x2a, 0x86, 0x48, 0xce, 0x3d, 0x04, 0x03, 0x02]));
const kCommonName = der(0x06, [0x55, 0x04, 0x03]);
const kSubjectAltName = der(0x06, [0x55, 0x1d, 0x11]);

// The time in UTC as YYMMDDHHMMSSZ.
const utcTime = (date) => der(0x17, `${date.toISOString().replace(/\D/g, "").slice(2, 14)}Z`);

// A certificate for 127.0.0.1 that signs itself (RFC 5280), and its key.
function selfSigned() {
  const { publicKey, privateKey } = generateKeyPairSync("ec", { namedCurve: "P-256" });
  const name = sequence(der(0x31, sequence(kCommonName, der(0x0c, "palpate test"))));
  const day_ms = 86_400_000;
  const from = new Date(Date.now() - day_ms);
  const until = new Date(Date.now() + day_ms);
  const names = der(0x04, sequence(der(0x87, [127, 0, 0, 1])));
  const certificate = sequence(
    der(0xa0, der(0x02, [2])), // version 3
    der(0x02, [1], randomBytes(8)),
    kEcdsaWithSha256, name, sequence(utcTime(from), utcTime(until)), name,
    publicKey.export({ type: "spki", format: "der" }),
    der(0xa3, sequence(sequence(kSubjectAltName, names))));
  const signature = sign("sha256", certificate, privateKey);
  const whole = sequence(certificate, kEcdsaWithSha256, der(0x03, [0], signature));
  const pem = whole.toString("base64").replace(/.{64}/g, "$&\n");
  return { cert: `-----BEGIN CERTIFICATE-----\n${pem}\n-----END CERTIFICATE-----\n`,
           key: privateKey.export({ type: "pkcs8", format: "pem" }) };
}

// options.passesHost: the server gets the browser's Host, not its own. options.password: what the
// proxy asks for, as NAME:PASSWORD. options.dropsSockets: a request for a WebSocket becomes a plain
// one, as in a proxy that is not set up for WebSockets.
export async function openProxy(options = {}) {
  const ports = new Map(); // by prefix, such as "/lab/palpate"
  const sockets = new Set();
  const socketsAsked = []; // paths of WebSockets
  const expected = options.password && `Basic ${Buffer.from(options.password).toString("base64")}`;

  // The server and the path there; null: none.
  const targetOf = (path) => {
    for (const [prefix, port] of ports) {
      if (path.startsWith(`${prefix}/`)) return { port, path: path.slice(prefix.length) };
    }
    return null;
  };
  const headersFor = (asked, port) => {
    const headers = { ...asked.headers, host: options.passesHost ? asked.headers.host : `127.0.0.1:${port}` };
    if (options.dropsSockets) {
      delete headers.upgrade;
      delete headers.connection;
    }
    return headers;
  };

  const server = createServer(selfSigned(), (asked, answer) => {
    if (expected && asked.headers.authorization !== expected) {
      answer.writeHead(401, { "WWW-Authenticate": 'Basic realm="lab"' });
      return answer.end();
    }
    if (ports.has(asked.url)) {
      answer.writeHead(301, { Location: `${asked.url}/` });
      return answer.end();
    }
    const target = targetOf(asked.url);
    if (!target) return answer.writeHead(404).end();
    const far = request({ host: "127.0.0.1", port: target.port, path: target.path, method: asked.method,
                          headers: headersFor(asked, target.port) }, (told) => {
      answer.writeHead(told.statusCode, told.headers);
      told.pipe(answer);
    });
    far.on("error", () => answer.destroy());
    asked.pipe(far);
  });
  if (!options.dropsSockets) server.on("upgrade", (asked, near) => {
    const target = targetOf(asked.url);
    socketsAsked.push(asked.url);
    if (!target || (expected && asked.headers.authorization !== expected)) return near.destroy();
    const far = connect(target.port, "127.0.0.1");
    const lines = Object.entries(headersFor(asked, target.port)).map(([name, value]) => `${name}: ${value}\r\n`);
    far.write(`GET ${target.path} HTTP/1.1\r\n${lines.join("")}\r\n`);
    for (const socket of [near, far]) {
      socket.unref();
      socket.on("error", () => {});
      socket.on("close", () => {
        near.destroy();
        far.destroy();
      });
    }
    near.pipe(far);
    far.pipe(near);
  });
  server.on("connection", (socket) => {
    socket.unref();
    sockets.add(socket);
    socket.on("close", () => sockets.delete(socket));
  });
  server.unref(); // a test that fails does not keep its process alive
  const listen = (port) => new Promise((resolve) => server.listen(port, "127.0.0.1", resolve));
  await listen(0);
  const { port } = server.address();
  const switchOff = () => {
    const closed = new Promise((resolve) => server.close(resolve));
    sockets.forEach((socket) => socket.destroy());
    return closed;
  };
  return {
    origin: `https://127.0.0.1:${port}`,
    socketsAsked,
    // Shows the server of this address under the prefix. Returns the address there.
    lead: (prefix, address) => {
      const url = new URL(address);
      ports.set(prefix, Number(url.port));
      return `https://127.0.0.1:${port}${prefix}/${url.hash}`;
    },
    switchOff,
    switchOn: () => listen(port),
    close: switchOff,
  };
}
