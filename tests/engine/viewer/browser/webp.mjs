// Animated WebP from single pictures (RIFF container of the WebP specification).

const kAnimation = 0x02; // flag of VP8X

function chunk(name, data) {
  const head = Buffer.alloc(8);
  head.write(name, 0, "latin1");
  head.writeUInt32LE(data.length, 4);
  return Buffer.concat([head, data, Buffer.alloc(data.length % 2)]);
}

// The chunks of a picture: those that hold its pixels.
function pixelChunks(picture) {
  const parts = [];
  for (let at = 12; at + 8 <= picture.length;) {
    const name = picture.toString("latin1", at, at + 4);
    const size = picture.readUInt32LE(at + 4);
    const isOfPixels = ["VP8 ", "VP8L", "ALPH"].includes(name);
    if (isOfPixels) parts.push(chunk(name, picture.subarray(at + 8, at + 8 + size)));
    at += 8 + size + (size % 2);
  }
  return Buffer.concat(parts);
}

// frames: {picture: a WebP file, x, y (even), width, height, duration_ms}; each covers a part of the
// canvas and leaves the rest. The animation is repeated for ever.
export function animatedWebp(width, height, frames) {
  const extended = Buffer.alloc(10);
  extended.writeUInt8(kAnimation, 0);
  extended.writeUIntLE(width - 1, 4, 3);
  extended.writeUIntLE(height - 1, 7, 3);
  const parts = [chunk("VP8X", extended), chunk("ANIM", Buffer.alloc(6))];
  for (const frame of frames) {
    const head = Buffer.alloc(16);
    head.writeUIntLE(frame.x / 2, 0, 3);
    head.writeUIntLE(frame.y / 2, 3, 3);
    head.writeUIntLE(frame.width - 1, 6, 3);
    head.writeUIntLE(frame.height - 1, 9, 3);
    head.writeUIntLE(Math.round(frame.duration_ms), 12, 3);
    head.writeUInt8(0x02, 15); // replaces, and is left where it is
    parts.push(chunk("ANMF", Buffer.concat([head, pixelChunks(frame.picture)])));
  }
  const body = Buffer.concat([Buffer.from("WEBP"), ...parts]);
  const head = Buffer.alloc(8);
  head.write("RIFF");
  head.writeUInt32LE(body.length, 4);
  return Buffer.concat([head, body]);
}
