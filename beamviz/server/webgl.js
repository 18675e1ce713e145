/* In a browser without WebGL (switched off, on a remote desktop, without a graphics driver) viser's
   page ends with an error and handles no message. Here it gets a context that draws nothing, so
   that all else works as usual: nodes, camera, and what the pointer is over. `plain_scene.js` then
   draws the scene. */
"use strict";
const beamvizWebGL = (() => {
  const SIZE = 4096; // of each limit of the context, as pixels of a texture
  const isThere = hasContext();
  /** @type {() => void} */
  let drawn = () => {};

  /** Whether the browser has WebGL 2, which three.js draws with. */
  function hasContext() {
    const context = document.createElement("canvas").getContext("webgl2");
    context?.getExtension("WEBGL_lose_context")?.loseContext(); // a page may have few of them
    return Boolean(context);
  }

  const DRAWING = ["drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced"];
  /* What the functions of a context return, where that is not undefined. */
  /** @type {Record<string, (...given: any[]) => any>} */
  const ANSWERS = {
    getContextAttributes: () => ({}),
    getSupportedExtensions: () => [],
    getShaderPrecisionFormat: () => ({ precision: 23, rangeMin: 127, rangeMax: 127 }),
    getShaderInfoLog: () => "",
    getProgramInfoLog: () => "",
    getShaderParameter: () => true,
    getProgramParameter: (_, name) => (String(name).startsWith("ACTIVE") ? 0 : true),
    checkFramebufferStatus: () => "FRAMEBUFFER_COMPLETE",
    clientWaitSync: () => "ALREADY_SIGNALED",
    isContextLost: () => false,
    getError: () => "NO_ERROR",
    getUniformLocation: () => null,
    getAttribLocation: () => -1,
    getParameter: (name) => {
      if (/VERSION|VENDOR|RENDERER/.test(name)) return "WebGL 2.0";
      return /BOX|VIEWPORT/.test(name) ? new Int32Array(4) : SIZE;
    },
  };

  /**
   * A context that draws nothing. Its constants are their names.
   * @param {HTMLCanvasElement} canvas
   */
  function emptyContext(canvas) {
    /** @type {Record<string, any>} */
    const parts = { canvas, ...ANSWERS, getExtension: () => emptyContext(canvas) };
    for (const name of DRAWING) parts[name] = () => drawn();
    return new Proxy(parts, {
      get(known, name) {
        if (typeof name !== "string") return undefined;
        if (name === "drawingBufferWidth") return canvas.width;
        if (name === "drawingBufferHeight") return canvas.height;
        known[name] ??= /^[A-Z]/.test(name) ? name : /^(create|fenceSync)/.test(name) ? () => ({}) : () => undefined;
        return known[name];
      },
    });
  }

  /**
   * Gives a canvas the empty context in place of WebGL.
   * @param {() => void} tell is called whenever something would have been drawn
   */
  function replace(tell) {
    drawn = tell;
    /** @type {WeakMap<HTMLCanvasElement, any>} */
    const contexts = new WeakMap(), { prototype } = HTMLCanvasElement, usual = /** @type {any} */ (prototype.getContext);
    /** @type {any} */ (prototype).getContext = function (/** @type {string} */ kind, /** @type {any} */ options) {
      if (!/^(experimental-)?webgl/.test(kind)) return usual.call(this, kind, options);
      if (!contexts.has(this)) contexts.set(this, emptyContext(this));
      return contexts.get(this);
    };
  }

  return { isThere, replace };
})();
