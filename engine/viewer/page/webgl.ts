// What the drawings of the page need to know of WebGL.

export const kMostPixels = 2; // per CSS pixel

// Whether WebGL draws in software, which is slow: a drawing then does without antialiasing and finer
// pixels. Throws an Error if the browser has no WebGL.
export function drawsInSoftware(canvas: HTMLCanvasElement): boolean {
  const probe = canvas.ownerDocument.createElement("canvas").getContext("webgl2");
  if (!probe) throw new Error("the browser has no WebGL 2");
  const info = probe.getExtension("WEBGL_debug_renderer_info");
  const name = info ? String(probe.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
