"use strict";
// A canvas drawn in WebGL 2 that dragging and arrow keys turn, and that the wheel, two fingers, + and - zoom. `null` in a
// browser without WebGL 2. Both shaders see `turn`, and `zoom` in units of the canvas's half width and height.
const turntable = (canvas, { vertex, fragment, around, above, scale }) => {
  const gl = canvas.getContext("webgl2", { antialias: true, premultipliedAlpha: false });
  if (!gl) {
    canvas.replaceWith("This browser has no WebGL 2 to show it with.");
    return null;
  }
  const program = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  const uniform = (name) => gl.getUniformLocation(program, name);

  const buffer = (target, content) => {
    gl.bindBuffer(target, gl.createBuffer());
    gl.bufferData(target, content, gl.STATIC_DRAW);
  };
  const kinds = new Map([[Uint8Array, gl.UNSIGNED_BYTE], [Uint16Array, gl.UNSIGNED_SHORT], [Int16Array, gl.SHORT],
    [Float32Array, gl.FLOAT]]);
  // Vertex data by attribute: [values, numbers a vertex, whether integers stand for 0 to 1].
  const vertices = (attributes, triangles) => {
    const made = gl.createVertexArray();
    gl.bindVertexArray(made);
    for (const [name, [values, width, isShare]] of Object.entries(attributes)) {
      buffer(gl.ARRAY_BUFFER, values);
      const at = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, width, kinds.get(values.constructor), isShare, 0, 0);
    }
    if (triangles) buffer(gl.ELEMENT_ARRAY_BUFFER, triangles);
    return made;
  };

  let zoom = 1, asked = false, content = () => {};
  const draw = () => {
    asked = false;
    const ratio = Math.min(window.devicePixelRatio || 1, 2), wide = canvas.clientWidth, high = canvas.clientHeight;
    canvas.width = Math.max(1, Math.round(wide * ratio));
    canvas.height = Math.max(1, Math.round(high * ratio));
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    const [c, s, d, t] = [Math.cos(around), Math.sin(around), Math.cos(above), Math.sin(above)];
    // Columns of the turn: about z, then towards whoever looks; x to the right, z upwards.
    gl.uniformMatrix3fv(uniform("turn"), false, [c, s * t, -s * d, -s, c * t, -c * d, 0, d, t]);
    const least = scale * zoom * Math.min(wide, high);
    gl.uniform2f(uniform("zoom"), least / wide, least / high);
    content();
  };
  const redraw = () => {
    if (!asked) requestAnimationFrame(draw);
    asked = true;
  };
  const turnBy = (x, y) => {
    around += x;
    above = Math.max(-1.57, Math.min(1.57, above + y));
    redraw();
  };
  const zoomBy = (factor) => {
    zoom = Math.max(0.3, Math.min(12, zoom * factor));
    redraw();
  };

  const fingers = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const spread = () => {
      const [[ax, ay], [bx, by]] = [...fingers.values()];
      return Math.hypot(ax - bx, ay - by);
    };
    const wide = fingers.size === 2 ? spread() : 0;
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (wide > 0) zoomBy(spread() / wide);
    else turnBy((event.clientX - before[0]) / 150, (event.clientY - before[1]) / 150);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  }
  // The wheel scrolls the page until the canvas is clicked.
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    zoomBy(Math.exp(-event.deltaY / 600));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
    const zooms = { "+": 1.1, "-": 1 / 1.1 };
    if (turns[event.key]) turnBy(...turns[event.key]);
    else if (zooms[event.key]) zoomBy(zooms[event.key]);
    else return;
    event.preventDefault();
  });
  new ResizeObserver(redraw).observe(canvas);
  // Draws `next` from now on.
  const show = (next) => {
    content = next;
    redraw();
  };
  // Saves the picture with a transparent ground. A buffer is readable only until the browser shows it.
  const save = (name) => {
    draw();
    canvas.toBlob((blob) => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(blob);
      link.download = name;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  };
  return { gl, uniform, vertices, redraw, show, save };
};
const decoded = (id) => Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
