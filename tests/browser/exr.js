// Reads the EXR files that etendue writes: scan lines of 32-bit B, G, R, compressed by ZIP or not at all.
'use strict';
const fs = require('fs');
const zlib = require('zlib');

function readHeader(bytes) {
  let at = 8;
  const text = () => { const end = bytes.indexOf(0, at), value = bytes.toString('latin1', at, end); at = end + 1; return value; };
  const attributes = {};
  for (let name = text(); name; name = text()) {
    text();  // its type
    const size = bytes.readInt32LE(at);
    attributes[name] = bytes.subarray(at + 4, at + 4 + size);
    at += 4 + size;
  }
  return {attributes, at};
}

// Undoes EXR's predictor and its interleaving of bytes.
function unpacked(packed, size) {
  if (packed.length === size) return packed;
  const bytes = zlib.inflateSync(packed), half = (size + 1) >> 1, result = Buffer.alloc(size);
  for (let i = 1; i < size; ++i) bytes[i] = (bytes[i - 1] + bytes[i] - 128) & 255;
  for (let i = 0; i < size; ++i) result[i] = bytes[i & 1 ? half + (i >> 1) : i >> 1];
  return result;
}

// Gives {width, height, at(x, y): [r, g, b]}.
function readExr(path) {
  const bytes = fs.readFileSync(path), {attributes, at} = readHeader(bytes);
  const window = attributes.dataWindow, [left, top, right, bottom] = [0, 4, 8, 12].map(i => window.readInt32LE(i));
  const width = right - left + 1, height = bottom - top + 1, rows = {0: 1, 2: 1, 3: 16}[attributes.compression[0]];
  if (!rows) throw new Error(path + ': compression ' + attributes.compression[0]);
  const planes = new Float32Array(3 * width * height);
  for (let block = 0; block < Math.ceil(height / rows); ++block) {
    const from = Number(bytes.readBigUInt64LE(at + 8 * block)), first = bytes.readInt32LE(from) - top;
    const count = Math.min(rows, height - first), size = bytes.readInt32LE(from + 4);
    const data = unpacked(bytes.subarray(from + 8, from + 8 + size), 12 * width * count);
    for (let y = 0; y < count; ++y)
      for (let channel = 0; channel < 3; ++channel)
        for (let x = 0; x < width; ++x)
          planes[3 * ((first + y) * width + x) + 2 - channel] = data.readFloatLE(4 * ((3 * y + channel) * width + x));
  }
  return {width, height, at: (x, y) => [...planes.subarray(3 * (y * width + x), 3 * (y * width + x) + 3)]};
}
module.exports = {readExr};
