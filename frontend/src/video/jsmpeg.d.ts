/** The part of jsmpeg that is used: its video decoder, which reads the elementary stream. */
declare module "@cycjimmy/jsmpeg-player" {
  export interface Planes {
    resize(width: number, height: number): void;
    /**
     * 4:2:0 planes of the coded size, which consists of whole macroblocks and is larger than the picture. Valid only
     * during the call.
     */
    render(y: Uint8ClampedArray, cr: Uint8ClampedArray, cb: Uint8ClampedArray): void;
  }
  export interface Mpeg1Video {
    readonly codedWidth: number;
    connect(destination: Planes): void;
    write(pts: number, data: Uint8Array): void;
    /** Advances by one start code. Returns true if it was a picture. */
    decode(): boolean;
  }
  const JSMpeg: {
    Decoder: { MPEG1Video: new (options: { streaming: boolean; videoBufferSize: number }) => Mpeg1Video };
  };
  export default JSMpeg;
}
