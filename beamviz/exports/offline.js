/* The scene of an exported page, drawn at any speed by interpolation between solved ones. Repeats
beam_mesh.segments and modes.displacement of the package on the data of speeds.py. */
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("speeds").textContent);
  const floats = (text) =>
    new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
  const HIDDEN = [1e-6, 1e-6, 1e-6], MAX_NODES = 10, last = data.speeds.length - 1;
  for (const beam of data.beams)
    for (const key of ["axes", "strains", "modes"]) beam[key] = floats(beam[key]);
  const [slider, shown, button] =
    ["speed", "speed-shown", "play"].map((id) => document.getElementById(id));
  const chart = document.querySelector("aside figure"), cells = new Map(), phases = {};
  let playing = matchMedia("(prefers-reduced-motion: reduce)").matches;
  let before = 0, angle = 0, position; // angle: of the hub; position: see `locate`

  /* The index of the last solved speed up to `speed`, and the place between it and the next. */
  function locate(speed) {
    let k = 0;
    while (k < last - 1 && data.speeds[k + 1] <= speed) k += 1;
    const step = last ? data.speeds[k + 1] - data.speeds[k] : 1;
    return { k, t: Math.min(Math.max((speed - data.speeds[k]) / step, 0), 1) };
  }
  /* One of the arrays of `size` numbers that lie one after the other for each speed. */
  function at(values, size, { k, t }) {
    const result = values.slice(k * size, (k + 1) * size), next = (k + 1) * size;
    if (t > 0) for (let i = 0; i < size; i++) result[i] += t * (values[next + i] - result[i]);
    return result;
  }
  const speedAt = (place) => at(data.speeds, 1, place)[0];
  /* A frequency, by its square, which is smooth in the square of the speed; null if unknown. */
  function frequency(label, { k, t }) {
    const ends = [k, Math.min(k + 1, last)], [f, g] = ends.map((i) => data.frequencies[label][i]);
    if (f === null || g === null) return null;
    const [a, b] = ends.map((i) => data.speeds[i] ** 2), speed = speedAt({ k, t });
    return Math.sqrt(f ** 2 + (b > a ? (speed ** 2 - a) / (b - a) : 0) * (g ** 2 - f ** 2));
  }

  /* The properties of a node with several instances, from those of each. */
  const joined = (instances) => Object.fromEntries(Object.keys(instances[0]).map((name) => {
    const type = name === "batched_colors" ? Uint8Array : Float32Array;
    return [name, type.from(instances.flatMap((one) => one[name]))];
  }));

  function messages(beam, place) {
    const n = beam.x.length, axis = at(beam.axes, 2 * n, place);
    const strains = at(beam.strains, n - 1, place);
    const modes = at(beam.modes, 4 * n * beam.labels.length, place), moved = new Float32Array(2 * n);
    beam.labels.forEach((label, m) => {
      const s = Math.sin(phases[label]), c = Math.cos(phases[label]), first = 4 * n * m;
      for (let i = 0; i < 2 * n; i++) moved[i] += s * modes[first + i] + c * modes[first + 2 * n + i];
    });
    const aside = beam.normal[2] ? 1 : 2, points = beam.x.map((_, i) => {
      const point = [beam.delta + axis[2 * i] + moved[2 * i], 0, 0];
      point[aside] = axis[2 * i + 1] + moved[2 * i + 1];
      return point;
    });
    const steps = points.slice(1).map((b, i) => [b[0] - points[i][0], b[aside] - points[i][aside]]);
    const along = steps.map(([u, v]) => Math.atan2(v, u));
    const wedge = along.map((direction, i) => {  // at the start of a piece
      const bend = i ? direction - along[i - 1] : 0;
      const least = Math.abs(bend - 2 * Math.PI * Math.round(bend / (2 * Math.PI)));
      return Math.tan(Math.min(least, 1) / 2);
    });
    const pieces = steps.map((step, i) => {
      const half = along[i] / 2, wedges = wedge[i] + (wedge[i + 1] ?? 0);
      const share = data.strain
        ? 0.5 + (0.5 * strain(i)) / beam.largest
        : Math.hypot(moved[2 * i] + moved[2 * i + 2], moved[2 * i + 1] + moved[2 * i + 3]) /
          (2 * beam.largest);
      const colour = 3 * Math.round(Math.min(Math.max(share, 0), 1) * (data.palette.length / 3 - 1));
      return {
        batched_positions: points[i].map((x, j) => (x + points[i + 1][j]) / 2),
        batched_wxyzs: [Math.cos(half), ...beam.normal.map((x) => x * Math.sin(half))],
        batched_scales: [Math.hypot(...step) + (beam.thickness / 2) * wedges, ...beam.size.slice(1)],
        batched_colors: data.palette.slice(colour, colour + 3),
      };
    });
    function strain(i) { // of the axis, and of the motion along it
      const [u, v] = [axis, moved].map((line) => [0, 1].map((j) => line[2 * i + 2 + j] - line[2 * i + j]));
      return strains[i] + (u[0] * v[0] + u[1] * v[1]) / Math.hypot(...u) / (beam.x[i + 1] - beam.x[i]);
    }
    const { names } = beam, updates = { [names.pieces]: joined(pieces) };
    updates[names.ends] = joined([pieces[0], pieces.at(-1)]);
    if (names.mass) {
      const { batched_wxyzs } = pieces[Math.min(beam.mass, n - 2)];
      updates[names.mass] = joined([{ batched_positions: points[beam.mass], batched_wxyzs }]);
    }
    if (names.nodes) updates[names.nodes] = joined(nodes(beam, modes, points, pieces));
    if (beam.straight) {
      const end = beam.delta + axis[2 * n - 2], half = beam.vertices.length / 2;
      const vertices = Float32Array.from(beam.vertices, (x, i) => (i >= half && i % 3 === 0 ? end : x));
      updates[names.rest] = { vertices };
    }
    const type = "SceneNodeUpdateMessage";
    return Object.entries(updates).map(([name, updates]) => ({ type, name, updates, owner: "" }));
  }

  /* Rings where the larger component of the mode changes its sign. */
  function nodes(beam, modes, points, pieces) {
    const part = beam.bends ? 1 : 0;
    const hidden = { batched_positions: [0, 0, 0], batched_wxyzs: [1, 0, 0, 0], batched_scales: HIDDEN };
    const rings = pieces.flatMap(({ batched_wxyzs }, i) => {
      const u = modes[2 * i + part], v = modes[2 * i + 2 + part], share = u / (u - v);
      const middle = points[i].map((x, j) => (1 - share) * x + share * points[i + 1][j]);
      return i && u * v < 0 ? [{ batched_positions: middle, batched_wxyzs, batched_scales: beam.ring }] : [];
    });
    return [...rings, ...Array(MAX_NODES).fill(hidden)].slice(0, MAX_NODES);
  }

  function frame(now) {
    const passed = playing ? (data.rate * Math.min(now - before, 100)) / 1000 : 0;
    const viewer = window.__viserMutable;
    before = now;
    for (const label of data.beams.flatMap((beam) => beam.labels))
      phases[label] = (phases[label] ?? Math.PI / 2) + passed * (frequency(label, position) ?? 0);
    angle += passed * speedAt(position);
    requestAnimationFrame(frame);
    if (!viewer?.camera || !viewer.nodeRefFromName[data.beams[0].names.pieces]) return;
    const turn = (data.direction * angle) / 2, wxyz = [Math.cos(turn), 0, 0, Math.sin(turn)];
    const turned = data.turning.map((name) => ({ type: "SetOrientationMessage", name, wxyz, owner: "" }));
    viewer.messageQueue.push(...turned, ...data.beams.flatMap((beam) => messages(beam, position)));
    viewer.requestRender();
  }

  function choose() {
    const wanted = slider.value / data.speed.factor, near = slider.step / data.speed.factor;
    position = locate(Math.abs(wanted - data.start) < near ? data.start : wanted);
    const speed = speedAt(position), moved = Math.abs(speed - data.start) > 1e-9;
    const number = Number((data.speed.factor * speed).toPrecision(4));
    const step = chart?.dataset.step * data.speed.factor;
    if (step) chart.querySelector("#marker").setAttribute("transform", `translate(${step * (speed - data.start)})`);
    shown.textContent = data.speed.unit ? `${number} ${data.speed.unit}` : `γ = ${number}`;
    for (const [label, { cell, error, texts }] of cells) {
      const value = moved ? frequency(label, position) : null;
      const text = value === null ? "–" : (data.factor * value).toPrecision(6);
      [cell.textContent, error.textContent] = moved ? [text, "–"] : texts;
    }
    beamvizCaptions.show(data.captions.flatMap((caption) => { // some hold for one speed alone
      const { text } = caption, label = text.split(" ")[0];
      const ofSpeed = text.startsWith("speed") || text.endsWith("rpm");
      const title = data.beams.length > 1 && label in data.frequencies;
      if (!moved) return [caption];
      if (ofSpeed) return [{ ...caption, text: text.replace(/[-.0-9]+/, number) }];
      return title ? [{ ...caption, text: label }] : [];
    }));
  }

  for (const row of document.querySelectorAll("aside table tr"))
    if (row.cells[1].tagName === "TD") {
      const [cell, error] = [row.cells[3], row.cells[4]];
      cells.set(row.cells[1].textContent, { cell, error, texts: [cell.textContent, error.textContent] });
    }
  [slider.min, slider.max] = [0, last].map((k) => data.speed.factor * data.speeds[k]);
  slider.step = (slider.max - slider.min) / 2000 || 1;
  slider.value = data.speed.factor * data.start;
  slider.oninput = choose;
  button.onclick = () => {
    playing = !playing;
    button.textContent = playing ? "Pause" : "Play";
  };
  button.onclick();
  choose();
  requestAnimationFrame(frame);
})();
