/* The charts of the page: SVG, with buttons and a slider over it.

beamvizChart.draw(host, data) draws the chart in the element `host`, or brings it up to date: keys
that are not given stay. All numbers are in the units of the page.

  name     accessible name
  message  why there are no lines
  x, y     {label, symbol, unit, range: [from, to], log}
  at       x of the lines
  lines    [{label, y: [number or null], at: its own x, second, dots,
             runs: [[first, last, style, name] ...]}]: in runs of one style and one name
  perRev   {slope, multiples}: lines y = k slope x; the y axis ends where the last of them ends
  gaps     [[from, to, text] ...]: parts of the x axis without lines
  marks    [{key, kind, x, y, text, action, value}]: those with an action are buttons
  cursor   {action, x}: the line of the beam shown; it sets x by dragging and by keys
  chosen   key of a mark                                                                        */
(() => {
  "use strict";
  const REACH = 14; // [px] from the pointer to a mark that it points at
  const CLICK = 4; // [px] a press that moves less is a click
  const HOLD = 600; // [ms] that a value set here is shown, whatever the server says
  const TOP = 20, BOTTOM = 42, LEFT = 62; // [px] of the margins
  const LETTERS = 15; // [px] least distance of two labels
  const charts = new WeakMap();
  const SIGNS = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" };
  const escape = (text) => String(text).replace(/[&<>"]/g, (sign) => SIGNS[sign]);
  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  const px = (value) => value.toFixed(1);

  function make(parent, tag, attributes = {}, text = "") {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.textContent = text;
    return parent.appendChild(made);
  }

  function scale(range, log, start, end) {
    const [to, back] = log ? [Math.log10, (v) => 10 ** v] : [(v) => v, (v) => v];
    const low = to(range[0]), rate = (end - start) / (to(range[1]) - low);
    const position = (value) => start + (to(value) - low) * rate;
    position.invert = (pixel) => back(low + (pixel - start) / rate);
    return position;
  }

  /* The largest of 1, 2 or 5 times a power of ten up to `value`. */
  function neat(value) {
    const power = 10 ** Math.floor(Math.log10(value));
    return power * [5, 2, 1].find((digit) => digit * power <= value * (1 + 1e-9));
  }

  /* A number with the decimals of a step. */
  function fixed(value, step) {
    const decimals = clamp(Math.ceil(-Math.log10(step) - 1e-9), 0, 9);
    return value.toFixed(decimals).replace(/^-(0\.?0*)$/, "$1");
  }

  const significant = (value) =>
    Math.abs(value) >= 1e4 ? value.toFixed(0) : String(Number(value.toPrecision(4)));
  const withUnit = (axis, text) => (axis.unit ? `${text} ${axis.unit}` : `${axis.symbol} = ${text}`);
  const superscript = (k) => [...String(k)].map((c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]).join("");
  const power = (k) => Math.abs(k) < 4 ? String(Number((10 ** k).toPrecision(1))) : `10${superscript(k)}`;

  /* Numbers and texts of about `count` ticks. */
  function ticks([low, high], log, count) {
    const made = [];
    if (log) {
      const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9);
      const step = Math.max(1, Math.ceil((last - first) / count));
      for (let k = first; k <= last; k += step) made.push([10 ** k, power(k)]);
      return made;
    }
    const least = (high - low) / Math.max(count, 1), below = neat(least);
    const step = [below, neat(2 * below), neat(2.5 * below), neat(5 * below)].find((s) => s >= least * 0.99);
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high * (1 + 1e-9); k++)
      made.push([k * step, fixed(k * step, step)]);
    return made;
  }

  /* The y of a line at x, NaN where it has none, and the run it is in there. */
  function valueAt({ at, y, runs }, x) {
    if (!(x >= at[0] && x <= at.at(-1))) return [NaN, null];
    const after = clamp(at.findIndex((one) => one >= x), 1, at.length - 1), before = after - 1;
    const share = (x - at[before]) / (at[after] - at[before] || 1);
    const run = runs.find(([first, last]) => before >= first && after <= last) ?? runs.at(-1);
    if (share === 0 || share === 1) return [y[share ? after : before] ?? NaN, run];
    if (y[before] === null || y[after] === null) return [NaN, run];
    return [y[before] + share * (y[after] - y[before]), run];
  }

  /* Ascending positions, moved as little as needed to be `least` apart, up to `end`. */
  function spread(places, least, end) {
    const moved = [];
    for (const place of places) moved.push(Math.max(place, (moved.at(-1) ?? -Infinity) + least));
    for (let k = moved.length - 1, limit = end; k >= 0; limit = moved[k--] - least)
      moved[k] = Math.min(moved[k], limit);
    return moved;
  }

  class Chart {
    constructor(host) {
      this.host = host;
      this.data = { lines: [], marks: [], gaps: [] };
      this.view = null; // the part of the x axis that is shown, null for all of it
      this.own = null; // {x, until}: a value set here
      this.buttons = new Map(); // of the marks, by key
      this.places = []; // of the marks
      const head = make(host, "div", { class: "chart-head" });
      this.keys = make(head, "ul", { class: "key-list", "aria-label": "key" });
      this.zoom = make(head, "div", { class: "zoom", role: "group", "aria-label": "zoom" });
      for (const [text, label, act] of [
        ["−", "Zoom out", () => this.zoomBy(2)],
        ["+", "Zoom in", () => this.zoomBy(0.5)],
        ["whole range", "Show the whole range", () => this.show(null)],
      ]) make(this.zoom, "button", { type: "button", "aria-label": label, title: label }, text).onclick = act;
      const enlarge = make(head, "button", { type: "button", class: "enlarge", "data-enlarge": "" }, "enlarge");
      enlarge.onclick = () => {
        const large = document.body.classList.toggle("enlarged");
        document.querySelectorAll("[data-enlarge]").forEach((one) => one.setAttribute("aria-pressed", large));
      };
      this.plot = make(host, "div", { class: "plot" });
      this.plot.innerHTML = '<svg role="img"></svg>';
      this.svg = this.plot.firstChild;
      this.line = make(this.plot, "div", { class: "operating", hidden: "" });
      this.flag = make(this.line, "span", { class: "flag" });
      this.events = make(this.plot, "div", { class: "events", role: "group" });
      this.hair = make(this.plot, "div", { class: "hair", hidden: "" });
      this.readout = make(this.plot, "div", { class: "readout", "aria-hidden": "true", hidden: "" });
      for (const [kind, act] of Object.entries({
        pointerdown: this.press, pointermove: this.move, pointerup: this.release,
        pointercancel: this.letGo, pointerleave: this.leave, wheel: this.wheel,
      })) this.plot.addEventListener(kind, act.bind(this), { passive: false });
      this.line.addEventListener("keydown", (event) => this.key(event));
      new ResizeObserver(() => this.render()).observe(this.plot);
    }

    set(data) {
      const before = this.data;
      this.data = { ...before, ...data };
      this.lines = this.data.lines.map((line) => ({ ...line, at: line.at ?? this.data.at }));
      if (JSON.stringify(this.data.x) !== JSON.stringify(before.x)) {
        const same = this.data.x.label === before.x?.label;
        this.view = this.drag && same ? this.view ?? before.x.range : null; // a drag keeps the axis
      }
      if (data.chosen && data.chosen !== before.chosen) this.reveal(data.chosen);
      this.render();
    }

    // The axes

    get range() { return this.view ?? this.data.x.range; }

    get yRange() {
      const { y, perRev } = this.data;
      if (!perRev) return y.range;
      const end = 1.05 * Math.max(...perRev.multiples) * perRev.slope * this.range[1];
      return [y.range[0], Math.min(y.range[1], end)];
    }

    get value() { return this.own ? this.own.x : this.data.cursor?.x; }

    /* A round step of at most a pixel. */
    get step() {
      const [low, high] = this.range;
      return neat((high - low) / Math.max(this.right - LEFT, 100));
    }

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

    zoomBy(factor, centre = this.value) {
      const [low, high] = this.range;
      if (!(centre >= low && centre <= high)) centre = (low + high) / 2;
      this.show([centre - (centre - low) * factor, centre + (high - centre) * factor]);
    }

    /* Bring a mark into view, and zoom in where it is too close to the left end to be readable. */
    reveal(key) {
      const mark = this.data.marks.find((one) => one.key === key), [start, end] = this.data.x.range;
      if (!mark) return;
      if (mark.x < this.range[0] || mark.x > this.range[1]) this.view = null;
      const distance = mark.x - start;
      if (distance > 0 && distance < 0.12 * (this.range[1] - start))
        this.view = [start, Math.min(start + 2.2 * distance, end)];
    }

    /* Keep the line of the beam in view, but for a drag. */
    follow() {
      if (!this.view || this.drag) return;
      const [low, high] = this.view, [start, end] = this.data.x.range, width = high - low;
      if (low < start || high > end || (low === start && 2 * high <= end && this.dragged)) this.view = null;
      else if (this.value < low || this.value > high) {
        const first = clamp(this.value - width / 2, start, end - width);
        this.view = [first, first + width];
      }
      this.dragged = false;
    }

    // Drawing

    render() {
      const { x, y, name, message, cursor } = this.data;
      const { clientWidth: width, clientHeight: height } = this.plot;
      if (!x || !width || !height) return;
      if (this.own && !this.drag && performance.now() > this.own.until) this.own = null;
      this.follow();
      const longest = Math.max(3, ...this.lines.map((line) => line.label.length));
      this.right = width - 12 - 9 * longest;
      this.bottom = height - BOTTOM;
      this.px = scale(this.range, x.log, LEFT, this.right);
      this.py = scale(this.yRange, y.log, this.bottom, TOP);
      const frame = `x="${LEFT}" y="${TOP}" width="${this.right - LEFT}" height="${this.bottom - TOP}"`;
      this.svg.setAttribute("aria-label", name);
      this.svg.innerHTML = `<clipPath id="clip-${this.host.id}"><rect ${frame}/></clipPath>${this.axes()}`
        + `<g clip-path="url(#clip-${this.host.id})">${this.gaps()}${this.paths()}</g>`
        + this.labels() + this.rings()
        + this.text("message", (LEFT + this.right) / 2, (TOP + this.bottom) / 2, message ?? "");
      this.zoom.hidden = x.log || y.log || !cursor;
      this.zoom.children[0].disabled = this.zoom.children[2].hidden = !this.view;
      this.drawKeys();
      this.drawMarks();
      this.drawCursor();
      if (this.pointer) this.hover(...this.pointer);
    }

    text(style, x, y, content) {
      return `<text class="${style}" x="${px(x)}" y="${px(y)}">${escape(content)}</text>`;
    }

    axes() {
      const { x, y } = this.data, right = this.right, bottom = this.bottom;
      let made = "";
      for (const [value, content] of ticks(this.range, x.log, (right - LEFT) / 70)) {
        const at = this.px(value), covered = Math.abs(at - this.px(this.value)) < 52;
        made += `<path class="grid" d="M${px(at)} ${TOP}V${bottom}"/>`;
        if (!covered) made += this.text("tick", at, bottom + 17, content);
      }
      for (const [value, content] of ticks(this.yRange, y.log, (bottom - TOP) / 30)) {
        const at = this.py(value);
        made += `<path class="grid" d="M${LEFT} ${px(at)}H${right}"/>`;
        made += this.text("tick y", LEFT - 7, at + 4.5, content);
      }
      return `${made}<path class="axis" d="M${LEFT} ${bottom}H${right}"/>`
        + this.text("title", (LEFT + right) / 2, bottom + 37, x.label)
        + `<text class="title" transform="translate(13 ${(TOP + bottom) / 2}) rotate(-90)">${escape(y.label)}</text>`;
    }

    gaps() {
      return (this.data.gaps ?? []).map(([from, to, text]) => {
        const [start, end] = [from, to].map((v) => clamp(this.px(v), LEFT, this.right));
        const fits = end - start > 7.5 * text.length;
        return `<rect class="gap" x="${px(start)}" y="${TOP}" width="${px(end - start)}" height="${this.bottom - TOP}"/>`
          + (fits ? this.text("message", (start + end) / 2, (TOP + this.bottom) / 2, text) : "");
      }).join("");
    }

    /* Multiples of the speed, as lines. */
    get rays() {
      const { slope, multiples } = this.data.perRev ?? { multiples: [] };
      return multiples.map((k) => ({
        label: `${k} ×`, at: this.range, y: this.range.map((x) => k * slope * x),
        runs: [[0, 1, "per-rev", ""]],
      }));
    }

    paths() {
      return [...this.rays, ...this.lines].map((line) => line.runs.map(([first, last, style]) => {
        let path = "", dots = "";
        for (let k = first, pen = "M"; k <= last; k++) {
          if (line.y[k] === null) { pen = "M"; continue; }
          const [x, y] = [px(this.px(line.at[k])), px(this.py(line.y[k]))];
          path += `${pen}${x} ${y}`;
          pen = "L";
          if (line.dots) dots += `<circle class="dot ${style}" r="3.5" cx="${x}" cy="${y}"/>`;
        }
        return `<path class="line ${style}${line.second ? " second" : ""}" d="${path}"/>${dots}`;
      }).join("")).join("");
    }

    /* The last point of a line inside the frame, and whether it leaves through the top there. */
    end({ at, y, runs, label, dots }) {
      const top = this.yRange[1], [low, high] = this.range;
      if (dots) return { y: this.py(y.at(-1)), style: runs[0][2], label };
      let k = at.length - 1;
      while (k >= 0 && (y[k] === null || y[k] > top || (at[k] > high && at[k - 1] > high))) k--;
      if (k < 0 || at[k] < low) return null;
      const style = (runs.findLast(([first]) => first <= k) ?? runs[0])[2];
      let x = Math.min(at[k], high), height = valueAt({ at, y, runs }, x)[0];
      const leaves = k + 1 < at.length && y[k + 1] > top && at[k] < high;
      if (leaves) {
        x = at[k] + ((top - y[k]) / (y[k + 1] - y[k])) * (at[k + 1] - at[k]);
        height = top;
      }
      if (height < this.yRange[0] || x > high) return null;
      return { x: this.px(x), y: this.py(height), style, label, above: leaves && this.px(x) < this.right - 8 };
    }

    /* Labels at the right ends of the lines, or above the chart where they leave it. */
    labels() {
      const ends = [...this.rays, ...this.lines].filter((line) => line.label && !line.second)
        .map((line) => this.end(line)).filter((one) => one);
      const beside = ends.filter((one) => !one.above).sort((a, b) => a.y - b.y);
      const heights = spread(beside.map((one) => one.y), LETTERS, this.bottom);
      let before = -Infinity;
      const above = ends.filter((one) => one.above).sort((a, b) => a.x - b.x)
        .filter((one) => one.x - before > 28 && ((before = one.x), true));
      return beside.map((one, k) =>
        this.text(`label ${one.style}`, (one.x ?? this.right) + 5, heights[k] + 4.5, one.label)).join("")
        + above.map((one) => this.text(`label above ${one.style}`, one.x, TOP - 5, one.label)).join("");
    }

    /* The beam shown, on each line. */
    rings() {
      const value = this.value;
      if (!this.data.cursor || value < this.range[0] || value > this.range[1]) return "";
      return this.lines.filter((line) => !line.second && !line.dots && line.label)
        .map((line) => valueAt(line, value)[0]).filter((y) => y <= this.yRange[1])
        .map((y) => `<circle class="ring" r="4.5" cx="${px(this.px(value))}" cy="${px(this.py(y))}"/>`).join("");
    }

    drawKeys() {
      const shown = this.lines.filter((line) => !line.second && !line.dots && line.label !== "tip");
      const styles = new Set(shown.flatMap((line) => line.runs.map((run) => run[2].split(" ")[0])));
      styles.delete("measure");
      const keys = [...styles].map((style) => [`line ${style}`, style]);
      if (this.lines.some((line) => line.second)) keys.push(["line second", "compared with"]);
      for (const kind of new Set(this.data.marks.map((mark) => mark.kind)))
        if (kind !== "point") keys.push([`mark ${kind}`, kind === "here" ? "this scene" : kind]);
      const markup = keys.map(([style, text]) => `<li><i class="key ${style}"></i>${text}</li>`).join("");
      if (this.keys.innerHTML !== markup) this.keys.innerHTML = markup;
    }

    drawMarks() {
      const { marks, chosen, name } = this.data;
      const old = new Map(this.buttons);
      this.events.setAttribute("aria-label", `Marks of the ${name}`);
      this.places = marks.map((mark) => ({ mark, x: this.px(mark.x), y: this.py(mark.y) }))
        .filter(({ x, y }) => x >= LEFT - 1 && x <= this.right + 1 && y >= TOP - 1 && y <= this.bottom + 1);
      for (const { mark, x, y } of this.places) {
        const button = this.buttons.get(mark.key) ?? this.addMark(mark);
        old.delete(mark.key);
        button.className = `mark ${mark.kind}`;
        button.style.translate = `${px(x)}px ${px(y)}px`;
        if (!mark.action) continue;
        button.setAttribute("aria-label", `Go to ${mark.text}`);
        button.setAttribute("aria-pressed", mark.key === chosen);
      }
      for (const [key, button] of old) {
        button.remove();
        this.buttons.delete(key);
      }
    }

    addMark({ key, action }) {
      const button = make(this.events, action ? "button" : "i", action ? { type: "button" } : {});
      const place = () => this.places.find((one) => one.mark.key === key);
      button.onfocus = () => this.tell(place());
      button.onblur = () => this.tell(null);
      button.onclick = (event) => { if (event.detail === 0) this.go(place().mark); }; // by keyboard
      this.buttons.set(key, button);
      return button;
    }

    drawCursor() {
      const { cursor, x, name } = this.data, value = this.value;
      this.line.hidden = !(cursor && value >= this.range[0] && value <= this.range[1]);
      if (this.line.hidden) return;
      const text = withUnit(x, fixed(value, this.step));
      this.line.style.translate = `${px(this.px(value))}px 0`;
      this.flag.textContent = text;
      for (const [key, one] of Object.entries({
        role: "slider", tabindex: 0, "aria-label": `${x.label}: line of this beam in the ${name}`,
        "aria-valuemin": x.range[0], "aria-valuemax": x.range[1],
        "aria-valuenow": Number(value.toPrecision(6)), "aria-valuetext": text,
      })) this.line.setAttribute(key, one);
    }

    // Pointer and keys: a press on a mark goes there, any other one takes the line along

    place(event) {
      const { left, top } = this.plot.getBoundingClientRect();
      return [event.clientX - left, event.clientY - top];
    }

    press(event) {
      if (event.button !== 0 || !this.px) return;
      const [x, y] = this.place(event), near = this.nearest(x, y)?.mark;
      this.pressed = { x, mark: near?.action && near };
      this.plot.setPointerCapture(event.pointerId);
      if (event.pointerType !== "mouse") return; // a touch may be the start of a scroll
      event.preventDefault();
      if (!this.pressed.mark) this.dragTo(x);
    }

    move(event) {
      const [x, y] = this.place(event);
      this.pointer = event.pointerType === "mouse" && !this.pressed ? [x, y] : null;
      if (this.pressed && (this.drag || Math.abs(x - this.pressed.x) > CLICK)) this.dragTo(x);
      else this.hover(x, y);
    }

    release(event) {
      if (this.pressed?.mark && !this.drag) this.go(this.pressed.mark);
      else if (this.pressed && !this.drag) this.dragTo(this.place(event)[0]);
      this.letGo();
    }

    letGo() {
      this.dragged = this.drag;
      this.pressed = this.drag = null;
      this.plot.classList.remove("dragging");
    }

    leave() {
      this.pointer = null;
      this.tell(null);
    }

    dragTo(x) {
      if (!this.data.cursor || x < LEFT - REACH || x > this.right + 3 * REACH) return;
      this.drag = true;
      this.plot.classList.add("dragging");
      this.tell(null);
      this.choose(this.px.invert(clamp(x, LEFT, this.right)));
      this.line.focus({ preventScroll: true });
    }

    /* Show a value at once, and send it. */
    choose(value) {
      const { cursor, x } = this.data;
      const round = Math.round(value / this.step) * this.step;
      value = Number(clamp(round, ...x.range).toPrecision(9));
      if (value === this.value) return;
      this.own = { x: value, until: performance.now() + HOLD };
      setTimeout(() => this.render(), HOLD + 10);
      this.render();
      beamviz.sendOften(cursor.action, value);
    }

    go(mark) {
      this.own = null;
      beamviz.send(mark.action, mark.value);
    }

    key(event) {
      const step = this.step * (event.shiftKey ? 1 : 5);
      const move = {
        ArrowRight: step, ArrowUp: step, ArrowLeft: -step, ArrowDown: -step,
        PageUp: 10 * step, PageDown: -10 * step, Home: -Infinity, End: Infinity,
      }[event.key];
      if (!move || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation(); // viser would move its camera
      this.choose(clamp(this.value + move, ...this.data.x.range));
    }

    /* Ctrl+wheel, or a pinch, zooms; sideways it moves the part that is shown. */
    wheel(event) {
      if (this.zoom.hidden || !this.px) return;
      const [low, high] = this.range;
      const shift = (event.deltaX * (high - low)) / (this.right - LEFT);
      if (event.ctrlKey) this.zoomBy(1.002 ** event.deltaY, this.px.invert(this.place(event)[0]));
      else if (this.view && Math.abs(event.deltaX) > Math.abs(event.deltaY)) this.show([low + shift, high + shift]);
      else return;
      event.preventDefault();
    }

    // Reading values

    nearest(x, y) {
      const distance = (one) => Math.hypot(one.x - x, one.y - y);
      return this.places.filter((one) => distance(one) <= REACH).sort((a, b) => distance(a) - distance(b))[0];
    }

    hover(x, y) {
      if (!this.px || this.drag) return;
      const near = this.nearest(x, y);
      const onLine = this.data.cursor && Math.abs(this.px(this.value) - x) < 8;
      this.plot.style.cursor = near?.mark.action ? "pointer" : onLine ? "ew-resize" : "";
      if (near) this.tell(near);
      else if (x >= LEFT && x <= this.right && y >= TOP && y <= this.bottom) this.read(x, y);
      else this.tell(null);
    }

    /* The values of all lines at the pointer; the nearest one in bold, with the gap to the next. */
    read(pixel, height) {
      const { x: axis, y: across } = this.data, x = this.px.invert(pixel);
      const rows = this.lines.filter((line) => line.label && !line.second && !line.dots).map((line) => {
        const [y, run] = valueAt(line, x);
        return { y, name: run?.[3] || line.label };
      }).filter((row) => !Number.isNaN(row.y)).sort((a, b) => b.y - a.y);
      if (!rows.length) return this.tell(null);
      const closest = (others, distance) => others.reduce((a, b) => (distance(b) < distance(a) ? b : a));
      const near = closest(rows, (row) => Math.abs(this.py(row.y) - height));
      const unit = across.unit ? ` ${across.unit}` : "";
      this.readout.replaceChildren();
      make(this.readout, "b", {}, withUnit(axis, fixed(x, this.step)));
      for (const row of rows)
        make(this.readout, "span", row === near ? { class: "near" } : {}, `${row.name}\u2002${significant(row.y)}${unit}`);
      if (rows.length > 1) {
        const next = closest(rows.filter((row) => row !== near), (row) => Math.abs(row.y - near.y));
        make(this.readout, "em", {}, `gap ${near.name}–${next.name}\u2002${significant(Math.abs(next.y - near.y))}${unit}`);
      }
      this.put(pixel, height);
      this.hair.hidden = false;
      this.hair.style.translate = `${px(pixel)}px 0`;
    }

    /* The text of a mark, beside it; nothing for null. */
    tell(place) {
      this.readout.hidden = this.hair.hidden = true;
      if (!place) return;
      this.readout.replaceChildren();
      make(this.readout, "b", {}, place.mark.text);
      if (place.mark.action) make(this.readout, "em", {}, "click to go there");
      this.put(place.x, place.y);
    }

    put(x, y) {
      this.readout.hidden = false;
      const { offsetWidth: width, offsetHeight: height } = this.readout;
      const { clientWidth, clientHeight } = this.plot;
      const left = x + 14 + width < clientWidth ? x + 14 : x - 14 - width;
      const top = clamp(y - height / 2, 0, Math.max(clientHeight - height, 0));
      this.readout.style.translate = `${clamp(left, 0, Math.max(clientWidth - width, 0))}px ${top}px`;
    }
  }

  window.beamvizChart = {
    draw(host, data) {
      if (!charts.has(host)) charts.set(host, new Chart(host));
      charts.get(host).set(data);
    },
  };
})();
