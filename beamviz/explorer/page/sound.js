/* The tones of the modes that swing, by WebAudio. The switch, which features/sound.py has on the page,
   names them: pairs of hertz and share; it is pressed here alone, so that no link can make a sound. */
"use strict";
const beamvizSound = (() => {
  const LOUDNESS = 0.2; // of all tones together, where 1 is the loudest
  const GLIDE = 0.03; // [s] in which a tone follows a change, without a click
  const AWAY = 0.3; // [s] after which a tone that has faded is stopped
  /** @type {AudioContext | null} */
  let audio = null;
  /** @type {{ oscillator: OscillatorNode, gain: GainNode }[]} */
  const voices = [];

  const button = () => /** @type {Part | null} */ (document.getElementById("sound"));

  /** @type {() => number[][]} */
  function wanted() {
    const e = button(), text = e?.ariaPressed === "true" ? e.dataset.tones : "";
    return text ? text.split(" ").map((tone) => tone.split(":").map(Number)) : [];
  }

  /** @param {AudioContext} context */
  function addVoice(context) {
    const oscillator = context.createOscillator(), gain = context.createGain();
    gain.gain.value = 0;
    oscillator.connect(gain).connect(context.destination);
    oscillator.start();
    voices.push({ oscillator, gain });
    return oscillator.frequency;
  }

  function play() {
    const tones = wanted();
    if (!audio) return;
    const now = audio.currentTime;
    tones.forEach(([hertz, share], k) => {
      if (!audio) return;
      if (k >= voices.length) addVoice(audio).value = hertz;
      voices[k].oscillator.frequency.setTargetAtTime(hertz, now, GLIDE);
      voices[k].gain.gain.setTargetAtTime(LOUDNESS * share, now, GLIDE);
    });
    for (const { oscillator, gain } of voices.splice(tones.length)) {
      gain.gain.setTargetAtTime(0, now, GLIDE);
      oscillator.stop(now + AWAY);
    }
  }

  function toggle() {
    const e = button();
    if (!e) return;
    e.ariaPressed = String(e.ariaPressed !== "true");
    audio ??= new AudioContext();
    void audio.resume();
    play();
  }

  document.addEventListener("click", (event) => {
    if (/** @type {Element} */ (event.target).closest?.("#sound")) toggle();
  });
  const section = document.getElementById("controls");
  const changes = { subtree: true, attributeFilter: ["data-tones", "aria-pressed"] };
  if (section) new MutationObserver(play).observe(section, changes);
  return { voices };
})();
