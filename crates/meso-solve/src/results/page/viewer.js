// The cracks: quantised corners, flat light from the surface's own derivatives, the specimen's box around them.
(() => {
  const canvas = document.getElementById("cracks");
  const size = canvas.dataset.size.split(" ").map(Number);
  const table = turntable(canvas, {
    around: -0.6, above: 0.45, scale: 1.5 / Math.hypot(...size),
    vertex: `
    in vec3 place; in float opening; uniform mat3 turn; uniform vec3 middle; uniform vec2 zoom;
    out vec3 seen; out float wide;
    void main() {
      seen = turn * (place - middle);
      wide = opening;
      float far = 3.2 - seen.z;
      gl_Position = vec4(seen.xy * zoom * 3.2, (far - 3.2) / 2.0 * far, far);
    }`,
    fragment: `
    in vec3 seen; in float wide; uniform vec4 line; out vec4 colour;
    void main() {
      if (line.a > 0.0) { colour = line; return; }
      vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
      float light = 0.45 + 0.55 * abs(dot(normal, normalize(vec3(0.3, 0.5, 0.8))));
      float w = sqrt(clamp(wide, 0.0, 1.0));
      vec3 narrow = vec3(0.98, 0.80, 0.45), middle = vec3(0.91, 0.46, 0.20), dark = vec3(0.55, 0.08, 0.10);
      colour = vec4(light * (w < 0.5 ? mix(narrow, middle, 2.0 * w) : mix(middle, dark, 2.0 * w - 1.0)), 1.0);
    }`,
  });
  if (!table) return;
  const { gl, uniform } = table;
  const triangles = new Uint32Array(decoded("triangles").buffer);
  const cracks = table.vertices({
    place: [new Uint16Array(decoded("corners").buffer), 3, true], opening: [decoded("openings"), 1, true],
  }, triangles);

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
  const box = table.vertices({ place: [new Float32Array(ends), 3, false] });

  table.show(() => {
    gl.uniform3f(uniform("middle"), size[0] / 2, size[1] / 2, size[2] / 2);
    gl.uniform4f(uniform("line"), 0, 0, 0, 0);
    gl.bindVertexArray(cracks);
    gl.drawElements(gl.TRIANGLES, triangles.length, gl.UNSIGNED_INT, 0);
    const ink = (getComputedStyle(canvas).color.match(/[\d.]+/g) || [128, 128, 128]).map(Number);
    gl.uniform4f(uniform("line"), ink[0] / 255, ink[1] / 255, ink[2] / 255, 1);
    gl.bindVertexArray(box);
    gl.drawArrays(gl.LINES, 0, 24);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", table.redraw);
})();
