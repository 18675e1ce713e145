/* The scene of an exported page at any of its solved speeds. */
(async () => {
  const { byId, send, update, ...offline } = beamvizOffline;
  /** @type {OfflineSpeeds} */
  const data = await offline.unpacked("speeds");
  const bodies = data.equilibria.map(({ vertices }) => vertices);
  const columns = [...bodies, ...data.beams.map(({ states }) => states)].flat();
  offline.undoSteps(columns, data.resolution); // between speeds
  const [slider, shown] = ["speed", "speed-shown"].map(byId), clock = offline.playButton();
  /** @type {Record<string, number>} */
  const phases = {};
  /** @type {HTMLElement | null} */
  const chart = document.querySelector("aside figure[data-step]");
  let angle = 0; // of the hub
  let k = data.start; // the solved speed that is shown

  /** @type {(numbers: number[][]) => number[]} at the present speed, from the values of each at all */
  const at = (numbers) => numbers.map((values) => values[k]);

  /**
   * Draws a beam at the present phases.
   * @param {VibratingBeam} beam
   */
  function draw(beam) {
    const state = at(beam.states), size = state.length / (1 + 2 * beam.modes.length);
    /** @param {number} number */
    const field = (number) => state.slice(number * size, (number + 1) * size);
    const moved = new Float32Array(size);
    beam.modes.forEach((mode, m) => {
      const s = Math.sin(phases[mode]), c = Math.cos(phases[mode]);
      const [real, imaginary] = [field(1 + 2 * m), field(2 + 2 * m)];
      for (let i = 0; i < size; i++) moved[i] += s * real[i] + c * imaginary[i];
    });
    offline.draw(data, beam, field(0), moved, field(1));
    if (beam.path) drawPath(beam, field, beam.path);
    offline.turn(data, beam, angle);
  }

  /**
   * Draws the path of the tip up to the present phases, as drawing/tip_path.py does.
   * @param {VibratingBeam} beam
   * @param {(number: number) => number[]} field
   * @param {[number, number, number]} limits
   */
  function drawPath({ root, modes }, field, [periods, most, samples]) {
    const rates = modes.map((mode) => data.frequencies[mode][k]), moving = rates.filter((rate) => rate > 0);
    if (!moving.length) return;
    const slowest = 2 * Math.PI / Math.min(...moving), fastest = 2 * Math.PI / Math.max(...moving);
    const span = moving.length > 1 ? Math.min(periods * slowest, most * fastest) : slowest;
    const [still, ...parts] = Array.from({ length: 1 + 2 * modes.length }, (_, n) => field(n).slice(-4, -1));
    const count = Math.ceil(samples * span / fastest - 1e-9);
    const points = Array.from({ length: count + 1 }, (_, i) => {
      const at = [...still];
      modes.forEach((mode, m) => {
        const phase = phases[mode] - rates[m] * span * (1 - i / count);
        const s = Math.sin(phase), c = Math.cos(phase);
        for (let j = 0; j < 3; j++) at[j] += s * parts[2 * m][j] + c * parts[2 * m + 1][j];
      });
      return at;
    });
    const ends = points.slice(1).flatMap((point, i) => [...points[i], ...point]);
    update(`${root}/rotor/tip_path`, [{ points: ends }]);
  }

  /** @param {number} seconds */
  function advance(seconds) {
    const passed = clock.playing ? data.rate * seconds : 0;
    for (const mode of data.beams.flatMap((beam) => beam.modes))
      phases[mode] = (phases[mode] ?? Math.PI / 2) + passed * data.frequencies[mode][k];
    angle += passed * data.gammas[k];
  }

  /* Shows the speed that is chosen: its numbers, its place in the chart and its beam. */
  function choose() {
    k = Number(slider.value);
    shown.textContent = data.speeds[k];
    slider.setAttribute("aria-valuetext", data.speeds[k]);
    byId("numbers").innerHTML = data.numbers[k];
    const moved = data.factor * (data.gammas[k] - data.gammas[data.start]);
    const marker = chart?.querySelector("#marker");
    marker?.setAttribute("transform", `translate(${Number(chart?.dataset.step) * moved})`);
    const rest = data.equilibria.map(({ vertices, faces }) => ({ vertices: at(vertices), faces }));
    for (const { root, equilibrium } of data.beams)
      if (rest[equilibrium]) update(`${root}/rotor/equilibrium`, [rest[equilibrium]]);
    if (data.arrow)
      send("SetSceneNodeVisibilityMessage", data.arrow, { visible: data.gammas[k] > 0 });
    beamvizCaptions.show(data.captions[k]);
  }

  [slider.min, slider.max, slider.step, slider.value] = [0, data.gammas.length - 1, 1, k].map(String);
  slider.oninput = choose;
  choose();
  offline.play(data, advance, () => data.beams.forEach(draw));
})();
