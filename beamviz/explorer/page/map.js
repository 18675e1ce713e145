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
  cursor   {action, x, y}: the beam shown, and the action that sets "x y"                           */
const BeamvizMap = (() => {
  "use strict";
  const { Figure, TOP, clamp, make, minus, px } = beamvizFigure;

  return class MapFigure extends Figure {
    /** @param {HTMLElement} host */
    constructor(host) {
      super(host, {}, 2, "place");
      this.plot.classList.add("map");
      this.field = make(this.plot, "div", { class: "field-of-map" });
      this.plot.prepend(this.field);
      this.canvas = make(this.field, "canvas", { "aria-hidden": "true" });
    }

    /** @param {ChartUpdate} data */
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
      const context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d")), image = context.createImageData(columns, rows);
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
      const width = this.right - this.left, height = this.bottom - TOP;
      const across = width / (columns - 1), up = height / (rows - 1); // of a beam, in its middle
      Object.assign(this.field.style, { left: `${this.left}px`, top: `${TOP}px`, width: `${width}px`, height: `${height}px` });
      Object.assign(this.canvas.style, {
        left: `${-across / 2}px`, top: `${-up / 2}px`, width: `${width + across}px`, height: `${height + up}px`,
      });
      this.drawHandle("This beam in the map");
      if (this.pointer) this.hover(this.pointer);
    }

    /* Borders of regions. */
    paths() {
      const lines = this.data.borders.map(([xs, ys]) =>
        `M${xs.map((x, k) => `${px(this.px(x ?? 0))} ${px(this.py(ys[k] ?? 0))}`).join("L")}`);
      return `<path class="border" d="${lines.join("")}"/>`;
    }

    labels() {
      /** @type {{ left: number, at: number, half: number, text: string }[]} */
      const placed = [];
      for (const { x, y, text } of this.data.regions) {
        const half = 4 * text.length + 8, at = this.py(y);
        const left = clamp(this.px(x), this.left + half, this.right - half);
        const free = placed.every((one) => Math.abs(one.at - at) > 18 || Math.abs(one.left - left) > one.half + half);
        if (free) placed.push({ left, at, half, text });
      }
      return placed.map(({ left, at, text }) => this.text("region", left, at + 5, text)).join("");
    }

    /**
     * @param {boolean} fine
     * @returns {Record<string, number[]>}
     */
    moves(fine) {
      const step = fine ? 1 : 5;
      return {
        ArrowRight: [step, 0], ArrowLeft: [-step, 0], ArrowUp: [0, step], ArrowDown: [0, -step],
        PageUp: [0, 10 * step], PageDown: [0, -10 * step], Home: [-Infinity, 0], End: [Infinity, 0],
      };
    }

    /**
     * Show the value at the pointer.
     * @param {Pixel} pixel
     */
    hover(pixel) {
      if (!this.isDrawn || !this.inside(pixel)) return this.hideReadout();
      const { columns, values, value } = this.data, rows = values.length / columns;
      const column = Math.round(((pixel[0] - this.left) / (this.right - this.left)) * (columns - 1));
      const row = Math.round(((this.bottom - pixel[1]) / (this.bottom - TOP)) * (rows - 1));
      const one = values[row * columns + column];
      const found = one === null ? "no frequency" : `${value.symbol} ${minus(Number(one.toPrecision(3)))} ${value.unit}`;
      const place = this.coordinates.map(({ scale }, k) => scale.invert(pixel[k]));
      this.write(pixel, [["b", this.describe(place)], ["span", found]]);
    }
  };
})();
