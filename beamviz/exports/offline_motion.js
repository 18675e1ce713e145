/* A motion in time on an exported page: play, pause, and any moment of it. */
(async () => {
  const PAUSE = 1.5; // [s] at the end, before it begins again
  const { byId, send, ...offline } = beamvizOffline;
  /** @type {OfflineMotion} */
  const data = await offline.unpacked("motion");
  const columns = data.beams.flatMap(({ fields, parts }) => [...fields, ...parts]);
  offline.undoSteps(columns, data.resolution);
  const [slider, shown] = ["time", "time-shown"].map(byId), clock = offline.playButton();
  /** @type {HTMLElement | null} */
  const chart = document.querySelector("aside figure[data-step]");
  const marker = chart?.querySelector("#marker"), last = data.angle.length - 1;
  let t = 0; // in parts of the whole motion
  let told = ""; // the captions

  /**
   * A value at the present time, from those at equal intervals.
   * @param {number[]} values
   */
  function at(values) {
    const k = Math.min(Math.floor(t * last), last - 1), share = t * last - k;
    return (1 - share) * values[k] + share * values[k + 1];
  }

  /**
   * The captions with the present speed, and without that of a mass that is not there.
   * @param {boolean} hasMass
   */
  function caption(hasMass) {
    const text = data.speed && data.speeds[Math.round(t * last)];
    if (`${text} ${hasMass}` === told) return;
    told = `${text} ${hasMass}`;
    for (const name of data.beams.flatMap(({ bodies }) => Object.keys(bodies)))
      send("SetSceneNodeVisibilityMessage", name, { visible: hasMass });
    const there = data.captions.filter(({ name }) => hasMass || !data.of_mass.includes(name));
    beamvizCaptions.show(there.map((one) => (one.name === data.speed ? { ...one, text } : one)));
  }

  function show() {
    for (const beam of data.beams) {
      const [still, ...shapes] = beam.fields, moved = new Float32Array(still.length);
      beam.parts.map(at).forEach((size, m) => {
        for (let i = 0; i < moved.length; i++) moved[i] += size * shapes[m][i];
      });
      offline.draw(data, beam, still, moved);
      offline.turn(data, beam, at(data.angle));
    }
    caption(data.with_mass[Math.floor(t * last)]);
  }

  /* Shows the numbers of the present moment, and its place in the chart. */
  function tell() {
    /** @param {OfflineMotion["readings"][0]} one */
    const text = ({ values, decimals }) => at(values).toFixed(decimals);
    const [time, ...others] = data.readings;
    others.forEach((one, k) => { byId(`reading-${k + 1}`).textContent = text(one); });
    shown.textContent = `${text(time)} ${time.unit}`;
    slider.setAttribute("aria-valuetext", shown.textContent);
    marker?.setAttribute("transform", `translate(${Number(chart?.dataset.step) * at(time.values)})`);
  }

  let over = 0; // [s] after the end

  /** @param {number} seconds */
  function advance(seconds) {
    if (!clock.playing) return;
    t += (data.rate * seconds) / data.until;
    over = t > 1 ? over + seconds : 0;
    t = over > PAUSE ? 0 : Math.min(t, 1);
    slider.value = String(t);
    tell();
  }

  [slider.min, slider.max, slider.step, slider.value] = ["0", "1", "any", "0"];
  slider.oninput = () => {
    clock.set(false);
    t = Number(slider.value);
    tell();
  };
  tell();
  offline.play(data, advance, show);
})();
