// Put into a page before its own scripts, after tools/devtool/page_wire.js: what its stream said, for the tests of test_stream.py.
(() => {
  const heard = { tiles: {}, codecs: {}, epoch: 0, frame: null, spoil: false };
  window.heardStills = heard;

  const fields = window.eachProtobufField;
  const names = { 1: "epoch", 2: "tile", 3: "tiles", 4: "x", 5: "y", 6: "width", 7: "height", 9: "hash", 12: "samples" };
  const frame_names = { 1: "codec", 3: "epoch", 6: "samples", 8: "width", 9: "height", 13: "denoised", 15: "quality" };
  const hear = (data) =>
    fields(new Uint8Array(data), (kind, body) => {
      if (kind === 2) {
        const frame = {};
        fields(body, (n, value) => n in frame_names && (frame[frame_names[n]] = value));
        heard.codecs[frame.codec] = true;
        heard.frame = frame;
      }
      if (kind !== 3) return;
      const still = { tile: 0, x: 0, y: 0 };
      fields(body, (n, value) => n in names && (still[names[n]] = value));
      if (still.epoch > heard.epoch) Object.assign(heard, { epoch: still.epoch, tiles: {} });
      heard.tiles[still.tile] = still;
      if (heard.spoil) still.hash[0] ^= 1; // the same bytes that the page will read
    });
  const Native = window.WebSocket;
  window.WebSocket = class extends Native {
    constructor(...given) {
      super(...given);
      this.addEventListener("message", ({ data }) => hear(data));
    }
  };

  // The canvas as the last coded picture left it: looked at before each picture of the screen until the mark is there.
  heard.keepCoded = (canvas) => {
    let kept = "";
    heard.coded = () => kept;
    const small = new OffscreenCanvas(128, 128).getContext("2d", { willReadFrequently: true });
    small.imageSmoothingQuality = "high";
    const native = CanvasRenderingContext2D.prototype.putImageData;
    const keep = () => {
      small.drawImage(canvas, 0, 0, 128, 128);
      const rgba = small.getImageData(0, 0, 128, 128).data;
      let text = "";
      for (let i = 0; i < rgba.length; i += 4) text += String.fromCharCode(rgba[i], rgba[i + 1], rgba[i + 2]);
      kept = btoa(text);
    };
    CanvasRenderingContext2D.prototype.putImageData = function (image, x, y) {
      if (this.canvas === canvas && x === 0 && y === 0) keep(); // the first tile: what is there is the stream's
      return native.call(this, image, x, y);
    };
  };
})();
