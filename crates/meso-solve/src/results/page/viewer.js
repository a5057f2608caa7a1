// A slider over the moments of a test: the dot on the curve, the sections, and the deformed body with its cracks follow it.
(() => {
  const at = (id) => document.getElementById(id);
  const moments = JSON.parse(at("moments").textContent);
  const [slider, factor, shell, canvas] = ["moment", "factor", "shell", "cracks"].map(at);
  const dot = document.querySelector(".now"), places = dot ? dot.dataset.at.split(" ").map((place) => place.split(",")) : [];
  const size = canvas.dataset.size.split(" ").map(Number);
  const table = turntable(canvas, {
    around: -0.6, above: 0.35, scale: 2.0 / Math.hypot(...size),
    vertex: `
    in vec3 place, moved; in float opening; uniform mat3 turn; uniform vec3 middle; uniform vec2 zoom; uniform float stretch;
    out vec3 seen; out float wide;
    void main() {
      seen = turn * (place + stretch * moved - middle);
      wide = opening;
      float far = 3.2 - seen.z;
      gl_Position = vec4(seen.xy * zoom * 3.2, (far - 3.2) / 2.0 * far, far);
    }`,
    fragment: `
    in vec3 seen; in float wide; uniform vec4 line; uniform float skin; out vec4 colour;
    void main() {
      vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
      float light = 0.45 + 0.55 * abs(dot(normal, normalize(vec3(0.3, 0.5, 0.8))));
      float w = sqrt(clamp(wide, 0.0, 1.0));
      vec3 narrow = vec3(0.98, 0.80, 0.45), middle = vec3(0.91, 0.46, 0.20), dark = vec3(0.55, 0.08, 0.10);
      vec3 crack = light * (w < 0.5 ? mix(narrow, middle, 2.0 * w) : mix(middle, dark, 2.0 * w - 1.0));
      colour = line.a == 0.0 ? vec4(crack, 1.0) : vec4(line.rgb * mix(1.0, light, skin), line.a);
    }`,
  });

  const tell = () => {
    const now = Number(slider.value);
    at("told").textContent = moments[now].told;
    at("times").textContent = `${Number(factor.value) < 10 ? Number(factor.value).toFixed(1) : Math.round(factor.value)} times`;
    for (const part of document.querySelectorAll("[data-moment]")) part.hidden = Number(part.dataset.moment) !== now;
    if (dot && places[now]) [dot.cx.baseVal.value, dot.cy.baseVal.value] = places[now].map(Number);
    if (table) table.redraw();
  };
  for (const control of [slider, factor, shell]) control.addEventListener("input", tell);
  if (moments.length < 2) slider.disabled = true;

  if (table) {
    const { gl, uniform } = table;
    const bytes = (id, kind) => new kind(decoded(id).buffer);
    const skin = bytes("body-triangles", Uint32Array), corners = bytes("body-corners", Uint16Array);
    // The data of a moment are unpacked when it is first shown.
    const made = [];
    const of = (now) => (made[now] ||= {
      body: table.vertices({ place: [corners, 3, true], moved: [bytes(`body-moved-${now}`, Int16Array), 3, true] }, skin),
      cracks: moments[now].triangles && table.vertices({
        place: [bytes(`corners-${now}`, Uint16Array), 3, true], moved: [bytes(`moved-${now}`, Int16Array), 3, true],
        opening: [bytes(`openings-${now}`, Uint8Array), 1, true],
      }, bytes(`triangles-${now}`, Uint32Array)),
    });
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
    const colour = (name) => (getComputedStyle(canvas)[name].match(/[\d.]+/g) || [128, 128, 128]).slice(0, 3).map((c) => c / 255);

    table.show(() => {
      const now = Number(slider.value), { body, cracks } = of(now), ink = colour("color");
      gl.clearColor(...colour("backgroundColor"), 1);
      gl.clear(gl.COLOR_BUFFER_BIT);
      gl.uniform3f(uniform("middle"), size[0] / 2, size[1] / 2, size[2] / 2);
      gl.uniform1f(uniform("stretch"), factor.value * moments[now].most_mm / Number(canvas.dataset.longest));
      gl.uniform4f(uniform("line"), 0, 0, 0, 0);
      if (cracks) {
        gl.bindVertexArray(cracks);
        gl.drawElements(gl.TRIANGLES, 3 * moments[now].triangles, gl.UNSIGNED_INT, 0);
      }
      gl.uniform1f(uniform("skin"), 0);
      gl.uniform4f(uniform("line"), ...ink.map((c, i) => (c + colour("backgroundColor")[i]) / 2), 1);
      gl.bindVertexArray(box);
      gl.drawArrays(gl.LINES, 0, 24);
      if (!shell.checked) return;
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.depthMask(false);
      gl.uniform1f(uniform("skin"), 1);
      gl.uniform4f(uniform("line"), 0.55, 0.60, 0.66, 0.18);
      gl.bindVertexArray(body);
      gl.drawElements(gl.TRIANGLES, skin.length, gl.UNSIGNED_INT, 0);
      gl.depthMask(true);
      gl.disable(gl.BLEND);
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", table.redraw);
  }
  tell();
})();
