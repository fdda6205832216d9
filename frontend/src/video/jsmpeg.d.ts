/** As much of jsmpeg as is used: its video decoder, fed with the elementary stream. */
declare module "@cycjimmy/jsmpeg-player" {
  export interface Planes {
    resize(width: number, height: number): void;
    /** 4:2:0 planes of the coded size: whole macroblocks, larger than the picture. Valid during the call only. */
    render(y: Uint8ClampedArray, cr: Uint8ClampedArray, cb: Uint8ClampedArray): void;
  }
  export interface Mpeg1Video {
    readonly codedWidth: number;
    connect(destination: Planes): void;
    write(pts: number, data: Uint8Array): void;
    /** Goes one start code further; true when that was a picture. */
    decode(): boolean;
  }
  const JSMpeg: {
    Decoder: { MPEG1Video: new (options: { streaming: boolean; videoBufferSize: number }) => Mpeg1Video };
  };
  export default JSMpeg;
}
