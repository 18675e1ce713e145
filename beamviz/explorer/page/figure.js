/* The common part of charts (chart.js) and maps (map.js): axes, lines with their labels, gaps, the
   text at the pointer, and the place of the beam shown, along x or in both directions, which is
   moved by a press, by dragging and by keys. Subclasses document their data. */
const beamvizFigure = (() => {
  "use strict";
  const TOP = 20, LEFT = 62; // [px] of the margins, LEFT at least
  const TITLE = 26; // [px] beside the labels of the y axis
  const LOW = 200; // [px] a chart that is less high has no row for the title of its x axis
  const LETTERS = 15; // [px] height of a label
  const LETTER = 9; // [px] width of a letter or digit
  const BETWEEN = 8; // [px] from a label to the next beside it
  const HOLD = 600; // [ms] during which a place set here is shown instead of the server's
  const CLICK = 4; // [px] a touch that moves less, or up or down, is a tap or a scroll
  /** @type {Record<string, string>} */
  const SIGNS = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" };
  /** @param {string} text */
  const escape = (text) => text.replace(/[&<>"]/g, (sign) => SIGNS[sign]);
  /** @type {(value: number, low: number, high: number) => number} */
  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  /** @param {number} value */
  const px = (value) => value.toFixed(1);

  /**
   * @param {Element} element
   * @param {Record<string, string | number>} attributes
   */
  function set(element, attributes) {
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  }

  /**
   * A new element at the end of another.
   * @template {keyof HTMLElementTagNameMap} Tag
   * @param {Element} parent
   * @param {Tag} tag
   * @param {Record<string, string | number>} attributes
   */
  function make(parent, tag, attributes = {}, text = "") {
    const made = document.createElement(tag);
    set(made, attributes);
    made.textContent = text;
    return parent.appendChild(made);
  }

  /**
   * @param {[number, number]} range
   * @param {boolean} log
   * @param {number} start
   * @param {number} end
   * @returns {Scale}
   */
  function scale(range, log, start, end) {
    /** @type {(value: number) => number} */
    const to = log ? Math.log10 : (v) => v;
    /** @type {(value: number) => number} */
    const back = log ? (v) => 10 ** v : (v) => v;
    const low = to(range[0]), rate = (end - start) / (to(range[1]) - low);
    /** @param {number} value */
    const position = (value) => start + (to(value) - low) * rate;
    /** @param {number} pixel */
    position.invert = (pixel) => back(low + (pixel - start) / rate);
    return position;
  }

  /**
   * The largest of 1, 2 or 5 times a power of ten up to `value`.
   * @param {number} value
   */
  function neat(value) {
    const power = 10 ** Math.floor(Math.log10(value));
    return power * ([5, 2].find((digit) => digit * power <= value * (1 + 1e-9)) ?? 1);
  }

  /**
   * The text of a number with a true minus sign, and none before zero.
   * @param {number | string} number
   */
  const minus = (number) => String(number).replace(/^-(0\.?0*)$/, "$1").replace(/^-/, "\u2212");

  /**
   * A number with the decimals of a step.
   * @param {number} value
   * @param {number} step
   */
  function fixed(value, step) {
    return minus(value.toFixed(clamp(Math.ceil(-Math.log10(step) - 1e-9), 0, 9)));
  }

  /** @type {(axis: Axis, text: string) => string} */
  const withUnit = (axis, text) => (axis.unit ? `${text} ${axis.unit}` : `${axis.symbol} = ${text}`);
  /** @param {number} k */
  const superscript = (k) => [...String(k)].map((c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]).join("");
  /** @param {number} k */
  const power = (k) => `10${superscript(k)}`;
  /** @param {number} k */
  const plain = (k) => String(Number((10 ** k).toPrecision(1)));

  /**
   * Numbers and texts of about `count` ticks.
   * @param {[number, number]} range
   * @param {boolean} log
   * @param {number} count
   */
  function ticks([low, high], log, count) {
    /** @type {[number, string][]} */
    const made = [];
    if (log) {
      const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9);
      const step = Math.max(1, Math.ceil((last - first) / count));
      const write = first > -3 && last < 4 ? plain : power;
      for (let k = first; k <= last; k += step) made.push([10 ** k, write(k)]);
      return made;
    }
    const least = (high - low) / Math.max(count, 1), below = neat(least);
    const larger = neat(5 * below);
    const step = [below, neat(2 * below), neat(2.5 * below)].find((s) => s >= least * 0.99) ?? larger;
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high * (1 + 1e-9); k++)
      made.push([k * step, fixed(k * step, step)]);
    return made;
  }

  /**
   * The y of a line at x, NaN where it has none, and the run it is in there.
   * @param {Pick<Curve, "at" | "y" | "runs">} line
   * @param {number} x
   * @returns {[number, ChartLine["runs"][0] | undefined]}
   */
  function valueAt({ at, y, runs }, x) {
    if (!(x >= at[0] && x <= at[at.length - 1])) return [NaN, undefined];
    const after = clamp(at.findIndex((one) => one >= x), 1, at.length - 1), before = after - 1;
    const share = (x - at[before]) / (at[after] - at[before] || 1);
    const run = runs.find(([first, last]) => before >= first && after <= last) ?? runs.at(-1);
    if (share === 0 || share === 1) return [y[share ? after : before] ?? NaN, run];
    const [left, right] = [y[before], y[after]];
    if (left === null || right === null) return [NaN, run];
    return [left + share * (right - left), run];
  }

  /**
   * Ascending positions, moved as little as needed to be `least` apart, up to `end`.
   * @param {number[]} places
   * @param {number} least
   * @param {number} end
   */
  function spread(places, least, end) {
    /** @type {number[]} */
    const moved = [];
    for (const place of places) moved.push(Math.max(place, (moved.at(-1) ?? -Infinity) + least));
    for (let k = moved.length - 1, limit = end; k >= 0; limit = moved[k--] - least)
      moved[k] = Math.min(moved[k], limit);
    return moved;
  }

  class Figure {
    /**
     * @param {HTMLElement} host
     * @param {ChartUpdate} data of which the rest comes by `set`, before the first drawing
     * @param {number} dimensions of the place
     * @param {string} style of its handle
     */
    constructor(host, data, dimensions, style) {
      this.host = host;
      this.data = /** @type {Required<ChartUpdate>} */ (data);
      this.dimensions = dimensions;
      // of the drawing: its scales, the sides of its frame, the width of a label
      this.px = this.py = scale([0, 1], false, 0, 1);
      this.left = LEFT;
      this.right = this.bottom = this.letters = 0;
      this.ruler = /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));
      this.isDrawn = this.low = false;
      // of the pointer
      /** @type {{ pixel: Pixel, mark: Mark | null } | null} */
      this.pressed = null;
      /** @type {Pixel | null} */
      this.pointer = null;
      this.drag = this.dragged = false;
      /** @type {Curve[]} */
      this.lines = []; // those of the data, each with an x of its own
      /** @type {[number, number] | null} */
      this.view = null; // the part of the x axis that is shown, null for all of it
      /** @type {HTMLElement | null} */
      this.flag = null;
      /** @type {{ place: number[], until: number } | null} */
      this.own = null; // a place set here
      this.plot = make(host, "div", { class: "plot" });
      this.plot.innerHTML = "<svg></svg>";
      this.svg = this.plot.children[0];
      this.readout = make(this.plot, "div", { class: "readout", "aria-hidden": "true", hidden: "" });
      this.hair = make(this.plot, "div", { class: "hair", hidden: "" });
      this.handle = make(this.plot, "div", { class: style, role: "slider", tabindex: 0, hidden: "" });
      this.handle.addEventListener("keydown", (event) => this.key(event));
      this.plot.onpointerdown = (event) => this.press(event);
      this.plot.onpointermove = (event) => this.move(event);
      this.plot.onpointerup = (event) => this.release(event);
      this.plot.onpointercancel = () => this.letGo();
      this.plot.onpointerleave = () => this.leave();
      this.plot.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
      new ResizeObserver(() => this.render()).observe(this.plot);
    }

    // What subclasses draw and do

    render() {}
    /** @param {number[]} pixel */
    hover(pixel) {}
    /**
     * @param {boolean} fine in the finest steps, by Shift
     * @returns {Record<string, number[]>} the steps of the place, by key
     */
    moves(fine) { return {}; }
    /** @param {Mark} mark */
    go(mark) {}
    /** @param {WheelEvent} event */
    wheel(event) {}

    /**
     * The pixel of a pointer event.
     * @param {MouseEvent} event
     * @returns {Pixel}
     */
    pixel(event) {
      const { left, top } = this.plot.getBoundingClientRect();
      return [event.clientX - left, event.clientY - top];
    }

    /** @param {Pixel} pixel */
    inside([x, y]) { return x >= this.left && x <= this.right && y >= TOP && y <= this.bottom; }

    /**
     * Shows lines of text beside a pixel.
     * @param {Pixel} pixel
     * @param {Styled[]} lines
     */
    write([x, y], lines) {
      this.readout.replaceChildren();
      for (const [tag, text, style = ""] of lines) make(this.readout, tag, { class: style }, text);
      this.readout.hidden = false;
      const { offsetWidth: width, offsetHeight: height } = this.readout;
      const { clientWidth, clientHeight } = this.plot;
      const left = x + 14 + width < clientWidth ? x + 14 : x - 14 - width;
      const top = clamp(y - height / 2, 0, Math.max(clientHeight - height, 0));
      this.readout.style.translate = `${clamp(left, 0, Math.max(clientWidth - width, 0))}px ${top}px`;
    }

    hideReadout() { this.readout.hidden = this.hair.hidden = true; }

    // The place of the beam shown

    get place() {
      const { x, y = NaN } = this.data.cursor ?? { x: NaN };
      return this.own?.place ?? [x, y].slice(0, this.dimensions);
    }

    /* The coordinates of the place: their axes, the ranges that are shown, the scales, the pixels of
       the ends, and round steps of at most a pixel. */
    get coordinates() {
      const { x, y } = this.data;
      /** @type {Omit<Coordinate, "step">[]} */
      const both = [
        { axis: x, range: this.range, scale: this.px, start: this.left, end: this.right },
        { axis: y, range: this.yRange, scale: this.py, start: TOP, end: this.bottom },
      ];
      return both.slice(0, this.dimensions).map((one) => (
        { ...one, step: neat((one.range[1] - one.range[0]) / Math.max(one.end - one.start, 100)) }));
    }

    /** @param {number[]} place */
    describe(place) {
      return this.coordinates.map(({ axis, step }, k) => withUnit(axis, fixed(place[k], step))).join(", ");
    }

    /** @param {number[]} place */
    hold(place) {
      this.own = { place, until: performance.now() + HOLD };
      setTimeout(() => this.render(), HOLD + 10);
    }

    /**
     * Shows the place nearest to this one immediately, and sends it.
     * @param {number[]} wanted
     */
    setPlace(wanted) {
      const place = this.coordinates.map(({ axis, step }, k) =>
        Number(clamp(Math.round(wanted[k] / step) * step, axis.range[0], axis.range[1]).toPrecision(9)));
      if (!this.data.cursor || String(place) === String(this.place)) return;
      this.hold(place);
      this.render();
      beamviz.sendOften(this.data.cursor.action, place.length > 1 ? place.join(" ") : place[0], this.data.x.unit);
    }

    /** @param {string} label */
    drawHandle(label) {
      const [{ axis }] = this.coordinates, place = this.place;
      this.handle.hidden = !this.coordinates.every(({ range }, k) => place[k] >= range[0] && place[k] <= range[1]);
      if (this.handle.hidden) return;
      const [x, y] = this.coordinates.map(({ scale }, k) => px(scale(place[k])));
      this.handle.style.translate = `${x}px ${y ?? 0}px`;
      set(this.handle, {
        "aria-label": label, "aria-valuemin": axis.range[0], "aria-valuemax": axis.range[1],
        "aria-valuenow": Number(place[0].toPrecision(6)), "aria-valuetext": this.describe(place),
      });
    }

    /**
     * Moves the place by steps; viser does not get the key then, as it would move its camera.
     * @param {KeyboardEvent} event
     */
    key(event) {
      const move = this.moves(event.shiftKey)[event.key];
      if (!move || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation();
      this.setPlace(this.coordinates.map(({ step }, k) => this.place[k] + move[k] * step));
    }

    // The pointer: a click on a mark goes there, elsewhere it moves the place

    /**
     * @param {Pixel} pixel
     * @param {string} pointer its type
     * @returns {Mark | null}
     */
    markAt(pixel, pointer) { return null; }

    /**
     * Whether a press at a pixel moves the place.
     * @param {Pixel} pixel
     */
    reaches(pixel) { return this.inside(pixel); }

    /** @param {PointerEvent} event */
    press(event) {
      if (event.button !== 0 || !this.isDrawn) return;
      const pixel = this.pixel(event);
      this.pressed = { pixel, mark: this.markAt(pixel, event.pointerType) };
      this.plot.setPointerCapture(event.pointerId);
      if (event.pointerType !== "mouse") return; // a touch may be the start of a scroll
      event.preventDefault();
      if (!this.pressed.mark) this.dragTo(pixel);
    }

    /** @param {PointerEvent} event */
    move(event) {
      const pixel = this.pixel(event);
      this.pointer = event.pointerType === "mouse" && !this.pressed ? pixel : null;
      const across = this.pressed ? Math.abs(pixel[0] - this.pressed.pixel[0]) : 0;
      if (this.drag || across > CLICK) this.dragTo(pixel);
      else this.hover(pixel);
    }

    /** @param {PointerEvent} event */
    release(event) {
      if (this.pressed?.mark && !this.drag) this.go(this.pressed.mark);
      else if (this.pressed && !this.drag) this.dragTo(this.pixel(event));
      this.letGo();
    }

    letGo() {
      this.dragged = this.drag;
      this.pressed = null;
      this.drag = false;
      this.plot.classList.remove("dragging");
      if (this.dragged) this.render();
      this.dragged = false;
    }

    leave() {
      this.pointer = null;
      this.hideReadout();
    }

    /** @param {Pixel} pixel */
    dragTo(pixel) {
      if (!this.data.cursor || !(this.drag || this.reaches(pixel))) return;
      this.drag = true;
      this.plot.classList.add("dragging");
      this.setPlace(this.coordinates.map(({ scale, start, end }, k) => scale.invert(clamp(pixel[k], start, end))));
      this.handle.focus({ preventScroll: true });
      this.hover(pixel);
    }

    // The axes

    /** @returns {[number, number]} */
    get range() { return this.view ?? this.data.x.range; }

    /** @returns {[number, number]} */
    get yRange() {
      const { y, perRev } = this.data;
      if (!perRev) return y.range;
      const steepest = Math.max(...perRev.multiples) * perRev.slope * this.range[1];
      const loci = this.lines.filter((line) => line.label || line.second);
      const lowest = Math.min(...loci.map((line) => Math.max(...line.y.map(Number)))); // all of it is seen
      return [y.range[0], Math.min(y.range[1], 1.05 * Math.max(steepest, lowest))];
    }

    // Drawing

    /* Draws axes, lines, labels and the rings at the line of the beam; false if there is no room. */
    drawFigure() {
      const { x, y, name, message = "" } = this.data;
      if (this.own && !this.pressed && performance.now() > this.own.until) this.own = null;
      const { clientWidth: width, clientHeight: height } = this.plot;
      if (!x || !width || !height) return false;
      this.letters = 4 + LETTER * Math.max(3, ...this.lines.map((line) => line.label.length));
      this.low = height < LOW;
      this.bottom = height - (this.low ? 24 : 42);
      this.plot.style.setProperty("--bottom", `${height - this.bottom}px`);
      this.isDrawn = true;
      this.py = scale(this.yRange, y.log, this.bottom, TOP);
      const widest = Math.max(...this.yTicks.map(([, content]) => content.length));
      this.left = Math.max(LEFT, LETTER * widest + TITLE);
      for (let needed = this.letters, room = 0; needed > room;) { // for the labels beside the chart
        room = needed;
        this.right = width - 8 - room;
        this.px = scale(this.range, x.log, this.left, this.right);
        needed = Math.max(...this.besideLabels().map((one) => one.x + one.width - BETWEEN - this.right));
      }
      const frame = `x="${this.left}" y="${TOP}" width="${this.right - this.left}" height="${this.bottom - TOP}"`;
      set(this.svg, { role: "img", "aria-label": name });
      this.svg.innerHTML = `<clipPath id="clip-${this.host.id}"><rect ${frame}/></clipPath>${this.axes()}`
        + `<g clip-path="url(#clip-${this.host.id})">${this.gaps()}${this.paths()}</g>`
        + this.labels() + this.rings() + this.message(this.left, this.right, message);
      return true;
    }

    /** @type {(style: string, x: number, y: number, content: string) => string} */
    text(style, x, y, content) {
      return `<text class="${style}" x="${px(x)}" y="${px(y)}">${escape(content)}</text>`;
    }

    /**
     * A text in the middle between two pixels along x, if there is room.
     * @param {number} start
     * @param {number} end
     * @param {string} content
     */
    message(start, end, content) {
      const fits = end - start > 7.5 * content.length;
      return fits ? this.text("message", (start + end) / 2, (TOP + this.bottom) / 2, content) : "";
    }

    get yTicks() { return ticks(this.yRange, this.data.y.log, (this.bottom - TOP) / 30); }

    axes() {
      const { x, y } = this.data, right = this.right, bottom = this.bottom;
      const short = bottom - TOP < 130; // only the symbol with its unit has room beside the axis
      const title = (short && y.label.match(/\S+ \[.*\]$/)?.[0]) || y.label;
      const flag = this.flag && this.data.cursor ? this.describe(this.place).length : 0;
      let made = "", beside = right + 16;
      for (const [value, content] of ticks(this.range, x.log, (right - this.left) / 70)) {
        const at = this.px(value), half = LETTER * (flag + content.length) / 2 + 12; // of the flag and the tick
        const covered = flag && Math.abs(at - this.px(this.place[0])) < half;
        made += `<path class="grid" d="M${px(at)} ${TOP}V${bottom}"/>`;
        if (covered) continue;
        made += this.text("tick", at, bottom + 17, content);
        beside = Math.max(beside, at + LETTER * content.length / 2 + 6);
      }
      for (const [value, content] of this.yTicks) {
        const at = this.py(value);
        made += `<path class="grid" d="M${this.left} ${px(at)}H${right}"/>`;
        made += this.text("tick y", this.left - 7, Math.min(at + 4.5, bottom + 1), content); // above the flag
      }
      return `${made}<path class="axis" d="M${this.left} ${bottom}H${right}"/>`
        + (this.low ? this.text("unit", beside, bottom + 17, x.unit || x.symbol)
          : this.text("title", (this.left + right) / 2, bottom + 37, x.label))
        + `<text class="title" transform="translate(13 ${(TOP + bottom) / 2}) rotate(-90)">${escape(title)}</text>`;
    }

    gaps() {
      return (this.data.gaps ?? []).map(([from, to, text]) => {
        const [start, end] = [from, to].map((v) => clamp(this.px(v), this.left, this.right));
        return `<rect class="gap" x="${px(start)}" y="${TOP}" width="${px(end - start)}" height="${this.bottom - TOP}"/>`
          + this.message(start, end, text);
      }).join("");
    }

    /**
     * Multiples of the speed, as lines.
     * @returns {Curve[]}
     */
    get rays() {
      const { slope, multiples } = this.data.perRev ?? { slope: 0, multiples: [] };
      return multiples.map((k) => ({
        label: `${k} ×`, at: this.range, y: this.range.map((x) => k * slope * x),
        runs: [[0, 1, "per-rev", ""]],
      }));
    }

    paths() {
      return [...this.rays, ...this.lines].map((line) => line.runs.map(([first, last, style]) => {
        let path = "", dots = "";
        for (let k = first, pen = "M"; k <= last; k++) {
          const height = line.y[k];
          if (height === null) { pen = "M"; continue; }
          const [x, y] = [px(this.px(line.at[k])), px(this.py(height))];
          path += `${pen}${x} ${y}`;
          pen = "L";
          if (line.dots) dots += `<circle class="dot ${style}" r="3.5" cx="${x}" cy="${y}"/>`;
        }
        return `<path class="line ${style}${line.second ? " second" : ""}" d="${path}"/>${dots}`;
      }).join("")).join("");
    }

    /**
     * The last point of a line inside the frame, and whether it leaves through the top there.
     * @param {Curve} line
     * @returns {LineEnd | null}
     */
    end({ at, y, runs, label, dots }) {
      const top = this.yRange[1], [low, high] = this.range;
      /** @param {number} k */
      const heightOf = (k) => y[k] ?? NaN;
      if (dots) return { x: this.right, y: this.py(heightOf(y.length - 1)), style: runs[0][2], label, above: false };
      let k = at.length - 1;
      while (k >= 0 && (!(heightOf(k) <= top) || (at[k] > high && at[k - 1] > high))) k--;
      if (k < 0 || at[k] < low) return null;
      const style = (runs.findLast(([first]) => first <= k) ?? runs[0])[2];
      let x = Math.min(at[k], high), height = valueAt({ at, y, runs }, x)[0];
      const leaves = k + 1 < at.length && heightOf(k + 1) > top && at[k] < high;
      if (leaves) {
        const share = (top - heightOf(k)) / (heightOf(k + 1) - heightOf(k));
        x = at[k] + share * (at[k + 1] - at[k]);
        height = top;
      }
      if (height < this.yRange[0] || x > high) return null;
      return { x: this.px(x), y: this.py(height), style, label, above: leaves && this.px(x) < this.right - 8 };
    }

    /* The ends of the lines that have a label: beside the chart in their order, above it in theirs. */
    ends() {
      const found = [...this.rays, ...this.lines].filter((line) => line.label && !line.second)
        .flatMap((line) => this.end(line) ?? []);
      return {
        beside: found.filter((one) => !one.above).sort((a, b) => a.y - b.y),
        above: found.filter((one) => one.above).sort((a, b) => a.x - b.x),
      };
    }

    /**
     * The width of a label, and at least that of three letters, so that short ones have columns.
     * @param {string} label
     */
    widthOf(label) {
      this.ruler.font = `600 14px ${getComputedStyle(this.plot).fontFamily}`;
      return Math.max(3 * LETTER, this.ruler.measureText(label).width);
    }

    /* Labels at the right ends of the lines, as close to them as they have room, the longest first;
       none is over another. */
    besideLabels() {
      const { beside } = this.ends();
      const lowest = this.bottom - (this.low ? 4 : 0); // the unit of the x axis stands below
      const columns = Math.ceil((beside.length * LETTERS) / (this.bottom - TOP)) || 1;
      const heights = spread(beside.map((one) => one.y), LETTERS / columns, lowest);
      const found = beside.map(({ x, label, style }, k) => (
        { x: x + 4, y: heights[k], width: this.widthOf(label) + BETWEEN, label, style }));
      /** @type {typeof found} */
      const placed = [];
      for (const one of [...found].sort((a, b) => b.width - a.width)) {
        const near = placed.filter(({ y }) => Math.abs(y - one.y) < LETTERS - 1e-6).sort((a, b) => a.x - b.x);
        for (const other of near)
          if (one.x < other.x + other.width && other.x < one.x + one.width) one.x = other.x + other.width;
        placed.push(one);
      }
      return found;
    }

    /* All labels of lines: beside the chart, or above it where they leave it, in as many rows as they
       need. */
    labels() {
      const { above } = this.ends(), wide = this.letters;
      const rows = Math.ceil((above.length * wide) / (this.right - this.left)) || 1;
      const places = spread(above.map((one) => one.x), wide / rows, this.right - wide / 2);
      return this.besideLabels().map(({ x, y, label, style }) => (
        this.text(`label ${style}`, this.besideSigns(x, y, label), y + 4.5, label))).join("") + above.map((one, k) => {
        const y = TOP - 5 + (k % rows) * LETTERS, away = Math.abs(places[k] - one.x) > wide / 2;
        const leader = away ? `<path class="leader ${one.style}" d="M${px(places[k])} ${y + 1}L${px(one.x)} ${TOP}"/>` : "";
        return leader + this.text(`label above ${one.style}`, places[k], y, one.label);
      }).join("");
    }

    /**
     * The x of a label in the chart, where a line ends: to the right of the line of the beam and of
     * marks that it would cover.
     * @param {number} x
     * @param {number} y
     * @param {string} label
     */
    besideSigns(x, y, label) {
      const beam = this.data.cursor ? [{ at: this.px(this.place[0]), half: 5 }] : [];
      const marks = (this.data.marks ?? []).filter((mark) => Math.abs(this.py(mark.y) - y) < LETTERS)
        .map((mark) => ({ at: this.px(mark.x), half: 9 }));
      const signs = [...beam, ...marks].filter(({ at, half }) => at + half < this.right);
      for (const { at, half } of signs.sort((a, b) => a.at - b.at))
        if (at - half < x + LETTER * label.length && x < at + half) x = at + half;
      return x;
    }

    /* The beam shown, on each line, with the name of its mode if the line ends with another one. */
    rings() {
      const [value] = this.place, x = this.px(value);
      if (!this.data.cursor || value < this.range[0] || value > this.range[1]) return "";
      const found = this.lines.filter((line) => !line.second && !line.dots && line.label).map((line) => {
        const [y, run] = valueAt(line, value);
        const [, , style = "", name = ""] = run ?? [];
        return { y, style, name: name === line.label ? "" : name };
      }).filter(({ y }) => y <= this.yRange[1]).map((one) => ({ ...one, y: this.py(one.y) }));
      const named = found.filter(({ name }) => name).sort((a, b) => a.y - b.y);
      const heights = spread(named.map(({ y }) => y - 9), LETTERS, this.bottom);
      const beside = x + 8 + this.letters < this.right ? 8 : -this.letters; // the labels at the ends are there
      return found.map(({ y }) => `<circle class="ring" r="4.5" cx="${px(x)}" cy="${px(y)}"/>`).join("")
        + named.map((one, k) => this.text(`label at-beam ${one.style}`, x + beside, heights[k] + 4.5, one.name)).join("");
    }
  }

  return { Figure, TOP, clamp, escape, make, minus, px, valueAt };
})();
