/* The charts of the page: a figure (figure.js) with buttons and a slider over it.

set(data) draws the chart; keys that are not given keep their values. All numbers are in the units
of the page.

  name     accessible name
  message  why there are no lines
  x, y     {label, symbol, unit, range: [from, to], log}
  at       x of the lines
  lines    [{label, y: [number or null], at: its own x, second, dots,
             runs: [[first, last, style, name] ...]}]: in runs of one style and one name
  keys     [{style, text}]: the key: styles of lines and marks
  perRev   {slope, multiples}: lines y = k slope x; the y axis ends where the last of them ends
  gaps     [[from, to, text] ...]: parts of the x axis without lines
  marks    [{key, kind, style, x, y, text, action, value}]: those with an action are buttons
  cursor   {action, x}: the line of the beam shown, and the action that sets x
  chosen   key of the mark at the beam                                                 */
const BeamvizChart = (() => {
  "use strict";
  const { Figure, TOP, clamp, escape, make, minus, px, valueAt } = beamvizFigure;
  const REACH = 14; // [px] from the pointer to a mark that it points at
  const FINGER = 22; // [px] the same for a finger
  /** @param {number} value */
  const significant = (value) =>
    minus(Math.abs(value) >= 1e4 ? value.toFixed(0) : Number(value.toPrecision(4)));

  return class ChartFigure extends Figure {
    /** @param {HTMLElement} host */
    constructor(host) {
      super(host, { lines: [], marks: [], gaps: [], keys: [] }, 1, "operating");
      /** @type {Map<string, HTMLElement>} */
      this.buttons = new Map(); // of the marks, by key
      /** @type {PlacedMark[]} */
      this.places = []; // of the marks
      const head = make(host, "div", { class: "chart-head" });
      host.prepend(head);
      this.keyList = make(head, "ul", { class: "key-list", "aria-label": "key" });
      this.zoom = make(head, "div", { class: "zoom", role: "group", "aria-label": "zoom", hidden: "" });
      /** @type {[string, string, () => void][]} */
      const zooms = [
        ["−", "Zoom out", () => this.zoomBy(2)],
        ["+", "Zoom in", () => this.zoomBy(0.5)],
        ["↔", "Show the whole range", () => this.show(null)],
      ];
      this.zooms = zooms.map(([text, label, act]) => {
        const button = make(this.zoom, "button", { type: "button", "aria-label": label, title: label }, text);
        button.onclick = act;
        return button;
      });
      this.flag = make(this.handle, "span", { class: "flag" });
      this.events = make(this.plot, "div", { class: "events", role: "group" });
    }

    /** @param {ChartUpdate} data */
    set(data) {
      const before = this.data;
      this.data = { ...before, ...data };
      this.lines = this.data.lines.map((line) => /** @type {Curve} */ ({ ...line, at: line.at ?? this.data.at }));
      if (JSON.stringify(this.data.x) !== JSON.stringify(before.x)) {
        const same = this.data.x.label === before.x?.label;
        this.view = this.drag && same ? this.view ?? before.x.range : null; // a drag keeps the axis
      }
      if (data.chosen && data.chosen !== before.chosen && !this.drag) this.reveal(data.chosen);
      this.render();
    }

    // The part of the x axis that is shown

    /** @param {[number, number] | null} view null for the whole range */
    show(view) {
      const [low, high] = this.data.x.range, whole = high - low;
      if (view) {
        const width = Math.max(view[1] - view[0], 1e-3 * whole);
        const start = clamp(view[0], low, high - width);
        view = width < whole ? [start, start + width] : null;
      }
      this.view = view;
      this.render();
    }

    /** @param {number} factor */
    zoomBy(factor, [centre] = this.place) {
      const [low, high] = this.range;
      if (!(centre >= low && centre <= high)) centre = (low + high) / 2;
      this.show([centre - (centre - low) * factor, centre + (high - centre) * factor]);
    }

    /**
     * Bring a mark into view, and zoom in where it is too close to the left end to be readable.
     * @param {string} key
     */
    reveal(key) {
      const mark = this.data.marks.find((one) => one.key === key);
      if (!mark) return; // as before the first data
      const [start, end] = this.data.x.range;
      this.hold([mark.x]);
      if (mark.x < this.range[0] || mark.x > this.range[1]) this.view = null;
      const distance = mark.x - start;
      if (distance > 0 && distance < 0.12 * (this.range[1] - start))
        this.view = /** @type {[number, number]} */ ([start, Math.min(start + 2.2 * distance, end)]);
    }

    /* Keep the line of the beam in view, except during a drag. */
    follow() {
      if (!this.view || this.drag) return;
      const [value] = this.place, [low, high] = this.view, [start, end] = this.data.x.range, width = high - low;
      if (low < start || high > end || (low === start && 2 * high <= end && this.dragged)) this.view = null;
      else if (value < low || value > high) {
        const first = clamp(value - width / 2, start, end - width);
        this.view = /** @type {[number, number]} */ ([first, first + width]);
      }
    }

    // Marks and the line of the beam

    render() {
      if (this.data.x) this.follow();
      if (!this.drawFigure()) return;
      const { x, y, cursor, name } = this.data;
      this.zoom.hidden = x.log || y.log || !cursor;
      this.zooms[0].disabled = this.zooms[2].hidden = !this.view;
      this.drawKeys();
      this.drawMarks();
      this.drawHandle(`${x.label}: line of this beam in the ${name}`);
      if (!this.handle.hidden) this.flag.textContent = this.describe(this.place);
      if (this.pointer) this.hover(this.pointer);
    }

    drawKeys() {
      const markup = this.data.keys.map(({ style, text, sign }) =>
        `<li><i class="key ${style}">${escape(sign)}</i>${escape(text)}</li>`).join("");
      if (this.keyList.innerHTML !== markup) this.keyList.innerHTML = markup;
    }

    drawMarks() {
      const { marks, chosen, name } = this.data;
      const old = new Map(this.buttons);
      this.events.setAttribute("aria-label", `Marks of the ${name}`);
      this.places = marks.map((mark) => ({ mark, x: this.px(mark.x), y: this.py(mark.y) }))
        .filter(({ x, y }) => x >= this.left - 1 && x <= this.right + 1 && y >= TOP - 1 && y <= this.bottom + 1);
      for (const { mark, x, y } of this.places) {
        const button = this.buttons.get(mark.key) ?? this.addMark(mark);
        old.delete(mark.key);
        button.className = mark.style;
        button.dataset.sign = mark.sign;
        button.style.translate = `${px(x)}px ${px(y)}px`;
        if (!mark.action) continue;
        button.setAttribute("aria-label", `Go to ${mark.text}`);
        button.ariaPressed = String(mark.key === chosen);
      }
      for (const [key, button] of old) {
        button.remove();
        this.buttons.delete(key);
      }
    }

    /** @param {Mark} mark */
    addMark({ key, action }) {
      const button = make(this.events, action ? "button" : "i", action ? { type: "button" } : {});
      const place = () => /** @type {PlacedMark} */ (this.places.find((one) => one.mark.key === key));
      button.onfocus = () => this.tell(place());
      button.onblur = () => this.hideReadout();
      button.onclick = (event) => { if (event.detail === 0) this.go(place().mark); }; // by keyboard
      this.buttons.set(key, button);
      return button;
    }

    // Pointer and keys

    /** @param {Pixel} pixel */
    nearest([x, y], reach = REACH) {
      /** @param {PlacedMark} one */
      const distance = (one) => Math.hypot(one.x - x, one.y - y);
      return this.places.filter((one) => distance(one) <= reach).sort((a, b) => distance(a) - distance(b))[0];
    }

    /**
     * @param {Pixel} pixel
     * @param {string} pointer
     */
    markAt(pixel, pointer) {
      const near = this.nearest(pixel, pointer === "touch" ? FINGER : REACH)?.mark;
      return near?.action ? near : null;
    }

    /** @param {Pixel} pixel */
    reaches([x]) { return x >= this.left - REACH && x <= this.right + 3 * REACH; }

    /**
     * @param {boolean} fine
     * @returns {Record<string, number[]>}
     */
    moves(fine) {
      const step = fine ? 1 : 5;
      return {
        ArrowRight: [step], ArrowUp: [step], ArrowLeft: [-step], ArrowDown: [-step],
        PageUp: [10 * step], PageDown: [-10 * step], Home: [-Infinity], End: [Infinity],
      };
    }

    /** @param {Mark} mark */
    go(mark) {
      this.hold([mark.x]);
      this.render();
      beamviz.sendAs(mark.action, mark.value ?? null, this.data.x.unit);
    }

    /**
     * Ctrl+wheel, or a pinch, zooms; a horizontal wheel moves the part that is shown.
     * @param {WheelEvent} event
     */
    wheel(event) {
      if (this.zoom.hidden || !this.isDrawn) return;
      const [low, high] = this.range;
      const shift = (event.deltaX * (high - low)) / (this.right - this.left);
      if (event.ctrlKey) this.zoomBy(1.002 ** event.deltaY, [this.px.invert(this.pixel(event)[0])]);
      else if (this.view && Math.abs(event.deltaX) > Math.abs(event.deltaY)) this.show([low + shift, high + shift]);
      else return;
      event.preventDefault();
    }

    // Reading values

    /** @param {Pixel} pixel */
    hover(pixel) {
      if (this.drag) return this.hideReadout();
      if (!this.isDrawn) return;
      const near = this.nearest(pixel), [x] = pixel;
      const onLine = this.data.cursor && Math.abs(this.px(this.place[0]) - x) < 8;
      this.plot.style.cursor = near?.mark.action ? "pointer" : onLine ? "ew-resize" : "";
      if (near) this.tell(near);
      else if (this.inside(pixel)) this.read(pixel);
      else this.hideReadout();
    }

    /**
     * Show the values of all lines at the pointer, the nearest in bold, with the gap to the next.
     * @param {Pixel} pixel
     */
    read(pixel) {
      const x = this.px.invert(pixel[0]), { unit } = this.data.y;
      /** @param {number} value */
      const number = (value) => `${significant(value)}${unit ? ` ${unit}` : ""}`;
      const rows = this.lines.filter((line) => line.label && !line.second && !line.dots).map((line) => {
        const [y, run] = valueAt(line, x);
        return { y, name: run?.[3] || line.label };
      }).filter((row) => !Number.isNaN(row.y)).sort((a, b) => b.y - a.y);
      if (!rows.length) return this.hideReadout();
      /** @typedef {typeof rows[0]} Row */
      /** @type {(others: Row[], distance: (row: Row) => number) => Row} */
      const closest = (others, distance) => others.reduce((a, b) => (distance(b) < distance(a) ? b : a));
      const near = closest(rows, (row) => Math.abs(this.py(row.y) - pixel[1]));
      /** @type {Styled[]} */
      const gap = [];
      if (rows.length > 1) {
        const next = closest(rows.filter((row) => row !== near), (row) => Math.abs(row.y - near.y));
        gap.push(["em", `gap ${near.name}–${next.name}\u2002${number(Math.abs(next.y - near.y))}`]);
      }
      /** @type {Styled[]} */
      const lines = rows.map((row) => ["span", `${row.name}\u2002${number(row.y)}`, row === near ? "near" : ""]);
      this.write(pixel, [["b", this.describe([x])], ...lines, ...gap]);
      this.hair.hidden = false;
      this.hair.style.translate = `${px(pixel[0])}px 0`;
    }

    /**
     * Show the text of a mark beside it.
     * @param {PlacedMark} place
     */
    tell({ mark, x, y }) {
      /** @type {Styled[]} */
      const action = mark.action ? [["em", "click to go there"]] : [];
      this.hair.hidden = true;
      this.write([x, y], [["b", mark.text], ...action]);
    }
  };
})();
