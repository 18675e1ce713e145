/* The only script that uses undocumented parts of viser's page; viser.css has its elements, and
   viser_private.py is the same for the server. `check` says on the page which of them are missing. */
"use strict";
const beamvizViser = (() => {
  const SUPPORTED = "viser>=1.1,<1.2";
  const LOWEST = (85 / 180) * Math.PI; // from the axis: the camera stays above the floor, and off the edge of the plane of rotation
  const AGAIN = 1000; // [ms] until what is missing is looked for again

  /**
   * A vector, a node and a camera of three.js, which viser draws with.
   * @typedef {{ x: number, y: number, clone(): Vector, setFromMatrixPosition(matrix: object): Vector,
   *   project(camera: object): Vector }} Vector
   * @typedef {{ position: Vector, matrixWorld: { elements: number[] }, traverse?(each: (solid: Solid) => void): void }} SceneNode
   * @typedef {{ isMesh?: boolean, isInstancedMesh?: boolean, material?: { uniforms?: { thickness?: object } },
   *   raycast?: () => void }} Solid
   *
   * What viser has in `window.__viserMutable`, "for tests and debugging".
   * @typedef {object} Viewer
   * @property {(message: object) => void} sendMessage to the server
   * @property {object[]} messageQueue as from the server
   * @property {() => void} requestRender
   * @property {Record<string, SceneNode | undefined>} nodeRefFromName
   * @property {HTMLCanvasElement} canvas
   * @property {any} scene of three.js
   * @property {any} camera of three.js
   * @property {{ zoomTo(zoom: number): void, maxPolarAngle: number }} cameraControl
   */
  const PARTS = { // the types of these
    sendMessage: "function", messageQueue: "object", requestRender: "function",
    nodeRefFromName: "object", canvas: "object", scene: "object", camera: "object", cameraControl: "object",
  };

  /** @returns {Partial<Viewer>} */
  const viewer = () => /** @type {any} */ (window).__viserMutable ?? {};
  let isWatched = false, isConnected = false;

  // What is missing

  function missing() {
    const found = /** @type {Record<string, any>} */ (viewer());
    const names = Object.entries(PARTS)
      .filter(([name, type]) => typeof found[name] !== type || found[name] === null)
      .map(([name]) => name);
    if (typeof found.cameraControl?.zoomTo !== "function") names.push("cameraControl.zoomTo");
    if (typeof found.cameraControl?.maxPolarAngle !== "number") names.push("cameraControl.maxPolarAngle");
    return isWatched && !isConnected ? [...names, "message of a connection"] : names;
  }

  /* Says what is missing, until nothing is: viser shows a scene, or should by now. Then its camera is
     turned no lower than LOWEST. */
  function check() {
    const names = missing(), id = "viser-lacks";
    const notice = document.getElementById(id) ?? document.createElement("p");
    notice.remove();
    if (!names.length) return void (/** @type {Viewer} */ (viewer()).cameraControl.maxPolarAngle = LOWEST);
    const text = `The scene is incomplete: viser's page lacks ${names.join(", ")}. Install ${SUPPORTED}.`;
    if (notice.textContent !== text) console.error(text);
    Object.assign(notice, { id, role: "alert", textContent: text });
    document.body.prepend(notice);
    setTimeout(check, AGAIN);
  }

  // The scene

  /** @param {object} message to the server */
  const send = (message) => viewer().sendMessage?.(message);

  /** @param {object} message as from the server */
  const receive = (message) => viewer().messageQueue?.push(message);

  const canvas = () => viewer().canvas ?? null;

  /* The scene of three.js, the node in it that has all of ours, its camera and its canvas. */
  function world() {
    const { scene, camera, canvas, nodeRefFromName } = viewer(), root = nodeRefFromName?.[""];
    return scene && root && camera && canvas ? { scene, root, camera, canvas } : null;
  }

  const render = () => viewer().requestRender?.();

  /** @param {number} zoom relative to the camera of the scene */
  const zoomTo = (zoom) => viewer().cameraControl?.zoomTo(zoom);

  /**
   * The pixel of a node on the canvas; null if the scene has none of this name.
   * @param {string} name
   * @returns {[number, number] | null}
   */
  function pixel(name) {
    const { nodeRefFromName, camera, canvas } = viewer(), node = nodeRefFromName?.[name];
    if (!node || !camera || !canvas) return null;
    const { x, y } = node.position.clone().setFromMatrixPosition(node.matrixWorld).project(camera);
    return [((x + 1) / 2) * canvas.clientWidth, ((1 - y) / 2) * canvas.clientHeight];
  }

  // The page around it

  /**
   * Tells whenever the connection is there or lost, as viser's worker, which has it, tells viser.
   * @param {(isConnected: boolean) => void} tell
   */
  function watchConnection(tell) {
    isWatched = true;
    window.Worker = class extends Worker {
      /**
       * @param {string | URL} url
       * @param {WorkerOptions} [options]
       */
      constructor(url, options) {
        super(url, options);
        this.addEventListener("message", ({ data }) => {
          if (data?.type !== "connected" && data?.type !== "closed") return;
          isConnected = data.type === "connected";
          tell(isConnected);
        });
      }
    };
  }

  /* Under a path: tells viser the address of its WebSocket, for which it would leave out the slash at
     the end, where many a proxy passes nothing on. Then nothing but our own script, by the function
     returned, replaces the address of the page: viser would add that of its WebSocket. */
  function ownAddress() {
    const replace = history.replaceState.bind(history);
    const { origin, pathname, search } = location;
    if (pathname !== "/") {
      const query = new URLSearchParams(search);
      query.set("websocket", origin.replace("http", "ws") + pathname);
      replace(null, "", `?${query}`);
    }
    let isRead = false;
    history.replaceState = () => {
      if (!isRead) replace(null, "", pathname + search);
      isRead = true;
    };
    /** @param {string} url */
    return (url) => {
      isRead = true;
      replace(null, "", url);
    };
  }

  /* viser would call preventDefault in a passive listener: without effect, but with an error. And the
     outline of a body, which is invisible, unscaled and at the hub until a pointer has been over the
     body, would take the pointer there: no drag would turn the view, and the server ends a connection
     that sends such a drag of no body. */
  function quietPointer() {
    /** @param {Event} event */
    const prepare = (event) => {
      if (!(event.target instanceof HTMLCanvasElement)) return;
      if (event.type === "pointerdown") event.preventDefault = () => {};
      for (const node of Object.values(viewer().nodeRefFromName ?? {})) node?.traverse?.(passOver);
    };
    for (const type of ["pointerdown", "pointermove"]) document.addEventListener(type, prepare, true);
  }

  /** @param {Solid} solid whose outline takes no pointer */
  function passOver(solid) {
    if (solid.isMesh && !solid.isInstancedMesh && solid.material?.uniforms?.thickness) solid.raycast = () => {};
  }

  /* Opens the palette of commands for Ctrl+K in a field, where viser ignores it. */
  /** @param {KeyboardEvent} event */
  const openPalette = (event) => document.body.dispatchEvent(new KeyboardEvent("keydown", event));

  return {
    check, send, receive, canvas, world, render, zoomTo, pixel, watchConnection, ownAddress, quietPointer,
    openPalette,
  };
})();
