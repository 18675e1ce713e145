/* Texts at points of viser's scene, written over its picture, and the picture with them as a file.
   Each point is a node of the scene. */
"use strict";
const beamvizCaptions = (() => {
  const EDGE = 4; // [px] from the edge of the picture
  /** @type {Record<string, number>} */
  const SIDES = { top: 0, center: -0.5, bottom: -1, right: -0.5 }; // of the text at its point: its offset
  const TEXTS = "#captions > *, #legend, #transport"; // of a page, which hints do not cover
  /** @typedef {{ name: string, text: string, anchor: string, hint?: boolean }} Text name of the node, key of SIDES */
  /** @typedef {{ left: number, top: number, width: number, height: number }} Box [px] in the picture */
  /** @type {(Text & { element: HTMLElement, width: number, height: number })[]} */
  let captions = [];
  let frame = 0;
  const layerOf = () => /** @type {HTMLElement} */ (document.getElementById("caption-layer"));

  /** @param {Text[]} list */
  function show(list) {
    const layer = layerOf();
    layer.replaceChildren(...list.map(({ text, hint }) => {
      const element = document.createElement("span");
      element.textContent = text;
      element.className = hint ? "hint" : "";
      return element;
    }));
    captions = list.map((one, k) => {
      const element = /** @type {HTMLElement} */ (layer.children[k]);
      return { ...one, element, width: element.offsetWidth, height: element.offsetHeight };
    });
    cancelAnimationFrame(frame);
    place(); // before viser draws: it passes on messages within a frame, after the other callbacks
  }

  /** @type {(a: Box, b: Box) => boolean} */
  const overlap = (a, b) => a.left <= b.left + b.width && b.left <= a.left + a.width
    && a.top < b.top + b.height && b.top < a.top + a.height;

  /**
   * The texts of the page over the scene.
   * @param {HTMLElement} canvas
   * @returns {Box[]}
   */
  function textsOf(canvas) {
    const { left, top } = canvas.getBoundingClientRect();
    return [...document.querySelectorAll(TEXTS)].map((one) => one.getBoundingClientRect()).filter((box) => box.width)
      .map((box) => ({ left: box.left - left, top: box.top - top, width: box.width, height: box.height }));
  }

  /* Moves all texts to their points; one that would cover another is moved down. */
  function place() {
    frame = captions.length ? requestAnimationFrame(place) : 0;
    const canvas = beamvizViser.canvas();
    /** @type {Box[]} */
    const placed = [];
    if (!canvas) return;
    for (const one of captions) {
      const pixel = beamvizViser.pixel(one.name);
      one.element.hidden = !pixel;
      if (!pixel) continue;
      const across = canvas.clientWidth - one.width - EDGE;
      const before = one.anchor === "right" ? 1 : 0.5; // the part of the text left of the point
      const left = Math.max(EDGE, Math.min(pixel[0] - before * one.width, across));
      let top = pixel[1] + SIDES[one.anchor] * one.height;
      const box = { left, top, width: one.width, height: one.height };
      const others = one.hint ? [...placed, ...textsOf(canvas)] : placed;
      for (const other of others) if (overlap(box, other)) top = box.top = other.top + other.height;
      const isCut = top + one.height > canvas.clientHeight;
      one.element.hidden = Boolean(one.hint && (isCut || others.some((other) => overlap(box, other))));
      placed.push(box);
      one.element.style.transform = `translate(${left.toFixed(1)}px, ${top.toFixed(1)}px)`;
    }
  }

  /**
   * The scene as it is on the screen, as a PNG.
   * @param {(png: Blob) => void} done is called with it
   */
  function picture(done) {
    const canvas = beamvizViser.canvas();
    if (!canvas) return;
    beamvizViser.render();
    requestAnimationFrame(() => { // right after viser has drawn: later its canvas is empty
      const { width, height } = canvas, layer = layerOf();
      const copy = Object.assign(document.createElement("canvas"), { width, height });
      const context = /** @type {CanvasRenderingContext2D} */ (copy.getContext("2d"));
      const box = canvas.getBoundingClientRect();
      const colour = getComputedStyle(/** @type {HTMLElement} */ (layer.parentElement));
      context.fillStyle = colour.backgroundColor;
      context.fillRect(0, 0, width, height);
      context.drawImage(beamvizPlainScene.canvas() ?? canvas, 0, 0, width, height);
      context.scale(width / box.width, height / box.height);
      context.translate(-box.left, -box.top);
      context.textAlign = "center";
      for (const text of /** @type {Iterable<HTMLElement>} */ (layer.children)) {
        if (text.hidden || text.className) continue; // also a hint
        const { left, top, right, bottom } = text.getBoundingClientRect();
        const { fontSize, fontFamily, color, backgroundColor } = getComputedStyle(text);
        const font = `${fontSize} ${fontFamily}`; // the shorthand is empty if it cannot say all
        context.fillStyle = backgroundColor;
        context.fillRect(left, top, right - left, bottom - top);
        Object.assign(context, { font, fillStyle: color });
        const { fontBoundingBoxAscent: up, fontBoundingBoxDescent: down } = context.measureText("x");
        const baseline = (top + bottom + up - down) / 2;
        context.fillText(text.textContent ?? "", (left + right) / 2, baseline);
      }
      copy.toBlob((png) => png && done(png));
    });
  }

  return { show, picture };
})();
