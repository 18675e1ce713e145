/* The scene in a browser without WebGL: the nodes that three.js would draw, projected by its camera
   and filled, nearest first, in the memory of a plain canvas over that of viser. Without shadows;
   light and tone curve are those of the page (exports/renderer.py). */
"use strict";
const beamvizPlainScene = (() => {
  const NOTE = "This browser has no WebGL: the page draws the scene itself, without shadows.";
  const PERIOD = 38; // [ms] between two pictures: the server sends 25 in a second
  const REST = 1; // part of the time that a picture has taken, until the next one
  const SLOW = 40; // [ms] for a usual picture, from which on pixels have one sample each, not four
  const MEMORY = 0.05; // weight of the last picture in what is usual: the first ones take longer
  const NEAR = 0.02; // [beam lengths] from the camera, as in renderer.py
  const ON_TOP = 1.0005; // how much nearer lines are than the surface they are on
  // The white lights of surroundings.py: directions and intensities, and the sky.
  const LIGHTS = [{ to: [-0.5, -1, 2.2], power: 1.8 }, { to: [1.5, -2, 0.6], power: 0.5 }];
  const SKY = [200, 200, 210].map((value) => (1.6 * (1 + linear(value / 255))) / 2); // at any point
  const EXPOSURE = 1 / 0.6;
  const TO_ACES = [0.59719, 0.35458, 0.04823, 0.076, 0.90834, 0.01566, 0.0284, 0.13383, 0.83777];
  const FROM_ACES = [1.60475, -0.53108, -0.07367, -0.10208, 1.10813, -0.00605, -0.00327, -0.07276, 1.07602];

  /**
   * @typedef {number[]} Triple
   * @typedef {{ elements: number[] }} Matrix as three.js has it, column by column
   * @typedef {{ count: number, getX(i: number): number, getY(i: number): number, getZ(i: number): number }} Points
   * @typedef {{ isMeshStandardMaterial?: boolean, isLineMaterial?: boolean, opacity: number, side: number,
   *   linewidth: number, color: { r: number, g: number, b: number, clone(): { r: number, g: number, b: number } } }} Material
   * @typedef {object} Solid
   * @property {boolean} visible
   * @property {Solid[]} children
   * @property {Material} [material]
   * @property {{ index: { array: ArrayLike<number> } | null, attributes: Record<string, Points> }} geometry
   * @property {Matrix & { clone(): Matrix }} matrixWorld
   * @property {boolean} [isInstancedMesh2]
   * @property {number} [instancesCount]
   * @property {object | null} [colorsTexture]
   * @property {(k: number, matrix: Matrix) => Matrix} getMatrixAt
   * @property {(k: number, colour: object) => { r: number, g: number, b: number }} getColorAt
   */

  const canvas = document.createElement("canvas");
  let samples = 2; // of a pixel along x and along y
  let usual = 0, next = 0, waits = false; // [ms] for a picture; time of the next one, and whether it is asked for
  let width = 0, height = 0; // [samples] of the picture
  let shown = new Uint32Array(0), depth = new Float32Array(0); // colours, and 1 / distance
  /** @type {number[]} */
  let projection = [];
  /** @type {Triple} */
  let eye = [0, 0, 0];
  let lights = LIGHTS; // in the coordinates of three.js, where y is up

  /** @type {(v: Triple) => Triple} */
  function unit(v) {
    const length = Math.hypot(...v) || 1;
    return v.map((x) => x / length);
  }

  /** @param {number} value */
  function linear(value) {
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  }

  /** @type {(m: number[], v: Triple) => Triple} */
  const times = (m, v) => [0, 3, 6].map((k) => m[k] * v[0] + m[k + 1] * v[1] + m[k + 2] * v[2]);

  /** @type {(m: number[], v: Triple) => Triple} */
  const turned = (m, [x, y, z]) => [0, 1, 2].map((i) => m[i] * x + m[i + 4] * y + m[i + 8] * z);

  /**
   * The product of two matrices of four columns each.
   * @type {(a: number[], b: number[]) => number[]}
   */
  function product(a, b) {
    const result = new Array(16).fill(0);
    for (let k = 0; k < 16; k++)
      for (let i = 0; i < 4; i++) result[k] += a[(k % 4) + 4 * i] * b[4 * (k >> 2) + i];
    return result;
  }

  // Light

  /**
   * Linear light (3) as three.js shows it, in bytes: the ACES tone curve, then sRGB.
   * @param {Triple} light
   */
  function toned(light) {
    const curve = times(TO_ACES, light.map((x) => x * EXPOSURE))
      .map((v) => (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081));
    return times(FROM_ACES, curve).map((v) => {
      const within = Math.min(Math.max(v, 0), 1);
      return 255 * (within <= 0.0031308 ? 12.92 * within : 1.055 * within ** (1 / 2.4) - 0.055);
    });
  }

  /**
   * The colour of a surface with a unit normal, by Lambert's reflection.
   * @type {(albedo: Triple, x: number, y: number, z: number) => Triple}
   */
  function shade(albedo, x, y, z) {
    let power = 0;
    for (const { to, power: full } of lights) power += full * Math.max(x * to[0] + y * to[1] + z * to[2], 0);
    return toned(albedo.map((part, k) => (part * (power + SKY[k])) / Math.PI));
  }

  /** @type {(colour: Triple, opacity: number) => number} */
  const packed = (colour, opacity) =>
    ((Math.round(255 * opacity) << 24) | (Math.round(colour[2]) << 16) | (Math.round(colour[1]) << 8) | Math.round(colour[0])) >>> 0;

  /** @type {(over: number, under: number) => number} a translucent colour over another one */
  function mixed(over, under) {
    const part = (over >>> 24) / 255, before = (under >>> 24) / 255;
    if (!before) return over;
    let result = Math.round(255 * (part + before * (1 - part))) << 24;
    for (const k of [0, 8, 16])
      result |= Math.round(part * ((over >> k) & 255) + (1 - part) * ((under >> k) & 255)) << k;
    return result >>> 0;
  }

  // Triangles. Points of the picture are x, y [samples] and 1 / distance, which is linear in them.

  /** @type {(point: Triple) => Triple} a point of the scene as x w, y w, w in the picture */
  function projected([x, y, z]) {
    const m = projection, w = m[3] * x + m[7] * y + m[11] * z + m[15];
    return [
      ((m[0] * x + m[4] * y + m[8] * z + m[12] + w) / 2) * width,
      ((w - m[1] * x - m[5] * y - m[9] * z - m[13]) / 2) * height,
      w,
    ];
  }

  /**
   * Fills a triangle, given by projected points; what is behind the camera is cut off.
   * @type {(corners: Triple[], colour: number, nearer?: number) => void}
   */
  function fill(corners, colour, nearer = 1) {
    /** @type {Triple[]} */
    const polygon = [];
    corners.forEach((a, k) => {
      const b = corners[(k + 1) % 3], part = (NEAR - a[2]) / (b[2] - a[2]);
      if (a[2] >= NEAR) polygon.push(a);
      if (a[2] >= NEAR !== b[2] >= NEAR) polygon.push(a.map((x, i) => x + part * (b[i] - x)));
    });
    const places = polygon.map(([x, y, w]) => [x / w, y / w, nearer / w]);
    for (let k = 2; k < places.length; k++) fillRows([places[0], places[k - 1], places[k]], colour);
  }

  /** @type {(places: Triple[], colour: number) => void} */
  function fillRows([a, b, c], colour) {
    const area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if (!area) return;
    const slope = ((b[2] - a[2]) * (c[1] - a[1]) - (c[2] - a[2]) * (b[1] - a[1])) / area;
    const rise = ((b[0] - a[0]) * (c[2] - a[2]) - (c[0] - a[0]) * (b[2] - a[2])) / area;
    const top = Math.max(Math.ceil(Math.min(a[1], b[1], c[1]) - 0.5), 0);
    const bottom = Math.min(Math.ceil(Math.max(a[1], b[1], c[1]) - 0.5), height);
    const edges = [[a, b], [b, c], [c, a]].filter(([p, q]) => p[1] !== q[1]), isSolid = colour >= 0xff000000;
    for (let y = top; y < bottom; y++) {
      let left = Infinity, right = -Infinity;
      for (const [p, q] of edges) {
        if (y + 0.5 < Math.min(p[1], q[1]) || y + 0.5 > Math.max(p[1], q[1])) continue;
        const x = p[0] + ((y + 0.5 - p[1]) / (q[1] - p[1])) * (q[0] - p[0]);
        left = Math.min(left, x);
        right = Math.max(right, x);
      }
      const start = Math.max(Math.ceil(left - 0.5), 0), stop = Math.min(Math.ceil(right - 0.5), width);
      let near = a[2] + slope * (start + 0.5 - a[0]) + rise * (y + 0.5 - a[1]);
      for (let at = y * width + start; at < y * width + stop; at++, near += slope) {
        if (near < depth[at]) continue;
        if (isSolid) depth[at] = near;
        shown[at] = isSolid ? colour : mixed(colour, shown[at]);
      }
    }
  }

  // Nodes

  /**
   * A surface, placed by a matrix, in a linear colour.
   * @type {(solid: Solid, material: Material, m: number[], albedo: Triple) => void}
   */
  function drawSurface({ geometry }, material, m, albedo) {
    const points = geometry.attributes.position, index = geometry.index?.array;
    /** @type {Triple[]} */
    const world = [];
    /** @type {Triple[]} */
    const seen = [];
    for (let k = 0; k < points.count; k++) {
      const x = points.getX(k), y = points.getY(k), z = points.getZ(k);
      world.push([0, 1, 2].map((i) => m[i] * x + m[i + 4] * y + m[i + 8] * z + m[i + 12]));
      seen.push(projected(world[k]));
    }
    const count = index ? index.length : points.count;
    for (let k = 0; k + 2 < count; k += 3) {
      const corners = index ? [index[k], index[k + 1], index[k + 2]] : [k, k + 1, k + 2];
      const [a, b, c] = corners.map((i) => world[i]);
      const u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]], v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
      let normal = unit([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]);
      const faces = normal[0] * (eye[0] - a[0]) + normal[1] * (eye[1] - a[1]) + normal[2] * (eye[2] - a[2]);
      if (material.side === 0 ? faces <= 0 : material.side === 1 && faces >= 0) continue;
      if (faces < 0) normal = normal.map((x) => -x);
      const colour = packed(shade(albedo, normal[0], normal[1], normal[2]), material.opacity);
      fill(corners.map((i) => seen[i]), colour);
    }
  }

  /** @type {(solid: Solid, material: Material) => void} */
  function drawLines({ geometry, matrixWorld: { elements: m } }, material) {
    const { instanceStart, instanceEnd } = geometry.attributes, { r, g, b } = material.color;
    const colour = packed(toned([r, g, b]), material.opacity), half = (material.linewidth * samples) / 2;
    for (let k = 0; k < instanceStart.count; k++) {
      const ends = [instanceStart, instanceEnd].map((points) => {
        const x = points.getX(k), y = points.getY(k), z = points.getZ(k);
        return projected([0, 1, 2].map((i) => m[i] * x + m[i + 4] * y + m[i + 8] * z + m[i + 12]));
      });
      if (ends.some(([, , w]) => w < NEAR)) continue;
      const [p, q] = ends, [x, y] = unit([q[0] / q[2] - p[0] / p[2], q[1] / q[2] - p[1] / p[2]]);
      const corners = ends.flatMap(([a, b, w]) => [1, -1].map((side) => [a - side * half * y * w, b + side * half * x * w, w]));
      fill([corners[0], corners[1], corners[2]], colour, ON_TOP);
      fill([corners[1], corners[2], corners[3]], colour, ON_TOP);
    }
  }

  /** @param {Solid} solid */
  function drawSolid(solid) {
    const material = /** @type {Material} */ (solid.material), m = solid.matrixWorld.elements;
    if (material.isLineMaterial) return drawLines(solid, material);
    const { r, g, b } = material.color;
    if (!solid.isInstancedMesh2) return drawSurface(solid, material, m, [r, g, b]);
    const placed = solid.matrixWorld.clone(), tint = material.color.clone();
    for (let k = 0; k < (solid.instancesCount ?? 0); k++) {
      const own = solid.colorsTexture ? solid.getColorAt(k, tint) : { r: 1, g: 1, b: 1 };
      const at = product(m, solid.getMatrixAt(k, placed).elements);
      drawSurface(solid, material, at, [r * own.r, g * own.g, b * own.b]);
    }
  }

  /**
   * The solids that three.js would draw of a node and those below it; not viser's own, as its
   * background and outlines.
   * @type {(node: Solid, list?: Solid[]) => Solid[]}
   */
  function solids(node, list = []) {
    if (!node.visible) return list;
    const { material } = node;
    if ((material?.isMeshStandardMaterial || material?.isLineMaterial) && material.opacity > 0) list.push(node);
    for (const child of node.children) solids(child, list);
    return list;
  }

  // The picture

  function draw() {
    const world = beamvizViser.world();
    if (!world) return;
    const { scene, root, camera, canvas: { clientWidth, clientHeight } } = world, m = root.matrixWorld.elements;
    if (!clientWidth || !clientHeight) return;
    width = samples * clientWidth;
    height = samples * clientHeight;
    if (canvas.width !== width || canvas.height !== height) {
      Object.assign(canvas, { width, height });
      shown = new Uint32Array(width * height);
      depth = new Float32Array(width * height);
    }
    shown.fill(0);
    depth.fill(0);
    projection = product(camera.projectionMatrix.elements, camera.matrixWorldInverse.elements);
    eye = camera.matrixWorld.elements.slice(12, 15);
    lights = LIGHTS.map(({ to, power }) => ({ to: unit(turned(m, to)), power }));
    const all = solids(scene), isClear = (/** @type {Solid} */ { material }) => (material?.opacity ?? 1) < 1;
    for (const solid of [...all.filter((one) => !isClear(one)), ...all.filter(isClear)]) drawSolid(solid);
    const picture = new ImageData(new Uint8ClampedArray(shown.buffer), width, height);
    canvas.getContext("2d")?.putImageData(picture, 0, 0);
    canvas.dataset.pictures = String(Number(canvas.dataset.pictures ?? 0) + 1);
  }

  /** Draws once three.js has gone through its scene; at most as often as the time allows. */
  function drawSoon() {
    if (waits) return;
    waits = true;
    setTimeout(() => requestAnimationFrame(() => {
      const start = performance.now();
      waits = false;
      draw();
      const taken = performance.now() - start;
      usual += MEMORY * (taken - usual);
      if (usual > SLOW) samples = 1;
      next = start + Math.max(PERIOD, taken * (1 + REST));
    }), Math.max(next - performance.now(), 0));
  }

  /**
   * In a browser without WebGL: puts the picture, and the reason for it, before an element.
   * @param {Element} element
   */
  function start(element) {
    if (beamvizWebGL.isThere) return;
    const host = document.createElement("div"), note = document.createElement("p");
    host.id = "plain-scene";
    note.textContent = NOTE;
    host.append(canvas, note);
    element.before(host);
    beamvizWebGL.replace(drawSoon);
  }

  return { start, canvas: () => (canvas.isConnected ? canvas : null) };
})();
