"use strict";
// Turns the packing in WebGL 2: quantised corners, flat light from the surface's own derivatives, a cut along z.
(() => {
  const canvas = document.getElementById("view");
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: true });
  if (!gl) {
    canvas.replaceWith("This browser has no WebGL 2 to show it with.");
    return;
  }
  const bytes = (id) => Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
  const data = new Uint16Array(bytes("bodies").buffer);
  const ends = new Uint16Array(bytes("edges").buffer);
  const size = canvas.dataset.size.split(" ").map(Number);
  const longest = Math.hypot(...size);

  let vertices = 0, corners = 0;
  for (let at = 0; at < data.length; at += 3 + 3 * (data[at + 1] + data[at + 2])) {
    vertices += data[at + 1];
    corners += 3 * data[at + 2];
  }
  const places = new Uint16Array(3 * vertices), kinds = new Uint8Array(vertices), triangles = new Uint32Array(corners);
  for (let at = 0, first = 0, next = 0; at < data.length;) {
    const [kind, n, m] = data.subarray(at, at + 3);
    places.set(data.subarray(at + 3, at + 3 + 3 * n), 3 * first);
    kinds.fill(kind, first, first + n);
    at += 3 + 3 * n;
    for (let i = 0; i < 3 * m; i++) triangles[next++] = first + data[at + i];
    at += 3 * m;
    first += n;
  }

  const shader = (type, text) => {
    const made = gl.createShader(type);
    gl.shaderSource(made, "#version 300 es\n" + text);
    gl.compileShader(made);
    return made;
  };
  const program = gl.createProgram();
  gl.attachShader(program, shader(gl.VERTEX_SHADER, `
    in vec3 place; in float kind; uniform mat3 turn; uniform vec3 size; uniform vec2 zoom;
    out vec3 seen; out float height; flat out int number;
    void main() {
      height = place.z;
      number = int(kind + 0.5);
      seen = turn * ((place - 0.5) * size);
      gl_Position = vec4(seen.xy * zoom, -0.9 * seen.z, 1.0);
    }`));
  gl.attachShader(program, shader(gl.FRAGMENT_SHADER, `
    precision highp float;
    in vec3 seen; in float height; flat in int number; uniform float cut; uniform vec4 line; out vec4 colour;
    void main() {
      if (line.a > 0.0) { colour = line; return; }
      if (height > cut) discard;
      vec3 all[6] = vec3[6](vec3(0.50, 0.66, 0.79), vec3(0.79, 0.65, 0.42), vec3(0.64, 0.69, 0.54),
        vec3(0.77, 0.55, 0.62), vec3(0.56, 0.72, 0.69), vec3(0.70, 0.62, 0.86));
      vec3 own = all[number % 6];
      if (!gl_FrontFacing) { colour = vec4(own * 0.62, 1.0); return; }
      vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
      colour = vec4(own * (0.5 + 0.5 * abs(dot(normal, normalize(vec3(0.3, 0.5, 0.8))))), 1.0);
    }`));
  gl.linkProgram(program);
  gl.useProgram(program);
  const uniform = (name) => gl.getUniformLocation(program, name);
  const attribute = (name) => gl.getAttribLocation(program, name);
  const buffer = (target, content) => {
    gl.bindBuffer(target, gl.createBuffer());
    gl.bufferData(target, content, gl.STATIC_DRAW);
  };
  const bodies = gl.createVertexArray(), edges = gl.createVertexArray();
  gl.bindVertexArray(bodies);
  buffer(gl.ARRAY_BUFFER, places);
  gl.enableVertexAttribArray(attribute("place"));
  gl.vertexAttribPointer(attribute("place"), 3, gl.UNSIGNED_SHORT, true, 0, 0);
  buffer(gl.ARRAY_BUFFER, kinds);
  gl.enableVertexAttribArray(attribute("kind"));
  gl.vertexAttribPointer(attribute("kind"), 1, gl.UNSIGNED_BYTE, false, 0, 0);
  buffer(gl.ELEMENT_ARRAY_BUFFER, triangles);
  gl.bindVertexArray(edges);
  buffer(gl.ARRAY_BUFFER, ends);
  gl.enableVertexAttribArray(attribute("place"));
  gl.vertexAttribPointer(attribute("place"), 3, gl.UNSIGNED_SHORT, true, 0, 0);

  const slider = document.getElementById("cut");
  let around = 0.65, above = 0.45, scale = 1.75, waits = false;
  const draw = () => {
    waits = false;
    const ratio = window.devicePixelRatio || 1, wide = canvas.clientWidth, high = canvas.clientHeight;
    canvas.width = Math.max(1, Math.round(wide * ratio));
    canvas.height = Math.max(1, Math.round(high * ratio));
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    const [c, s, d, t] = [Math.cos(around), Math.sin(around), Math.cos(above), Math.sin(above)];
    // Columns of the turn: about z, then towards whoever looks; z points upwards.
    gl.uniformMatrix3fv(uniform("turn"), false, [c, s * t, -s * d, -s, c * t, -c * d, 0, d, t]);
    gl.uniform3fv(uniform("size"), size.map((length) => length / longest));
    const least = Math.min(wide, high);
    gl.uniform2f(uniform("zoom"), scale * least / wide, scale * least / high);
    gl.uniform1f(uniform("cut"), Number(slider.value) + 1e-4);
    gl.uniform4f(uniform("line"), 0, 0, 0, 0);
    gl.bindVertexArray(bodies);
    gl.drawElements(gl.TRIANGLES, triangles.length, gl.UNSIGNED_INT, 0);
    gl.uniform4f(uniform("line"), 0.5, 0.5, 0.5, 1);
    gl.bindVertexArray(edges);
    gl.drawArrays(gl.LINES, 0, ends.length / 3);
  };
  const redraw = () => {
    if (!waits) requestAnimationFrame(draw);
    waits = true;
  };
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!canvas.hasPointerCapture(event.pointerId)) return;
    around += event.movementX / 150;
    above = Math.max(-1.57, Math.min(1.57, above + event.movementY / 150));
    redraw();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    scale = Math.max(0.5, Math.min(20, scale * Math.exp(-event.deltaY / 500)));
    redraw();
  }, { passive: false });
  slider.addEventListener("input", redraw);
  new ResizeObserver(redraw).observe(canvas);
  redraw();
})();
