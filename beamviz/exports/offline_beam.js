/* Draws beams into the scene of an exported page. Repeats beam_mesh.segments of the package on the
   data of html_page.beam_record. */
"use strict";
const beamvizOffline = (() => {
  const MAX_WEDGE = Math.tan(0.5), MIN_STEP = 10; // of a mode, in resolutions; less is rounding
  const LATE = 10000; // [ms] after which the scene should be there
  /** @type {(id: string) => HTMLInputElement} */
  const byId = (id) => /** @type {any} */ (document.getElementById(id));
  /** @type {(x: number[]) => Vec3} */
  const three = ([x, y, z]) => [x, y, z];

  /**
   * The data of a script element, compressed JSON.
   * @param {string} id
   */
  async function unpacked(id) {
    const packed = Uint8Array.from(atob(byId(id).textContent ?? ""), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(stream).json();
  }

  /**
   * Turns columns of second differences, in integers, into numbers, in place.
   * @param {number[][]} columns
   * @param {number} resolution
   */
  function undoSteps(columns, resolution) {
    for (const values of columns)
      for (const unit of [1, resolution])
        values.forEach((step, k) => { values[k] = unit * step + (k ? values[k - 1] : 0); });
  }

  /**
   * A message to the scene, as viser's server sends it.
   * @param {string} type
   * @param {string} name of the node
   * @param {object} values
   */
  const send = (type, name, values) =>
    beamvizViser.receive({ type, name, owner: "", ...values });

  /** @type {Record<string, Uint8ArrayConstructor | Uint32ArrayConstructor>} */
  const TYPES = { batched_colors: Uint8Array, faces: Uint32Array }; // of properties that are integers

  /**
   * Sets the properties of a node, from those of each of its instances.
   * @param {string} name
   * @param {Record<string, number[]>[]} instances
   */
  function update(name, instances) {
    send("SceneNodeUpdateMessage", name, { updates: Object.fromEntries(
      Object.keys(instances[0]).map((key) => {
        const type = TYPES[key] ?? Float32Array;
        return [key, type.from(instances.flatMap((one) => one[key]))];
      })) });
  }

  /** @type {(a: Vec3, b: Vec3) => Vec3} */
  const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
  /** @type {(a: Vec3, b: Vec3) => number} */
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  /** @type {(a: Vec3) => Vec3} */
  const unit = (a) => three(a.map((x) => x / Math.hypot(...a)));

  /**
   * A normal of the straight beam along x, rotated with it to a direction without torsion.
   * @param {Vec3} normal
   * @param {Vec3} tangent
   */
  function bent(normal, tangent) {
    const [x, y, z] = tangent, once = cross([0, -z, y], normal), twice = cross([0, -z, y], once);
    return three(normal.map((v, j) => v + once[j] + twice[j] / Math.max(1 + x, 1e-300)));
  }

  /**
   * The vertices of a rectangular section swept along points: four of each ring.
   * @param {Vec3[]} points
   * @param {Surface} surface
   */
  function swept(points, { rings, normals }) {
    return rings.flatMap(([i, thickness, breadth], k) => {
      const before = points[Math.max(i - 1, 0)], after = points[Math.min(i + 1, points.length - 1)];
      const tangent = unit(three(after.map((x, j) => x - before[j])));
      const up = bent(normals[k], tangent), side = cross(up, tangent);
      return [[1, 1], [-1, 1], [-1, -1], [1, -1]].flatMap(([s, u]) => points[i].map((place, j) =>
        place + (s * thickness * side[j] + u * breadth * up[j]) / 2));
    });
  }

  /**
   * Draws a beam. still, moved: four numbers of each station, x, y, z and strain, at rest and their
   * change; mode: the same of the mode whose nodes are marked, if one is.
   * @param {OfflineScene} data
   * @param {OfflineBeam | VibratingBeam} beam
   * @param {number[]} still
   * @param {Float32Array} moved
   * @param {number[]} [mode]
   */
  function draw(data, beam, still, moved, mode) {
    const { root, turns } = beam, now = moved.map((x, i) => x + still[i]);
    /** @type {Vec3[]} */
    const points = [];
    for (let i = 0; i < now.length; i += 4) points.push(three([...now.slice(i, i + 3)]));
    const steps = points.slice(1).map((b, i) => three(b.map((x, j) => x - points[i][j])));
    const tangents = steps.map(unit);
    const wedges = tangents.map((tangent, i) => { // about the axis of the bend at the start of a piece
      const axis = cross(tangents[Math.max(i - 1, 0)], tangent), sine = Math.hypot(...axis);
      const half = Math.atan2(sine, dot(tangents[Math.max(i - 1, 0)], tangent)) / 2;
      const size = Math.min(Math.abs(Math.tan(half)), MAX_WEDGE) / Math.max(sine, 1e-300);
      return three(axis.map((x) => x * size));
    });
    wedges.push([0, 0, 0]);
    const wxyzs = tangents.map(([x, y, z], i) => { // of its turn about x, and of its bend
      const sine = Math.hypot(y, z), half = Math.atan2(sine, x) / 2;
      const w = Math.cos(half), size = Math.sin(half) / (sine || 1);
      const c = Math.cos(turns[i] / 2), s = Math.sin(turns[i] / 2);
      return [w * c, w * s, size * (y * s - z * c), size * (y * c + z * s)];
    });
    /** @type {(i: number, share: number) => Record<string, number[]>} at a part of the way along a piece */
    const on = (i, share) => ({
      batched_positions: points[i].map((x, j) => x + share * steps[i][j]),
      batched_wxyzs: wxyzs[i],
    });
    const pieces = steps.map((step, i) => {
      const middle = [0, 1, 2].map((j) => moved[4 * i + j] + moved[4 * i + 4 + j]);
      const value = data.strain ? beam.largest + now[4 * i + 3] : Math.hypot(...middle);
      const share = Math.min(Math.max(value / (2 * beam.largest), 0), 1);
      const colour = 3 * Math.round(share * (data.palette.length / 3 - 1));
      const upright = bent([0, -Math.sin(turns[i]), Math.cos(turns[i])], tangents[i]);
      const [longer, wider] = [upright, cross(upright, tangents[i])].map((side) =>
        Math.abs(dot(wedges[i], side)) + Math.abs(dot(wedges[i + 1], side)));
      const [y, z] = beam.sections[i];
      const scales = [Math.hypot(...step) + (y * longer + z * wider) / 2, y, z];
      const colours = { batched_colors: data.palette.slice(colour, colour + 3) };
      return { ...on(i, 0.5), batched_scales: scales, ...colours };
    });
    if (beam.surface) {
      update(`${root}/rotor/body`, [{ vertices: swept(points, beam.surface), faces: beam.surface.faces }]);
    } else {
      update(`${root}/rotor/beam`, pieces);
      update(`${root}/rotor/ends`, beam.capped.map((i) => pieces[i]));
    }
    /** @param {number} station */
    const body = (station) => {
      const piece = Math.min(station, pieces.length - 1);
      return on(piece, station - piece);
    };
    for (const [name, at] of Object.entries(beam.bodies)) update(name, at.map(body));
    for (const { name, station, above } of beam.labels_of_bodies)
      send("SetPositionMessage", name, { position: above.map((x, j) => x + points[station][j]) });
    if (!mode || !("ring" in beam)) return;
    /** @type {(i: number, share: number, size: number[]) => Record<string, number[]>} */
    const ring = (i, share, size) =>
      ({ ...on(i, share), batched_scales: size, batched_colors: beam.ring_colour });
    const [length, larger] = beam.ring;
    const rings = pieces.flatMap((_, i) => { // where the mode changes its sign
      const [u, v] = [i, i + 1].map((n) => mode[4 * n + beam.component]);
      const node = i && u * v < 0 && Math.abs(u - v) > MIN_STEP * data.resolution;
      const whole = [length, ...beam.sections[i].map((x) => larger * x)];
      return node ? [ring(i, u / (u - v), whole)] : [];
    });
    update(`${root}/rotor/nodes`, rings.length ? rings : [ring(0, 0, [0, 0, 0])]);
  }

  /**
   * Turns the hub of a beam, or the ground, by an angle; a beam drawn over another turns with that.
   * @param {OfflineScene} data
   * @param {OfflineBeam} beam
   * @param {number} angle
   */
  function turn(data, { root, surface }, angle) {
    if (surface) return;
    const half = (data.turning[1] * angle) / 2, wxyz = [Math.cos(half), 0, 0, Math.sin(half)];
    send("SetOrientationMessage", `${root}/${data.turning[0]}`, { wxyz });
  }

  /**
   * Calls `advance` with the seconds since the last frame in every frame, and `show` in those in
   * which the scene is there.
   * @param {OfflineScene} data
   * @param {(seconds: number) => void} advance
   * @param {() => void} show
   */
  function play(data, advance, show) {
    let before = 0;
    setTimeout(beamvizViser.check, LATE);
    requestAnimationFrame(function frame(now) {
      advance(Math.min(now - before, 100) / 1000);
      before = now;
      requestAnimationFrame(frame);
      const canvas = beamvizViser.canvas();
      if (!canvas || !beamvizViser.pixel(`${data.beams[0].root}/rotor/ends`)) return;
      const { clientWidth, clientHeight } = canvas; // the scene is fitted into a square
      beamvizViser.zoomTo(Math.min(1, clientWidth / clientHeight));
      show();
      beamvizViser.render();
    });
  }

  /* A button that starts and pauses; it plays at first unless the visitor prefers reduced motion.
  */
  function playButton() {
    const button = byId("play");
    const state = {
      playing: !matchMedia("(prefers-reduced-motion: reduce)").matches,
      /** @param {boolean} playing */
      set(playing) {
        state.playing = playing;
        button.textContent = playing ? "Pause" : "Play";
      },
    };
    state.set(state.playing);
    button.onclick = () => state.set(!state.playing);
    return state;
  }

  beamvizPlainScene.start(byId("caption-layer"));
  return { byId, unpacked, undoSteps, send, update, draw, turn, play, playButton };
})();
