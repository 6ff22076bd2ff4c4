// Pixels of the viewer: half-floats as the page or files beside it hold them, tone mapping, and maps of error.
//
// An image is 3 planes of half-floats (a map of FLIP, which takes C++ to compute, is one), in units that are a power of two so that white lies near 1. Each row holds differences of
// neighbours' bits, all high bytes come before all low bytes, deflated, in base64 (encode_halves in images.cpp).

const halfValues = new Float32Array(65536);
for (let bits = 0; bits < 65536; ++bits) {
  const exponent = bits >> 10 & 31, fraction = bits & 1023, sign = bits >> 15 ? -1 : 1;
  halfValues[bits] = sign * (exponent === 0 ? fraction * 2 ** -24
    : exponent === 31 ? (fraction ? NaN : Infinity) : (1 + fraction / 1024) * 2 ** (exponent - 15));
}

// Files beside the page call this: a page from disk may run scripts from disk, and read nothing else.
const awaited = new Map();
function pixelData(name, base64) { awaited.get(name)?.(base64); }
const dataOf = ({data, file}) => data !== undefined ? Promise.resolve(data) : new Promise((resolve, reject) => {
  awaited.set(file, resolve);
  document.head.append(make('script', {src: file, onerror: () => reject(new Error(file + ' is not beside this page'))}));
});

async function decodeHalves(source, width, height, planes = 3) {
  const text = atob(await dataOf(source)), packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = planes * width * height, result = new Uint16Array(count);
  for (let i = 0; i < count; ++i) {
    const difference = bytes[i] << 8 | bytes[count + i];
    result[i] = i % width === 0 ? difference : result[i - 1] + difference;
  }
  return result;
}

// --- colours ---
const srgbByte = v => Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
const hexColour = text => [1, 3, 5].map(i => parseInt(text.slice(i, i + 2), 16));
function gradient(stops) {
  const colours = stops.map(hexColour), table = new Uint8ClampedArray(256 * 3);
  for (let i = 0; i < 256; ++i) {
    const at = i / 255 * (colours.length - 1), left = Math.min(Math.floor(at), colours.length - 2), f = at - left;
    for (let c = 0; c < 3; ++c) table[3 * i + c] = Math.round((1 - f) * colours[left][c] + f * colours[left + 1][c]);
  }
  return {stops, table};
}
const imageData = JSON.parse(document.getElementById('images').textContent);
const viridis = gradient(imageData.colours);
// Blue is too dark, orange too bright; told apart by the colour-blind, too.
const diverging = gradient(['#08306b', '#2171b5', '#6baed6', '#c6dbef', '#f7f7f7', '#fdd0a2', '#fd8d3c', '#d94801', '#7f2704']);

const toneMaps = {
  srgb: {label: 'clamped', of: v => v},
  reinhard: {label: 'Reinhard', of: v => v / (1 + v)},
  log: {label: 'logarithmic', of: v => Math.log2(1 + 255 * v) / 8}
};
// Bytes of all 65536 half-floats: tone mapping is a look-up.
function toneTable(tone, scale) {
  const table = new Uint8ClampedArray(65536);
  for (let bits = 0; bits < 65536; ++bits) {
    const value = halfValues[bits] * scale;
    table[bits] = value > 0 ? srgbByte(clamp(tone.of(Math.min(value, 1e9)), 0, 1)) : 0;
  }
  return table;
}

// --- maps of error: the mean over channels of what each one errs by; d: image less reference, r: reference ---
// FLIP looks at a pixel's surroundings; its map is in the page where the experiment asks for that metric.
const mapKinds = {
  relative: {label: 'relative squared error', of: (d, r, epsilon) => d * d / (r * r + epsilon)},
  squared: {label: 'squared error', of: d => d * d},
  absolute: {label: 'absolute error', of: d => Math.abs(d)},
  symmetric: {label: 'symmetric relative error', of: (d, r) => d === 0 ? 0 : Math.abs(d) / (Math.abs(d + r) + Math.abs(r))},
  signed: {label: 'signed error', of: d => d, signed: true, even: true},
  flip: {label: 'FLIP', even: true}
};
const kindOfMetric = metric => ({mse: 'squared', smape: 'symmetric', bias: 'signed', flip: 'flip'})[metric] ?? 'relative';

// How to read value and error of a pixel. Where halves of nearly equal images would lose their difference, it is held apart.
const valueAt = (scene, pixels, i) => halfValues[pixels.x[i]] * scene.unit;
const differenceAt = (scene, image, pixels, reference, i) => pixels.difference
  ? halfValues[pixels.difference[i]] * image.differenceUnit : (halfValues[pixels.x[i]] - halfValues[reference.x[i]]) * scene.unit;
function errorAt(scene, image, pixels, reference, kind, pixel) {
  if (!kind.of) return pixels.flip ? halfValues[pixels.flip[pixel]] : NaN;
  const plane = scene.width * scene.height;
  let sum = 0;
  for (let i = pixel; i < 3 * plane; i += plane)
    sum += kind.of(differenceAt(scene, image, pixels, reference, i), valueAt(scene, reference, i), scene.epsilon);
  return sum / 3;
}

function paint(canvas, scene, colourOf) {
  const {width, height} = scene, data = new ImageData(width, height), out = data.data;
  for (let pixel = 0; pixel < width * height; ++pixel) {
    colourOf(pixel, out, 4 * pixel);
    out[4 * pixel + 3] = 255;
  }
  Object.assign(canvas, {width, height}).getContext('2d').putImageData(data, 0, 0);
  return canvas;
}
function paintImage(canvas, scene, pixels, table) {
  const plane = scene.width * scene.height, {x} = pixels;
  return paint(canvas, scene, (pixel, out, at) => {
    out[at] = table[x[pixel]];
    out[at + 1] = table[x[pixel + plane]];
    out[at + 2] = table[x[pixel + 2 * plane]];
  });
}
function paintMap(canvas, scene, image, pixels, reference, kindName) {
  const kind = mapKinds[kindName], [low, high] = scene.ranges[kindName], {table} = kind.signed ? diverging : viridis;
  return paint(canvas, scene, (pixel, out, at) => {
    const error = errorAt(scene, image, pixels, reference, kind, pixel);
    const t = kind.even ? (error - low) / (high - low) : error > 0 ? (Math.log10(error) - low) / (high - low) : 0;
    const from = 3 * Math.round(255 * (clamp(t, 0, 1) || 0));
    for (let c = 0; c < 3; ++c) out[at + c] = table[from + c];
  });
}
