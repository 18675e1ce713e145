/* Maps of the page: a quantity in colours over two numbers (axes by figure.js). set(data) draws the
   map; keys that are not given keep their values. Data, in the units of the page:

  name     accessible name
  x, y     {label, symbol, unit, range: [from, to]}
  columns  number of columns of
  values   [number or null], row by row from the bottom
  colours  [[red, green, blue] ...] from the smallest to the largest of
  range    [from, to]
  value    {symbol, unit} of the values
  borders  [[[x ...], [y ...]] ...]: lines between regions
  regions  [{x, y, text}]: their names, as far as there is room
  beam     [x, y]: the beam shown; it is moved by a press on the map, by dragging and by keys      */
const BeamvizMap = (() => {
  "use strict";
  const { Figure, LEFT, TOP, clamp, fixed, make, neat, px, set, withUnit } = beamvizFigure;
  const CLICK = 6; // [px] a touch that moves less is a tap

  return class MapFigure extends Figure {
    constructor(host) {
      super(host);
      this.plot.classList.add("map");
      this.field = make(this.plot, "div", { class: "field-of-map" });
      this.plot.prepend(this.field);
      this.canvas = make(this.field, "canvas", { "aria-hidden": true });
      this.ring = make(this.plot, "div", { class: "place", role: "slider", tabindex: 0, hidden: "" });
      this.ring.addEventListener("keydown", (event) => this.key(event));
    }

    get value() { return NaN; } // no tick is covered

    get place() { return this.own?.value ?? this.data.beam ?? [NaN, NaN]; }

    set(data) {
      const before = this.data.values;
      this.data = { ...this.data, ...data };
      if (this.data.values !== before) this.paint();
      this.render();
    }

    /* One pixel for each value; the browser enlarges and smooths them. */
    paint() {
      const { columns, values, colours, range: [low, high] } = this.data;
      const rows = values.length / columns, last = colours.length - 1;
      Object.assign(this.canvas, { width: columns, height: rows });
      const context = this.canvas.getContext("2d"), image = context.createImageData(columns, rows);
      values.forEach((value, k) => {
        if (value === null) return; // transparent
        const share = clamp((value - low) / (high - low || 1), 0, 1) * last;
        const before = Math.min(Math.floor(share), last - 1), part = share - before;
        const at = 4 * ((rows - 1 - Math.floor(k / columns)) * columns + (k % columns));
        for (let c = 0; c < 3; c++)
          image.data[at + c] = (1 - part) * colours[before][c] + part * colours[before + 1][c];
        image.data[at + 3] = 255;
      });
      context.putImageData(image, 0, 0);
    }

    render() {
      if (!this.drawFigure()) return;
      const { columns, values } = this.data, rows = values.length / columns;
      const width = this.right - LEFT, height = this.bottom - TOP;
      const across = width / (columns - 1), up = height / (rows - 1); // of a beam, in its middle
      Object.assign(this.field.style, { left: `${LEFT}px`, top: `${TOP}px`, width: `${width}px`, height: `${height}px` });
      Object.assign(this.canvas.style, {
        left: `${-across / 2}px`, top: `${-up / 2}px`, width: `${width + across}px`, height: `${height + up}px`,
      });
      this.drawRing();
    }

    /* Borders of regions. */
    paths() {
      const lines = this.data.borders.map(([xs, ys]) =>
        `M${xs.map((x, k) => `${px(this.px(x))} ${px(this.py(ys[k]))}`).join("L")}`);
      return `<path class="border" d="${lines.join("")}"/>`;
    }

    labels() {
      const placed = [];
      for (const { x, y, text } of this.data.regions) {
        const half = 4 * text.length, at = this.py(y);
        const left = clamp(this.px(x), LEFT + half, this.right - half);
        const free = placed.every((one) => Math.abs(one.at - at) > 18 || Math.abs(one.left - left) > one.half + half);
        if (free) placed.push({ left, at, half, text });
      }
      return placed.map(({ left, at, text }) => this.text("region", left, at + 5, text)).join("");
    }

    drawRing() {
      const [x, y] = this.place, { x: along, y: up } = this.data;
      const inside = [[x, along], [y, up]].every(([v, axis]) => v >= axis.range[0] && v <= axis.range[1]);
      this.ring.hidden = !inside;
      if (!inside) return;
      const text = this.describe(x, y);
      this.ring.style.translate = `${px(this.px(x))}px ${px(this.py(y))}px`;
      set(this.ring, {
        "aria-label": "This beam in the map", "aria-valuemin": along.range[0],
        "aria-valuemax": along.range[1], "aria-valuenow": Number(x.toPrecision(6)), "aria-valuetext": text,
      });
    }

    // Places

    get steps() {
      const size = [this.right - LEFT, this.bottom - TOP];
      return [this.data.x, this.data.y].map(({ range }, k) => neat((range[1] - range[0]) / Math.max(size[k], 100)));
    }

    describe(x, y) {
      const [first, second] = this.steps;
      return `${withUnit(this.data.x, fixed(x, first))}, ${withUnit(this.data.y, fixed(y, second))}`;
    }

    choose(pixels) {
      const x = this.px.invert(clamp(pixels[0], LEFT, this.right));
      const y = this.py.invert(clamp(pixels[1], TOP, this.bottom));
      this.setPlace([x, y]);
    }

    /* Show a point immediately, and send it. */
    setPlace(place) {
      const axes = [this.data.x, this.data.y];
      place = place.map((value, k) => {
        const step = this.steps[k];
        return Number(clamp(Math.round(value / step) * step, ...axes[k].range).toPrecision(9));
      });
      this.hold(place);
      this.drawRing();
      beamviz.sendOften("move_beam", place.join(" "));
    }

    press(event) {
      const pixels = this.pixel(event);
      if (event.button !== 0 || !this.px || !this.inside(pixels)) return;
      this.pressed = pixels;
      if (event.pointerType !== "mouse") return; // it may be the start of a scroll
      event.preventDefault();
      this.plot.setPointerCapture(event.pointerId);
      this.choose(pixels);
      this.ring.focus({ preventScroll: true });
    }

    move(event) {
      const pixels = this.pixel(event);
      if (this.pressed && event.pointerType === "mouse") this.choose(pixels);
      this.read(pixels);
    }

    letGo() { this.pressed = null; }

    leave() { this.readout.hidden = true; }

    release(event) {
      const pixels = this.pixel(event), before = this.pressed;
      this.pressed = null;
      if (before && event.pointerType !== "mouse" && Math.hypot(pixels[0] - before[0], pixels[1] - before[1]) < CLICK)
        this.choose(pixels);
    }

    key(event) {
      const steps = event.shiftKey ? 50 : 5;
      const move = this.taken(event, {
        ArrowRight: [steps, 0], ArrowLeft: [-steps, 0], ArrowUp: [0, steps], ArrowDown: [0, -steps],
      });
      if (move) this.setPlace(this.place.map((value, k) => value + move[k] * this.steps[k]));
    }

    /* Show the value at the pointer. */
    read(pixels) {
      this.readout.hidden = !this.px || !this.inside(pixels);
      if (this.readout.hidden) return;
      const { columns, values, value } = this.data, rows = values.length / columns;
      const column = Math.round(((pixels[0] - LEFT) / (this.right - LEFT)) * (columns - 1));
      const row = Math.round(((this.bottom - pixels[1]) / (this.bottom - TOP)) * (rows - 1));
      const one = values[row * columns + column];
      this.readout.replaceChildren();
      make(this.readout, "b", {}, this.describe(this.px.invert(pixels[0]), this.py.invert(pixels[1])));
      const found = one === null ? "no frequency" : `${value.symbol} ${Number(one.toPrecision(3))} ${value.unit}`;
      make(this.readout, "span", {}, found);
      this.put(pixels);
    }
  };
})();
