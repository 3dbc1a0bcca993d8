// The shaders at work: the furnace at one angle or along a strip of them, and the two spheres.

const HEADER = "#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\n";
const STRIP = 256;

class Renderer {
  // Throws where the browser has no WebGL 2.
  constructor() {
    this.canvas = document.createElement("canvas");
    const gl = this.canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.gl = gl;
    const { corners, material, furnace, lit, enclosed } = DATA.shaders;
    this.programs = {
      furnace: this.program(corners, material + furnace),
      lit: this.program(corners, material + lit),
      enclosed: this.program(corners, "const float PI = 3.14159265358979;\n" + enclosed),
    };
    this.table = this.texture();
    this.strip = this.texture();
    this.pixel = this.texture();
    this.frame = gl.createFramebuffer();
    gl.bindVertexArray(gl.createVertexArray());
  }

  program(vertex, fragment) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, HEADER + text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
        throw new Error(`a shader was refused: ${gl.getShaderInfoLog(shader)}`);
      }
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      throw new Error(`shaders do not fit together: ${gl.getProgramInfoLog(program)}`);
    }
    return program;
  }

  texture() {
    const { gl } = this;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return texture;
  }

  // Uniforms by name: numbers are floats, arrays vectors, and the rest says what it is.
  set(program, values) {
    const { gl } = this;
    gl.useProgram(program);
    for (const [name, value] of Object.entries(values)) {
      const place = gl.getUniformLocation(program, name);
      if (typeof value === "number") gl.uniform1f(place, value);
      else if (Array.isArray(value)) gl.uniform3fv(place, value);
      else if ("uint" in value) gl.uniform1ui(place, value.uint);
      else if ("int" in value) gl.uniform1i(place, value.int);
      else {
        gl.activeTexture(gl.TEXTURE0 + value.unit);
        gl.bindTexture(gl.TEXTURE_2D, value.texture);
        gl.uniform1i(place, value.unit);
      }
    }
  }

  // rho and E of the chosen lobe as one texture: of a pair the mix by r0 is formed texel by texel, which is linear, too.
  uploadTable(settings) {
    const { gl } = this;
    const { material, r0, size, storage } = settings;
    const pair = tableOf(material.surface, 0, size, storage).albedo;
    const own = tableOf(material.surface, material.sheet, size, storage).albedo;
    const texels = new Float32Array(4 * size * size);
    for (let i = 0; i < size * size; i++) {
      const [x, y] = [i % size, Math.floor(i / size)];
      for (const channel of RGB) {
        texels[4 * i + channel] = material.sheet
          ? own.at(x, y, channel)
          : (1 - r0[channel]) * pair.at(x, y, 0) + r0[channel] * pair.at(x, y, 1);
      }
      texels[4 * i + 3] = pair.at(x, y, 1);
    }
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.table);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, size, size, 0, gl.RGBA, gl.FLOAT, texels);
  }

  // What all shaders of a material are told.
  choose(settings) {
    this.uploadTable(settings);
    const { material, surface } = settings;
    const tables = albedosOf(settings, "table");
    this.uniforms = {
      u_family: { uint: surface.familyCode },
      u_masking: { uint: surface.maskingCode },
      u_fresnel: { uint: material.fresnelCode },
      u_roughness: settings.roughness,
      u_eta: material.fresnelCode === 3 ? settings.r0 : material.eta,
      u_k: material.k,
      u_r0: settings.r0,
      u_ks: settings.ks,
      u_kd: settings.kd,
      u_coupling: { int: COUPLINGS.indexOf(settings.coupling) },
      u_compensation: { int: COMPENSATIONS.indexOf(settings.compensation) },
      u_table: { unit: 0, texture: this.table },
      u_row: settings.row * (settings.size - 1),
      u_rho_mean: compensated(settings, tables).mean,
      u_e_mean: tables.eMean,
    };
  }

  draw(width, height) {
    const { gl } = this;
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Furnace values as floats, four to a pixel: red, green, blue and mu.
  integrate(target, width, mu) {
    const { gl, frame } = this;
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, target);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32UI, width, 1, 0, gl.RGBA_INTEGER, gl.UNSIGNED_INT, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
    gl.bindTexture(gl.TEXTURE_2D, null);
    this.set(this.programs.furnace, { ...this.uniforms, u_mu: mu, u_width: width });
    this.draw(width, 1);
    const bits = new Uint32Array(4 * width);
    gl.readPixels(0, 0, width, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, bits);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return new Float32Array(bits.buffer);
  }

  // The furnace value at one cosine.
  read(mu) {
    return Array.from(this.integrate(this.pixel, 1, mu).slice(0, 3));
  }

  // The furnace over theta, from 0 to 90 degrees at the middles of STRIP pixels.
  furnace() {
    return this.integrate(this.strip, STRIP, -1);
  }

  // Draws a sphere into a canvas of the page.
  sphere(name, target, values) {
    const { gl, canvas } = this;
    const size = target.width;
    if (canvas.width !== size || canvas.height !== size) [canvas.width, canvas.height] = [size, size];
    const shared = name === "lit" ? this.uniforms : {};
    const strip = { unit: 1, texture: this.strip };
    this.set(this.programs[name], { ...shared, ...values, u_strip: strip, u_pixel: (1.12 * 2) / size });
    this.draw(size, size);
    target.getContext("2d").drawImage(canvas, 0, 0);
    gl.flush();
  }
}
