// Pictures: reads PNG files as a browser writes them, and writes PPM files.

import { inflateSync } from "node:zlib";
import { writeFileSync } from "node:fs";

const kChannels = { 2: 3, 6: 4 }; // by the colour type: RGB, RGBA

function paeth(a, b, c) {
  const [pa, pb, pc] = [Math.abs(b - c), Math.abs(a - c), Math.abs(a + b - 2 * c)];
  return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

// Undoes the filters of the rows of a PNG (specification, section 9).
function unfilter(data, height, rowBytes, step) {
  const out = Buffer.alloc(height * rowBytes);
  for (let row = 0; row < height; ++row) {
    const filter = data[row * (rowBytes + 1)];
    for (let i = 0; i < rowBytes; ++i) {
      const at = row * rowBytes + i;
      const left = i >= step ? out[at - step] : 0;
      const up = row > 0 ? out[at - rowBytes] : 0;
      const corner = row > 0 && i >= step ? out[at - rowBytes - step] : 0;
      const guess = [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter];
      out[at] = data[row * (rowBytes + 1) + 1 + i] + guess;
    }
  }
  return out;
}

// {width, height, at(x, y): [r, g, b]} of an 8-bit PNG without interlacing.
export function readPng(bytes) {
  const width = bytes.readUInt32BE(16);
  const height = bytes.readUInt32BE(20);
  const channels = kChannels[bytes[25]];
  if (bytes[24] !== 8 || !channels || bytes[28] !== 0) throw new Error("png: is of another kind");
  const parts = [];
  for (let at = 8; at < bytes.length;) {
    const size = bytes.readUInt32BE(at);
    const isData = bytes.toString("latin1", at + 4, at + 8) === "IDAT";
    if (isData) parts.push(bytes.subarray(at + 8, at + 8 + size));
    at += size + 12;
  }
  const data = unfilter(inflateSync(Buffer.concat(parts)), height, width * channels, channels);
  return {
    width, height,
    at: (x, y) => [...data.subarray((y * width + x) * channels, (y * width + x) * channels + 3)],
  };
}

// The pixels whose colour passes the test, as [x, y].
export function pixelsWhere(picture, test) {
  const found = [];
  for (let y = 0; y < picture.height; ++y) {
    for (let x = 0; x < picture.width; ++x) {
      if (test(picture.at(x, y))) found.push([x, y]);
    }
  }
  return found;
}

// Writes a picture of colours: colourOf(x, y) is [r, g, b].
export function writePpm(file, width, height, colourOf) {
  const bytes = Buffer.alloc(3 * width * height);
  for (let i = 0; i < width * height; ++i) {
    colourOf(i % width, Math.floor(i / width)).forEach((value, k) => (bytes[3 * i + k] = value));
  }
  writeFileSync(file, Buffer.concat([Buffer.from(`P6\n${width} ${height}\n255\n`), bytes]));
}
