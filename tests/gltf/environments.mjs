// Pictures of environments, for tests: latitude-longitude panoramas, the six faces of
// EXT_lights_image_based, and the illuminance that they give.
//
// In a panorama, +y is at the top.  Longitude runs to the right, from +x through +z.
import { deflateSync } from "node:zlib";

const pi = Math.PI;
const luminance = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

/** A panorama from an uncompressed TIFF file of 32-bit floats in R, G and B. */
export function panoramaFromTiff(bytes) {
  const tags = new Map();
  let at = bytes.readUInt32LE(4);
  for (let n = bytes.readUInt16LE(at), entry = at + 2; n > 0; n -= 1, entry += 12) {
    const size = bytes.readUInt16LE(entry + 2) === 3 ? 2 : 4;
    const count = bytes.readUInt32LE(entry + 4);
    const start = count * size > 4 ? bytes.readUInt32LE(entry + 8) : entry + 8;
    const value = (i) => bytes.readUIntLE(start + i * size, size);
    tags.set(bytes.readUInt16LE(entry), Array.from({ length: count }, (_, i) => value(i)));
  }
  const [width, height] = [tags.get(256)[0], tags.get(257)[0]];
  const strips = tags.get(273).map((start, i) => bytes.subarray(start, start + tags.get(279)[i]));
  const data = Buffer.concat(strips);
  if (tags.get(259)[0] !== 1 || data.length !== width * height * 12)
    throw new Error("the TIFF file is not one of uncompressed floats in R, G and B");
  // Compression leaves values below 0, which have no meaning.
  const rgb = Float32Array.from({ length: 3 * width * height }, (_, i) =>
    Math.max(0, data.readFloatLE(4 * i)),
  );
  return { width, height, rgb };
}

/** Calls `visit(direction, solid angle [sr], RGB)` for small parts of a panorama. */
export function forPanorama({ width, height, rgb }, visit) {
  const parts = 2; // along each side of a texel
  for (let y = 0; y < height * parts; ++y) {
    const [above, below] = [y, y + 1].map((edge) => Math.cos((pi * edge) / (height * parts)));
    const cosine = (above + below) / 2;
    const sine = Math.sqrt(1 - cosine * cosine);
    for (let x = 0; x < width * parts; ++x) {
      const longitude = (2 * pi * (x + 0.5)) / (width * parts);
      const w = [sine * Math.cos(longitude), cosine, sine * Math.sin(longitude)];
      const texel = 3 * (Math.floor(y / parts) * width + Math.floor(x / parts));
      visit(w, ((above - below) * 2 * pi) / (width * parts), rgb.subarray(texel, texel + 3));
    }
  }
}

/** The middle of each quarter of a texel. */
const quarters = [0.25, 0.75].flatMap((y) => [[0.25, y], [0.75, y]]);

/** The RGB value of a panorama in a direction. */
function lookup({ width, height, rgb }, [x, y, z]) {
  const u = Math.atan2(z, x) / (2 * pi);
  const v = Math.acos(y / Math.hypot(x, y, z)) / pi;
  const column = Math.min(width - 1, Math.floor((u - Math.floor(u)) * width));
  const texel = 3 * (Math.min(height - 1, Math.floor(v * height)) * width + column);
  return rgb.subarray(texel, texel + 3);
}

// The faces +x, -x, +y, -y, +z, -z of OpenGL's cube maps: the middle, and the directions of
// growing columns and rows.  [OpenGL 4.6, table 8.19]
const openglFaces = [
  { middle: [1, 0, 0], columns: [0, 0, -1], rows: [0, -1, 0] },
  { middle: [-1, 0, 0], columns: [0, 0, 1], rows: [0, -1, 0] },
  { middle: [0, 1, 0], columns: [1, 0, 0], rows: [0, 0, 1] },
  { middle: [0, -1, 0], columns: [1, 0, 0], rows: [0, 0, -1] },
  { middle: [0, 0, 1], columns: [1, 0, 0], rows: [0, -1, 0] },
  { middle: [0, 0, -1], columns: [-1, 0, 0], rows: [0, -1, 0] },
];

