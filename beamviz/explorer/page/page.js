/* The page around viser's scene: applies the updates of the server (beamviz.apply), and sends the
   actions of elements with data-set, data-do or data-key. See __init__.py. */
"use strict";
const beamviz = (() => {
  const PERIOD = 33; // [ms] between two messages of the same action
  const PAUSE = 500; // [ms] between two changes of the address
  const LONGEST = 7900; // [characters] of an address that the server takes
  const READ = 80; // [ms] for a character of a note over the page, which then goes
  const PREFERENCES = { dark: "prefers-color-scheme: dark", still: "prefers-reduced-motion: reduce" };
  const ALL = "[data-set]", ACT = "button[data-set], [data-do]", TAB = "[role=tab]";
  /** @type {NonNullable<Update["values"]>} */
  const values = {};
  /** @type {NonNullable<Update["props"]>} */
  const props = {};
  /** @type {Record<string, ChartUpdate>} */
  const drawn = {};
  /** @type {Record<string, string>} */
  const texts = {};
  /** @type {Record<string, { value?: Scalar }>} */
  const waiting = {};
  /** @type {Record<string, number>} the number of the last action with each name */
  const sent = {};
  /** @type {Record<string, Part>} the control that the visitor has used last, by its key */
  const used = {};
  /** @type {string | null} */
  let bridge = null;
  /** @type {string | null} */
  let address = null;
  /** @type {Part | null} */
  let held = null;
  /** @type {{ slider: Part, inputs: number } | null} the slider below a finger, and how often it has moved */
  let touched = null;
  let count = 0, handled = 0; // the last action that was sent, and that the server has answered

  /** @type {(selector: string, root?: ParentNode) => Part[]} */
  const all = (selector, root = document) => /** @type {Part[]} */ ([...root.querySelectorAll(selector)]);
  /** @type {(id: string) => Part | null} */
  const found = (id) => /** @type {Part | null} */ (document.getElementById(id));
  /** @type {(id: string) => Part} one that is always there */
  const byId = (id) => /** @type {Part} */ (found(id));
  /** @type {(event: Event) => Part} */
  const targetOf = (event) => /** @type {Part} */ (event.target);
  /** @param {string} query */
  const media = (query) => matchMedia(`(${query})`);
  const opensLink = location.search !== ""; // not the scene of which the first picture may be
  const replaceAddress = beamvizViser.ownAddress();
  /** @param {Part} e */
  const isTyped = (e) => e.matches?.("input[type=text], textarea, select");

  // To the server

  /**
   * Sends a value, in place of an earlier one that waits.
   * @template {keyof Actions} Name
   * @param {Name} action
   * @param {Actions[Name]} value
   */
  const send = (action, value) => sendAs(action, value);

  /**
   * The same for an action that an element or a chart names; the server checks its value.
   * @param {string | undefined} action
   * @param {Scalar} value
   * @param {string} [unit] of the value: one in another unit than that of the slider is not sent, as of
   *   a chart before the beam got a size
   */
  function sendAs(action, value, unit) {
    if (action === undefined) return;
    if (unit !== undefined && (found(`${action}-slider`)?.dataset.unit ?? unit) !== unit) return;
    if (!LOOKS.includes(action)) dropRefused(action);
    if (!bridge) return;
    if (waiting[action]) waiting[action] = {};
    const text = JSON.stringify([++count, action, value]);
    if (text.length > 130000) return;
    const message = { type: "GuiUpdateMessage", uuid: bridge, updates: { value: text } };
    sent[action] = count;
    beamvizViser.send(message);
  }

  /**
   * Whether the server has answered all actions with this name: until then its values are earlier.
   * @param {string} action
   */
  const isAnswered = (action) => (sent[action] ?? 0) <= handled && waiting[action]?.value === undefined;

  /**
   * Sends immediately, and after that the latest value every PERIOD.
   * @param {string} action
   * @param {Scalar} value
   * @param {string} [unit]
   */
  function sendOften(action, value, unit) {
    if (waiting[action]) return void (waiting[action] = { value });
    sendAs(action, value, unit);
    waiting[action] = {};
    setTimeout(() => {
      const { value } = waiting[action];
      delete waiting[action];
      if (value !== undefined) sendOften(action, value, unit);
    }, PERIOD);
  }

  function sendPreferences() {
    const names = Object.entries(PREFERENCES).filter(([, query]) => media(query).matches);
    send("preferences", names.map(([name]) => name).join(" "));
  }

  // From the server

  /** @param {Update} update */
  function apply(update) {
    if (update.bridge) {
      bridge = update.bridge;
      for (const store of [values, props, drawn, texts, sent]) for (const key in store) delete store[key];
      beamvizViser.check();
      nameCanvas();
    }
    handled = update.handled ?? handled;
    const rows = update.html?.["mode-rows"] ? rowPlaces() : null, step = lessonStep(), guessed = found("try"), met = isMet();
    Object.assign(values, update.values); // the new texts show them
    for (const [id, html] of Object.entries(update.html ?? {})) {
      texts[id] = html;
      fill(found(id), html);
    }
    if (rows) moveRows(rows);
    if (update.html?.modes) showDigits(hasAllDigits()); // it has the button
    for (const [key, value] of Object.entries(update.values ?? {})) {
      controls(key).forEach((e) => showValue(e, value));
    }
    for (const [key, changes] of Object.entries(update.props ?? {})) {
      props[key] = { ...props[key], ...changes };
      controls(key, true).forEach((e) => setProps(e, changes));
    }
    for (const [id, data] of Object.entries(update.charts ?? {})) draw(id, data);
    if (update.captions) beamvizCaptions.show(update.captions);
    if (update.ready) {
      sendPreferences();
      send("met", localStorage.getItem("beamviz-met") ?? "");
      send("answers", `${voter()} ${localStorage.getItem("beamviz-answers") ?? ""}`);
      send("used", localStorage.getItem("beamviz-used") ?? "");
      send("link", location.search.slice(0, LONGEST));
    }
    if (update.open) showTab(update.open);
    for (const key of update.point ?? []) point(key);
    if (update.focus) focus(update.focus);
    const turned = lessonStep() !== step; // also to another lesson, which may stand elsewhere
    if (turned || update.point || update.props?.lesson?.hidden === false) { // it names controls, or opens
      byId("lesson").scrollIntoView({ block: "nearest" });
    }
    if (turned) byId("lesson").scrollTop = 0;
    else if (!met && isMet()) byId("verdict").scrollIntoView({ block: "nearest" }); // else it is in the scene
    else if (!guessed) found("try")?.scrollIntoView({ block: "nearest" }); // which a guess has brought
    if (update.dark !== undefined) document.documentElement.dataset.theme = update.dark ? "dark" : "light";
    if (update.address !== undefined) {
      dropRefused();
      setAddress(update.address);
    }
    if (update.used) localStorage.setItem("beamviz-used", update.used.join(" "));
    if (update.met) localStorage.setItem("beamviz-met", update.met.join(" "));
    if (update.answers?.length) localStorage.setItem("beamviz-answers", update.answers.join(" "));
    for (const one of update.say ?? []) say(one.text, one.error);
  }

  /* The open lesson and its step. */
  const lessonStep = () => all("#lesson h3, #lesson [aria-current]").map((e) => e.textContent).join();

  const isMet = () => Boolean(byId("verdict").querySelector(".met"));

  /* A random name of this browser, which has the answers: a lecture counts each once, also after the page is opened again. */
  function voter() {
    const name = localStorage.getItem("beamviz-voter") ?? Math.random().toString(36).slice(2);
    localStorage.setItem("beamviz-voter", name);
    return name;
  }

  /** @type {(query: string) => string} the open lesson, in words of our own for one from a teacher */
  const lessonOf = (query) => {
    const keys = new URLSearchParams(query);
    return keys.get("lesson") ?? (keys.has("own_step") ? "own" : "");
  };

  /**
   * Browsers allow only some changes of the address in a time: sets the latest one, every PAUSE.
   * @param {string} query
   */
  function setAddress(query) {
    if (address !== null) return void (address = query);
    address = query;
    const url = location.pathname + (query && `?${query}`);
    const lesson = lessonOf(query);
    if (lesson && lesson !== lessonOf(location.search)) history.pushState(null, "", url); // Back returns to the scene before
    else replaceAddress(url); // all else is undone by steps: Back would lose them
    setTimeout(() => {
      const latest = address;
      address = null;
      if (latest !== null && latest !== location.search.slice(1)) setAddress(latest);
    }, PAUSE);
  }

  /** @param {string} key */
  function controls(key, named = false) {
    const those = all(`[data-set="${CSS.escape(key)}"]`), one = named ? found(key) : null;
    return one ? [...those, one] : those;
  }

  /**
   * The control in use keeps the visitor's value while it is held, and until the server has answered
   * it; a field until its text has been sent. again: the value was shown before, and a text that is
   * no number stays.
   * @param {Part} e
   * @param {(typeof values)[string]} value
   */
  function showValue(e, value, again = false) {
    const key = e.dataset.set ?? "";
    const table = e.matches("table");
    if (e === held || ((table || e === used[key]) && !isAnswered(key))) return;
    if (table) return showCells(e, String(value ?? ""));
    if (e.typed && (again || e === document.activeElement)) return;
    if (e.unsent && !isNumber(e) && e === document.activeElement) return;
    if (e.matches("button")) e.ariaPressed = String(e.dataset.value === undefined
      ? Boolean(value) : JSON.stringify(JSON.parse(e.dataset.value)) === JSON.stringify(value));
    else if (e.type === "checkbox") e.checked = Boolean(value);
    else if (e.value !== String(value ?? "")) e.value = String(value ?? "");
    if (e.typed) e.removeAttribute("aria-invalid");
    e.typed = false;
    if (e.type === "range") paint(e);
  }

  /* Actions that change no beam. */
  const LOOKS = ["playing", "pace", "tab", "rotating_frame", "dark", "preferences"];

  /**
   * A text that is no number stays in its field until another edit, here or of the scene, as a value
   * that the server refuses; then the field shows the number of the beam.
   * @param {string} [action] the edit
   */
  function dropRefused(action) {
    for (const e of all("input.number[aria-invalid]")) {
      const key = e.dataset.set ?? "";
      if (!e.typed || e === document.activeElement || key === action) continue;
      e.typed = false;
      e.removeAttribute("aria-invalid");
      showValue(e, values[key]);
    }
  }

  // Tables of fields: one text with all of their cells, tabs between them, a line for each row

  /** @param {Part} table */
  const cellsOf = (table) => all("tbody tr", table).map((row) => all("input.cell", row));
  /** @param {Part} table */
  const textOf = (table) => cellsOf(table).map((row) => row.map((e) => e.value.replace(/[\t\n]/g, " ")).join("\t")).join("\n");

  /**
   * The cell in use keeps what is typed in it.
   * @param {Part} table
   * @param {string} text
   */
  function showCells(table, text) {
    const rows = text ? text.split("\n").map((line) => line.split("\t")) : [];
    cellsOf(table).forEach((row, i) => row.forEach((e, k) => {
      const value = rows[i]?.[k] ?? "";
      if (e !== document.activeElement && e.value !== value) e.value = value;
    }));
  }

  /**
   * Several cells of a spreadsheet, pasted into one, replace the table; a text pasted into its box counts at once.
   * @param {ClipboardEvent} event
   */
  function onPaste(event) {
    const e = targetOf(event), table = e.closest?.("[data-paste]");
    const text = event.clipboardData?.getData("text") ?? "";
    if (e.matches?.("textarea[data-set]")) setTimeout(() => e.dispatchEvent(new Event("change", { bubbles: true })));
    if (!table || !e.matches(".cell") || !/[\t\n]/.test(text.trim())) return;
    event.preventDefault();
    e.blur();
    sendAs(table.dataset.paste, text);
  }

  /**
   * @param {Part} e
   * @param {Record<string, Scalar>} changes
   */
  function setProps(e, changes) {
    for (const [name, value] of Object.entries(changes)) {
      if (value === null || value === false) e.removeAttribute(name);
      else e.setAttribute(name, value === true ? "" : String(value));
    }
    const key = e.dataset.set ?? "";
    if (e.typed && "data-unit" in changes) { // what was typed was meant in another one
      e.typed = false;
      showValue(e, values[key]);
    }
    if (["min", "max", "step"].some((name) => name in changes) && key in values) showValue(e, values[key]);
  }

  /**
   * Colours the track of a slider up to its thumb, and sets its text for screen readers.
   * @param {Part} e
   */
  function paint(e) {
    const min = Number(e.min), range = Number(e.max) - min || 1;
    e.style.setProperty("--part", `${(100 * (Number(e.value) - min)) / range}%`);
    e.setAttribute("aria-valuetext", `${e.value} ${e.dataset.unit ?? ""}`.trim());
  }

  /**
   * @param {string} id
   * @param {ChartUpdate} data
   */
  function draw(id, data) {
    drawn[id] = { ...drawn[id], ...data };
    const host = found(id), Kind = "values" in drawn[id] ? BeamvizMap : BeamvizChart;
    if (host) (host.figure ??= new Kind(host)).set(drawn[id]);
  }

  // New content is merged into the present elements, which keep focus, scroll position and drags.

  /**
   * @param {Part | null} e
   * @param {string} html
   */
  function fill(e, html) {
    if (!e) return;
    const template = document.createElement("template");
    template.innerHTML = html;
    morph(e, template.content);
    for (const one of [e, ...all(ALL, e)]) {
      const key = one.dataset.set ?? "";
      if (props[key]) setProps(one, props[key]);
      if (key in values) showValue(one, values[key], true);
    }
    for (const one of all("[id]", e)) {
      if (props[one.id]) setProps(one, props[one.id]);
      if (one.id in texts) fill(one, texts[one.id]);
      if (one.id in drawn) draw(one.id, drawn[one.id]);
    }
  }

  /**
   * The heading of a section that can be closed, "" of another element. A section of the same heading
   * stays open or closed as the visitor has left it; one in place of another is not closed.
   * @param {Element} e
   */
  const headingOf = (e) => (e.matches("details") && e.querySelector("summary")?.textContent) || "";

  /**
   * Elements with an id keep it, and their place among others: what is new before them, or gone, moves
   * them only.
   * @param {Element} old
   * @param {Element | DocumentFragment} fresh
   */
  function morph(old, fresh) {
    const after = /** @type {Part[]} */ ([...fresh.childNodes]), ids = after.map((node) => node.id);
    let next = /** @type {Part | null} */ (old.firstChild);
    const passed = () => {
      const there = next;
      next = /** @type {Part | null} */ (there?.nextSibling ?? null);
      return there;
    };
    for (const [k, node] of after.entries()) {
      const same = node.id ? [...old.children].find((e) => e.id === node.id) : null;
      const following = same && next && next.compareDocumentPosition(same) & Node.DOCUMENT_POSITION_FOLLOWING;
      while (following && next !== same) passed()?.remove();
      const there = next?.id && ids.indexOf(next.id) > k ? null : passed();
      if (!there) old.insertBefore(node, next);
      else if (there.nodeType !== node.nodeType || there.nodeName !== node.nodeName
        || there.id !== node.id) there.replaceWith(node);
      else if (node.nodeType !== Node.ELEMENT_NODE) {
        if (there.nodeValue !== node.nodeValue) there.nodeValue = node.nodeValue;
      } else {
        const left = headingOf(there), isLeft = Boolean(left) && left === headingOf(node);
        for (const { name } of [...there.attributes]) {
          const own = there.typed ? /^aria-invalid$/ : /^(style|aria-pressed|aria-valuetext)$/;
          const kept = (there.matches(ALL) && own.test(name)) || (left && name === "open");
          if (!node.hasAttribute(name) && !kept) there.removeAttribute(name);
        }
        for (const { name, value } of node.attributes) {
          if (there.getAttribute(name) === value || (isLeft && name === "open")) continue;
          there.setAttribute(name, value);
          if (name === "selected") there.selected = true;
        }
        if (!there.hasAttribute("data-chart")) morph(there, node);
      }
    }
    while (next) passed()?.remove();
  }

  /** @param {string} text */
  function say(text, error = false) {
    const live = byId("live"), toast = byId("toast");
    live.textContent = error ? "" : text; // an error is told once, by its alert
    if (!error) return;
    toast.textContent = text;
    toast.hidden = false;
    clearTimeout(toast.timer);
    toast.timer = setTimeout(() => (toast.hidden = true), READ * text.length + 3000);
  }

  // The table of modes: a row whose mode changes its place moves there, and is told

  const rowPlaces = () => new Map(all("#mode-rows [data-row]").map((row) => [row.dataset.row ?? "", row.offsetTop]));
  /** @param {number} k */
  const ordinal = (k) => `${k}${["st", "nd", "rd"][k - 1] ?? "th"}`;

  /** @param {ReturnType<typeof rowPlaces>} before */
  function moveRows(before) {
    const rows = all("#mode-rows [data-row]"), names = [...before.keys()];
    const same = rows.length === names.length && rows.every((row) => before.has(row.dataset.row ?? ""));
    const moved = rows.filter((row, k) => same && row.dataset.row !== names[k]);
    if (!moved.length) return;
    const told = moved.map((row) => `${row.dataset.row} is now ${ordinal(rows.indexOf(row) + 1)}`).join(", ");
    byId("told").textContent = told;
    say(told);
    clearTimeout(byId("told").timer);
    byId("told").timer = setTimeout(() => (byId("told").textContent = ""), 6000);
    if (media(PREFERENCES.still).matches) return;
    for (const row of moved) row.animate([
      { transform: `translateY(${Number(before.get(row.dataset.row ?? "")) - row.offsetTop}px)`, background: "var(--tint)" },
      { transform: "none" },
    ], { duration: 600, easing: "ease-in-out" });
  }

  // What the visitor does

  /** @type {(text: string | undefined) => Scalar} */
  const json = (text) => (text === undefined ? null : JSON.parse(text));
  const tabs = () => all(TAB).filter((tab) => !tab.hidden);
  /** @type {(tab: Part) => string[]} */
  const panelsOf = (tab) => (tab.dataset.panels ?? "").split(" "); // of its views, the first one its own
  /** @type {(tab: Part) => Part} */
  const panelOf = (tab) => byId(panelsOf(tab)[0]);

  /**
   * Sends what a button is for: that something is switched, a value that it sets, or an action. What
   * was switched is shown before the server has answered, so that a second press switches it back.
   * @param {Part} e
   */
  function press(e) {
    const key = e.dataset.set, value = json(e.dataset.value);
    if (key && e.dataset.value === undefined) {
      used[key] = e;
      e.ariaPressed = String(e.ariaPressed !== "true");
      sendAs(key, e.ariaPressed === "true");
    } else if (key) {
      for (const host of all("[data-chart]")) host.figure?.reveal?.(String(value));
      sendAs(key, value);
    } else sendAs(e.dataset.do, value, e.dataset.unit);
  }

  /**
   * Opens the tab that the server says, unless the visitor has opened another since.
   * @param {string} name
   */
  function showTab(name) {
    const panel = found(`tab-${name}`);
    if (panel?.hidden && isAnswered("tab")) openTab(panel, false);
  }

  /** @param {Part} panel */
  function openTab(panel, tell = true) {
    const tab = all(TAB).find((one) => panelsOf(one).includes(panel.id));
    if (!tab) return;
    for (const one of all(TAB)) {
      one.ariaSelected = String(one === tab);
      one.tabIndex = one === tab ? 0 : -1;
      one.hidden = one !== tab && one.dataset.aside !== undefined;
    }
    tab.setAttribute("aria-controls", panel.id);
    for (const one of all("[role=tabpanel]")) one.hidden = one !== panel;
    for (const group of all(".views")) {
      group.hidden = group.dataset.of !== tab.id;
      for (const view of all("[data-panel]", group)) view.ariaPressed = String(view.dataset.panel === panel.id);
    }
    tab.scrollIntoView({ block: "nearest", inline: "nearest" });
    panel.dispatchEvent(new CustomEvent("shown", { bubbles: true }));
    if (panel.getBoundingClientRect().top > innerHeight - 160) byId("dock").firstElementChild?.scrollIntoView(); // below the fold
    if (tell) send("tab", panel.id.slice(4));
  }

  /**
   * Opens the sections that contain a control, and highlights it.
   * @param {string} key
   */
  function point(key) {
    const those = [...controls(key, true), ...all(`[data-do="${CSS.escape(key)}"]`)];
    const e = those.find((one) => !one.matches("button[data-value]")) ?? those[0]; // which sets one value
    if (!e) return;
    if (e.matches("[role=tabpanel]")) return openTab(e);
    for (let up = e.parentElement; up; up = up.parentElement) {
      if (up.matches("details")) up.open = true;
      else if (up.matches("[role=tabpanel]")) openTab(up);
    }
    for (const inside of all(":scope > details", e)) inside.open = true;
    const pulsing = e.closest(".field, .row") ?? e;
    pulsing.scrollIntoView({ block: pulsing.clientHeight > 200 ? "start" : "nearest" });
    pulsing.classList.remove("pulse");
    requestAnimationFrame(() => pulsing.classList.add("pulse"));
    setTimeout(() => pulsing.classList.remove("pulse"), 3200);
  }

  /**
   * @param {string} id of a field
   */
  function focus(id) {
    const field = /** @type {HTMLInputElement | null} */ (found(id));
    field?.focus();
    field?.select();
  }

  /** @param {string} link */
  function copyLink(link) {
    const copied = navigator.clipboard?.writeText(link);
    if (!copied) return say(`Copy this address: ${link}`, true);
    copied.then(() => say("Link copied", true), () => say("The browser did not copy the link", true));
  }

  function savePicture() {
    beamvizCaptions.picture((png) => {
      const href = URL.createObjectURL(png);
      Object.assign(document.createElement("a"), { href, download: "beam.png" }).click();
      setTimeout(() => URL.revokeObjectURL(href), 10000);
      say("Picture saved");
    });
  }

  const hasAllDigits = () => localStorage.getItem("beamviz-digits") === "all";

  /**
   * Frequencies in all accurate digits with their errors, or in five digits.
   * @param {boolean} all
   */
  function showDigits(all) {
    const button = found("digits");
    if (button) button.ariaPressed = String(all);
    document.documentElement.dataset.digits = all ? "all" : "few";
    localStorage.setItem("beamviz-digits", all ? "all" : "few");
  }

  /** @param {Event} event */
  function onInput(event) {
    const e = targetOf(event), key = e.dataset?.set;
    if (e.type === "file" && event.type === "change") load(e, [...(e.files ?? [])]);
    const table = e.matches?.(".cell") ? e.closest("table") : null;
    if (table && event.type === "change") sendAs(table.dataset.set, textOf(table));
    e.unsent = event.type === "input" && isTyped(e) && !e.matches("select");
    if (!key) return;
    used[key] = e;
    if (e.type === "range") paint(e);
    if (isNumber(e)) {
      e.typed = true;
      e.removeAttribute("aria-invalid");
    }
    if (e.type === "range" && event.type === "input") {
      if (touched?.slider === e && ++touched.inputs === 1) return; // a finger may begin to scroll the page
      sendOften(key, e.valueAsNumber);
    }
    else if (event.type === "change" && e.type === "checkbox") sendAs(key, e.checked);
    else if (event.type === "change" && isNumber(e)) enter(e, key);
    else if (event.type === "change" && e.type !== "range") sendAs(key, e.value);
  }

  /** @param {Part} e */
  const isNumber = (e) => e.matches("input.number");

  /**
   * Sends the number of a field, with a decimal point or comma; what is none is said, and stays. An
   * emptied field gets the number of the beam.
   * @param {Part} e
   * @param {string} key
   */
  function enter(e, key) {
    if (!e.value.trim()) {
      e.typed = false;
      if (typeof values[key] === "number") showValue(e, values[key]);
      return send("forget_refused", null); // which was the value of the field
    }
    const text = e.value.trim().replace(/^\u2212/, "-");
    const grouped = /^-?\d{1,3}(,\d{3})+$/.test(text); // 1,500: thousands, or a decimal comma?
    const number = grouped ? NaN : Number(text.replace(",", ".") || NaN);
    e.toggleAttribute("aria-invalid", !Number.isFinite(number));
    if (Number.isFinite(number)) {
      e.typed = false;
      return sendAs(key, number);
    }
    const [whole] = text.split(",");
    const remedy = grouped ? `write ${text.replaceAll(",", "")}, or ${whole}.${text.split(",")[1]}` : "write a number, as 0.5";
    say(`${e.value}: ${remedy}`, true);
  }

  /**
   * Sends the files that were chosen, each as its name and its text, up to just above the limit of the
   * server.
   * @param {Part} e
   * @param {File[]} files
   */
  async function load(e, files) {
    const texts = files.slice(0, 3).map(async (file) => `${file.name}\n${await file.slice(0, 64001).text()}`);
    const text = (await Promise.all(texts)).join("\x1c");
    if (text.length > 120000) say("These files are too large for the page", true);
    else if (text) sendAs(e.dataset.do, text);
    e.value = "";
  }

  /**
   * Files dropped anywhere are those of the field for files that takes them by their suffix, else of
   * that which takes any; until then the page says that it does.
   * @param {DragEvent} event
   */
  function onDrag(event) {
    if (!event.dataTransfer?.types.includes("Files")) return;
    event.preventDefault(); // else the browser opens the file in place of the page
    const leaves = event.type === "dragleave" && event.relatedTarget === null;
    byId("drop").hidden = leaves || event.type === "drop";
    if (event.type !== "drop") return;
    const files = [...event.dataTransfer.files], fields = all("input[type=file]");
    const takes = (/** @type {Part} */ e) => e.accept && files.every((file) => file.name.toLowerCase().endsWith(e.accept));
    const field = fields.find(takes) ?? fields.find((e) => !e.accept);
    if (field && files.length) load(field, files);
  }

  /** @param {Event} event the end of a press; one that is cancelled has scrolled the page */
  function release(event) {
    const e = held;
    held = null;
    const key = e?.dataset.set ?? "";
    if (touched?.inputs === 1 && event.type === "pointerup") sendOften(key, touched.slider.valueAsNumber);
    touched = null;
    if (e && key in values) showValue(e, values[key], true);
  }

  /**
   * @param {KeyboardEvent} event
   * @param {Part} tab
   */
  function onTabKey(event, tab) {
    const those = tabs(), k = those.indexOf(tab);
    /** @type {Record<string, number>} */
    const places = { ArrowRight: k + 1, ArrowLeft: k - 1, Home: 0, End: those.length - 1 };
    const next = places[event.key];
    if (next === undefined) return;
    event.preventDefault();
    const other = those[(next + those.length) % those.length];
    openTab(panelOf(other));
    other.focus();
  }

  const letters = () => localStorage.getItem("beamviz-letters") !== "off";

  /**
   * viser moves its camera by letters and arrows: it gets only arrows, with focus on the scene.
   * @param {KeyboardEvent} event
   */
  function onKey(event) {
    const e = targetOf(event), key = event.key.toLowerCase();
    const inViser = e.closest?.("[role=dialog]"); // ours are no dialogs by their role
    if (e.matches?.(TAB)) onTabKey(event, e);
    if (key === "k" && document.querySelector("dialog:modal")) event.stopPropagation(); // below it nothing opens
    const editsText = inViser ? isTyped(e) : e.unsent || e.typed; // whose typing the browser undoes
    if ((event.ctrlKey || event.metaKey) && /^[zy]$/.test(key) && !editsText) {
      event.preventDefault();
      send(event.shiftKey || key === "y" ? "redo" : "undo", null);
    }
    if ((event.ctrlKey || event.metaKey) && key === "k" && e.matches?.("input, select") && !inViser) {
      event.preventDefault();
      beamvizViser.openPalette(event);
    }
    if (event.ctrlKey || event.metaKey || event.altKey || isTyped(e) || inViser) return;
    const letter = key.length === 1 && key !== " ";
    const arrow = key.startsWith("arrow"), isBall = e.matches?.("#pull-slider");
    if (isBall && (key === "enter" || key === "escape")) send("let_go", key === "enter");
    if (letter || (arrow && (isBall || !e.closest?.("#scene, [role=slider]")))) event.stopPropagation();
    if (!letter || !letters() || document.querySelector("dialog[open]")) return;
    all(`[data-key="${CSS.escape(key)}"]`)[0]?.click();
  }

  /* Gives the canvas of the scene a name and a tab stop. */
  function nameCanvas() {
    const canvas = beamvizViser.canvas();
    if (!canvas) return;
    canvas.setAttribute("role", "img");
    canvas.ariaLabel = "The rotating beam in motion. Arrow keys turn the view.";
    canvas.tabIndex = 0;
  }

  /* Shows the open text, if any, beside its question mark. */
  function placeText() {
    const [text] = all(":popover-open"), [mark] = text ? all(`[popovertarget="${CSS.escape(text.id)}"]`) : [];
    if (!mark) return;
    text.style.left = "8px"; // where nothing narrows it
    const at = mark.getBoundingClientRect(), { offsetWidth: width, offsetHeight: height } = text;
    const below = at.bottom + 6 + height < innerHeight;
    text.style.left = `${Math.max(8, Math.min(at.left - 12, innerWidth - width - 8))}px`;
    text.style.top = `${below ? at.bottom + 6 : Math.max(8, at.top - 6 - height)}px`;
  }

  function start() {
    beamvizViser.watchConnection((isConnected) => byId("offline")[isConnected ? "close" : "show"]());
    byId("restarted").hidden = window === window.parent; // not in the frame of a cell
    beamvizViser.quietPointer();
    found("first-picture")?.classList.toggle("opening", !opensLink);
    beamvizPlainScene.start(byId("caption-layer"));
    for (const kind of ["toggle", "scroll"]) document.addEventListener(kind, placeText, true);
    addEventListener("popstate", () => send("link", location.search.slice(0, LONGEST)));
    byId("skip").onclick = (event) => {
      event.preventDefault();
      const first = byId("alpha-slider");
      const section = first.closest("details");
      if (section) section.open = true;
      first.focus();
    };
    document.addEventListener("click", (event) => {
      const e = targetOf(event), tab = e.closest(TAB), acting = e.closest(ACT);
      const dialog = e.closest("[data-dialog]"), pointing = e.closest("[data-point]");
      const view = e.closest("[data-panel]"), copying = e.closest("[data-copy]");
      if (tab) openTab(panelOf(tab));
      else if (view) openTab(byId(view.dataset.panel ?? ""));
      else if (pointing) point(pointing.dataset.point ?? "");
      else if (e.closest("#copy-link")) copyLink(location.href);
      else if (copying) copyLink(`${location.origin}${location.pathname}?${copying.dataset.copy}`);
      else if (e.closest("#save-picture")) savePicture();
      else if (e.closest("#enlarge")) byId("enlarge").ariaPressed = String(document.body.classList.toggle("enlarged"));
      else if (e.closest("#digits")) showDigits(byId("digits").ariaPressed !== "true");
      else if (dialog) byId(dialog.dataset.dialog ?? "").showModal();
      else if (acting && !e.closest("input, select, label")) press(acting);
    });
    document.addEventListener("paste", onPaste);
    for (const kind of /** @type {const} */ (["dragenter", "dragover", "dragleave", "drop"])) document.addEventListener(kind, onDrag);
    for (const kind of ["input", "change"]) document.addEventListener(kind, onInput);
    document.addEventListener("pointerdown", (event) => {
      held = targetOf(event).closest(ALL);
      touched = event.pointerType === "touch" && held?.type === "range" ? { slider: held, inputs: 0 } : null;
    }, true);
    for (const kind of ["pointerup", "pointercancel"]) document.addEventListener(kind, release, true);
    window.addEventListener("keydown", onKey, true);
    document.addEventListener("focusout", (event) => targetOf(event).matches("#pull-slider") && send("let_go", false));
    for (const query of Object.values(PREFERENCES)) media(query).addEventListener("change", sendPreferences);
    showDigits(hasAllDigits());
    const box = byId("letters");
    box.checked = letters();
    box.onchange = () => localStorage.setItem("beamviz-letters", box.checked ? "on" : "off");
  }

  start();
  return { apply, send, sendAs, sendOften, drawn };
})();
