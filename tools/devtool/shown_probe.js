// Runs in the viewer's page before its own scripts (benches/frame_rate.py). Redirects its stream to
// another server, and records before each screen refresh which frame of the stream was drawn last.
// The timestamp of a VideoFrame is the number of its frame.
(() => {
  const probe = { screen: [], shown: [] };
  window.diaphaneShown = probe;
  const { port } = window.diaphanePlayer;
  const Native = window.WebSocket;
  window.WebSocket = class extends Native {
    constructor(_, protocols) {
      super(`ws://127.0.0.1:${port}/`, protocols);
    }
  };
  let newest = 0;
  const draw = CanvasRenderingContext2D.prototype.drawImage;
  CanvasRenderingContext2D.prototype.drawImage = function (source, ...where) {
    draw.call(this, source, ...where);
    if (source instanceof VideoFrame) newest = source.timestamp;
  };
  const look = () => {
    requestAnimationFrame(look);
    const now = performance.now();
    probe.screen.push(now);
    if (newest !== (probe.shown.at(-1)?.seq ?? 0)) probe.shown.push({ seq: newest, now });
  };
  requestAnimationFrame(look);
})();
