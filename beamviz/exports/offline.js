/* The scene of an exported page, drawn at any speed by interpolation between solved ones. Repeats
beam_mesh.segments and modes.displacement of the package on the data of speeds.py. */
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("speeds").textContent);
  const floats = (text) =>
    new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
  const SIDES = { top: 0, center: -0.5, bottom: -1 }, HIDDEN = 1e-6, MAX_NODES = 10;
  const palette = floats(data.palette), last = data.speeds.length - 1;
  for (const beam of data.beams)
    for (const key of ["axes", "strains", "modes", "vertices"]) beam[key] = floats(beam[key]);
  const slider = document.getElementById("speed"), shown = document.getElementById("speed-shown");
  const chart = document.querySelector("aside figure");
  const button = document.getElementById("play"), cells = new Map();
  let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  let before = 0, angle = 0, phases = {}, position = { k: 0, t: 0 };

  /* The solved speeds on both sides of `speed`, and its place between them. */
  function locate(speed) {
    let k = 0;
    while (k < last - 1 && data.speeds[k + 1] <= speed) k += 1;
    const step = last ? data.speeds[k + 1] - data.speeds[k] : 1;
    return { k, t: Math.min(Math.max((speed - data.speeds[k]) / step, 0), 1) };
  }
  const between = (values, { k, t }) => (last ? (1 - t) * values[k] + t * values[k + 1] : values[0]);
  /* One of the arrays of `size` numbers that lie one after the other for each speed. */
  function at(values, size, { k, t }) {
    const result = values.slice(k * size, (k + 1) * size), next = (k + 1) * size;
    if (t > 0) for (let i = 0; i < size; i++) result[i] += t * (values[next + i] - result[i]);
    return result;
  }
  /* A frequency, by its square, which is smooth in the square of the speed. */
  function frequency(label, { k, t }) {
    const values = data.frequencies[label], ends = [values[k], values[Math.min(k + 1, last)]];
    if (ends.includes(null)) return null;
    const [a, b] = [data.speeds[k], data.speeds[Math.min(k + 1, last)]];
    const speed = a + t * (b - a), part = b > a ? (speed * speed - a * a) / (b * b - a * a) : 0;
    return Math.sqrt(ends[0] ** 2 + part * (ends[1] ** 2 - ends[0] ** 2));
  }

  function messages(beam, place) {
    const n = beam.x.length, count = n - 1, axis = at(beam.axes, 2 * n, place);
    const many = beam.labels.length, modes = at(beam.modes, many * 4 * n, place);
    const moved = new Float32Array(2 * n);
    beam.labels.forEach((label, m) => {
      const size = between(beam.sizes.map((row) => row[m]), place), phase = phases[label];
      const s = size * Math.sin(phase), c = size * Math.cos(phase), first = m * 4 * n;
      for (let i = 0; i < 2 * n; i++) moved[i] += s * modes[first + i] + c * modes[first + 2 * n + i];
    });
    const aside = beam.normal[2] ? 1 : 2, points = [], along = [];
    for (let i = 0; i < n; i++) {
      const point = [beam.delta + axis[2 * i] + moved[2 * i], 0, 0];
      point[aside] = axis[2 * i + 1] + moved[2 * i + 1];
      points.push(point);
    }
    for (let i = 0; i < count; i++)
      along.push(Math.atan2(points[i + 1][aside] - points[i][aside], points[i + 1][0] - points[i][0]));
    const wedge = new Float32Array(n);
    for (let i = 1; i < count; i++) {
      const bend = along[i] - along[i - 1];
      const least = Math.abs(bend - 2 * Math.PI * Math.round(bend / (2 * Math.PI)));
      wedge[i] = Math.tan(Math.min(least, 1) / 2);
    }
    const pieces = {
      batched_positions: new Float32Array(3 * count), batched_wxyzs: new Float32Array(4 * count),
      batched_scales: new Float32Array(3 * count), batched_colors: new Uint8Array(3 * count),
    };
    const strains = at(beam.strains, count, place);
    for (let i = 0; i < count; i++) {
      const [a, b] = [points[i], points[i + 1]];
      const length = Math.hypot(b[0] - a[0], b[aside] - a[aside]);
      const share = data.strain
        ? 0.5 + (0.5 * strain(i)) / beam.largest
        : Math.hypot(moved[2 * i] + moved[2 * i + 2], moved[2 * i + 1] + moved[2 * i + 3]) /
          (2 * beam.largest);
      const entry = 3 * Math.round(Math.min(Math.max(share, 0), 1) * (palette.length / 3 - 1));
      pieces.batched_wxyzs[4 * i] = Math.cos(along[i] / 2);
      for (let j = 0; j < 3; j++) {
        pieces.batched_positions[3 * i + j] = (a[j] + b[j]) / 2;
        pieces.batched_wxyzs[4 * i + 1 + j] = Math.sin(along[i] / 2) * beam.normal[j];
        pieces.batched_scales[3 * i + j] = beam.size[j];
        pieces.batched_colors[3 * i + j] = palette[entry + j];
      }
      pieces.batched_scales[3 * i] = length + (beam.thickness / 2) * (wedge[i] + wedge[i + 1]);
    }
    function strain(i) { // of the axis, and of the motion along it
      const u = [axis[2 * i + 2] - axis[2 * i], axis[2 * i + 3] - axis[2 * i + 1]];
      const v = [moved[2 * i + 2] - moved[2 * i], moved[2 * i + 3] - moved[2 * i + 1]];
      return strains[i] + (u[0] * v[0] + u[1] * v[1]) / Math.hypot(...u) / (beam.x[i + 1] - beam.x[i]);
    }
    const pick = (i) => (values) => values.slice((values.length / count) * i, (values.length / count) * (i + 1));
    const ends = {};
    for (const [name, values] of Object.entries(pieces)) {
      const width = values.length / count;
      ends[name] = new values.constructor(2 * width);
      ends[name].set(values.subarray(0, width));
      ends[name].set(values.subarray(width * (count - 1)), width);
    }
    const list = [[beam.names.pieces, pieces], [beam.names.ends, ends]];
    if (beam.names.mass) {
      const wxyzs = pick(Math.min(beam.mass, count - 1))(pieces.batched_wxyzs);
      const here = Float32Array.from(points[beam.mass]);
      list.push([beam.names.mass, { batched_positions: here, batched_wxyzs: wxyzs }]);
    }
    if (beam.names.nodes) list.push([beam.names.nodes, nodes(beam, modes, points, pieces.batched_wxyzs)]);
    if (beam.straight) {
      const vertices = beam.vertices.slice();
      for (let i = vertices.length / 2; i < vertices.length; i += 3) vertices[i] = beam.delta + axis[2 * n - 2];
      list.push([beam.names.rest, { vertices }]);
    }
    const type = "SceneNodeUpdateMessage";
    return list.map(([name, updates]) => ({ type, name, updates, owner: "" }));
  }

  /* Rings where the larger component of the mode changes its sign. */
  function nodes(beam, modes, points, wxyzs) {
    const positions = new Float32Array(3 * MAX_NODES), turns = new Float32Array(4 * MAX_NODES);
    const scales = new Float32Array(3 * MAX_NODES).fill(HIDDEN), part = beam.bends[0] >= 0.5 ? 1 : 0;
    for (let k = 0; k < MAX_NODES; k++) turns[4 * k] = 1;
    for (let i = 1, k = 0; i < beam.x.length - 1 && k < MAX_NODES; i++) {
      const u = modes[2 * i + part], v = modes[2 * i + 2 + part];
      if (u * v >= 0) continue;
      const share = u / (u - v);
      for (let j = 0; j < 3; j++)
        positions[3 * k + j] = (1 - share) * points[i][j] + share * points[i + 1][j];
      turns.set(wxyzs.subarray(4 * i, 4 * i + 4), 4 * k);
      scales.set([0.007 + 1.3 * beam.size[0], 1.3 * beam.size[1], 1.3 * beam.size[2]], 3 * k);
      k += 1;
    }
    return { batched_positions: positions, batched_wxyzs: turns, batched_scales: scales };
  }

  function draw() {
    const viewer = window.__viserMutable;
    if (!viewer?.camera || !viewer.nodeRefFromName[data.beams[0].names.pieces]) return;
    const turn = (data.direction * angle) / 2, wxyz = [Math.cos(turn), 0, 0, Math.sin(turn)];
    const turned = data.turning.map((name) => ({ type: "SetOrientationMessage", name, wxyz, owner: "" }));
    viewer.messageQueue.push(...turned, ...data.beams.flatMap((beam) => messages(beam, position)));
    viewer.requestRender();
    captions(viewer);
  }

  function captions({ nodeRefFromName: refs, camera, canvas }) {
    for (const { name, anchor, element } of data.captions) {
      const node = refs[name], place = node?.position.clone().setFromMatrixPosition(node.matrixWorld);
      if (!place) continue;
      const { x, y } = place.project(camera), { clientWidth: width, clientHeight: height } = canvas;
      const left = ((x + 1) / 2) * width - element.offsetWidth / 2;
      const top = ((1 - y) / 2) * height + SIDES[anchor] * element.offsetHeight;
      element.style.transform = `translate(${left.toFixed(1)}px, ${top.toFixed(1)}px)`;
    }
  }

  function frame(now) {
    const passed = playing ? (data.rate * Math.min(now - before, 100)) / 1000 : 0;
    before = now;
    for (const beam of data.beams)
      for (const label of beam.labels)
        phases[label] = (phases[label] ?? Math.PI / 2) + passed * (frequency(label, position) ?? 0);
    angle += passed * between(data.speeds, position);
    draw();
    requestAnimationFrame(frame);
  }

  function choose() {
    const wanted = slider.value / data.speed.factor, near = slider.step / data.speed.factor;
    position = locate(Math.abs(wanted - data.start) < near ? data.start : wanted);
    const speed = between(data.speeds, position), moved = Math.abs(speed - data.start) > 1e-9;
    const number = Number((data.speed.factor * speed).toPrecision(4));
    const step = chart?.dataset.step * data.speed.factor;
    if (step) chart.querySelector("#marker").setAttribute("transform", `translate(${step * (speed - data.start)})`);
    shown.textContent = data.speed.unit ? `${number} ${data.speed.unit}` : `γ = ${number}`;
    for (const [label, { cell, error, texts }] of cells) {
      const value = moved ? frequency(label, position) : null;
      const text = value === null ? "–" : (data.factor * value).toPrecision(6);
      [cell.textContent, error.textContent] = moved ? [text, "–"] : texts;
    }
    for (const { text, element } of data.captions) {  // some hold for the speed of the scene alone
      const label = text.split(" ")[0], ofSpeed = text.startsWith("speed") || text.endsWith("rpm");
      const title = data.beams.length > 1 && label in data.frequencies;
      element.hidden = moved && !ofSpeed && !title;
      element.textContent = !moved ? text : ofSpeed ? text.replace(/[-.0-9]+/, number) : label;
    }
  }

  for (const row of document.querySelectorAll("aside table[aria-label=modes] tr"))
    if (row.cells[1]?.tagName === "TD") {
      const [cell, error] = [row.cells[3], row.cells[4]];
      cells.set(row.cells[1].textContent, { cell, error, texts: [cell.textContent, error.textContent] });
    }
  const layer = document.getElementById("captions");
  for (const caption of data.captions) {
    caption.element = layer.appendChild(document.createElement("span"));
    caption.element.textContent = caption.text;
  }
  slider.min = data.speed.factor * data.speeds[0];
  slider.max = data.speed.factor * data.speeds[last];
  slider.step = (slider.max - slider.min) / 2000 || 1;
  slider.value = data.speed.factor * data.start;
  slider.oninput = choose;
  button.onclick = () => {
    playing = !playing;
    button.textContent = playing ? "Pause" : "Play";
  };
  button.textContent = playing ? "Pause" : "Play";
  choose();
  requestAnimationFrame(frame);
})();
