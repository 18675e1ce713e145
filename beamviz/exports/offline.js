/* The scene of an exported page at any of its solved speeds. Repeats beam_mesh.segments of the
package on the data of html_page.py. */
"use strict";
(async () => {
  const byId = (id) => document.getElementById(id);
  const packed = Uint8Array.from(atob(byId("speeds").textContent), (c) => c.charCodeAt(0));
  const unpacked = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const data = await new Response(unpacked).json();
  for (const values of [data.body, ...data.beams.map(({ states }) => states)].flat())
    for (const unit of [1, data.resolution]) // from second differences between speeds, in integers
      values.forEach((step, k) => { values[k] = unit * step + (k ? values[k - 1] : 0); });
  const MIN_STEP = 10, // a smaller one is rounding
    MAX_WEDGE = Math.tan(0.5);
  const [slider, shown, button] = ["speed", "speed-shown", "play"].map(byId), phases = {};
  const chart = document.querySelector("aside figure[data-step]");
  let playing = matchMedia("(prefers-reduced-motion: reduce)").matches;
  let before = 0, angle = 0; // of the hub
  let k = data.start; // the solved speed that is shown

  /* Numbers at the present speed, from the values of each at all. */
  const at = (numbers) => numbers.map((values) => values[k]);
  const send = (type, name, values) =>
    window.__viserMutable?.messageQueue?.push({ type, name, owner: "", ...values });

  /* Sets the properties of a node, from those of each of its instances. */
  function update(name, instances) {
    send("SceneNodeUpdateMessage", name, { updates: Object.fromEntries(
      Object.keys(instances[0]).map((key) => {
        const type = { batched_colors: Uint8Array, faces: Uint32Array }[key] ?? Float32Array;
        return [key, type.from(instances.flatMap((one) => one[key]))];
      })) });
  }

  /* Draws a beam at the present phases. A station has four numbers: x, y, z, strain. */
  function draw({ root, labels, states, normal, ...beam }) {
    const state = at(states), size = state.length / (1 + 2 * labels.length);
    const moved = new Float32Array(size);
    labels.forEach((label, m) => {
      const s = Math.sin(phases[label]), c = Math.cos(phases[label]), first = (1 + 2 * m) * size;
      for (let i = 0; i < size; i++) moved[i] += s * state[first + i] + c * state[first + size + i];
    });
    const now = moved.map((x, i) => x + state[i]), points = [];
    for (let i = 0; i < size; i += 4) points.push([...now.slice(i, i + 3)]);
    const steps = points.slice(1).map((b, i) => b.map((x, j) => x - points[i][j]));
    const along = steps.map(([x, y, z]) => Math.atan2(normal[2] * y - normal[1] * z, x));
    const wedge = along.map((direction, i) => // at the start of a piece
      i && Math.min(Math.abs(Math.tan((direction - along[i - 1]) / 2)), MAX_WEDGE));
    const on = (i, share) => ({ // at a part of the way along a piece
      batched_positions: points[i].map((x, j) => x + share * steps[i][j]),
      batched_wxyzs: [Math.cos(along[i] / 2), ...normal.map((x) => x * Math.sin(along[i] / 2))],
    });
    const pieces = steps.map((step, i) => {
      const middle = [0, 1, 2].map((j) => moved[4 * i + j] + moved[4 * i + 4 + j]);
      const value = data.strain ? beam.largest + now[4 * i + 3] : Math.hypot(...middle);
      const share = Math.min(Math.max(value / (2 * beam.largest), 0), 1);
      const colour = 3 * Math.round(share * (data.palette.length / 3 - 1));
      const wedges = (beam.thicknesses[i] / 2) * (wedge[i] + (wedge[i + 1] ?? 0));
      const scales = [Math.hypot(...step) + wedges, ...beam.sections[i]];
      const colours = { batched_colors: data.palette.slice(colour, colour + 3) };
      return { ...on(i, 0.5), batched_scales: scales, ...colours };
    });
    update(`${root}/rotor/beam`, pieces);
    update(`${root}/rotor/ends`, beam.capped.map((i) => pieces[i]));
    const body = (station) => {
      const piece = Math.min(station, pieces.length - 1);
      return on(piece, station - piece);
    };
    for (const [name, at] of Object.entries(beam.bodies)) update(name, at.map(body));
    for (const { name, station, above } of beam.labels_of_bodies)
      send("SetPositionMessage", name, { position: above.map((x, j) => x + points[station][j]) });
    const ring = (i, share, size) =>
      ({ ...on(i, share), batched_scales: size, batched_colors: beam.ring_colour });
    const [length, larger] = beam.ring;
    const rings = pieces.flatMap((_, i) => { // where the mode changes its sign
      const [u, v] = [i, i + 1].map((n) => state[size + 4 * n + beam.component]);
      const node = i && u * v < 0 && Math.abs(u - v) > MIN_STEP * data.resolution;
      const whole = [length, ...beam.sections[i].map((x) => larger * x)];
      return node ? [ring(i, u / (u - v), whole)] : [];
    });
    update(`${root}/rotor/nodes`, rings.length ? rings : [ring(0, 0, [0, 0, 0])]);
    const turn = (data.turning[1] * angle) / 2, wxyz = [Math.cos(turn), 0, 0, Math.sin(turn)];
    send("SetOrientationMessage", `${root}/${data.turning[0]}`, { wxyz });
  }

  function frame(now) {
    const passed = playing ? (data.rate * Math.min(now - before, 100)) / 1000 : 0;
    const viewer = window.__viserMutable;
    before = now;
    for (const label of data.beams.flatMap((beam) => beam.labels))
      phases[label] = (phases[label] ?? Math.PI / 2) + passed * data.frequencies[label][k];
    angle += passed * data.gammas[k];
    requestAnimationFrame(frame);
    if (!viewer?.camera || !viewer.nodeRefFromName[`${data.beams[0].root}/rotor/ends`]) return;
    const { clientWidth, clientHeight } = viewer.canvas; // the scene is fitted into a square
    viewer.cameraControl?.zoomTo(Math.min(1, clientWidth / clientHeight));
    data.beams.forEach(draw);
    viewer.requestRender();
  }

  /* Shows the speed that is chosen: its numbers, its place in the chart and its beam. */
  function choose() {
    k = Number(slider.value);
    shown.textContent = data.speeds[k];
    slider.setAttribute("aria-valuetext", data.speeds[k]);
    byId("numbers").innerHTML = data.numbers[k];
    const moved = data.factor * (data.gammas[k] - data.gammas[data.start]);
    const marker = chart?.querySelector("#marker");
    marker?.setAttribute("transform", `translate(${chart.dataset.step * moved})`);
    const body = { vertices: at(data.body), faces: data.faces };
    for (const { root } of data.beams) update(`${root}/rotor/equilibrium`, [body]);
    if (data.arrow)
      send("SetSceneNodeVisibilityMessage", data.arrow, { visible: data.gammas[k] > 0 });
    beamvizCaptions.show(data.captions[k]);
  }

  [slider.min, slider.max, slider.step, slider.value] = [0, data.gammas.length - 1, 1, k];
  slider.oninput = choose;
  button.onclick = () => {
    playing = !playing;
    button.textContent = playing ? "Pause" : "Play";
  };
  button.onclick();
  choose();
  requestAnimationFrame(frame);
})();
