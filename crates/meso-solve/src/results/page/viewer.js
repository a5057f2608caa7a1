"use strict";
// Turns the cracks in WebGL 2: quantised corners, flat light from the surface's own derivatives, the specimen's box around it.
(() => {
  const canvas = document.getElementById("cracks");
  const gl = canvas.getContext("webgl2", { antialias: true, premultipliedAlpha: false });
  if (!gl) {
    canvas.replaceWith("This browser has no WebGL 2 to show them with.");
    return;
  }
  const bytes = (id) => Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
  const corners = new Uint16Array(bytes("corners").buffer);
  const openings = bytes("openings");
  const triangles = new Uint32Array(bytes("triangles").buffer);
  const size = canvas.dataset.size.split(" ").map(Number);

  const shader = (type, text) => {
    const made = gl.createShader(type);
    gl.shaderSource(made, "#version 300 es\n" + text);
    gl.compileShader(made);
    return made;
  };
  const program = gl.createProgram();
  gl.attachShader(program, shader(gl.VERTEX_SHADER, `
    in vec3 place; in float opening; uniform mat3 turn; uniform vec3 middle; uniform float zoom;
    out vec3 seen; out float wide;
    void main() {
      seen = turn * (place - middle);
      wide = opening;
      float far = 3.2 - seen.z;
      gl_Position = vec4(seen.xy * zoom * 3.2, (far - 3.2) / 2.0 * far, far);
    }`));
  gl.attachShader(program, shader(gl.FRAGMENT_SHADER, `
    precision highp float;
    in vec3 seen; in float wide; uniform vec4 line; out vec4 colour;
    void main() {
      if (line.a > 0.0) { colour = line; return; }
      vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
      float light = 0.45 + 0.55 * abs(dot(normal, normalize(vec3(0.3, 0.5, 0.8))));
      float w = sqrt(clamp(wide, 0.0, 1.0));
      vec3 narrow = vec3(0.98, 0.80, 0.45), middle = vec3(0.91, 0.46, 0.20), dark = vec3(0.55, 0.08, 0.10);
      colour = vec4(light * (w < 0.5 ? mix(narrow, middle, 2.0 * w) : mix(middle, dark, 2.0 * w - 1.0)), 1.0);
    }`));
  gl.linkProgram(program);
  gl.useProgram(program);
  const uniform = (name) => gl.getUniformLocation(program, name);
  const attribute = (name) => gl.getAttribLocation(program, name);

  const buffer = (target, data) => {
    gl.bindBuffer(target, gl.createBuffer());
    gl.bufferData(target, data, gl.STATIC_DRAW);
  };
  const cracks = gl.createVertexArray();
  gl.bindVertexArray(cracks);
  buffer(gl.ARRAY_BUFFER, corners);
  gl.enableVertexAttribArray(attribute("place"));
  gl.vertexAttribPointer(attribute("place"), 3, gl.UNSIGNED_SHORT, true, 0, 0);
  buffer(gl.ARRAY_BUFFER, openings);
  gl.enableVertexAttribArray(attribute("opening"));
  gl.vertexAttribPointer(attribute("opening"), 1, gl.UNSIGNED_BYTE, true, 0, 0);
  buffer(gl.ELEMENT_ARRAY_BUFFER, triangles);

  const box = gl.createVertexArray();
  gl.bindVertexArray(box);
  const ends = [];
  for (let axis = 0; axis < 3; axis++) {
    for (let side = 0; side < 4; side++) {
      const end = [0, 0, 0];
      end[(axis + 1) % 3] = (side & 1) * size[(axis + 1) % 3];
      end[(axis + 2) % 3] = (side >> 1) * size[(axis + 2) % 3];
      ends.push(...end);
      end[axis] = size[axis];
      ends.push(...end);
    }
  }
  buffer(gl.ARRAY_BUFFER, new Float32Array(ends));
  gl.enableVertexAttribArray(attribute("place"));
  gl.vertexAttribPointer(attribute("place"), 3, gl.FLOAT, false, 0, 0);

  let yaw = -0.6, pitch = 0.45, zoom = 1.5 / Math.hypot(...size);
  // x to the right, z upwards, then turned about z and about the screen's horizontal axis; columns first.
  const turn = () => {
    const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    return [cy, sp * sy, -cp * sy, -sy, sp * cy, -cp * cy, 0, cp, sp];
  };
  let asked = false;
  const draw = () => {
    asked = false;
    const pixels = Math.round(canvas.clientWidth * Math.min(window.devicePixelRatio || 1, 2)) || 300;
    if (canvas.width !== pixels || canvas.height !== pixels) canvas.width = canvas.height = pixels;
    gl.viewport(0, 0, pixels, pixels);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.uniformMatrix3fv(uniform("turn"), false, turn());
    gl.uniform3f(uniform("middle"), size[0] / 2, size[1] / 2, size[2] / 2);
    gl.uniform1f(uniform("zoom"), zoom);
    gl.uniform4f(uniform("line"), 0, 0, 0, 0);
    gl.bindVertexArray(cracks);
    gl.drawElements(gl.TRIANGLES, triangles.length, gl.UNSIGNED_INT, 0);
    const ink = (getComputedStyle(canvas).color.match(/[\d.]+/g) || [128, 128, 128]).map(Number);
    gl.uniform4f(uniform("line"), ink[0] / 255, ink[1] / 255, ink[2] / 255, 1);
    gl.bindVertexArray(box);
    gl.drawArrays(gl.LINES, 0, 24);
  };
  const redraw = () => {
    if (!asked) requestAnimationFrame(draw);
    asked = true;
  };
  const turnBy = (x, y) => {
    yaw += x;
    pitch = Math.max(-1.57, Math.min(1.57, pitch + y));
    redraw();
  };
  const zoomBy = (factor) => {
    zoom = Math.max(0.2, Math.min(10, zoom * factor));
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
  canvas.addEventListener("wheel", (event) => {
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
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  redraw();
})();