/** A point of a face, with `s` and `t` from -1 to 1.  The extension mirrors OpenGL's faces. */
function pointOf({ middle, columns, rows }, s, t, mirrored = true) {
  const right = mirrored ? -s : s;
  return middle.map((m, i) => m + right * columns[i] + t * rows[i]);
}

const srgb = (linear) =>
  linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
const linear = Float64Array.from({ length: 256 }, (_, code) => {
  const coded = code / 255;
  return coded <= 0.04045 ? coded / 12.92 : ((coded + 0.055) / 1.055) ** 2.4;
});

/** Six faces of `size` x `size` texels, coded as RGBD: four bytes each, RGB divided by alpha. */
export function facesFromPanorama(panorama, size) {
  return openglFaces.map((face) => {
    const texels = Buffer.alloc(4 * size * size);
    for (let i = 0; i < size * size; ++i) {
      const mean = [0, 0, 0];
      for (const [x, y] of quarters) {
        const s = (2 * ((i % size) + x)) / size - 1;
        const t = (2 * (Math.floor(i / size) + y)) / size - 1;
        const value = lookup(panorama, pointOf(face, s, t));
        for (let c = 0; c < 3; ++c) mean[c] += value[c] / quarters.length;
      }
      const alpha = Math.max(1, Math.min(255, Math.floor(255 / Math.max(...mean))));
      for (let c = 0; c < 3; ++c)
        texels[4 * i + c] = Math.round(255 * Math.min(1, srgb((mean[c] * alpha) / 255)));
      texels[4 * i + 3] = alpha;
    }
    return texels;
  });
}

/** Calls `visit(direction, solid angle [sr], RGB)` for the quarters of the texels of six faces. */
export function forFaces(faces, size, visit, mirrored = true) {
  faces.forEach((texels, f) => {
    for (let i = 0; i < size * size; ++i) {
      const rgb = [0, 1, 2].map((c) => (linear[texels[4 * i + c]] * 255) / texels[4 * i + 3]);
      for (const [x, y] of quarters) {
        const s = (2 * ((i % size) + x)) / size - 1;
        const t = (2 * (Math.floor(i / size) + y)) / size - 1;
        const point = pointOf(openglFaces[f], s, t, mirrored);
        const distance = Math.hypot(...point);
        visit(point.map((p) => p / distance), size ** -2 / distance ** 3, rgb);
      }
    }
  });
}

/** The illuminance [lx] of a surface with each normal, under what `forParts` calls back. */
export function illuminances(normals, forParts) {
  const sums = normals.map(() => 0);
  forParts(([x, y, z], steradian, rgb) => {
    const light = luminance(rgb) * steradian;
    normals.forEach((n, i) => (sums[i] += light * Math.max(0, x * n[0] + y * n[1] + z * n[2])));
  });
  return sums;
}

/** A PNG file of `size` x `size` texels of four bytes. */
export function png(size, texels) {
  const header = Buffer.alloc(13);
  header.writeUInt32BE(size, 0);
  header.writeUInt32BE(size, 4);
  header.set([8, 6, 0, 0, 0], 8); // 8 bits; red, green, blue, alpha
  const rows = Array.from({ length: size }, (_, y) =>
    Buffer.concat([Buffer.of(0), texels.subarray(4 * size * y, 4 * size * (y + 1))]),
  );
  return Buffer.concat([
    Buffer.from("\x89PNG\r\n\x1a\n", "latin1"),
    chunk("IHDR", header),
    chunk("IDAT", deflateSync(Buffer.concat(rows))),
    chunk("IEND", Buffer.alloc(0)),
  ]);
}

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type, "latin1"), data]);
  const [length, check] = [Buffer.alloc(4), Buffer.alloc(4)];
  length.writeUInt32BE(data.length);
  check.writeUInt32BE(crc32(body));
  return Buffer.concat([length, body, check]);
}

function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; ++bit) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return (crc ^ 0xffffffff) >>> 0;
}
