// The packing: quantised corners, flat light from the surface's own derivatives, cuts along x, y and z.
// Bodies are convex and do not overlap: where a cut opens one, its inner side fills exactly the cut face.
(() => {
  const canvas = document.getElementById("view");
  const size = canvas.dataset.size.split(" ").map(Number);
  const table = turntable(canvas, {
    around: 0.65, above: 0.45, scale: 1.75,
    vertex: `
    in vec3 place; in float kind; uniform mat3 turn; uniform vec3 size; uniform vec2 zoom;
    out vec3 seen; out vec3 share; flat out int number;
    void main() {
      share = place;
      number = int(kind + 0.5);
      seen = turn * ((place - 0.5) * size);
      gl_Position = vec4(seen.xy * zoom, -0.9 * seen.z, 1.0);
    }`,
    fragment: `
    in vec3 seen; in vec3 share; flat in int number; uniform vec3 cut; uniform vec4 line; out vec4 colour;
    void main() {
      if (line.a > 0.0) { colour = line; return; }
      if (any(greaterThan(share, cut))) discard;
      vec3 all[6] = vec3[6](vec3(0.50, 0.66, 0.79), vec3(0.79, 0.65, 0.42), vec3(0.64, 0.69, 0.54),
        vec3(0.77, 0.55, 0.62), vec3(0.56, 0.72, 0.69), vec3(0.70, 0.62, 0.86));
      vec3 own = all[number % 6];
      if (!gl_FrontFacing) { colour = vec4(mix(own, vec3(1.0), 0.3), 1.0); return; }
      vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
      colour = vec4(own * (0.5 + 0.5 * abs(dot(normal, normalize(vec3(0.3, 0.5, 0.8))))), 1.0);
    }`,
  });
  if (!table) return;
  const { gl, uniform } = table;
  const data = new Uint16Array(decoded("bodies").buffer);
  const ends = new Uint16Array(decoded("edges").buffer);

  let count = 0, corners = 0;
  for (let at = 0; at < data.length; at += 3 + 3 * (data[at + 1] + data[at + 2])) {
    count += data[at + 1];
    corners += 3 * data[at + 2];
  }
  const places = new Uint16Array(3 * count), kinds = new Uint8Array(count), triangles = new Uint32Array(corners);
  for (let at = 0, first = 0, next = 0; at < data.length;) {
    const [kind, n, m] = data.subarray(at, at + 3);
    places.set(data.subarray(at + 3, at + 3 + 3 * n), 3 * first);
    kinds.fill(kind, first, first + n);
    at += 3 + 3 * n;
    for (let i = 0; i < 3 * m; i++) triangles[next++] = first + data[at + i];
    at += 3 * m;
    first += n;
  }
  const bodies = table.vertices({ place: [places, 3, true], kind: [kinds, 1, false] }, triangles);
  const edges = table.vertices({ place: [ends, 3, true] });

  const sliders = ["x", "y", "z"].map((axis) => document.getElementById("cut-" + axis));
  sliders.forEach((slider) => slider.addEventListener("input", table.redraw));
  document.getElementById("save").addEventListener("click", () => table.save("packing.png"));
  const longest = Math.hypot(...size);
  table.show(() => {
    gl.uniform3fv(uniform("size"), size.map((length) => length / longest));
    gl.uniform3fv(uniform("cut"), sliders.map((slider) => Number(slider.value) + 1e-4));
    gl.uniform4f(uniform("line"), 0, 0, 0, 0);
    gl.bindVertexArray(bodies);
    gl.drawElements(gl.TRIANGLES, triangles.length, gl.UNSIGNED_INT, 0);
    gl.uniform4f(uniform("line"), 0.5, 0.5, 0.5, 1);
    gl.bindVertexArray(edges);
    gl.drawArrays(gl.LINES, 0, ends.length / 3);
  });
})();
